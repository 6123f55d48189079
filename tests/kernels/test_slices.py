"""Long tasks in several blocks: block by block on chips that know nothing of each other, and each block run twice, they
leave the words that the whole task leaves."""

from collections.abc import Callable

import pytest
from harness import WINDOW_A, Dsp
from test_golden_kernels import agv, agv_facing_a_person, crane, ship

SHARED = 0x9000  # words of shared memory that tasks use


def three_rows() -> Dsp:
    dsp = ship()
    dsp.device(dsp.symbols["SCAN_ROWS"], 3)
    return dsp


def shared(dsp: Dsp) -> list[int]:
    return list(dsp.chip.read(WINDOW_A, SHARED))


def in_slices(
    kernel: str, prepare: Callable[[], Dsp], cycles: int, argument: int = 0
) -> tuple[int, int, list[int], list[int]]:
    """TB_RESULT, TB_NOTIFY, shared memory at the end, and the cycles of each block."""
    memory: list[int] | None = None
    taken: list[int] = []
    for slice_ in range(1000):
        for _ in range(2):  # the second time as after a DSP that died at the end of its block
            dsp = prepare()
            if memory is not None:
                dsp.chip.load_words(WINDOW_A, memory)
            s = dsp.symbols
            dsp.chip.poke(WINDOW_A + s["SLICE_CYCLES"], cycles)
            dsp.chip.poke(s["TASK"] + s["TB_SLICE"], slice_)
            dsp.chip.poke(s["TASK"] + s["TB_AREA"], dsp.area - WINDOW_A)
            result, notify, count = dsp.run(kernel + "_sliced", argument)
            memory = shared(dsp)
        taken.append(count)
        if notify != s["MUST_CONTINUE"]:
            return result, notify, memory, taken
    raise AssertionError("it never ends")


PREPARE: dict[str, Callable[[], Dsp]] = {
    "avoidance": agv,
    "avoidance_dwa": agv_facing_a_person,
    "identify": three_rows,
    "grab_path": crane,
}


def first_block(kernel: str) -> None:
    """A block of about 10 000 cycles, for tests that run a split kernel."""
    dsp = PREPARE[kernel]()
    dsp.chip.poke(WINDOW_A + dsp.symbols["SLICE_CYCLES"], 10_000)
    dsp.chip.poke(dsp.symbols["TASK"] + dsp.symbols["TB_AREA"], dsp.area - WINDOW_A)
    assert dsp.run(kernel + "_sliced", 45_000)[1] == dsp.symbols["MUST_CONTINUE"]


@pytest.mark.parametrize(("kernel", "prepare", "cycles", "blocks", "longest"), [
    ("avoidance_dwa", agv_facing_a_person, 20_000, 13, 30_000),  # 10 samples each: 121 / 10
    ("avoidance_dwa", agv_facing_a_person, 1, 121, 12_000),
    ("avoidance_dwa", agv_facing_a_person, 1_000_000, 1, 235_000),
    ("identify", three_rows, 25_000, 3, 40_000),
    ("identify", three_rows, 50_000, 2, 70_000),
    ("identify", three_rows, 1_000_000, 1, 110_000),
    ("grab_path", crane, 1, 2, 1_500),
])  # fmt: skip
def test_blocks_leave_what_the_whole_task_leaves(
    kernel: str, prepare: Callable[[], Dsp], cycles: int, blocks: int, longest: int
) -> None:
    whole = prepare()
    result, notify, _ = whole.run(kernel)
    s = whole.symbols
    kept = {*range(s["SV_BASE"], s["SV_BASE"] + 9 * s["SV_WORDS"]), s["BLOCK_POOL"] + s["TB_ALIVE"]}
    expected = {offset: word for offset, word in enumerate(shared(whole)) if offset not in kept}
    got_result, got_notify, memory, taken = in_slices(kernel, prepare, cycles)
    assert (got_result, got_notify) == (result, notify)
    assert {offset: memory[offset] for offset in expected if offset != whole.symbols["SLICE_CYCLES"]} == {
        offset: word for offset, word in expected.items() if offset != whole.symbols["SLICE_CYCLES"]
    }
    assert len(taken) == blocks and max(taken) < longest


def test_a_synthetic_load_is_as_long_in_pieces() -> None:
    *_, taken = in_slices("avoidance", agv, 10_000, argument=45_000)
    assert [round(cycles, -3) for cycles in taken] == [10_000, 10_000, 10_000, 10_000, 5_000]


@pytest.mark.parametrize("last", [1, 8, 23])
def test_a_last_piece_shorter_than_the_kernels_own_work_ends_at_once(last: int) -> None:
    *_, taken = in_slices("avoidance", agv, 1000, argument=1000 + last)
    assert len(taken) == 2 and taken[1] < 200
