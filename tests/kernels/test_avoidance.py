"""The three methods of obstacle avoidance: against their reference on random scenes, and in closed loop among obstacles
that stand and move."""

from __future__ import annotations

import dataclasses
import math
import random
from itertools import pairwise

import pytest
from agv_words import agv_dsp, measure, set_leg
from avoidance_loop import RANGE, Drive, drive, show
from harness_agv import WINDOW_A, Dsp, from_ti, signed, to_ti
from lanes import chain, loop
from range_scene import FIRST, MOST, MOUNT, STEP, Disc, Scene
from reference_agv import Segment, pose_at
from reference_avoidance import BINS, METHODS, NOTHING, Lane, Look, Said, View, motion

# plant-and-bus.md 2.2; with a scene full of echoes a method may cost up to twice its estimate (VFH projects up to 72
# echoes onto the lane)
ESTIMATE = {"avoidance_potential": 1_200, "avoidance_vfh": 9_000, "avoidance_dwa": 150_000}
WORST = {"avoidance_potential": 34_000, "avoidance_vfh": 48_000, "avoidance_dwa": 250_000}
# Singles of at most 60 m: 4e-6 m each, some ten of them; the lane's arcs to 1 mm where it is decided (2.4 m beside a
# lane of 12 m radius), which the forces and angles turn into at most 2 mm of shift or mm/s; integers to the nearest
# half.
BOUND = 3.5  # mm, mm/s


@pytest.fixture(scope="module")
def dsp() -> Dsp:
    return agv_dsp()


def random_view(r: random.Random) -> View:
    segments = r.choice([loop()[0], chain(0, 0, 0.3, [(120, 0, 5)]), loop()[1]])
    segments = [Segment(*(from_ti(to_ti(float(v))) for v in dataclasses.astuple(s))) for s in segments]
    total = sum(s.length for s in segments)
    s = from_ti(to_ti(r.uniform(0, total - 1)))
    start = 0.0
    for segment in segments:
        if s <= start + segment.length:
            break
        start += segment.length
    x, y, heading = pose_at(segment, s - start)
    off = r.uniform(-1, 1)
    x, y, heading = x - off * math.sin(heading), y + off * math.cos(heading), heading + r.uniform(-0.1, 0.1)
    scene = Scene()
    for _ in range(r.choice([0, 1, 2, 5])):
        away, beside = r.uniform(8, 40), r.uniform(-6, 6)
        scene.discs.append(
            Disc(
                x + away * math.cos(heading) - beside * math.sin(heading),
                y + away * math.sin(heading) + beside * math.cos(heading),
                0.3,
            )
        )
    if r.random() < 0.3:  # somebody at the front's corner
        away, beside = r.uniform(7.8, 10), r.uniform(-4, 4)
        scene.discs.append(
            Disc(
                x + away * math.cos(heading) - beside * math.sin(heading),
                y + away * math.sin(heading) + beside * math.cos(heading),
                0.3,
            )
        )
    if r.random() < 0.3:
        scene.box(x + 30 * math.cos(heading), y + 30 * math.sin(heading), r.uniform(-3, 3), 14.8, 3.0)
    x, y, heading = round(1e3 * x) / 1e3, round(1e3 * y) / 1e3, round(1e6 * heading) / 1e6
    rays = scene.scan(x, y, heading)
    for i in range(180):
        if r.random() < 0.05:
            rays[i] = 0  # an echo that was missed
    shift = r.choice([0.0, 0.0, -1.2, 0.8, 2.5])
    view = View(x, y, heading, r.randrange(0, 6000) / 1e3, [None if m in (0, MOST) else m / 1e3 for m in rays], FIRST / 1e6, STEP / 1e6, MOUNT / 1e3,
                segments, s, from_ti(to_ti(segment.curvature)), shift, round(s + r.uniform(-10, 10), 3), count=2 * r.randrange(30, 500), period=r.choice([0.02, 0.032]))  # fmt: skip
    if r.random() < 0.5:
        view.wait, view.place = view.count + r.randrange(-5, 50), round(s + r.uniform(5, 20), 3)
    view.flank = round(s + r.uniform(-20, 5), 3)
    if r.random() < 0.7:
        # What is seen now was elsewhere before: nearer to the lane, farther, or not there at all.
        lane = Lane(view, 72)
        now = motion(lane, 0.0, math.inf, math.inf)[1]
        kept = (
            [p if p == NOTHING else from_ti(to_ti(p + r.choice([0.0, 0.0, 0.3, 1.0, -0.5]))) for p in places]
            for places in now.sides
        )
        nearest = lane.s + min((e.along for e in lane.echoes), default=10.0)
        block, beside = (
            r.choice(
                [NOTHING, *(from_ti(to_ti(place)) for place in (s + r.uniform(10, 30), nearest + r.uniform(0, 1.5)))]
            )
            for _ in range(2)
        )
        view.then = Look(((view.count >> 4) - 2 << 4) + r.randrange(16), block, beside, (next(kept), next(kept)))
        earlier = (
            [p if p == NOTHING else from_ti(to_ti(p + r.choice([0.0, 0.5, 1.0, 1.5]))) for p in places]
            for places in now.sides
        )
        if r.random() < 0.7:
            view.older = Look(
                ((view.count >> 4) - 3 << 4) + r.randrange(16), NOTHING, NOTHING, (next(earlier), next(earlier))
            )
    return view


