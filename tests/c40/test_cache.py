"""The instruction cache (c40-hardware.md 6). Where a word is fetched from shows in what its fetch costs: SLOW has one
wait state, a hit none."""

from typing import Any

import pytest
import small_programs
from cmrc._core import c40

LOCAL, SLOW = 0x300000, 0x40000000
ENABLE, FREEZE, CLEAR = 0x800, 0x400, 0x1000
NOP, ADD_1_TO_R0, RETI, RETS = 0x0C800000, 0x02600001, 0x78000000, 0x78800000
SEGMENT = 32


@pytest.fixture
def processor() -> Any:
    processor = c40.Processor("default")
    processor.load_words(SLOW, [NOP] * 1024)
    processor.set("ST", ENABLE)
    return processor


def misses(processor: Any, address: int) -> bool:
    """One instruction from an empty pipeline: a miss waits once, and says why; a fetch with the cache off waits for its
    memory."""
    before = processor.causes
    processor.pc = address
    processor.step()
    spent = {cause: after - before[cause] for cause, after in processor.causes.items() if after != before[cause]}
    assert spent in ({"execute": 1}, {"execute": 1, "cache_miss": 1})
    return "cache_miss" in spent


def misses_and_branches(processor: Any, address: int) -> bool:
    before = processor.causes["cache_miss"]
    processor.pc = address
    processor.step()
    return processor.causes["cache_miss"] == before + 1


def waits_for_memory(processor: Any, address: int) -> bool:
    before = processor.causes["wait_state"]
    processor.pc = address
    processor.step()
    return processor.causes["wait_state"] == before + 1


def test_a_miss_loads_one_word(processor: Any) -> None:
    assert [misses(processor, SLOW + n) for n in (0, 0, 1, 0, 1, 31, 31, 2)] == [
        True,
        False,
        True,
        False,
        False,
        True,
        False,
        True,
    ]


def test_four_segments_fit_and_the_least_recently_used_one_goes(processor: Any) -> None:
    a, b, c, d, e = (SLOW + n * SEGMENT for n in range(5))
    assert all(misses(processor, address) for address in (a, b, c, d))
    assert not any(misses(processor, address) for address in (a, b, c, d, a))  # b is the oldest now
    assert misses(processor, e)
    assert not any(misses(processor, address) for address in (c, d, a, e))
    assert misses(processor, b)  # takes the place of c, which was used longest ago
    assert [misses(processor, address) for address in (d, a, e, b)] == [False] * 4
    assert misses(processor, c)


def test_a_miss_of_a_word_is_a_use_of_its_segment(processor: Any) -> None:
    a, b, c, d, e = (SLOW + n * SEGMENT for n in range(5))
    for address in (a, b, c, d, a + 1, e):
        misses(processor, address)
    assert [misses(processor, address) for address in (a, a + 1, b)] == [False, False, True]


def test_a_segment_that_comes_back_has_lost_its_other_words(processor: Any) -> None:
    for n in range(6):
        misses(processor, SLOW + n * SEGMENT)
        misses(processor, SLOW + n * SEGMENT + 5)
    assert misses(processor, SLOW)
    assert misses(processor, SLOW + 5)


def test_frozen_it_serves_hits_and_loads_nothing(processor: Any) -> None:
    misses(processor, SLOW)
    processor.set("ST", ENABLE | FREEZE)
    assert [misses(processor, SLOW + n) for n in (0, 1, 1)] == [False, True, True]
    processor.set("ST", ENABLE)
    assert [misses(processor, SLOW + n) for n in (0, 1, 1)] == [False, True, False]


def test_frozen_it_keeps_the_order_of_use(processor: Any) -> None:
    a, b, c, d, e = (SLOW + n * SEGMENT for n in range(5))
    for address in (a, b, c, d):
        misses(processor, address)
    processor.set("ST", ENABLE | FREEZE)
    misses(processor, a)
    processor.set("ST", ENABLE)
    misses(processor, e)
    assert misses(processor, a)


