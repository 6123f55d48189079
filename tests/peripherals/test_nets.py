"""Nets between pins of chips. Expected values are counted by hand from docs/networks.md, Pins: an edge needs no time, a
receiver samples its pins at the start of each of its cycles, and the sample takes effect one cycle later."""

from __future__ import annotations

import json
import random
import subprocess
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import ChipSnapshot, Network, NetworkError

CYCLE = 50_000  # ps, of H1 at 40 MHz
HEAD = """
        .text
start:  ldhi 2fh,ar1            ; the vector table
        or 0fa00h,ar1
        ldpe ar1,ivtp
        ldhi 2fh,sp
        or 0fb00h,sp
        ldhi 10h,ar0            ; the peripherals
"""
END = "done:   b done\n"
EDGE, LEVEL = 0x9, 0xB  # of a nibble of IIF: an enabled interrupt
COUNT = "isr:    addi 1,r2\n        reti\n"


def assembled(text: str) -> Any:
    return c40.assemble(HEAD + text)


def clock(period: int, timer: int = 0) -> str:
    """A timer in clock mode with its output on: the pin goes low at once, and changes every 2 * period cycles."""
    base = 0x20 + 0x10 * timer
    return f"        ldi {period},r0\n        sti r0,*+ar0({base + 8:x}h)\n        ldi 3c1h,r0\n        sti r0,*+ar0({base:x}h)\n"


def listener(vector: int, setting: str, service: str = COUNT) -> Any:
    """Sleeps, and counts the interrupts of one vector in R2."""
    text = f"{setting}        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1({vector:x}h)\n"
    return assembled(text + "        or 2000h,st\nwait:   idle\n        b wait\n" + service)


def iiof(pin: int, nibble: int = EDGE) -> str:
    return f"        ldi 0{nibble << 4 * pin:x}h,iif\n"


def edges(network: Network) -> list[tuple[int, str]]:
    return [(event.time_ps, event.kind) for event in network.events if event.kind in ("rise", "fall")]


def interrupts(network: Network, chip: int) -> list[int]:
    return [event.time_ps for event in network.peripheral_events if event.kind == "interrupt" and event.chip == chip]


def low(network: Network, chip: int, register: str = "R2") -> int:
    """The integer in an extended-precision register."""
    return int(network.chips[chip].registers[register]) & 0xFFFFFFFF


def run(
    programs: list[Any],
    nets: list[str],
    until_us: float | None = None,
    script: Callable[[Network], None] = lambda network: None,
    **how: Any,
) -> Network:
    """The run. It must be the same in every order of turns, and wherever it is cut, also by a snapshot."""
    outcomes = []
    for order in (0, 5, 6):
        network = Network(programs, nets=nets, record_words=True, record_peripherals=True, turn_order=order, **how)
        script(network)
        if order == 6 and until_us is not None:
            for cut in sorted(random.Random(order).uniform(0, until_us) for _ in range(4)):
                network.run(until_us=cut)
            other = Network(programs, nets=nets, record_words=True, record_peripherals=True, turn_order=1, **how)
            other.restore(ChipSnapshot.from_bytes(network.snapshot().to_bytes()))
            network = other
        stop = network.run(until_us=until_us) if until_us is not None else network.run()
        outcomes.append(
            (
                stop,
                network.event_trace,
                network.nets,
                [(chip.status, chip.message, chip.cycles, chip.registers["R2"]) for chip in network.chips],
            )
        )
        assert outcomes[-1] == outcomes[0], order
    return network


# ---- timing ----