def bank_of(dsp: Dsp, slot: int) -> int:
    """Where the look of a slot of 16 points is kept: beside what a split task of AGV 0 keeps."""
    s = dsp.symbols
    return (
        WINDOW_A + s["SV_BASE"] + s["SV_WORDS"] + s["AV_BANK"] + slot % 2 * 0x400 + slot // 2 % 2 * s["AV_BANK_WORDS"]
    )


def run(dsp: Dsp, kernel: str, view: View) -> tuple[Said, int, int]:
    set_leg(dsp, 1, view.segments)
    dsp.put("AG_PRODUCED", view.count)
    dsp.put("AG_PERIOD_US", round(view.period * 1e6))
    for look, slots in ((view.then, 2), (view.older, 3)):
        words = (
            [0] * (3 + 2 * BINS)
            if look is None
            else [look.count + 1, *map(to_ti, (look.block, look.close, *look.sides[0], *look.sides[1]))]
        )
        for i, word in enumerate(words):
            dsp.chip.poke(bank_of(dsp, (view.count >> 4) - slots) + i, word)
    dsp.put("AG_TRAJECTORY", view.s, 8)
    dsp.put("AG_POINT", view.curvature, 8 + 6)
    dsp.put("AG_AVOID_SHIFT", round(view.shift * 1e3))
    dsp.put("AG_AVOID_HOLD", round(view.hold * 1e3))
    dsp.put("AG_AVOID_WAIT", view.wait)
    for name, value in (("PLACE", view.place), ("BESIDE", view.flank)):
        dsp.put(f"AG_AVOID_{name}", round(value * 1e3))
    measure(dsp, round(view.x * 1e3), round(view.y * 1e3), round(view.heading * 1e6), round(view.speed * 1e3), 0)
    show(dsp, [MOST if ray is None else round(ray * 1e3) for ray in view.rays])
    result, notify, cycles = dsp.run(kernel)
    assert notify == 0
    limit = dsp.word("AG_AVOID_LIMIT")
    shift, hold, place, flank = (
        signed(dsp.word(f"AG_AVOID_{name}")) / 1e3 for name in ("SHIFT", "HOLD", "PLACE", "BESIDE")
    )
    return (
        ((None if limit == 0 else (limit - 1) / 1e3), shift, hold, place, flank, signed(dsp.word("AG_AVOID_WAIT"))),
        result,
        cycles,
    )


def close(a: Said, b: Said) -> bool:
    if (a[0] is None) != (b[0] is None) or abs(
        a[-1] - b[-1]
    ) > 3:  # points while the vehicle does not move, of up to 2000
        return False
    return all(abs(1e3 * (p - q)) <= BOUND for p, q in zip(a[:-1], b[:-1]) if p is not None and q is not None)