def test_what_unfreezes_it_was_itself_fetched_frozen(processor: Any) -> None:
    """RETI gives CF back in its execute stage: its own word has not come into the cache; the next one does."""
    processor.load_words(SLOW, [RETI])
    processor.load_words(0x2FF900, [SLOW + 64])
    processor.set("SP", 0x2FF900)
    processor.set("ST", ENABLE | FREEZE)  # PCF is 0
    assert misses_and_branches(processor, SLOW)
    assert processor.get("ST") & FREEZE == 0
    processor.set("SP", 0x2FF900)
    assert misses_and_branches(processor, SLOW)


def test_switched_off_it_keeps_its_words(processor: Any) -> None:
    misses(processor, SLOW)
    processor.set("ST", 0)
    assert waits_for_memory(processor, SLOW)
    assert waits_for_memory(processor, SLOW + 1)
    processor.set("ST", ENABLE)
    assert [misses(processor, SLOW + n) for n in (0, 1)] == [False, True]


def test_clearing_empties_it_and_reads_back_zero(processor: Any) -> None:
    for n in range(4):
        misses(processor, SLOW + n)
    processor.set("ST", ENABLE | CLEAR)
    assert processor.get("ST") == ENABLE
    assert all(misses(processor, SLOW + n) for n in range(4))


def test_changed_code_runs_as_it_was_until_the_cache_is_cleared(processor: Any) -> None:
    misses(processor, SLOW)
    processor.poke(SLOW, ADD_1_TO_R0)
    assert not misses(processor, SLOW)
    assert processor.get("R0") & 0xFFFFFFFF == 0
    processor.set("ST", ENABLE | CLEAR)
    assert misses(processor, SLOW)
    assert processor.get("R0") & 0xFFFFFFFF == 1


@pytest.mark.parametrize("exact", [True, False])
def test_a_program_that_writes_over_its_code_needs_cc(exact: bool) -> None:
    """Its loop is in the cache when the new instruction is stored: it counts by 1 on, until CC."""
    text = """
        call loop
        ldi @new,r2
        sti r2,@e
        call loop
        or 1000h,st
        call loop
stop:   bu stop
loop:   ldi 9,rc
        rptb e
        nop
e:      addi 1,r1
        rets
new:    addi 100,r1
"""
    processor, image = small_programs.load(text, at=LOCAL)
    processor.set_exact(exact)
    for name, value in {"DP": LOCAL >> 16, "SP": 0x2FFA00, "ST": ENABLE}.items():
        processor.set(name, value)
    processor.run(10_000, until=image.symbols["stop"])
    assert processor.get("R1") & 0xFFFFFFFF == 10 + 10 + 10 * 100
    assert small_programs.consistent(processor)


def cycles_per_pass(
    body: str, status: int, registers: dict[str, int], at: int, exact: bool
) -> tuple[int, dict[str, int]]:
    """Of a repeated block once it is in the cache: the difference of 30 passes and 10."""
    cycles, causes = [], []
    for count in (10, 30):
        processor, image = small_programs.load(
            f"        ldi {count - 1},rc\n        rptb e\n{body}\nstop:   bu stop\n", at=at
        )
        processor.set_exact(exact)
        for name, value in (registers | {"ST": status}).items():
            processor.set(name, value)
        processor.run(100_000, until=image.symbols["stop"])
        assert small_programs.consistent(processor)
        cycles.append(processor.cycle)
        causes.append(processor.causes)
    assert (cycles[1] - cycles[0]) % 20 == 0
    return (cycles[1] - cycles[0]) // 20, {
        c: (causes[1][c] - causes[0][c]) // 20 for c in causes[0] if causes[1][c] != causes[0][c]
    }


