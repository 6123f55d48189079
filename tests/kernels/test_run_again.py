"""Every kernel is safe to run again: it is stopped in the middle, as by a DSP that dies, what it has written so far
stays in shared memory, and another chip with garbage in its scratch memory runs the same block from the start. Then
shared memory and devices have the words that an undisturbed run leaves."""

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest
from agv_words import UNIT
from harness_agv import RETURN, WINDOW_A, WINDOW_B, Dsp
from range_scene import Disc, Scene
from test_golden_kernels import CASES, TICK, agv, agv_facing_a_person, agv_planned, crane, crane_moving, gantry
from test_slices import PREPARE

SHARED = (WINDOW_A + 0x1000, 0x5000)  # crane, AGVs, users' tasks, log of errors, what split tasks keep of two robots
DEVICES = (WINDOW_B, 0x500)
MOST_STATES = 60  # of a long kernel: so many of the memories in which it can stop are tried
SCRATCH_WORDS = 1024


@dataclass
class Case:
    kernel: str
    prepare: Callable[[], Dsp]
    argument: int = 0
    tick: int = 0
    slice: int = 0

    def __str__(self) -> str:
        return f"{self.kernel}-{self.prepare.__name__}" + (f"-{self.slice}" if self.slice else "")


# ---- more places to stop than the golden traces have ----
def gantry_waits_for_its_travel() -> Dsp:
    """20 m along the quay: the leg is longer than its trolley needs."""
    dsp = gantry()
    dsp.put("CR_STRETCH", 1.0)
    for i, value in enumerate((1 / 2.3, 1 / 0.8, 1 / 0.12, 1 / 0.65, 0.0, 0.0, 0.0)):
        dsp.put("CR_SPEED", value, i)
    for i, value in enumerate((0.0, -8.0, 16.0, 0.0, 20.0, 10.0, 9.0, 0.0)):
        dsp.put("CR_ROUTE", value, i)
    return dsp


def crane_before_its_second_leg() -> Dsp:
    """A leg of one point has ended; the next has two segments."""
    dsp = crane()
    dsp.put("CR_ROUTE_COUNT", 0, 1)
    dsp.run("trajectory_crane")
    dsp.put("CR_LEG", 3)
    dsp.put("CR_ROUTE_COUNT", 2, 3)
    for i, value in enumerate((6.0, 20.0, 16.0, 0.0, 12.0, 16.0, 14.0, 0.0)):
        dsp.put("CR_ROUTE", value, 64 + i)
    return dsp


def crane_stopping() -> Dsp:
    """On the path's clock, which slows down; one drive is off."""
    dsp = crane_moving()
    dsp.put("CR_STOPPED", 1)
    for i, value in enumerate((TICK, 8000, 1.0, 0.0, -1 / 8000, TICK, 0.0, 0x1D)):
        dsp.put("CR_PATH", value, i)
    return dsp


def agv_beside_its_lane_home() -> Dsp:
    """Beside the second segment of three: the first has to go."""
    dsp = agv()
    dsp.device(UNIT + dsp.symbols["AGV_X"], -20_000)
    dsp.device(UNIT + dsp.symbols["AGV_Y"], -4_000)
    return dsp


def agv_that_remembers() -> Dsp:
    """Avoidance has seen something that has left its sensor's view."""
    dsp = agv_facing_a_person()
    for n in range(3):
        dsp.put("AG_PRODUCED", 5 * n)
        dsp.run("avoidance_potential", n)
    for i, echo in enumerate(Scene([Disc(40.0, 8.0, 0.3)]).scan(22.01, 7.995, 0.0009)):
        dsp.device(dsp.symbols["AGV_RANGE"] + dsp.symbols["RANGE_RAY"] + i, echo)
    return dsp


def errors_in_the_log() -> Dsp:
    dsp = Dsp()
    dsp.run("error", 0x20042, TICK - 1)
    return dsp


def sliced(kernel: str, slice_: int) -> Case:
    """A block of a split task: each block before it has run."""

    def begun() -> Dsp:
        dsp = PREPARE[kernel]()
        dsp.chip.poke(WINDOW_A + dsp.symbols["SLICE_CYCLES"], 20_000)
        for n in range(slice_):
            put_task(dsp, slice_=n)
            dsp.run(f"{kernel}_sliced", 45_000)
        return dsp

    return Case(f"{kernel}_sliced", begun, 45_000, slice=slice_)


MORE = [
    Case("trajectory_gantry", gantry_waits_for_its_travel),
    Case("trajectory_gantry_shaper", gantry_waits_for_its_travel),
    Case("trajectory_crane", crane_before_its_second_leg, 1),
    Case("trajectory_crane", crane_moving, 3),
    Case("torque", crane_stopping, 0, TICK + 400),
    Case("pid", crane, 0, TICK),
    Case("pid", crane_stopping, 0, TICK + 400),
    Case("pid_document", crane_moving, 0, TICK + 24),
    Case("home_agv", agv_beside_its_lane_home, 0, TICK),
    Case("trajectory_agv", agv_planned, 1),
    Case("avoidance_potential", agv_that_remembers, 3),
    Case("avoidance_vfh", agv_that_remembers, 3),
    Case("error", errors_in_the_log, 0x20042, TICK),
    *[sliced(kernel, n) for kernel in ("avoidance", "avoidance_dwa", "identify", "grab_path") for n in (0, 1)],
]


