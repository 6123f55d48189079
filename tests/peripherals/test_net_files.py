"""Nets and actions in Python, on the command line and in a file, and the errors for those that cannot be."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cmrc.network import Network, NetworkError
from net_programs import COUNT, END, HEAD, assembled, clock, iiof


@pytest.mark.parametrize(("nets", "message"), [
    (["0.TCLK0"], "is not a net; DRIVER>RECEIVER is expected, as 0.TCLK0>1.IIOF1"),
    (["0.TCLK0>1.IIOF1>1.IIOF2"], "is not a net"),
    (["0.TCLK0>"], '"" is not a pin of a chip; CHIP.PIN is expected'),
    (["0.TCLK0>2.IIOF1"], "there is no chip 2; 0 or 1 is expected"),
    (["0.TCLK2>1.IIOF1"], "IIOF0 to IIOF3, TCLK0, TCLK1, NMI or RESET is expected"),
    (["0.NMI>1.IIOF1"], "0.NMI cannot drive it; IIOF and TCLK are outputs"),
    (["0.TCLK0+0.IIOF1>1.IIOF1"], "two pins drive it; an open-drain net is written with &"),
    (["0.TCLK0>1.IIOF1", "0.IIOF1>1.IIOF1"], "pin 1.IIOF1 is already on net 0"),
    (["0.TCLK0>1.IIOF1+1.IIOF1"], "pin 1.IIOF1 is in it twice"),
    (["0.TCLK0>1.IIOF1,1.IIOF2"], "(+ joins receivers, & joins drivers, as 0.IIOF1&1.IIOF1>2.IIOF0+2.IIOF2)"),
    (["0.TCLK0>1.IIOF1&1.IIOF2"], "(+ joins receivers, & joins drivers,"),
    (["0.IIOF1,1.IIOF1>1.IIOF2"], "(+ joins receivers, & joins drivers,"),
])  # fmt: skip
def test_nets_that_cannot_be(nets: list[str], message: str) -> None:
    with pytest.raises(NetworkError) as error:
        Network([assembled(END)] * 2, nets=nets)
    assert message in str(error.value)


def test_actions_that_cannot_be() -> None:
    network = Network([assembled(END)] * 2, nets=["sync: 0.TCLK0>1.IIOF1", "free: >1.IIOF2"])
    for wrong, message in (
        (lambda: network.drive("sync", True, 1), "sync (0.TCLK0>1.IIOF1) is driven by a chip"),
        (lambda: network.drive("snyc", True, 1), "there is no net snyc; sync, free is expected"),
        (lambda: network.drive(7, True, 1), "there is no net 7; the network has 2"),
        (lambda: network.pulse("free", 1, width_us=0), "a width of more than 0 us is expected"),
        (
            lambda: network.pulse("free", 1, width_us=3, period_us=3, count=2),
            "a period of more than the width is expected",
        ),
        (lambda: network.pulse("free", 1, width_us=3, period_us=2), "a period of more than the width is expected"),
    ):
        with pytest.raises(NetworkError) as error:
            wrong()
        assert message in str(error.value)


FILE = """
[[chip]]
name = "root"
program = "clock.asm"
[[chip]]
program = "count.asm"
[[net]]
name = "sync"
drivers = "root.TCLK0"
receivers = ["1.IIOF1"]
[[net]]
name = "line"
receivers = ["1.IIOF2"]
rest = "low"
[[event]]
at_us = 10
action = "pulse"
net = "line"
width_us = 2
period_us = 10
count = 3
"""


@pytest.fixture
def command(emulator: Path, tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """`emulator exec` in a folder with clock.asm, count.asm and net.toml."""
    (tmp_path / "clock.asm").write_text(HEAD + clock(100) + END)
    text = f"{iiof(1)}        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(4)\n        or 2000h,st\nwait:   idle\n        b wait\n"
    (tmp_path / "count.asm").write_text(HEAD + text + COUNT)

    def run(*arguments: str, file: str = FILE) -> subprocess.CompletedProcess[str]:
        (tmp_path / "net.toml").write_text(file)
        return subprocess.run(
            [emulator, "exec", *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
        )

    return run


def test_a_net_and_an_action_on_the_command_line(command: Any) -> None:
    done = command("count.asm", "--net", "index: >0.IIOF1", "--action", "10,pulse,index,1,20,3", "--json")
    found = json.loads(done.stdout)
    assert done.returncode == 0 and found["chips"][0]["registers"]["R2"] & 0xFFFFFFFF == 3
    assert found["nets"] == [{"name": "index", "pins": ">0.IIOF1", "level": 1, "edges": 6, "missed": 0}]
    text = command("clock.asm", "count.asm", "--net", "0.TCLK0>1.IIOF1", "--cycles", "2000").stdout
    assert "net 0 (0.TCLK0>1.IIOF1): high, 10 edges\n" in text


@pytest.mark.parametrize(("count", "says"), [(1, "2 edges, 1 pulse"), (3, "6 edges, 3 pulses")])
def test_a_missed_pulse_is_counted_once(command: Any, tmp_path: Path, count: int, says: str) -> None:
    """It has two edges. A chip of 40 MHz looks every 50 ns."""
    (tmp_path / "spin.asm").write_text("start: nop\n br start\n")
    pulses = ["--action", f"5.01,pulse,p,0.02,0.1,{count}", "--cycles", "200"]
    text = command("spin.asm", "--net", "p: >0.IIOF2", *pulses).stdout
    assert f"net p (>0.IIOF2): high, {says} missed by a receiver\n" in text


def test_the_first_thousand_missed_pulses_of_a_net_are_events_and_all_are_counted(command: Any, tmp_path: Path) -> None:
    """Pulses of 10 ns every 20 ns: a chip that looks every 50 ns misses nearly all, for as long as they last."""
    (tmp_path / "spin.asm").write_text("start: nop\n br start\n")
    run = ["spin.asm", "--net", "x: >0.IIOF2", "--net", "y: >0.IIOF3", "--action", "0,pulse,x,0.01,0.02,20000"]
    run += ["--action", "0,pulse,y,0.01,0.02,600", "--cycles", "10000", "--json"]
    found = json.loads(command(*run).stdout)
    missed = {net["name"]: net["missed"] for net in found["nets"]}
    assert missed["x"] > 10000 and 0 < missed["y"] <= 1000
    for name, count in missed.items():
        assert sum(f"missed {name}" in event for event in found["events"]) == min(count, 1000), name


@pytest.mark.parametrize(("action", "message"), [
    ("10,pulse,index", "AT_US,pulse,NET,WIDTH_US[,PERIOD_US[,COUNT]] is expected"),
    ("10,pulse,index,x", "AT_US,pulse,NET,WIDTH_US[,PERIOD_US[,COUNT]] is expected"),
    ("10,pulse,index,1,2,0.5", "COUNT is an integer"),
    ("10,pulse,index,1,2,0", "COUNT is an integer"),
    ("10,low,index,1", 'low has only a target; "1" is too much'),
    ("10,low,intex", "there is no net intex; index is expected"),
])  # fmt: skip
def test_actions_on_the_command_line_that_cannot_be(command: Any, action: str, message: str) -> None:
    done = command("count.asm", "--net", "index: >0.IIOF1", "--action", action)
    assert done.returncode == 2 and done.stdout == "" and message in done.stderr


@pytest.mark.parametrize("driver", ["root.TCLK0", "0.TCLK0"])  # a chip with a name has its number, too
def test_nets_of_a_file(command: Any, driver: str) -> None:
    file = FILE.replace("root.TCLK0", driver)
    found = json.loads(command("--network", "net.toml", "--cycles", "2000", "--json", file=file).stdout)
    assert [(net["name"], net["pins"], net["level"], net["edges"]) for net in found["nets"]] == [
        ("sync", "0.TCLK0>1.IIOF1", 1, 10),
        ("line", ">1.IIOF2", 0, 6),
    ]


@pytest.mark.parametrize(("old", "new", "message"), [
    ('drivers = "root.TCLK0"', 'drivers = "rot.TCLK0"', "net.toml:9: net.drivers: \"rot.TCLK0\" is not a pin of a chip; there is no chip rot; root or 1 is expected"),
    ('rest = "low"', 'rest = "down"', 'net.toml:14: net.rest: "high" or "low" is expected'),
    ('rest = "low"', "open_drain = 1", "net.toml:14: net.open_drain: true or false is expected"),
    ('receivers = ["1.IIOF2"]', 'receivers = ["1.IIOF1"]', "net.toml:11: net line (>1.IIOF1): pin 1.IIOF1 is already on net sync"),
    ('net = "line"', 'chip = "root"', "net.toml:18: event: pulse needs a net"),
    ("width_us = 2\n", "", "net.toml:15: event: width_us is missing"),
    ('action = "pulse"', 'action = "low"', "only a pulse has one"),
    ('receivers = ["1.IIOF2"]\n', "", "net.toml:11: net: receivers is missing"),
])  # fmt: skip
def test_files_that_cannot_be(command: Any, old: str, new: str, message: str) -> None:
    assert old in FILE
    done = command("--network", "net.toml", file=FILE.replace(old, new))
    assert done.returncode == 2 and message in done.stderr, done.stderr