EIGHT_LOADS = "        ldi *ar0,r0\n" * 7 + "e:      ldi *ar0,r0"
EIGHT_ADDS = "        addi 1,r0\n" * 7 + "e:      addi 1,r0"
FORTY_ADDS = "        addi 1,r0\n" * 39 + "e:      addi 1,r0"
MANY_ADDS = "        addi 1,r0\n" * 159 + "e:      addi 1,r0"


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize(
    ("body", "status", "at", "cycles", "causes"),
    [
        # Eight fetches and eight reads on one bus, or eight reads alone.
        (EIGHT_LOADS, 0, LOCAL, 16, {"execute": 8, "memory_conflict": 8}),
        (EIGHT_LOADS, ENABLE, LOCAL, 8, {"execute": 8}),
        # Two cycles for each fetch from memory with one wait state, or one.
        (EIGHT_ADDS, 0, SLOW, 16, {"execute": 8, "wait_state": 8}),
        (EIGHT_ADDS, ENABLE, SLOW, 8, {"execute": 8}),
        (FORTY_ADDS, ENABLE, SLOW, 40, {"execute": 40}),
        # 160 words in a circle through 128: each pass finds none of what it needs.
        (MANY_ADDS, ENABLE, SLOW, 320, {"execute": 160, "cache_miss": 160}),
    ],
)
def test_what_a_loop_costs(body: str, status: int, at: int, cycles: int, causes: dict[str, int], exact: bool) -> None:
    assert cycles_per_pass(body, status, {"AR0": LOCAL + 0x1000}, at, exact) == (cycles, causes)


def test_on_chip_code_is_not_cached() -> None:
    """c40-hardware.md 6: only fetches from the external buses are."""
    processor = c40.Processor("default")
    processor.load_words(0x2FF800, [NOP] * 8)
    processor.set("ST", ENABLE)
    processor.pc = 0x2FF800
    processor.run(8)
    processor.poke(0x2FF800, ADD_1_TO_R0)
    processor.pc = 0x2FF800
    processor.step()
    assert processor.get("R0") & 0xFFFFFFFF == 1


def run_in_pieces(processor: Any, end: int) -> None:
    while processor.pc != end:
        processor.run(3, until=end)


def run_step_by_step(processor: Any, end: int) -> None:
    while processor.pc != end:
        processor.step()


def run_by_the_exact_engine(processor: Any, end: int) -> None:
    processor.set_exact(True)
    processor.run(100_000, until=end)


WAYS = {
    "whole": lambda processor, end: processor.run(100_000, until=end),
    "in pieces": run_in_pieces,
    "step by step": run_step_by_step,
    "exact": run_by_the_exact_engine,
}
THREE_SEGMENTS, ONE_SEGMENT, ONE_WORD = SLOW + 0xDA, SLOW + 0x48, SLOW
ROUTINES = {"three": (THREE_SEGMENTS, 44), "one": (ONE_SEGMENT, 30), "word": (ONE_WORD, 1)}


def misses_of_the_last_call(calls: list[str], way: str) -> int:
    """A program on the chip calls routines in slow memory, and changes the cache in between."""

    def run(calls: list[str]) -> Any:
        text = ""
        for what in calls:
            called = {"three": "r8", "one": "r9", "word": "r10"}.get(what)
            text += f"        callu {called}\n" if called else f"        {what}\n" + "        nop\n" * 8
        processor, image = small_programs.load(text + "stop:   bu stop\n")
        for name, (address, words) in zip(("R8", "R9", "R10"), ROUTINES.values(), strict=True):
            processor.load_words(address, [NOP] * (words - 1) + [RETS])
            processor.set(name, address)
        WAYS[way](processor, image.symbols["stop"])
        assert small_programs.consistent(processor)
        return processor.causes["cache_miss"]

    return int(run(calls) - run(calls[:-1]))


ON, HOLD, THAW, EMPTY = "or 800h,st", "or 400h,st", "andn 400h,st", "or 1000h,st"


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("before", "expected"),
    [
        ([], 44),
        (["three"], 0),
        (["three", "one", HOLD], 6),  # the first word's segment went for the second of the other routine
        (["three", "one", HOLD, "three"], 6),
        (["three", "one", HOLD, "three", EMPTY], 44),
        (["three", "one", HOLD, "three", EMPTY, THAW], 44),
        (["three", "one", HOLD, "three", THAW, "word", HOLD], 38),  # the second one's went, too
        (["three", "one", HOLD, "three", THAW, "word", HOLD, "three"], 38),
    ],
)
def test_a_frozen_cache_hits_the_words_that_it_holds_however_a_program_is_run(
    before: list[str], expected: int, way: str
) -> None:
    """A block that was recorded with hits does not fit where the words are gone: frozen, a missing segment takes the
    place of no other."""
    assert misses_of_the_last_call([ON, *before, "three"], way) == expected
