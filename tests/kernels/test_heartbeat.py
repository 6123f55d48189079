"""The heartbeat of long kernels (lib/alive.asm): the time between its beats, and that they change nothing else."""

import random
from collections.abc import Callable

import pytest
from harness_agv import RETURN, WINDOW_A, Dsp
from test_golden_kernels import agv, agv_facing_a_person, ship
from test_grab_path import prepare, random_scene

MOST = 18_750
"""Cycles, 0.75 ms at C40-50: what measures.md 4 allows between two beats. The windows are free here; the waits of the
bus come on top."""

CALL = 4
"""Cycles of a CALL (c40-isa.md)."""


def beats(dsp: Dsp, kernel: str, argument: int = 0) -> list[int]:
    """Cycles from the kernel's begin to its beats and its end."""
    s, chip = dsp.symbols, dsp.chip
    word = WINDOW_A + s["BLOCK_POOL"] + s["TB_ALIVE"]
    chip.poke(s["TASK"] + s["TB_ALIVE"], 0xFFFFFFF0)  # as the executive has copied it
    chip.poke(s["TASK"] + s["TB_ARGUMENT"], argument)
    for name, value in (("AR6", dsp.area), ("AR7", s["TASK"]), ("DP", s["PAGE"]), ("SP", s["STACK"]), ("ST", 0x0800)):
        chip.set(name, value)
    chip.poke(s["STACK"], RETURN)
    chip.pc = s[f"kernel_{kernel}"]
    begin, at = chip.cycle, []
    chip.add_breakpoint(s["alive"])
    while chip.pc != RETURN:
        chip.run(20_000_000, RETURN)
        at.append(chip.cycle - begin)
        if chip.pc == s["alive"]:
            chip.step()
    chip.remove_breakpoint(s["alive"])
    assert chip.peek(word) == (0xFFFFFFF0 + len(at) - 1) & 0xFFFFFFFF  # counted up once per beat, whatever was there
    return at


def longest(at: list[int]) -> int:
    return max(b - a for a, b in zip([0, *at], at))


def empty_bay() -> Dsp:
    dsp = ship()
    s = dsp.symbols
    dsp.device(s["SCAN_ROWS"], 2)
    for i in range(s["SCAN_COUNT"]):
        dsp.device(s["SCAN_PROFILE"] + i, dsp.device_word(s["SCAN_DECK"]))
    return dsp


def walled_in() -> Dsp:
    """Every ray ends near the lane in a bend: the most work that avoidance can have."""
    dsp = agv_facing_a_person()
    s = dsp.symbols
    for ray in range(s["RANGE_RAYS"]):
        dsp.device(s["AGV_RANGE"] + s["RANGE_RAY"] + ray, 3_000 + 40 * ray)
    return dsp


@pytest.mark.parametrize(("kernel", "scene", "argument", "bound"), [
    ("identify", ship, 0, 2_500), ("identify", empty_bay, 0, 2_500),
    ("avoidance", agv, 200_000, 2_100),
    ("avoidance_potential", walled_in, 0, MOST), ("avoidance_vfh", walled_in, 0, MOST), ("avoidance_dwa", walled_in, 0, MOST),
    ("avoidance_potential", agv_facing_a_person, 0, 8_000), ("avoidance_vfh", agv_facing_a_person, 0, 8_000), ("avoidance_dwa", agv_facing_a_person, 0, 8_000),
])  # fmt: skip
def test_beats_are_so_close(kernel: str, scene: Callable[[], Dsp], argument: int, bound: int) -> None:
    at = beats(scene(), kernel, argument)
    assert len(at) > 2 and longest(at) <= bound


def test_planning_beats_however_long_it_takes() -> None:
    rng, dsp, whole = random.Random(5), Dsp(), 0
    for _ in range(40):
        boxes, bay, target, produced = random_scene(rng)
        prepare(dsp, boxes, bay, target, produced, (22.0, 8.0, 6.0, 0.0))  # type: ignore[arg-type]
        for kernel in ("grab_path", "home_crane"):
            at = beats(dsp, kernel)
            whole = max(whole, at[-1])
            assert longest(at) <= 3_500
    assert whole > 200_000


def test_a_beat_keeps_registers_and_status() -> None:
    dsp = Dsp()
    chip, rng = dsp.chip, random.Random(1)
    names = [*(f"AR{n}" for n in range(8)), "IR0", "IR1", "BK", "RC", "RS", "RE"]
    for name in names:
        chip.set(name, rng.getrandbits(32))
    for n in range(12):
        chip.set(f"R{n}", rng.getrandbits(40))
    before = [chip.get(name) for name in (*names, *(f"R{n}" for n in range(12)))]
    for status in (0x0800, 0x087F):
        s = dsp.symbols
        for name, value in (("DP", s["PAGE"]), ("SP", s["STACK"]), ("ST", status)):
            chip.set(name, value)
        chip.poke(s["STACK"], RETURN)
        chip.pc, begin = s["alive"], chip.cycle
        assert chip.run(1_000, RETURN)["reason"] == "breakpoint"
        assert CALL + chip.cycle - begin == 17
        assert chip.get("ST") == status
        assert [chip.get(name) for name in (*names, *(f"R{n}" for n in range(12)))] == before