def nudged(view: View, r: random.Random) -> View:
    """The same view within the resolution of the kernel's numbers."""
    return dataclasses.replace(
        view, x=view.x + r.uniform(-1e-3, 1e-3), y=view.y + r.uniform(-1e-3, 1e-3), heading=view.heading + r.uniform(-1e-5, 1e-5),
        speed=view.speed + r.uniform(-1e-5, 1e-5), rays=[m if m is None else m + r.uniform(-1e-4, 1e-4) for m in view.rays])  # fmt: skip


@pytest.mark.parametrize("kernel", METHODS)
def test_a_method_agrees_with_its_reference(dsp: Dsp, kernel: str) -> None:
    r = random.Random(5)
    count = 60 if kernel == "avoidance_dwa" else 150
    edges, limited, shifted, waits = 0, 0, 0, 0
    for n in range(count):
        view = random_view(r)
        got, result, cycles = run(dsp, kernel, view)
        assert cycles < WORST[kernel]
        want = METHODS[kernel](view)
        if not close(got, want):
            # A decision that a millimetre turns: the kernel must then agree with the reference on the other side of it.
            edges += 1
            assert any(close(got, METHODS[kernel](nudged(view, r))) for _ in range(60)), (n, got, want)
        assert (
            result == (got[0] is not None) * dsp.symbols["AVOID_SLOWED"] | (got[1] != 0) * dsp.symbols["AVOID_SHIFTED"]
        )
        limited += got[0] is not None
        shifted += got[1] != 0
        waits += got[-1] > view.wait
    assert edges <= count // 10
    assert limited > count // 5 and shifted > count // 10 and waits >= count // 60


@pytest.mark.parametrize("kernel", METHODS)
def test_run_again_it_says_the_same(dsp: Dsp, kernel: str) -> None:
    r = random.Random(6)
    for _ in range(3):
        view = random_view(r)
        run(dsp, kernel, view)
        assert dsp.run(kernel)[0] in range(4)
        again = [dsp.word(name) for name in ("AG_AVOID_LIMIT", "AG_AVOID_SHIFT", "AG_AVOID_HOLD", "AG_AVOID_WAIT")]
        dsp.run(kernel)
        assert [
            dsp.word(name) for name in ("AG_AVOID_LIMIT", "AG_AVOID_SHIFT", "AG_AVOID_HOLD", "AG_AVOID_WAIT")
        ] == again


@pytest.mark.parametrize("kernel", METHODS)
def test_a_sensor_without_rays_limits_nothing(dsp: Dsp, kernel: str) -> None:
    view = random_view(random.Random(7))
    run(dsp, kernel, view)
    dsp.device(RANGE + dsp.symbols["RANGE_COUNT"], 0)
    dsp.put("AG_AVOID_LIMIT", 1)
    dsp.run(kernel)
    assert [dsp.word(name) for name in ("AG_AVOID_LIMIT", "AG_AVOID_SHIFT")] == [0, 0]


@pytest.mark.parametrize("kernel", METHODS)
def test_without_a_leg_it_looks_straight_ahead(dsp: Dsp, kernel: str) -> None:
    run(dsp, kernel, random_view(random.Random(7)))
    for count, ahead, limit in ((0, 1000, 1), (0, MOST, 0)):
        dsp.put("AG_SEGMENT_COUNT", count, 1)
        dsp.put("AG_PRODUCED", 0)
        for name in ("AG_AVOID_HOLD", "AG_AVOID_SHIFT", "AG_AVOID_WAIT", "AG_AVOID_BESIDE"):
            dsp.put(name, 0)
        show(dsp, [ahead if abs(i - 89.5) < 20 else MOST for i in range(180)])
        dsp.run(kernel)
        assert dsp.word("AG_AVOID_LIMIT") == limit


LANE = [Segment(0.0, 0.0, 0.0, 100.0, 0.0, 5.0)]


