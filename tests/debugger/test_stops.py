"""The debugger's stops against the full trace; its display against a run without a debugger."""

import random
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40 as package
from cmrc.debug import Debugger, Hit
from cmrc.network import Network
from locations import ROOT
from nasty_programs import CYCLES, DATA, generate
from nasty_runs import Bench, assembled, made, state

CYCLE_PS = 50_000
SEEDS = [*range(30), *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(30, 1000))]
EXAMPLES = sorted(
    [
        *(ROOT / "c40_programs" / "examples").glob("*.asm"),
        *(ROOT / "c40_programs" / "examples" / "peripherals").glob("*.asm"),
    ]
)


def program_without_pins(seed: int) -> Any:
    """Pins are raised by hand, which a debugger does not."""
    return replace(generate(seed), pins=())


def debugger_of(chip: Any, image: Any) -> Debugger:
    return Debugger(chip.debug(image))


def by_trace(chip: Any, cycles: int) -> list[dict[str, Any]]:
    return [record for record in chip.trace(cycles) if "pc" in record]


def instant(debugger: Debugger) -> int:
    assert debugger.stop.time_ps % CYCLE_PS == 0
    return debugger.stop.time_ps // CYCLE_PS


def stops_until_the_end(debugger: Debugger) -> Iterator[tuple[int, tuple[Hit, ...]]]:
    while (stop := debugger.go(CYCLES * CYCLE_PS * 1e-12)).hits:
        yield instant(debugger), stop.hits