def test_an_edge_interrupts_a_sleeping_chip_one_cycle_later() -> None:
    network = run([assembled(clock(100) + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 100)
    falls = [at for at, kind in edges(network) if kind == "fall"]
    assert all(later - earlier == 400 * CYCLE for earlier, later in pairwise(falls)) and len(falls) == 5
    assert [at for at, kind in edges(network) if kind == "rise"] == [at + 200 * CYCLE for at in falls]
    assert interrupts(network, 1)[1:] == [
        at + CYCLE for at in falls[1:]
    ]  # at the first edge the chip does not sleep yet
    assert low(network, 1) == 5


@pytest.mark.parametrize("mhz", [33.0, 50.0, 60.0])
def test_a_receiver_looks_at_its_own_cycles(mhz: float) -> None:
    network = run([assembled(clock(100) + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 100, clocks_mhz=[40, mhz])
    falls = [at for at, kind in edges(network) if kind == "fall"]

    def looked(at: int) -> int:
        number = -(-at * int(mhz * 500_000) // 10**12)
        return (number + 1) * 10**12 // int(mhz * 500_000)

    assert interrupts(network, 1)[1:] == [looked(at) for at in falls[1:]]


def test_pulse_mode_gives_pulses_of_one_cycle() -> None:
    text = clock(50).replace("3c1h", "2c1h")
    network = run([assembled(text + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 50)
    rises = [at for at, kind in edges(network) if kind == "rise"]
    falls = [at for at, kind in edges(network) if kind == "fall"]
    assert len(rises) == 9 and falls[1:] == [
        at + CYCLE for at in rises
    ]  # the first falling edge is the one at which the timer takes the pin
    assert interrupts(network, 1)[1:] == [at + CYCLE for at in falls[1:]]


def test_a_short_pulse_is_missed_by_a_slow_receiver_and_counted() -> None:
    text = clock(50).replace("3c1h", "2c1h")
    network = run([assembled(text + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 50, clocks_mhz=[50, 34.7])
    (net,) = network.nets
    seen = sum(
        at > edges(network)[0][0] + CYCLE * 10 for at in interrupts(network, 1)
    )  # none at the edge at which the timer takes the pin
    assert net.missed == sum(event.kind == "missed" for event in network.events)
    assert seen > 0 < net.missed and seen + net.missed == sum(kind == "rise" for _, kind in edges(network))


# ---- effects ----


def test_a_level_interrupts_as_long_as_it_lasts() -> None:
    network = run(
        [listener(4, iiof(1, LEVEL))], ["wire: >0.IIOF1"], 60, lambda network: network.pulse("wire", 20, width_us=5)
    )
    fall, rise = edges(network)
    assert (fall, rise) == ((20_000_000, "fall"), (25_000_000, "rise"))
    taken = interrupts(network, 0)
    assert len(taken) > 3 and taken[0] == 20_000_000 + CYCLE and taken[-1] <= 25_000_000 + CYCLE + 4 * CYCLE


def test_nmi_needs_no_enabling() -> None:
    text = (
        "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(1)\nwait:   b wait\n"
        + COUNT
    )
    network = run(
        [assembled(text)],
        ["wire: >0.NMI"],
        60,
        lambda network: network.pulse("wire", 20, width_us=1, period_us=10, count=3),
    )
    assert low(network, 0) == 3
    assert [at // 10_000_000 for at in interrupts(network, 0)] == [2, 3, 4]


def test_a_general_purpose_input_reads_the_level() -> None:
    """FLAG of IIOF2 is bit 10 of IIF."""
    text = "wait:   ldi iif,r1\n        and 400h,r1\n        bnz wait\n        addi 1,r2\nback:   ldi iif,r1\n        and 400h,r1\n        bz back\n        b wait\n"
    network = run(
        [assembled("        ldi 0,iif\n        ldi 0,r2\n" + text)],
        ["wire: >0.IIOF2"],
        60,
        lambda network: network.pulse("wire", 20, width_us=5, period_us=10, count=3),
    )
    assert low(network, 0) == 3


def test_a_timer_counts_encoder_pulses_and_the_index_pulse_reads_it() -> None:
    """Timer 0 counts rising edges of its pin; the service routine of IIOF1 stores the count."""
    text = "        ldhi 0ffffh,r0\n        sti r0,*+ar0(28h)\n        ldi 0c1h,r0\n        sti r0,*+ar0(20h)\n" + iiof(
        1
    )
    program = listener(4, text, "isr:    addi 1,r2\n        ldi *+ar0(24h),r3\n        reti\n")

    def script(network: Network) -> None:
        network.pulse("encoder", 10, width_us=0.5, period_us=1, count=300)
        network.pulse("index", 110.6, width_us=0.5, period_us=100)

    network = run([program], ["encoder: >0.TCLK0", "index: >0.IIOF1"], 330, script)
    assert low(network, 0) == 3 and network.chips[0].peripherals["TIMER0.counter"] == 300
    assert low(network, 0, "R3") == 300  # from 310.6 us on; the last edge was at 309.5 + 0.5
    network = run([program], ["encoder: >0.TCLK0", "index: >0.IIOF1"], 250, script)
    assert low(network, 0, "R3") == 201  # edges at 10.5, 11.5, ... 210.5 us


def test_an_edge_lets_the_dma_move_a_word() -> None:
    """DMA channel 2, synchronised by IIOF2 (DIE code 4): one word per pulse."""
    start = (
        "        ldhi 10h,ar2\n        or 0c0h,ar2\n        ldhi 2fh,r0\n        or 0f800h,r0\n        sti r0,*+ar2(1)\n        ldi 1,r1\n"
        "        sti r1,*+ar2(2)\n        ldi 10,r1\n        sti r1,*+ar2(3)\n        addi 64,r0\n        sti r0,*+ar2(4)\n        ldi 1,r1\n        sti r1,*+ar2(5)\n"
        "        ldi 100h,iif\n        ldi 400h,die\n        ldhi 0c0h,r1\n        or 47h,r1\n        sti r1,*ar2\n        ldi 0,r2\n"
    )
    network = run(
        [assembled(start + "wait:   idle\n        b wait\n")],
        ["wire: >0.IIOF2"],
        200,
        lambda network: network.pulse("wire", 20, width_us=5, period_us=10, count=4),
    )
    assert network.chips[0].peripherals["DMA2.counter"] == 10 - 4


def test_one_chip_holds_another_in_reset_and_lets_it_start() -> None:
    """A net that is low at rest: chip 1 is held until chip 0 makes an output of IIOF1 and drives it high (IIF 60h; 20h
    drives low)."""
    master = assembled(
        "        ldi 99,rc\n        rpts rc\n        nop\n        ldi 60h,iif\n        ldi 99,rc\n        rpts rc\n        nop\n        ldi 20h,iif\n"
        + END
    )
    slave = assembled("        ldi 7,r2\n" + END)
    network = run([master, slave], ["reset: 0.IIOF1>1.RESET"], 30)
    kinds = [(event.kind, event.place) for event in network.events]
    assert kinds == [("rise", 0), ("fall", 0), ("hold", 1)] or kinds == [("fall", 0), ("hold", 1)]
    assert network.chips[1].status == "held" and low(network, 1) == 7


# ---- several drivers ----


def puller(delay: int, length: int) -> Any:
    """Drives IIOF1 low for a while: 20h is an output that is low, 60h one that is high."""
    wait = "        rpts {}\n        nop\n"
    return assembled(
        "        ldi 60h,iif\n"
        + wait.format(delay)
        + "        ldi 20h,iif\n"
        + wait.format(length)
        + "        ldi 60h,iif\n"
        + END
    )


def test_an_open_drain_net_is_low_while_one_pulls() -> None:
    alone = [run([puller(*times)], ["0.IIOF1>0.IIOF2"], 60) for times in ((100, 300), (200, 400))]
    falls, rises = [
        [[at for at, kind in edges(network) if kind == which] for network in alone] for which in ("fall", "rise")
    ]
    both = run([puller(100, 300), puller(200, 400), listener(3, iiof(0))], ["0.IIOF1&1.IIOF1>2.IIOF0"], 60)
    assert edges(both) == [(falls[0][0], "fall"), (rises[1][0], "rise")]
    assert interrupts(both, 2) == [falls[0][0] + CYCLE]


def test_an_input_that_is_made_an_output_is_a_fault() -> None:
    network = run(
        [assembled(clock(100) + END), assembled("        rpts 200\n        nop\n        ldi 20h,iif\n" + END)],
        ["sync: 0.TCLK0>1.IIOF1"],
        100,
    )
    assert network.chips[1].status == "fault"
    assert "pin IIOF1 becomes an output, and a net drives it" in network.chips[1].message


# ---- links beside nets ----


def test_a_word_that_is_asked_for_by_a_pin_interrupts_its_driver_that_runs_on() -> None:
    """Chip 0 alone is awake. Its timer's edges wake chip 1, which answers each by a word: ICRDY of port 0 (vector Eh)
    interrupts chip 0."""
    vector = "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(0eh)\n        ldi 4,iie\n        or 2000h,st\n"
    first = assembled(
        vector
        + clock(1000)
        + "wait:   addi 1,r4\n        b wait\nisr:    ldi *+ar0(41h),r1\n        addi 1,r2\n        reti\n"
    )
    second = listener(4, iiof(1), "isr:    addi 1,r2\n        sti r2,*+ar0(72h)\n        reti\n")
    network = run([first, second], ["0.TCLK0>1.IIOF1"], 1100, links=["0.0:1.3"])
    asked = [at for at, kind in edges(network) if kind == "fall"]
    # The time to take the interrupt, to store the word and to send it. Before the first word, chip 1 also has to get
    # the token.
    after = [answer - edge for answer, edge in zip(interrupts(network, 0), asked, strict=True)]
    assert len(after) == 6 and all(16 * CYCLE < cycles < 28 * CYCLE for cycles in after)


# ---- the end ----


def test_a_clock_that_nobody_heeds_does_not_keep_a_network_going() -> None:
    network = run([assembled(clock(100) + END), assembled(END)], ["0.TCLK0>1.IIOF1"])
    assert [chip.status for chip in network.chips] == ["halt", "halt"] and network.now_ps < 10_000_000


def test_a_sleeper_whose_net_is_still_has_come_to_rest() -> None:
    network = run([assembled(END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"])
    assert network.chips[1].status == "sleeping" and network.chips[1].message.endswith("until a pin interrupts it")


def test_pulses_to_come_keep_a_sleeper_waiting() -> None:
    network = run(
        [listener(4, iiof(1))], ["wire: >0.IIOF1"], None, lambda network: network.pulse("wire", 50_000, width_us=1)
    )
    assert low(network, 0) == 1


# ---- orders, cuts, snapshots ----


def random_network(seed: int, turn_order: int) -> Network:
    rng = random.Random(seed)
    chips = rng.randrange(2, 5)
    programs, nets, taken = [], [], set()
    linked = rng.random() < 0.5  # words go round a ring: chips wait at their ports while their pins change
    for _ in range(chips):
        text = clock(rng.randrange(3, 60)) if rng.random() < 0.6 else ""
        text += clock(rng.randrange(3, 60), 1).replace("3c1h", rng.choice(["3c1h", "2c1h", "0c1h", "1c1h"]))
        text += f"        ldhi 8000h,iie\n        ldhi 0,iif\n        or {rng.choice([0x9900, 0xB900, 0x9B00, 0x9960]):#x},iif\n"
        service = rng.choice([COUNT, "isr:    addi 1,r2\n        xor 40h,iif\n        reti\n"])
        relay = f"        ldhi 10h,ar3\n        or 40h,ar3\n        ldi {rng.randrange(2)},r7\n        bz wait\n        sti r7,*+ar3(2)\nwait:   ldi *+ar3(31h),r7\n        addi 1,r7\n        sti r7,*+ar3(2)\n        b wait\n"
        body = (
            relay
            if linked and rng.random() < 0.7
            else rng.choice(
                [
                    "wait:   idle\n        b wait\n",
                    "wait:   addi 1,r4\n        b wait\n",
                    "wait:   ldi *+ar0(24h),r5\n        addi r5,r6\n        b wait\n",
                ]
            )
        )
        vectors = "".join(f"        sti r0,*+ar1({vector:x}h)\n" for vector in (1, 2, 3, 4, 5, 6, 0x2B))
        programs.append(
            assembled(
                text
                + "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n"
                + vectors
                + "        or 2000h,st\n"
                + body
                + service
            )
        )

    def pin(names: list[str]) -> str:
        free = [f"{chip}.{name}" for chip in range(chips) for name in names if f"{chip}.{name}" not in taken]
        chosen = rng.choice(free)
        taken.add(chosen)
        return chosen

    for _ in range(rng.randrange(1, 2 * chips)):
        receivers = "+".join(pin(["IIOF2", "IIOF3", "NMI", "TCLK1"]) for _ in range(rng.choice([1, 1, 2])))
        drivers = (
            "&".join(pin(["TCLK0", "IIOF1"]) for _ in range(rng.choice([1, 1, 2])))
            if len(taken) < 3 * chips and rng.random() < 0.8
            else ""
        )
        nets.append(f"{drivers}>{receivers}")
    links = [f"{n}.0:{(n + 1) % chips}.3" for n in range(chips)] if linked else []
    made = Network(
        programs,
        links=links,
        nets=nets,
        clocks_mhz=[rng.choice([40, 50, 60, 33.333]) for _ in range(chips)],
        turn_order=turn_order,
        record_words=True,
        record_peripherals=True,
    )
    for number, net in enumerate(nets):
        if net.startswith(">"):
            made.pulse(number, rng.uniform(1, 20), width_us=rng.uniform(0.01, 1), period_us=rng.uniform(2, 20))
    for _ in range(rng.choice([0, 0, 2])):
        action = getattr(made, rng.choice(["hold", "release", "reset"]))
        action(rng.randrange(chips), rng.uniform(1, 60))
    return made


def outcome(made: Network) -> tuple[Any, ...]:
    chips = [
        (chip.status, chip.message, chip.pc, chip.cycles, chip.instructions, chip.causes, chip.peripherals)
        for chip in made.chips
    ]
    return made.now_ps, made.nets, chips, made.event_trace


def check(seed: int) -> None:
    one, other = random_network(seed, 0), random_network(seed, seed + 1)
    assert one.run(until_us=150) == other.run(until_us=150)
    assert outcome(one) == outcome(other)
    cut = random_network(seed, 0)
    rng = random.Random(seed)
    for at in sorted(rng.uniform(0, 150) for _ in range(5)):
        cut.run(until_us=at)
    resumed = random_network(seed, 2)
    resumed.restore(cut.snapshot())
    resumed.run(until_us=150)
    assert outcome(one) == outcome(resumed)


# 2389: a chip in IDLE that nothing can wake, held and released.
@pytest.mark.parametrize("seed", [*range(12), 2389])
def test_the_order_of_turns_and_cuts_change_nothing(seed: int) -> None:
    check(seed)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(12, 4000))
def test_the_order_of_turns_and_cuts_change_nothing_by_the_hundred(seed: int) -> None:
    check(seed)


# ---- bad input ----


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


# ---- command line and files ----


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


@pytest.mark.parametrize(("action", "message"), [
    ("10,pulse,index", "AT_US,pulse,NET,WIDTH_US[,PERIOD_US[,COUNT]] is expected"),
    ("10,pulse,index,x", "AT_US,pulse,NET,WIDTH_US[,PERIOD_US[,COUNT]] is expected"),
    ("10,pulse,index,1,2,0.5", "COUNT is an integer"),
    ("10,low,index,1", 'low has only a target; "1" is too much'),
    ("10,low,intex", "there is no net intex; index is expected"),
])  # fmt: skip
def test_actions_on_the_command_line_that_cannot_be(command: Any, action: str, message: str) -> None:
    done = command("count.asm", "--net", "index: >0.IIOF1", "--action", action)
    assert done.returncode == 2 and done.stdout == "" and message in done.stderr


def test_nets_of_a_file(command: Any) -> None:
    found = json.loads(command("--network", "net.toml", "--cycles", "2000", "--json").stdout)
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
