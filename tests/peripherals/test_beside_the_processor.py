"""DMA and timers beside a processor that runs, sleeps or waits: programs that were counted by hand from c40-hardware.md
3, 4 and 7.

The programs are in data/faults; their outcomes were computed by hand, not taken from a run. Each is run whole, cut
at random cycles, step by step, with the self-checks and as a member of a network: the outcome is the same.
"""

from __future__ import annotations

import itertools
import json
import random
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc._core import c40, toolchain
from cmrc.network import Network
from dma_chips import low

FAULTS = Path(__file__).parent / "data" / "faults"
TIMING = str(FAULTS / "timing-board.toml")
PERIOD_PS = 50_000


def loaded(
    name: str, board: str = "default", checks: bool = False, text: str | None = None, at: int | None = None
) -> tuple[Any, Any]:
    sections = {} if at is None else {".text": at}
    image = toolchain.assemble(text if text is not None else (FAULTS / name).read_text(), name, sections=sections)
    chip = c40.Processor(board, checks)
    chip.load_image(image)
    chip.record_events()
    return chip, image


def whole(chip: Any, cycles: int) -> None:
    chip.run(cycles - chip.cycle)


def cut(chip: Any, cycles: int) -> None:
    rng = random.Random(cycles)
    while chip.cycle < cycles:
        if chip.run(min(rng.choice([1, 2, 3, 7, 40, 333]), cycles - chip.cycle))["reason"] != "limit":
            return


def stepped(chip: Any, cycles: int) -> None:
    while chip.cycle < cycles:
        if chip.step()["reason"] != "limit":
            return


WAYS: dict[str, Callable[[Any, int], None]] = {"whole": whole, "cut": cut, "stepped": stepped}
ALONE = [*WAYS, "exact", "checked"]


def run_alone(way: str, name: str, cycles: int, board: str = "default", **more: Any) -> tuple[Any, Any]:
    chip, image = loaded(name, board, way == "checked", **more)
    chip.set_exact(way == "exact")
    WAYS.get(way, whole)(chip, cycles)
    assert sum(chip.causes.values()) == chip.cycle
    return chip, image


def cycles_of(chip: Any, kind: str) -> list[int]:
    return [cycle for what, cycle, *_ in chip.events if what == kind]


# ---- timers are served whatever the processor does


@pytest.mark.parametrize("way", ALONE)
def test_a_timer_wakes_a_processor_that_sleeps_beside_a_dma_block(way: str) -> None:
    chip, image = run_alone(way, "idle_dma2.asm", 1660)
    assert cycles_of(chip, "interrupt") == list(range(228, 1629, 200))
    assert cycles_of(chip, "timer")[:8] == cycles_of(chip, "interrupt")
    assert chip.pc == image.symbols["done"] and low(chip, "R10") == 8


def test_the_same_in_a_network_and_from_the_package() -> None:
    network = Network(
        [cmrc.c40.assemble_file(FAULTS / name) for name in ("idle_dma2.asm", "nop.asm")],
        links=["0.3:1.0"],
        record_peripherals=True,
    )
    network.run(until_us=200)
    assert [e.cycle for e in network.peripheral_events if e.kind == "interrupt"] == list(range(228, 1629, 200))
    assert network.chips[0].status == "halt" and 1640 < network.chips[0].cycles < 1655
    alone = cmrc.c40.Processor(cmrc.c40.assemble_file(FAULTS / "idle_dma2.asm"))
    alone.run(max_cycles=4000)
    assert alone.registers["R10"] & 0xFFFFFFFF == 8


