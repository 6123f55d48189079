"""Networks on the command line and in files, and what cannot be a network."""

from __future__ import annotations

import json
import resource
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cmrc.network import Network, NetworkError, SharedMemory
from network_programs import DATA, IDLES, STOP, WORDS, interrupt_program, program, receiver, sender, stream_by_dma


@pytest.mark.parametrize(("links", "message"), [
    (["0.0:1.7"], "chip 1 has no port 7; 0 to 5 are possible"),
    (["0.0:2.3"], "there is no chip 2; the network has chips 0 to 1"),
    (["0.0:0.0"], "chip 0 port 0 cannot be linked to itself"),
    (["0.0:1.1"], "both begin with the token; connect one of ports 0 to 2 with one of 3 to 5"),
    (["0.3:1.5"], "both begin without the token"),
    (["0.0:1.3", "0.0:1.4"], "port 0 of chip 0 already has link 0.0:1.3"),
    (["0.0-1.3"], "CHIP.PORT:CHIP.PORT is expected"),
    (["00:1.3"], "CHIP.PORT is expected"),
    (["x.0:1.3"], "there is no chip x"),
])  # fmt: skip
def test_links_that_cannot_be(links: list[str], message: str) -> None:
    with pytest.raises(NetworkError) as error:
        Network([program(STOP)] * 2, links=links)
    assert message in str(error.value) and links[-1] in str(error.value)


def test_networks_that_cannot_be() -> None:
    for given, message in [
        ({"topology": "ring:65"}, "at most 64|1 to 64"),
        ({"topology": "hypercube:12"}, "1, 2, 4, 8, 16, 32 or 64"),
        ({"topology": "star:4"}, "not a topology"),
        ({"clocks_mhz": [40, 40]}, "clocks_mhz"),
        ({"clocks_mhz": -3}, "clock of -3"),
        ({"memories": [SharedMemory("m", 4, {0: 0x300000})]}, "no window that holds"),
        ({"memories": [SharedMemory("m", 4, {3: 0xC0000000})]}, "no chip 3"),
    ]:
        with pytest.raises(NetworkError, match=message):
            Network(program(STOP), **given)  # type: ignore[arg-type]
    with pytest.raises(NetworkError, match="factor of 2"):
        Network([program(STOP)] * 2, links=["0.0:1.3"], clocks_mhz=[60, 25])
    network = Network(program("        nop\n" + STOP), topology="ring:2")
    with pytest.raises(NetworkError, match="there is no link 2"):
        network.cut(2, 1)
    with pytest.raises(NetworkError, match="there is no chip 2"):
        network.reset(2, 1)
    network.run()
    with pytest.raises(NetworkError, match="has already run to"):
        network.cut(0, 0)


