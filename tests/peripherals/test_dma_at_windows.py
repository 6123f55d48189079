"""A chip whose DMA, or whose processor beside it, is at a window: how a run is cut, the order of turns and the way in
which a program is run change nothing, and every run ends."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network, SharedMemory
from hang_guard import within

SHARED, OTHER = 0x70000000, 0xC0000000

BOARD = """
name = "two devices"
[[region]]
name = "local"
base = 0x300000
words = 0x1000
bus = "local"
[[region]]
name = "w1"
kind = "window"
base = 0x70000000
words = 0x10000
bus = "local"
[[region]]
name = "global"
base = 0x80000000
words = 0x1000
bus = "global"
[[region]]
name = "w2"
kind = "window"
base = 0xC0000000
words = 0x10000
bus = "global"
[[device]]
name = "R1"
kind = "registers"
base = 0x70000000
words = 16
waits = 1
[[device]]
name = "R2"
kind = "registers"
base = 0xC0000000
words = 16
waits = 2
"""


def copy(source: int, destination: int, words: int, priority: int, channel: int = 5) -> str:
    """Starts a DMA channel; the addresses stay, but for memory."""
    base = 0xA0 + 16 * channel
    control = 0x00C40004 | priority
    values = ((1, source), (4, destination), (3, words), (0, control))
    return "".join(
        f"        ldhi 0{value >> 16:x}h,r9\n        or 0{value & 0xFFFF:x}h,r9\n        sti r9,*+ar6(0{base + at:x}h)\n"
        for at, value in values
    )


def program(text: str) -> Any:
    head = "        .text\nstart:  ldhi 10h,ar6\n        ldhi 7000h,ar4\n        ldhi 0c000h,ar5\n"
    return c40.assemble(head + text + "end:    bu end\n")


def shared(chips: int) -> list[SharedMemory]:
    return [SharedMemory("s", 16, dict.fromkeys(range(chips), SHARED), waits=1)]


@pytest.mark.parametrize("priority", [0, 1, 3])
def test_a_dma_that_finds_a_shared_memory_busy_waits(priority: int) -> None:
    """Whatever the phase in which the other chip reads: every word is copied, and the run ends."""

    def run(nops: int, order: int) -> tuple[Any, ...]:
        reader = program("        nop\n" * nops + "        ldi *ar4,r1\n")
        mover = program(copy(SHARED, 0x80000000, 20, priority))
        network = Network([reader, mover], memories=shared(2), turn_order=order)
        stop = network.run()
        return stop.reason, stop.time_ps, network.chips[1].peripherals["DMA5.counter"], network.event_trace

    for nops in range(4, 16):
        results = within(20, lambda nops=nops: [run(nops, order) for order in (0, 1, 2)])
        assert results[0][0] == "ended" and results[0][2] == 0
        assert results[1:] == results[:1] * 2


ARMED = """
        ldhi 4000h,r10
        ldi r10,die
        ldi 10,r9
        sti r9,*+ar6(0d3h)
        ldhi 30h,r9
        or 800h,r9
        sti r9,*+ar6(0d4h)
        ldhi 10h,r9
        or 71h,r9
        sti r9,*+ar6(0d1h)
        ldhi 0c4h,r9
        or 44h,r9
        sti r9,*+ar6(0d0h)
loop:   nop
        addi 1,r0
        addi 1,r1
        bu loop