@pytest.mark.parametrize(
    ("first", "second", "link", "end"),
    [("tsync_idle.asm", "nop.asm", "0.0:1.3", 4050), ("tsync_port.asm", "snd6000.asm", "0.3:1.0", 4030)],
)
def test_a_timer_drives_the_dma_of_a_processor_that_sleeps_or_waits(
    first: str, second: str, link: str, end: int
) -> None:
    """20 words, one per 200 cycles: the last is written some 4000 cycles after the start, while the processor sleeps or
    waits for a FIFO."""
    found = []
    for slice_us in (1000, 37, 1):
        network = Network(
            [cmrc.c40.assemble_file(FAULTS / name) for name in (first, second)], links=[link], record_peripherals=True
        )
        for n in itertools.count(1):
            if network.run(until_us=n * slice_us).reason != "limit" or n * slice_us >= 600:
                break
        ends = [e.cycle for e in network.peripheral_events if e.kind == "dma_end"]
        assert len(ends) == 1 and abs(ends[0] - end) < 40
        found.append((ends, network.chips[0].registers["R8"], network.chips[0].registers["R10"]))
    assert found[0] == found[1] == found[2]
    assert found[0][1] & 0xFFFFFFFF == 0


def test_a_network_gives_one_answer_however_its_run_is_cut() -> None:
    found = []
    for slice_us in (5000, 50, 7, 1):
        network = Network.from_file(FAULTS / "tur.toml", record_peripherals=True)
        for n in itertools.count(1):
            stop = network.run(until_us=n * slice_us)
            if stop.reason != "limit" or n * slice_us > 5000:
                break
        found.append(([(chip.status, chip.cycles, chip.causes) for chip in network.chips], network.event_trace))
    assert all(other == found[0] for other in found[1:])
    assert abs(found[0][0][0][1] - 8054) < 10


@pytest.mark.parametrize("way", ALONE)
def test_no_timer_event_is_missing_from_the_list(way: str) -> None:
    chip, _ = run_alone(way, "lost.asm", 900, TIMING)
    events = [cycle for cycle in cycles_of(chip, "timer") if cycle < 880]
    assert events == list(range(15, 880, 10))


# ---- one bus slot a word


@pytest.mark.parametrize("way", ALONE)
@pytest.mark.parametrize(
    ("name", "stalls"), [("fetch_dma_first.asm", 40), ("fetch_rotating.asm", 40), ("fetch_cpu_first.asm", 0)]
)
def test_a_dma_word_costs_a_fetch_one_slot_or_none(way: str, name: str, stalls: int) -> None:
    chip, _ = run_alone(way, name, 700, TIMING)
    assert (chip.causes["dma_conflict"], chip.causes["memory_conflict"]) == (stalls, 0)
    assert chip.peripheral("DMA0.counter") == 0
    if stalls == 0:
        assert max(cycles_of(chip, "dma_end")) < 175


# ---- reads of registers, and of the cache's control


@pytest.mark.parametrize("way", ALONE)
def test_a_read_of_a_timer_does_not_depend_on_an_unrelated_stall(way: str) -> None:
    values = [run_alone(way, name, 60)[0] for name in ("clampA.asm", "clampB.asm")]
    assert [low(chip, "R1") for chip in values] == [
        2,
        2,
    ]  # the counter ticks every second cycle, and E is four cycles after the start


@pytest.mark.parametrize("way", ["whole", "cut", "stepped", "exact"])
def test_a_frozen_cache_still_takes_the_words_that_were_fetched_before(way: str) -> None:
    chip, image = loaded("freeze.asm", TIMING, at=0x310000)
    chip.set_exact(way == "exact")
    chip.run(10_000, until=image.symbols["begin"])
    begun = chip.cycle
    chip.add_breakpoint(image.symbols["end"])
    while chip.pc != image.symbols["end"]:
        if way in ("whole", "exact"):
            chip.run(10_000)
        elif way == "cut":
            chip.run(3)
        else:
            chip.step()
    assert chip.cycle - begun - 8 == 102


# ---- a repeated block may not end with a branch


@pytest.mark.parametrize("way", ALONE)
def test_a_branch_at_the_end_of_a_repeated_block_is_a_fault_before_it_changes_anything(way: str) -> None:
    chip, image = run_alone(way, "rb.asm", 100)
    stop = chip.run(10)
    assert chip.halted and stop["reason"] == "limit"
    assert chip.pc == image.symbols["last"] and (low(chip, "R1"), chip.get("RC")) == (1, 10)
    alone, image = loaded("rb.asm")
    stop = alone.run(100)
    assert (stop["reason"], stop["kind"], stop["pc"]) == ("fault", "illegal_sequence", image.symbols["last"])