@pytest.mark.parametrize("seed", SEEDS)
def test_breakpoints_stop_before_each_of_their_instructions(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    program = program_without_pins(seed)
    board, image = Bench(tmp_path).board(program), assembled(program)
    records = by_trace(made(program, board, image), CYCLES)
    executed = sorted({record["pc"] for record in records})
    chosen = set(rng.sample(executed, min(len(executed), rng.choice([1, 3, len(executed)]))))
    chip = made(program, board, image)
    debugger = debugger_of(chip, image)
    for address in chosen:
        debugger.break_at(address)
    found = []
    for cycle, hits in stops_until_the_end(debugger):
        assert [hit.pc for hit in hits] == [chip.pc], seed
        found.append((cycle, chip.pc))
    if "branches to itself" in debugger.stop.text:  # which is met once, and nothing else comes
        again = sum(1 for _ in takewhile(lambda record: record["pc"] == chip.pc, reversed(records)))
        assert again > 1
        records = records[: len(records) - again + 1]
    assert found == [
        (record["cycle"], record["pc"]) for record in records if record["pc"] in chosen and 0 < record["cycle"] < CYCLES
    ], seed


@pytest.mark.parametrize("seed", SEEDS)
def test_a_step_onto_a_breakpoint_has_met_it(seed: int, tmp_path: Path) -> None:
    """Each step executes one instruction, and says so where it has come to a breakpoint; ``go`` looks for later
    ones."""
    rng = random.Random(seed)
    program = program_without_pins(seed)
    board, image = Bench(tmp_path).board(program), assembled(program)
    records = by_trace(made(program, board, image), CYCLES)
    chosen = set(rng.sample(sorted({record["pc"] for record in records}), 3))
    chip = made(program, board, image)
    debugger = debugger_of(chip, image)
    for address in chosen:
        debugger.break_at(address)
    met = 0
    for before, record in pairwise(records[:60]):
        if before["cycle"] + before["cycles"] != record["cycle"]:
            break  # an interrupt is between them
        stop = debugger.step()
        if stop.reason == "over":  # a fault
            return
        assert (instant(debugger), chip.pc) == (record["cycle"], record["pc"]), seed
        assert stop.reason == ("breakpoint" if record["pc"] in chosen else "step"), seed
        assert [hit.pc for hit in stop.hits] == [record["pc"]] * (record["pc"] in chosen)
        met += len(stop.hits)
    later = [record["cycle"] for record in records if record["pc"] in chosen and record["cycle"] > instant(debugger)]
    stop = debugger.go(CYCLES * CYCLE_PS * 1e-12)
    assert [instant(debugger)] * len(stop.hits) == [cycle for cycle in later[:1] if cycle < CYCLES], seed
    assert sum(debugger.hits().values()) == met + len(stop.hits)


@pytest.mark.parametrize("step", ["over", "line", "next_line"])
def test_steps_over_calls_and_lines_go_on_from_a_breakpoint_that_they_have_met(step: str) -> None:
    image = package.assemble("start:  ldi 0,r0\nloop:   addi 1,r0\n        addi 2,r1\n        b loop\n")
    debugger = package.Processor(image).debug()
    debugger.break_at("loop")
    debugger.break_at("loop+1", condition="r0 == 2")
    reasons = [(debugger.step(step).reason, debugger.value("pc - start")) for _ in range(6)]
    assert reasons == [("breakpoint", 1), ("step", 2), ("step", 3), ("breakpoint", 1), ("breakpoint", 2), ("step", 3)]


def test_a_stop_goes_on_where_each_of_its_functions_says_so() -> None:
    image = package.assemble("start:  ldi 0,r0\nloop:   addi 1,r0\n        b loop\n")
    called: list[tuple[int, bool]] = []
    for first, second in ((True, True), (True, False), (False, True), (True, None)):
        debugger = package.Processor(image).debug()
        for answer in (first, second):
            number = debugger.break_at("loop", condition="r0 < 3")
            if answer is not None:  # a condition without a function stops
                debugger.call(
                    number, lambda _, number=number, answer=answer: (called.append((number, answer)), answer)[1]
                )
        stop = debugger.go(20e-6)
        stays = (first, second) != (True, True)
        assert (stop.reason == "breakpoint") == stays and debugger.value("r0") == 0 or not stays, (first, second)
        assert len(called) == (1 if second is None else 2 if stays else 6)  # each is called
        called.clear()


def test_a_command_without_a_chip_means_that_of_the_last_stop() -> None:
    image = package.assemble("start:  ldi 0,r0\nloop:   addi 1,r0\n        b loop\n")
    debugger = Network([image, image]).debug()
    debugger.break_at("loop", chip=1, condition="r0 == 2")
    assert debugger.go().chip == 1
    debugger.set_register("r1", 7)
    assert (debugger.value("r1"), debugger.value("chip1.r1"), debugger.value("r1", chip=0)) == (7, 7, 2)  # of chips
    assert debugger.step().chip == 1 and debugger.value("pc - loop") == 1


def test_an_instant_in_seconds_is_the_nearest_picosecond() -> None:
    image = package.assemble("start:  ldi 0,r0\nloop:   addi 1,r0\n        b loop\n")
    with package.Processor(image).debug() as debugger:
        assert 65e-6 * 1e12 < 65_000_000 and debugger.go_to(65e-6).time_ps == 65_000_000
    assert not debugger.open
    with pytest.raises(RuntimeError, match="this debugger is closed"):
        debugger.go()


def test_a_step_stops_at_breakpoints_of_all_chips_of_its_instant() -> None:
    image = package.assemble("start:  ldi 0,r0\nloop:   addi 1,r0\n        b loop\n")
    debugger = Network([image, image]).debug()
    debugger.break_at("loop", chip=1)
    stop = debugger.step(chip=0)
    assert (stop.reason, [hit.chip for hit in stop.hits]) == ("breakpoint", [1])
    at = stop.time_ps
    assert debugger.step(chip=1).time_ps > at and debugger.go().time_ps > at + CYCLE_PS


@pytest.mark.parametrize("seed", SEEDS)
def test_watchpoints_stop_after_each_access_of_the_processor(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    program = program_without_pins(seed)
    board, image = Bench(tmp_path).board(program), assembled(program)
    records = by_trace(made(program, board, image), CYCLES)
    touched = sorted({address for record in records for _, address, _ in record["memory"]})
    if not touched:
        pytest.skip("this program touches no memory")
    first = rng.choice(touched)
    words = rng.choice([1, 1, 5])
    on = rng.choice(["write", "read", "access"])
    letters = {"write": "w", "read": "r", "access": "rw"}[on]
    debugger = debugger_of(made(program, board, image), image)
    debugger.watch(first, words, on=on)
    expected = []
    for record in records:
        end = record["cycle"] + record["cycles"]
        for how, address, value in record["memory"]:
            if how in letters and first <= address < first + words and end <= CYCLES:
                expected.append((end, record["pc"], value))
    found = [
        (cycle, hit.pc, hit.value)
        for cycle, hits in stops_until_the_end(debugger)
        for hit in hits
        if "DMA" not in hit.text and "interrupt" not in hit.text
    ]
    # An instruction that crosses the end is looked at by the trace only.
    assert found == [hit for hit in expected if hit in found or hit[0] < CYCLES], seed


def test_a_watch_for_writes_sees_the_return_address_of_an_interrupt() -> None:
    image = package.assemble(
        """
        .text
start:  ldhi 2fh,ar1
        or 0fa00h,ar1
        ldpe ar1,ivtp
        ldhi 2fh,sp
        or 0fb00h,sp
        ldhi hi16(isr),r0
        or lo16(isr),r0
        sti r0,*+ar1(2)
        ldhi 10h,ar0
        ldi 20,r0
        sti r0,*+ar0(28h)
        ldi 3c1h,r0
        sti r0,*+ar0(20h)
        ldi 1,iie
        or 2000h,st
wait:   b wait
isr:    reti
"""
    )
    debugger = package.Processor(image).debug()
    debugger.watch(0x2FFB01, on="write")
    [hit] = debugger.go(1e-3).hits
    assert "interrupt" in hit.text and image.symbols["wait"] <= hit.value <= image.symbols["wait"] + 3


def test_a_watch_stops_after_every_word_of_a_dma() -> None:
    """Channel 0 moves 40 words on chip, without a chain: c40-hardware.md 3."""
    source, destination, words = 0x2FF800, 0x2FF900, 40
    program = package.assemble(
        f"""
        .text
start:  ldhi 10h,ar0
        or 0a0h,ar0
        ldp values
        ldi @values,r0
        ldi @values+1,r1
        ldi @values+2,r2
        ldi 1,r3
        sti r0,*+ar0(1)
        sti r3,*+ar0(2)
        sti r2,*+ar0(3)
        sti r1,*+ar0(4)
        sti r3,*+ar0(5)
        ldi @values+3,r4
        sti r4,*ar0
loop:   bu loop
values: .word {source}, {destination}, {words}, 00c00008h
        """
    )
    chip = package.Processor(program)
    for n in range(words):
        chip.memory[source + n] = 100 + n
    debugger = chip.debug()
    debugger.watch(destination, words)
    times = []
    for n in range(words):
        stop = debugger.go()
        (hit,) = stop.hits
        assert "DMA channel 0" in hit.text and hit.value == 100 + n
        # The branch under way is executed whole, and the DMA beside it: four cycles, two words.
        moved = sum(debugger.word(destination + k) != 0 for k in range(words))
        assert n + 1 <= moved <= n + 3
        assert [debugger.word(destination + k) for k in range(n + 1)] == [100 + k for k in range(n + 1)]
        times.append(stop.time_ps)
    assert times == sorted(set(times))
    assert not debugger.go(times[-1] * 1e-12 + 1e-4).hits
    writer = debugger.last_write(destination + 7)
    assert writer is not None and "DMA channel 0" in writer.text and writer.time_ps == times[7]


@pytest.mark.parametrize("seed", range(8))
def test_a_word_of_a_dma_is_there_at_the_stop_and_not_before(seed: int) -> None:
    rng = random.Random(seed)
    beside = ["nop", "addi 1,r1", "sti r1,@tab", "mpyi 3,r3", "rpts 3\n        addi 1,r4", "ldi @src,r2"]
    body = "".join(f"        {rng.choice(beside)}\n" for _ in range(30))
    program = package.assemble(f"""
        .data
src:    .word 11,22,33,44
dst:    .space 4
tab:    .word 00c40004h, src, 1, 4, dst, 1, 0, 0
        .text
start:  ldpk hi16(tab)
        ldhi 10h,ar1
        or 0a0h,ar1
        ldi @tab+1,r0
        sti r0,*+ar1(1)
        ldi 1,r0
        sti r0,*+ar1(2)
        sti r0,*+ar1(5)
        ldi 4,r0
        sti r0,*+ar1(3)
        ldi @tab+4,r0
        sti r0,*+ar1(4)
        ldi @tab,r0
        sti r0,*ar1
{body}done:   b done
""")
    debugger = package.Processor(program).debug()
    debugger.watch("dst", 4, on="change")
    for n in range(4):
        (hit,) = debugger.go().hits
        assert hit.value == debugger.value(f"[dst + {n}]") == 11 * (n + 1)
        at = debugger.stop.time_ps
        # From an instant at which the word is still old, its change comes.
        only = debugger.watch(f"dst+{n}", on="change")
        for back_ps in range(0, 4 * CYCLE_PS, CYCLE_PS):
            debugger.go_to_ps(at - back_ps)
            if debugger.value(f"[dst + {n}]") == 0:
                assert only in [hit.number for hit in debugger.go().hits] or debugger.stop.time_ps < at
        debugger.remove(only)
        debugger.go_to_ps(at)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_stop_shows_the_state_of_a_run_without_a_debugger(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    program = program_without_pins(seed)
    board, image = Bench(tmp_path).board(program), assembled(program)
    chip = made(program, board, image)
    debugger = debugger_of(chip, image)
    debugger.watch(DATA[rng.choice(sorted(DATA))], 48, on="access")
    debugger.break_at("again")
    for _ in range(8):
        if not debugger.go(CYCLES * CYCLE_PS * 1e-12).hits:
            break
        alone = made(program, board, image)
        alone.run(max(instant(debugger), 1))
        assert state(alone) == state(chip), (seed, instant(debugger))
    if debugger.stop.reason == "over":  # a fault; a chip that is run further stays there
        return
    debugger.close()
    end = chip.cycle + CYCLES
    chip.run(CYCLES)
    undisturbed = made(program, board, image)
    undisturbed.run(end)
    assert state(undisturbed) == state(chip), seed


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_steps_forward_and_back_come_to_the_same_states(path: Path) -> None:
    rng = random.Random(path.stem)
    program = package.assemble_file(path)
    debugger = Network([program]).debug()
    debugger.go_to_ps(rng.randrange(0, rng.choice([1_000_000, 5_000_000, 20_000_000])))
    if debugger.step().reason != "step":
        debugger.go_to_ps(0)
    seen = []
    for _ in range(40):
        seen.append((debugger.stop.time_ps, debugger._core.state()))
        if debugger.step().reason != "step":
            seen.pop()
            break
    for time_ps, before in reversed(seen):
        assert debugger.step_back().time_ps == time_ps
        assert debugger._core.state() == before
    for time_ps, before in rng.sample(seen, 3):
        fresh = Network([program])
        fresh._core.run_until(time_ps)
        assert fresh.debug()._core.state() == before


@pytest.mark.parametrize("seed", SEEDS)
def test_the_last_writer_is_that_of_the_full_trace(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    program = program_without_pins(seed)
    board, image = Bench(tmp_path).board(program), assembled(program)
    records = by_trace(made(program, board, image), CYCLES)
    now = rng.randrange(CYCLES // 2, CYCLES)
    chip = made(program, board, image)
    debugger = debugger_of(chip, image)
    debugger.go_to_ps(now * CYCLE_PS)
    here = debugger._core.state()
    for address in sorted(
        {a for r in records for how, a, _ in r["memory"] if how == "w" and a < 0x100000 or a > 0x100100}
    )[:6]:
        writes = [
            (r["cycle"] + r["cycles"], r["pc"], v)
            for r in records
            for how, a, v in r["memory"]
            if how == "w" and a == address and r["cycle"] + r["cycles"] <= now
        ]
        writer = debugger.last_write(address)
        assert debugger._core.state() == here
        if writer is not None and ("DMA" in writer.text or "interrupt" in writer.text):
            continue
        assert (None if writer is None else (writer.time_ps // CYCLE_PS, writer.pc, writer.value)) == (
            writes[-1] if writes else None
        ), (seed, hex(address))


def test_words_that_are_watched_in_two_memories_are_where_they_were(tmp_path: Path) -> None:
    """Watched words lie apart in the emulator; the memory that a program and a snapshot see is one."""
    program = program_without_pins(4)
    board, image = Bench(tmp_path).board(program), assembled(program)
    plain, watched = made(program, board, image), made(program, board, image)
    for chip in (plain, watched):
        for place in DATA.values():
            chip.load_words(place, [place + n for n in range(256)])
    beside, debugger = debugger_of(plain, image), debugger_of(watched, image)
    numbers = [debugger.watch(place + 100, 7) for place in DATA.values()]
    for end in (CYCLES // 2, CYCLES):
        beside.go(end * CYCLE_PS * 1e-12)
        while debugger.go(end * CYCLE_PS * 1e-12).hits:
            pass
        assert state(watched) == state(plain)
        for number in numbers if end < CYCLES else ():
            debugger.remove(number)
    assert [watched.peek(DATA["slow"] + 100 + n) for n in range(7)] == [DATA["slow"] + 100 + n for n in range(7)]