"""


@pytest.mark.parametrize("net", ["0.IIOF0>1.NMI", "0.TCLK0>1.IIOF1"])
def test_a_chip_that_drives_a_net_beside_its_dma_reaches_every_limit(net: str) -> None:
    """The DMA waits for a word that does not come; or it copies endlessly."""
    busy = copy(0x80000000, 0x80000100, 0, 0) + "loop:   nop\n        addi 1,r0\n        bu loop\n"
    for text in (ARMED, busy):

        def run(cycle: int, text: str = text) -> list[int]:
            network = Network([program(text), program("loop:   nop\n        bu loop\n")], nets=[net])
            network.run(until_us=cycle / 20)
            return [chip.cycles for chip in network.chips]

        for cycle in range(298, 310):
            assert min(within(20, lambda run=run, cycle=cycle: run(cycle))) >= cycle


BODIES = {
    "two loads": "        ldi *+ar4(1),r1\n     || ldi *ar5,r2\n",
    "load and store": "        ldi *ar5,r3\n     || sti r2,*ar4\n",
    "two stores": "        sti r3,*ar5\n     || sti r2,*ar4\n",
    "multiply": "        mpyi3 *ar4,*ar5,r1\n",
    "one store": "        sti r2,*ar5\n",
    "one load": "        ldi *ar5,r2\n",
}
MEMORY, R1, R2 = 0x80000000, 0x70000004, 0xC0000004


@pytest.fixture
def board(tmp_path: Path) -> Path:
    path = tmp_path / "board.toml"
    path.write_text(BOARD)
    return path


def ends(chip: c40.Processor) -> tuple[Any, ...]:
    return chip.cycles, chip.causes, chip.registers, chip.peripherals


@pytest.mark.parametrize("priority", [0, 1, 3])
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(("source", "destination"), [(MEMORY, R2), (MEMORY, R1), (R1, MEMORY), (R1, R2), (R2, R2)])
def test_one_chip_is_the_same_however_its_run_is_cut(
    board: Path, body: str, priority: int, source: int, destination: int
) -> None:
    text = BODIES[body]
    for phase in range(0, 6, 2):
        image = program(
            copy(source, destination, 12, priority) + "        nop\n" * phase + text + "        nop\n" + text
        )
        whole = c40.Processor(image, board=board)
        assert whole.run(until="end").reason == "until"
        for piece in (1, 2, 5):
            cut = c40.Processor(image, board=board)
            while cut.run(piece, until="end").reason == "limit":
                pass
            assert ends(cut) == ends(whole), (phase, piece)
        stepped = c40.Processor(image, board=board)
        while stepped.pc != stepped.address("end"):
            before = stepped.instructions
            stepped.step()
            assert stepped.instructions - before <= 1
        assert ends(stepped)[:3] == ends(whole)[:3], phase


@pytest.mark.parametrize("body", BODIES)
def test_a_processor_with_the_higher_priority_waits_for_one_access_of_the_dma_at_most(board: Path, body: str) -> None:
    """Before each of its own accesses (c40-hardware.md 3.4: with PRI 00 it wins each conflict)."""
    text = BODIES[body]
    alone = c40.Processor(program(copy(MEMORY, R2, 0, 0).replace("0c4h", "0") + text), board=board)
    alone.run(until="end")
    beside = c40.Processor(program(copy(MEMORY, R2, 200, 0) + text), board=board)
    beside.run(until="end")
    assert beside.cycles <= alone.cycles + 2 * 6
    assert beside.peripheral("DMA5.counter") > 190


TIMER = """
        ldi 50,r9
        sti r9,*+ar6(38h)
        ldi 2c1h,r9
        sti r9,*+ar6(30h)
{armed}
        ldi *+ar6(51h),r7