DELAYED = ["bd", "beqd", "bned", "beqaf", "beqat", "bneat", "bneaf"]


@pytest.mark.parametrize("passes", [0, 1, 5])
@pytest.mark.parametrize("distance", range(5))
@pytest.mark.parametrize("branch", [*DELAYED, "b", "beq", "bne", "call", "callne", "retsne", "idle", "trapne", "rpts"])
def test_what_may_stand_how_near_to_the_end(branch: str, distance: int, passes: int) -> None:
    """Taken or not, annulled or not, in the first pass or the last: a delayed branch from RE - 3 on, other program
    control at RE."""
    operand = {"rpts": " 2", "retsne": "", "idle": "", "trapne": " 5", "call": " out", "callne": " out"}.get(
        branch, " out"
    )
    body = [f"        {branch}{operand}" if n == distance else "        addi 1,r2" for n in range(distance, -1, -1)]
    body[-1] = "last:" + body[-1]
    text = (
        f"        .text\n        ldi {passes},rc\n        ldi 1,r0\n        rptb last\n"
        + "\n".join(body)
        + "\nout:    nop\n        nop\ndone:   bu done\n"
    )
    illegal = distance == 0 or (branch in DELAYED and distance <= 3)
    outcomes = []
    for way in ("whole", "stepped", "exact", "checked"):
        chip, image = loaded("near.asm", checks=way == "checked", text=text)
        chip.set("SP", 0x2FFB00)
        chip.set_exact(way == "exact")
        if way == "stepped":
            for _ in range(40):
                stop = chip.step()
                if stop["reason"] != "limit":
                    break
        else:
            stop = chip.run(60)
        outcomes.append(
            (
                stop["reason"],
                stop.get("kind"),
                stop.get("message") if stop["reason"] == "fault" else None,
                chip.pc if illegal else None,
            )
        )
        if illegal:
            assert (stop["reason"], stop["kind"]) == ("fault", "illegal_sequence")
            assert (
                chip.pc == image.symbols["last"] - distance and chip.get("RC") == passes and chip.get("SP") == 0x2FFB00
            )
    assert all(outcome == outcomes[0] for outcome in outcomes)


# ---- ends and deadlocks


def exec_json(emulator: Path, *arguments: str) -> tuple[int, dict[str, Any]]:
    result = subprocess.run(
        [emulator, "exec", *arguments, "--json"], capture_output=True, text=True, check=False, timeout=60, cwd=FAULTS
    )
    return result.returncode, json.loads(result.stdout)


def test_two_chips_that_write_before_they_read_are_a_deadlock(emulator: Path) -> None:
    """Eighteen words each: the FIFOs of both directions are full, and only the token goes to and fro."""
    for turn_order in (0, 1):
        network = Network([cmrc.c40.assemble_file(FAULTS / "dl2.asm")] * 2, links=["0.0:1.3"], turn_order=turn_order)
        assert network.run(until_us=10_000).reason == "deadlock"
        assert [chip.status for chip in network.chips] == ["waiting"] * 2
        assert [chip.waits_for for chip in network.chips] == [1, 0]
        assert all("waits for room in output FIFO" in chip.message for chip in network.chips)
    status, report = exec_json(emulator, "dl2.asm", "dl2.asm", "--link", "0.0:1.3")
    assert status == 1 and report["stop"]["reason"] == "deadlock"