@pytest.fixture
def run(emulator: Path, tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    (tmp_path / "send.asm").write_text("        .text\n" + sender(0, 3))
    (tmp_path / "take.asm").write_text("        .text\n" + receiver(3, 3))

    def command(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [emulator, "exec", *arguments], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60
        )

    return command


FILE = """
[[chip]]
name = "left"
program = "send.asm"
clock_mhz = 50
[[chip]]
program = "take.asm"
[[link]]
ports = "left.0:1.3"
word_cycles = 10
[[event]]
at_us = 1.0
action = "cut"
link = "0.0:1.3"
[[event]]
at_us = 4.0
action = "restore"
link = "1.3:left.0"
"""


def test_two_programs_and_a_link(run: Any) -> None:
    result = run(
        "send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--dump", f"1:{DATA}:3", "--link-trace", "trace"
    )
    report = json.loads(result.stdout)
    assert result.returncode == 0 and report["stop"]["reason"] == "ended"
    assert report["dumps"] == [{"chip": 1, "address": DATA, "words": [1, 2, 3]}]
    assert report["links"][0]["forth"] == {"sent": 3, "arrived": 3, "under_way": 0, "lost": 0, "tokens": 0}
    assert all(sum(chip["causes"].values()) == chip["cycles"] for chip in report["chips"])


def test_links_nets_events_and_dumps_as_text(run: Any) -> None:
    """The cut comes while the second word is on its way. A row of a dump has eight words."""
    given = ("--link", "0.0:1.3", "--net", "p: 0.TCLK0>1.IIOF1", "--action", "0.5,cut,0.0:1.3")
    text = run("send.asm", "take.asm", *given, "--dump", f"1:{DATA}:9", "--dump", f"0:{DATA}:1").stdout
    assert text[text.index("\nlink ") + 1 :].splitlines() == [
        "link 0.0:1.3 (cut): forth 2 words (1 lost), back 0 words",
        "net p (0.TCLK0>1.IIOF1): high, 0 edges",
        "event 500000 cut 0.0:1.3",
        "event 500000 lost 0.0>1.3 00000002 after 0 bytes",
        "chip 1 002FF800: 00000001" + 7 * " 00000000",
        "chip 1 002FF808: 00000000",
        "chip 0 002FF800: 00000000",
    ]


def test_a_network_file(run: Any, tmp_path: Path) -> None:
    (tmp_path / "network.toml").write_text(FILE)
    result = run("--network", "network.toml", "--json", "--dump", f"1:{DATA}:3")
    report = json.loads(result.stdout)
    assert [event.split()[1] for event in report["events"]] == ["cut", "lost", "restored"]
    assert (
        report["stop"]["reason"] == "deadlock" and result.returncode == 1
    )  # one word is gone, and chip 1 waits for a third
    assert report["chips"][1]["waits_for"] == 0 and report["chips"][0]["name"] == "left"
    for old, new, message in [
        ('name = "left"', 'nam = "left"', "network.toml:3: no such key chip.nam; known are"),
        ('name = "left"', 'nam = "left"', 'entry, until, boot; did you mean "name"?'),
        ('name = "left"', 'name = "left"\nboard = "flt"', 'network.toml:4: there is no board "flt"; default, flat, or a file'),
        ('"left.0:1.3"', '"left.7:1.3"', "network.toml:9: link left.7:1.3: left.7: chip 0 has no port 7; 0 to 5 are possible"),
        ('"left.0:1.3"', '"right.0:1.3"', "there is no chip right"),
        ("word_cycles = 10", "word_cycles = -1", "network.toml:10: word_cycles: an integer from 0"),
        ('action = "cut"', 'action = "bite"', 'there is no action "bite"; cut, restore, reset, hold, release, pull_out, low, high, open, pulse is expected'),
        ('link = "1.3:left.0"', 'link = "0.1:1.3"', "there is no link 0.1:1.3; 0.0:1.3 is expected"),
        ("at_us = 1.0", "at_us = -1.0", "event.at_us: a number from 0"),
        ('program = "take.asm"', 'name = "x"', "chip 1 has no program"),
        ("[[chip]]\nname", "[chip]\nname", "network.toml"),
    ]:  # fmt: skip
        (tmp_path / "network.toml").write_text(FILE.replace(old, new, 1))
        bad = run("--network", "network.toml")
        assert bad.returncode == 2 and bad.stdout == "" and message in bad.stderr, (new, bad.stderr)


def test_all_errors_of_a_network_file_at_once(run: Any, tmp_path: Path) -> None:
    """Of the chips first; then of what connects them, by their names; then of the events, by the names of both."""
    wrong_chips = """[[chip]]
name = 1
program = "lost.asm"
clock_mhz = 0
[[chip]]
boot = "yes"
entri = "start"
"""
    (tmp_path / "network.toml").write_text(wrong_chips)
    bad = run("--network", "network.toml")
    assert bad.returncode == 2 and bad.stderr.splitlines() == [
        "emulator: network.toml:2: name: text in quotes is expected",
        "network.toml:3: program: there is no file lost.asm",
        "network.toml:4: clock_mhz: a number from 0.001 to 1000 is expected",
        'network.toml:5: chip 1 has no program, and does not boot; program = "FILE" or boot = true is expected',
        "network.toml:6: boot: true or false is expected",
        (
            "network.toml:7: no such key chip.entri; known are number, name, program, board, clock_mhz, entry, until, "
            'boot; did you mean "entry"?'
        ),
    ]
    wrong_links = FILE.replace('ports = "left.0:1.3"', 'ports = "left.0:4.3"\n[[link]]\nports = "left.1:1.4"\n[[link]]\n'
                               'ports = "left.1:1.5"\n[[memory]]\nname = "m"\n[[net]]')  # fmt: skip
    (tmp_path / "network.toml").write_text(wrong_links)
    bad = run("--network", "network.toml")
    assert bad.returncode == 2 and bad.stderr.splitlines() == [
        "emulator: network.toml:9: link left.0:4.3: 4.3: there is no chip 4; the network has chips 0 to 1",
        "network.toml:13: link 0.1:1.5: port 1 of chip 0 already has link 0.1:1.4; a port has one link",
        "network.toml:14: memory: words is missing",
        "network.toml:16: net: receivers is missing",
        "network.toml:17: no such key net.word_cycles; known are name, drivers, receivers, open_drain, rest",
    ]
    wrong_events = FILE.replace("at_us = 1.0", "at_us = -1.0").replace('action = "cut"', 'action = "bite"')
    (tmp_path / "network.toml").write_text(wrong_events)
    bad = run("--network", "network.toml")
    assert bad.returncode == 2 and bad.stderr.splitlines() == [
        "emulator: network.toml:12: event.at_us: a number from 0 to 1000000000000 is expected",
        (
            'network.toml:13: there is no action "bite"; cut, restore, reset, hold, release, pull_out, low, high, open, '
            "pulse is expected"
        ),
    ]


def test_of_very_many_errors_the_first_are_shown(run: Any, tmp_path: Path) -> None:
    (tmp_path / "network.toml").write_text(FILE + '[[event]]\nat_us = 1\nchip = 0\nkind = "hold"\n' * 5000)
    bad = run("--network", "network.toml")
    lines = bad.stderr.splitlines()
    assert bad.returncode == 2 and len(lines) == 21 and lines[-1] == "network.toml: 9980 more errors"


def test_what_is_done_to_a_network_from_the_command_line_as_from_a_file(run: Any, tmp_path: Path) -> None:
    (tmp_path / "network.toml").write_text(FILE)
    from_file = json.loads(run("--network", "network.toml", "--json").stdout)
    (tmp_path / "network.toml").write_text(FILE[: FILE.index("[[event]]")])
    asked = json.loads(
        run(
            "--network", "network.toml", "--json", "--action", "1,cut,left.0:1.3", "--action", "4.0,restore,1.3:0.0"
        ).stdout
    )
    assert asked == from_file
    held = json.loads(
        run(
            "send.asm",
            "take.asm",
            "--link",
            "0.0:1.3",
            "--json",
            "--action",
            "0.5,hold,1",
            "--action",
            "100,release,1",
            "--action",
            "200,reset,0",
        ).stdout
    )
    assert [event.split()[1:] for event in held["events"]] == [["hold", "1"], ["release", "1"], ["reset", "0"]]
    assert held["chips"][1]["causes"]["halted"] in range(1980, 2000)
    out = json.loads(run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--action", "0.5,pull_out,1").stdout)
    assert out["chips"][1]["status"] == "pulled_out" and out["links"][0]["cut"]


@pytest.mark.parametrize(("action", "message"), [
    ("1,bite,0", 'there is no action "bite"; cut, restore, reset, hold, release, pull_out, low, high, open, pulse is expected'),
    ("1,cutt,0.0:1.3", 'pulse is expected; did you mean "cut"?'),
    ("1,cut,0.1:1.3", "there is no link 0.1:1.3; 0.0:1.3 is expected"),
    ("1,cut,0", "CHIP.PORT:CHIP.PORT is expected"),
    ("1,reset,2", "there is no chip 2; the network has chips 0 to 1"),
    ("x,reset,1", "AT_US,ACTION,TARGET is expected"),
    ("-1,reset,1", "AT_US,ACTION,TARGET is expected"),
    ("1,reset", "AT_US,ACTION,TARGET is expected"),
])  # fmt: skip
def test_actions_that_cannot_be(run: Any, action: str, message: str) -> None:
    result = run("send.asm", "take.asm", "--link", "0.0:1.3", "--action", action)
    assert result.returncode == 2 and result.stdout == "" and message in result.stderr, result.stderr


def test_an_action_on_a_chip_that_is_gone_is_refused_before_the_run(run: Any) -> None:
    out = ["--action", "3,pull_out,1", "--action", "4,release,1"]
    result = run("send.asm", "take.asm", "--link", "0.0:1.3", *out)
    assert result.returncode == 2 and result.stdout == ""
    assert "release at 4000000 ps: chip 1 is pulled out at 3000000 ps" in result.stderr


def test_what_one_chip_can_be_asked_a_network_can(run: Any, tmp_path: Path) -> None:
    options = ["--trace", "t", "--events", "e", "--check", "--profile", "--pipeline", "0:20", "--peripherals"]
    plain = json.loads(run("send.asm", "take.asm", "--link", "0.0:1.3", "--json").stdout)
    result = run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", *options)
    report = json.loads(result.stdout)
    assert result.returncode == 0 and report["stop"] == plain["stop"]
    for n, (chip, before) in enumerate(zip(report["chips"], plain["chips"], strict=True)):
        assert {key: chip[key] for key in before} == before
        trace = (tmp_path / f"t.chip{n}").read_text().splitlines()
        assert len(trace) == 1 + chip["instructions"] and all(f"[dsp {n}]" in line for line in trace[1:])
        assert (
            chip["diagnostics"] == []
            and chip["profile"]["causes"] == chip["causes"]
            and chip["profile"]["instructions"] == chip["instructions"]
        )
        assert "ldhi 10h,ar0" in chip["pipeline"]
        assert chip["peripherals"]["PORT3.control"]["fields"]["PORT DIR"] == 1 and chip["peripherals"][
            "DMA5.auxiliary_link"
        ] == {"value": 0}
    events = (tmp_path / "e").read_text().splitlines()
    times = [int(line.split()[0]) for line in events]
    assert times == sorted(times) and len(events) == 9
    assert [line.split(" ", 1)[1] for line in events if line.endswith("00000002")] == [
        "chip 0: port_write 0 = 00000002",
        "word 0.0>1.3 00000002",
        "chip 1: port_read 3 = 00000002",
    ]
    for seed in "12":
        again = run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--turn-order", seed, *options)
        assert again.stdout == result.stdout and (tmp_path / "e").read_text().splitlines() == events
    text = run("send.asm", "take.asm", "--link", "0.0:1.3", *options).stdout
    assert [
        text.count(word) for word in ("checks: no rule was broken", "profile: routines", "pipeline, cycles 0 to 20")
    ] == [2, 2, 2]


def test_a_network_from_a_file_in_python(run: Any, tmp_path: Path) -> None:
    (tmp_path / "network.toml").write_text(FILE)
    run("--network", "network.toml", "--events", "e")
    network = Network.from_file(tmp_path / "network.toml", record_words=True, record_peripherals=True)
    assert network.run().reason == "deadlock"
    assert network.event_trace == (tmp_path / "e").read_text().splitlines()
    assert [event.kind for event in network.events if event.kind not in ("word", "token")] == [
        "cut",
        "lost",
        "restored",
    ]
    assert [(event.chip, event.kind, event.number, event.value, event.channel) for event in network.peripheral_events][
        :2
    ] == [(0, "port_write", 0, 1, None), (0, "port_write", 0, 2, None)]
    assert network.chips[0].name == "left" and network.chips[0].pc == network.chips[0].address("end")
    chip = network.chips[1]
    assert (
        chip.peripherals["PORT3.control"] == 4
        and chip.fields("port3.control")["INPUT LEVEL"] == 0
        and len(chip.peripherals) == 2 + 6 + 6 + 54
    )
    with pytest.raises(IndexError, match=r"PORT9\.control.*PORT"):
        chip.fields("PORT9.control")
    (tmp_path / "network.toml").write_text(FILE.replace('"cut"', '"bite"'))
    with pytest.raises(NetworkError, match="network.toml:13: there is no action"):
        Network.from_file(tmp_path / "network.toml")
    with pytest.raises(NetworkError, match="nowhere.toml: cannot be read"):
        Network.from_file(tmp_path / "nowhere.toml")


def test_interrupts_and_dma_are_events() -> None:
    network = Network([program(IDLES)] * 2, links=["0.0:1.3"], record_peripherals=True)
    stream_by_dma(network.chips[0]._core, network.chips[1]._core)
    network.run(until_us=40)
    seen = [(event.chip, event.kind, event.number, event.channel) for event in network.peripheral_events]
    assert seen.count((0, "port_write", 0, 0)) == seen.count((1, "port_read", 3, 3)) == len(WORDS)
    assert seen[-1] == (1, "dma_end", 3, None) and seen.count((0, "dma_end", 0, None)) == 1
    network = Network(
        [program(sender(0, 2)), program(interrupt_program(3, IDLES))], links=["0.0:1.3"], record_peripherals=True
    )
    network.run(until_us=40)
    taken = [event for event in network.peripheral_events if event.kind == "interrupt"]
    assert [(event.chip, event.number) for event in taken] == [(1, 0x0D + 4 * 3 + 1)] * 2
    assert network.chips[1].memory[0x2FFA00:0x2FFA02] == [1, 2]


@pytest.mark.parametrize(("arguments", "message"), [
    (["send.asm", "take.asm", "--link", "0.0:1.6"], "chip 1 has no port 6; 0 to 5 are possible"),
    (["send.asm", "--topology", "ring"], "--topology"),
    (["send.asm", "take.asm", "--topology", "ring:3"], "one program for all or 3 programs are expected, not 2"),
    (["send.asm", "take.asm", "--boot", "3"], "--boot: in a network the chips boot one another: boot = true of a [[chip]]"),
    (["send.asm", "take.asm", "--load-at", "1000h"], "--load-at: is for .hex files only"),
    (["send.asm", "take.asm", "--pipeline", "5"], "--pipeline: \"5\" is not FIRST:LAST"),
    (["send.asm", "take.asm", "--dump", "table:3"], "is not CHIP:ADDRESS:COUNT"),
    (["send.asm", "take.asm", "--dump", "2:0x300000:3"], "there is no chip 2; 0 to 1 are possible"),
    (["send.asm", "take.asm", "--dump", "1:0x300000:0"], "--dump: 0 words; 1 to 1000000 are possible"),
    (["send.asm", "take.asm", "--dump", "1:0x300000:1000001"], "--dump: 1000001 words; 1 to 1000000 are possible"),
    (["--network", "nowhere.toml"], "nowhere.toml: no such file"),
    (["--network", "nowhere.toml", "--until", "end"], "where a chip starts and ends are given in the file"),
])  # fmt: skip
def test_bad_commands(run: Any, arguments: list[str], message: str) -> None:
    result = run(*arguments)
    assert result.returncode == 2 and result.stdout == "" and message in result.stderr, result.stderr


def half_a_gigabyte() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (1 << 29, 1 << 29))


@pytest.mark.unsanitized
def test_a_long_run_without_an_event_needs_no_more_memory(emulator: Path, tmp_path: Path) -> None:
    """The check for endless loops keeps instructions. At 330 million cycles it looks for the sixth time."""
    (tmp_path / "counts.asm").write_text("start:\tldi 0,r0\nround:\taddi 1,r0\n\tb round\n")
    done = subprocess.run(
        [emulator, "exec", "counts.asm", "counts.asm", "--max-cycles", "380000000"],
        cwd=tmp_path, capture_output=True, text=True, check=False, preexec_fn=half_a_gigabyte,
    )  # fmt: skip
    assert done.returncode == 1 and "380000001 cycles" in done.stdout, done.stderr