@pytest.mark.parametrize("kernel", METHODS)
@pytest.mark.parametrize("pillar", [2.9, -2.9])
def test_no_shift_while_something_is_beside_the_flank(dsp: Dsp, kernel: str, pillar: float) -> None:
    """A post in the lane asks for a shift to the left, and a pillar is going out of view, there or to the right, where
    the rear would swing: not before that has passed it."""

    def shift(s: float, flank: float) -> tuple[float, float]:
        scene = Scene([Disc(41.0, -0.9, 0.3), Disc(28.0, pillar, 0.3)])
        rays = [None if m in (0, MOST) else m / 1e3 for m in scene.scan(s, 0.0, 0.0)]
        got, *_ = run(
            dsp,
            kernel,
            View(s, 0.0, 0.0, 1.0, rays, FIRST / 1e6, STEP / 1e6, MOUNT / 1e3, LANE, s, 0.0, 0.0, 0.0, flank=flank),
        )
        return got[1], got[4]

    at_front, beside = shift(20.0, 0.0)
    assert at_front <= 0 and beside == pytest.approx(28.0 + 9.0, abs=0.3)
    assert shift(22.0, beside)[0] <= 0  # out of view
    assert shift(22.0, 21.0)[0] > 0.5  # as if it had not been there


def arrives(came: Drive) -> bool:
    return came.arrived and abs(came.end[0] - 100) < 0.03 and abs(came.end[1]) < 0.03 and abs(came.end[2]) < 0.005


@pytest.mark.parametrize("kernel", METHODS)
def test_a_free_lane_is_driven_as_without_avoidance(dsp: Dsp, kernel: str) -> None:
    if kernel == "avoidance_dwa":
        came, alone = drive(dsp, kernel, LANE, Scene()), drive(dsp, None, LANE, Scene())
        assert came.trace == alone.trace and arrives(came)
        return
    segments = loop()[0]
    came, alone = drive(dsp, kernel, segments, Scene()), drive(dsp, None, segments, Scene())
    assert came.trace == alone.trace and came.arrived


@pytest.mark.parametrize(
    ("kernel", "load"),
    [("avoidance_potential", 0.0), ("avoidance_vfh", 0.0), ("avoidance_vfh", 30e3), ("avoidance_dwa", 0.0)],
)
def test_a_person_beside_the_middle_of_the_lane_is_passed(dsp: Dsp, kernel: str, load: float) -> None:
    for side in (0.9, -0.9) if kernel == "avoidance_potential" else (-0.9,):
        came = drive(dsp, kernel, LANE, Scene([Disc(50.0, side, 0.3)]), load=load)
        assert arrives(came)
        assert 0.4 < came.clearance < 3.0  # without avoidance it is run over
        assert came.seconds < 45


@pytest.mark.parametrize("kernel", METHODS)
def test_a_person_who_walks_across_is_spared(dsp: Dsp, kernel: str) -> None:
    came = drive(dsp, kernel, LANE, Scene([Disc(55.0, -15.0, 0.3, 0.0, 1.2)]))
    assert arrives(came)
    assert came.clearance > 0.4


@pytest.mark.parametrize("kernel", METHODS)
def test_a_lane_that_is_shut_is_stopped_in(dsp: Dsp, kernel: str) -> None:
    """A vehicle stands across the whole lane: stop before it and stay; the drive's own 1 m/s^2 is enough."""
    scene = Scene()
    scene.box(70.0, 0.0, math.pi / 2, 14.8, 3.0)
    came = drive(dsp, kernel, LANE, scene, limit=33.0)
    assert not came.arrived
    assert came.clearance > 0.8
    assert came.stood > 2
    speeds = [v for *_, v, _ in came.trace]
    assert max(a - b for a, b in pairwise(speeds)) < 0.02 * 1.6


def test_without_avoidance_the_person_is_run_over(dsp: Dsp) -> None:
    assert drive(dsp, None, LANE, Scene([Disc(50.0, 0.9, 0.3)])).clearance < 0