# ---- the words that nothing reads, and filters ----
def unread(case: Case, dsp: Dsp) -> set[int]:
    """Addresses of words that may differ, and why."""
    s = dsp.symbols
    if case.kernel.startswith(("trajectory_crane", "trajectory_gantry")):
        words = set()  # the durations of segments that a bank's leg does not have
        for bank in range(2):
            first = dsp.area + s["CR_TRAJECTORY"] + 1 + bank * s["TJ_BANK_STRIDE"]
            segments = dsp.chip.peek(first + s["TJ_SEGMENTS"] - s["TJ_K0"])
            durations = first + s["TJ_DURATION"] - s["TJ_K0"]
            words |= {durations + i for i in range(segments, s["TJ_MAX_SEGMENTS"])}
        return words
    if case.kernel == "error":  # the generation of the block that wrote the entry: the host counts it up
        log = WINDOW_A + s["ER_BASE"] + s["ER_LOG"] + s["ER_GENERATION"]
        return {log + 4 * n for n in range(s["ER_ENTRIES"])}
    return set()


def judged(case: Case, dsp: Dsp, before: list[int], now: list[int]) -> bool:
    """PID and avoidance are filters: once they write what they keep of themselves, a second run is their next sample or
    look (docs/kernels.md, A block that runs again)."""
    s = dsp.symbols
    if case.kernel.startswith("pid"):
        name, count = "CR_PID", 56
    elif case.kernel.startswith("avoidance_"):
        name, count = "AG_AVOID_LIMIT", s["AG_AVOID_BESIDE"] + 1 - s["AG_AVOID_LIMIT"]
    else:
        return True
    first = dsp.area + s[name] - SHARED[0]
    return before[first : first + count] == now[first : first + count]


def to_its_end(case: Case, dsp: Dsp, shared: list[int], rng: random.Random) -> list[int]:
    """Of a split task, whose next block alone reads what this one kept: shared memory at its end, without these
    words."""
    s = dsp.symbols
    kept = s["SV_BASE"] + WINDOW_A - SHARED[0]
    if not case.kernel.endswith("_sliced"):
        return shared
    dsp.chip.load_words(SHARED[0], shared)
    for n in range(case.slice + 1, 1000):
        garbage(dsp, rng)
        put_task(dsp, n)
        if dsp.run(case.kernel, case.argument, case.tick)[1] != s["MUST_CONTINUE"]:
            return words(dsp, SHARED)[:kept]
    raise AssertionError("it never ends")


# ---- stopping and running again ----
def put_task(dsp: Dsp, slice_: int, generation: int = 1) -> None:
    s = dsp.symbols
    for name, value in (("TB_SLICE", slice_), ("TB_AREA", dsp.area - WINDOW_A), ("TB_GENERATION", generation)):
        dsp.chip.poke(s["TASK"] + s[name], value)


def garbage(dsp: Dsp, rng: random.Random) -> None:
    dsp.chip.load_words(dsp.symbols["SCRATCH"], [rng.getrandbits(32) for _ in range(SCRATCH_WORDS)])


def words(dsp: Dsp, area: tuple[int, int]) -> list[int]:
    return list(dsp.chip.read(*area))


def stopped(case: Case, cycles: int, window: list[tuple[int, int]]) -> Iterator[tuple[int, list[int], list[int]]]:
    """The memories in which the kernel can stop: cycle, shared memory, devices."""
    dsp = case.prepare()
    put_task(dsp, case.slice)
    begin = dsp.start(case.kernel, case.argument, case.tick)
    step = cycles // 3000 + 1
    last = None
    while (cycle := dsp.chip.cycle - begin) < cycles:
        seen = [words(dsp, area) for area in window]
        if seen != last:
            yield cycle, words(dsp, SHARED), words(dsp, DEVICES)
            last = seen
        dsp.chip.run(step, RETURN)
    yield cycle, words(dsp, SHARED), words(dsp, DEVICES)  # its end, before the executive has said so


@pytest.mark.parametrize("case", [*(Case(*row) for row in CASES), *MORE], ids=str)
def test_a_block_that_runs_again_leaves_the_same_words(case: Case) -> None:
    rng = random.Random(str(case))
    dsp = case.prepare()
    area = dsp.area
    put_task(dsp, case.slice)
    before = words(dsp, SHARED)
    result = dsp.run(case.kernel, case.argument, case.tick)
    after, commands = words(dsp, SHARED), words(dsp, DEVICES)
    may_differ = unread(case, dsp)
    window = [(area, 0x280 if area == WINDOW_A + dsp.symbols["CR_BASE"] else 0x100), (UNIT + WINDOW_B, 0x20)]
    changed = [i for i, (a, b) in enumerate(zip(before, after, strict=True)) if a != b]
    if changed:  # only what this kernel writes
        window.append((SHARED[0] + changed[0], changed[-1] + 1 - changed[0]))
    states = [s for s in stopped(case, result[2], window) if judged(case, dsp, before, s[1])]
    if len(states) > MOST_STATES and result[2] > 3000:
        states = [states[0], *sorted(rng.sample(states[1:-1], MOST_STATES - 2), key=lambda s: s[0]), states[-1]]
    continues = result[1] == dsp.symbols["MUST_CONTINUE"]
    want = to_its_end(case, dsp, after, rng) if continues else after
    other = case.prepare()
    for cycle, shared, registers in states:
        other.chip.load_words(SHARED[0], shared)
        other.chip.load_words(DEVICES[0], registers)
        garbage(other, rng)
        put_task(other, case.slice, generation=2)
        again = other.run(case.kernel, case.argument, case.tick)
        assert again[:2] == result[:2], cycle
        assert words(other, DEVICES) == commands, cycle
        shared = words(other, SHARED)
        if continues:
            shared = to_its_end(case, other, shared, rng)
        differ = [SHARED[0] + i for i, (a, b) in enumerate(zip(want, shared, strict=True)) if a != b]
        assert not [f"{word:X}" for word in differ if word not in may_differ], cycle
    assert states