def test_idle2_that_nothing_can_wake_ends_as_idle_does(emulator: Path, tmp_path: Path) -> None:
    stops = []
    for instruction in ("idle", "idle2"):
        (tmp_path / f"{instruction}.asm").write_text(
            f"        .text\nstart:  ldi 1,r0\n        {instruction}\n        bu start\n"
        )
        status, report = exec_json(emulator, str(tmp_path / f"{instruction}.asm"), "--max-cycles", "5000")
        network = Network([cmrc.c40.assemble_file(tmp_path / f"{instruction}.asm")] * 2, links=["0.0:1.3"])
        stops.append((status, report["stop"], network.run(until_us=1000), [chip.status for chip in network.chips]))
    assert stops[0] == stops[1]
    assert stops[0][1]["reason"] == "idle" and stops[0][3] == ["idle", "idle"]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("access", ["ldi *+ar0(1),r2", "sti r2,*+ar0(2)"])
def test_a_block_that_ends_in_the_cycle_of_an_access_to_a_port_ends_before_it(way: str, access: str) -> None:
    """A word goes to external memory by DMA 0; some cycles after the start, the processor accesses port 0."""
    together = 0
    for later in range(12):
        nops = "        nop\n" * later
        text = f"start:  ldhi 10h,ar0\n        or 40h,ar0\n        ldi 0,r2\n        sti r1,*+ar0(60h)\n{nops}        {access}\n        nop\ndone:   b done\n"
        chip, _ = loaded("beside.asm", text="        .text\n" + text, at=0x2FF900)
        for register, value in ((1, 0x2FFC00), (2, 1), (3, 1), (4, 0x40000000), (5, 1)):
            chip.poke(0x1000A0 + register, value)
        chip.set("R1", 3 << 22 | 1 << 2 | 1 << 18)
        chip.deliver(0, 7)
        WAYS[way](chip, 60)
        ((_, end, *_),) = (event for event in chip.events if event[0] == "dma_end")
        ((name, at, *_),) = (event for event in chip.events if event[0].startswith("port_"))
        order = [event[0] for event in chip.events if event[0] in ("dma_end", name)]
        assert order == (["dma_end", name] if end <= at else [name, "dma_end"])
        together += end == at
    assert together > 0


@pytest.mark.parametrize("way", ["whole", "stepped"])
@pytest.mark.parametrize(
    ("nops", "wait", "later"),
    [(0, 2, 2), (0, 3, 1), (0, 4, 0), (1, 1, 2), (1, 2, 1), (1, 3, 0), (2, 1, 1), (2, 2, 0), (2, 3, 0)],
)
def test_after_a_read_of_a_window_a_load_waits_for_the_dmas_write_on_its_bus(
    nops: int, wait: int, later: int, way: str
) -> None:
    """The store that starts the DMA executes in cycle 4. The DMA reads on the chip in cycle 5, and writes to the local
    bus, with one wait state, in cycles 6 to
    8. The load from the local bus behind a read of a window that takes `wait` cycles more would begin in cycle 5 + nops
       + wait: not before cycle 9 beside the DMA."""
    between = "        nop\n" * nops
    text = f"""        .text
start:  ldhi 10h,ar0
        ldhi 4000h,ar1
        ldhi 0C000h,ar3
        or 400h,ar1
        sti r1,*+ar0(0a0h)
{between}        ldi *ar3,r2
        ldi *ar1,r3
        ldi r3,r4
done:   b done
"""
    cycles = {}
    for started in (False, True):
        chip, image = loaded("window.asm", text=text, at=0x2FF900)
        for register, value in ((1, 0x2FFC00), (2, 1), (3, 1), (4, 0x40000000), (5, 1)):
            chip.poke(0x1000A0 + register, value)
        chip.set("R1", 3 << 22 | 1 << 2 | 1 << 18 if started else 0)
        done = image.symbols["done"]
        while (stop := chip.run(100, done) if way == "whole" else chip.step())[
            "reason"
        ] == "external_access" or chip.pc != done:
            if stop["reason"] == "external_access":
                chip.complete_read(5, 0, wait)
        cycles[started] = chip.cycle
    assert cycles[False] == 5 + nops + wait + 4
    assert cycles_of(chip, "dma_end") == [9]
    assert cycles[True] - cycles[False] == later == max(0, 9 - (5 + nops + wait))