"""


@pytest.mark.parametrize(
    ("armed", "action", "expected"),
    [(a, *row) for a in (True, False) for row in (("", 19), ("reset", 19), ("hold", 9))],
)
def test_timers_go_on_while_the_processor_waits_at_a_port(armed: bool, action: str, expected: int) -> None:
    """An event every 5 us, up to 100 us: wherever the run is cut, and whatever happens to the chip at 48 us."""
    arm = "        ldhi 0c4h,r9\n        or 0c4h,r9\n        sti r9,*+ar6(0e0h)\n" if armed else ""
    images = [program(TIMER.format(armed=arm)), program("loop:   nop\n        bu loop\n")]
    for cut in (None, 10, 30, 47.95, 48, 60):
        network = Network(images, links=["0.1:1.3"], record_peripherals=True)
        if action:
            getattr(network, action)(0, 48)
        if cut is not None:
            network.run(until_us=cut)
        network.run(until_us=100)
        assert sum("timer" in event for event in network.event_trace) == expected, cut


# What the network of the random test is made of.
SOURCES = (SHARED, SHARED + 3, OTHER, 0x80000000, 0x300800)
INSTRUCTIONS = (
    *BODIES.values(),
    "        ldi *ar4,r1\n        xor r1,r3\n",
    "        nop\n        nop\n        nop\n",
    "        ldi 96h,iif\n        ldi 92h,iif\n",
    "        ldi *+ar6(24h),r1\n        xor iif,r3\n",
    "        sti r3,*+ar4(1)\n        ldi *ar4,r1\n",
)


def random_network(seed: int, turn_order: int) -> Network:
    """A chip with a DMA at two shared memories, others that read and write them, and nets that the first drives."""
    rng = random.Random(seed)
    chips = rng.randrange(1, 4)
    programs = []
    for chip in range(chips):
        period, mode = rng.randrange(2, 30), rng.choice(["2c1h", "3c1h"])
        text = f"        ldi {period},r9\n        sti r9,*+ar6(28h)\n        ldi {mode},r9\n        sti r9,*+ar6(20h)\n"
        text += f"        ldi {rng.randrange(1, 4)},ar7\nagain:  nop\n"
        for _ in range(rng.randrange(3, 9)):
            if chip == 0 and rng.random() < 0.4:
                ends = rng.choice(SOURCES), rng.choice(SOURCES)
                text += copy(*ends, rng.choice([1, 5, 20]), rng.choice([0, 1, 3]), rng.randrange(6))
            text += rng.choice(INSTRUCTIONS)
        programs.append(program(text + "        dbu ar7,again\n"))
    everywhere = range(chips)
    memories = [
        SharedMemory("s", 16, dict.fromkeys(everywhere, SHARED), waits=rng.randrange(4)),
        SharedMemory("o", 16, dict.fromkeys(everywhere, OTHER), waits=rng.randrange(3)),
    ]
    nets = ["0.IIOF0>1.IIOF1", f"0.TCLK0>{chips - 1}.IIOF2"][: rng.randrange(3)] if chips > 1 else []
    clocks = [rng.choice([40, 50, 33.333]) for _ in range(chips)]
    return Network(
        programs, memories=memories, nets=nets, clocks_mhz=clocks, turn_order=turn_order, record_peripherals=True
    )


def seen(network: Network) -> tuple[Any, ...]:
    chips = [
        (c.status, c.pc, c.cycles, c.instructions, dict(c.causes), dict(c.registers), dict(c.peripherals))
        for c in network.chips
    ]
    return network.now_ps, chips, [list(network.memory(n)) for n in (0, 1)], network.event_trace


END_US = 60


def outcomes(seed: int) -> tuple[tuple[Any, ...], list[tuple[Any, ...]]]:
    """Of the whole run, and of the same in other ways."""
    whole = random_network(seed, 0)
    whole.run(until_us=END_US)
    others = []
    for order in range(3):
        cut = random_network(seed, order)
        rng = random.Random(seed + order)
        for at in sorted(rng.uniform(0, END_US / 3) for _ in range(5)):
            cut.run(until_us=at)
        cut.run(until_us=END_US)
        others.append(seen(cut))
    return seen(whole), others


# At the end of 197 and 990 a timer at a net and another chip do something at one instant.
@pytest.mark.parametrize("seed", [*range(40), 197, 990])
def test_the_order_of_turns_and_cuts_change_nothing(seed: int) -> None:
    whole, others = within(20, lambda: outcomes(seed))
    for other in others:
        assert other == whole


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(40, 1500))
def test_the_order_of_turns_and_cuts_change_nothing_by_the_hundred(seed: int) -> None:
    whole, others = within(20, lambda: outcomes(seed))
    for other in others:
        assert other == whole
