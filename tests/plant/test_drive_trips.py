"""The drives' own protection (docs/plant.md, Trips): what trips a drive and when, what its status shows, and what ends
a trip."""

import numpy as np
import pytest
from cmrc._core import plant

MS = 1_000_000_000
LATCH = 125e-6
READY, FAULT, BRAKE = 1, 2, 8
OVERSPEED, SATURATION, HEAT, WARNING = 1, 2, 4, 8
TRAVEL, SLEW, ROTATOR = 0, 1, 4
GEAR = plant.CraneParameters().drives[ROTATOR].gear


def dock(joint: int, **parameters: float) -> plant.Dock:
    """Every latch is recorded; one drive has other parameters."""
    config = plant.default_dock(1)
    crane = config.crane
    drives = crane.drives
    for name, value in parameters.items():
        setattr(drives[joint], name, value)
    crane.drives = drives
    config.crane = crane
    config.signal_decimation = 1
    config.drive_timeout = 0.0
    dock = plant.Dock(config)
    dock.enable_drives(0x1F, 0)
    return dock


def trips(dock: plant.Dock) -> list[tuple[float, int, int]]:
    return [(e.time * 1e-12, e.index, int(e.values[0])) for e in dock.events if e.kind == "drive_tripped"]


def test_a_drive_that_is_too_fast_for_ten_milliseconds_trips() -> None:
    it = dock(ROTATOR, rated_speed=20.0)
    it.set_torque_code(ROTATOR, 1500, 0)
    it.advance_to(1500 * MS)
    times = np.array([s.time * 1e-12 for s in it.signals])
    fast = np.abs([s.qd[ROTATOR] for s in it.signals]) > 1.15 * 20.0 / GEAR
    first = int(np.argmax(fast))
    assert fast[first] and not fast[:first].any()
    # 80 latches of 125 us make the 10 ms; the first of them is the one that ends with too fast a motor.
    assert trips(it) == [(pytest.approx(times[first + 79], abs=1e-9), ROTATOR, 0)]
    assert it.drive_status(ROTATOR, 1500 * MS) == FAULT | BRAKE
    assert it.drive_trip(ROTATOR, 1500 * MS) == OVERSPEED
    assert it.signal.torque[ROTATOR] == pytest.approx(0, abs=1e-6)


def test_a_drive_just_below_that_speed_does_not_trip() -> None:
    it = dock(ROTATOR, rated_speed=20.0)
    for t in range(0, 3000, 1):
        fast = abs(it.signal.qd[ROTATOR]) > 1.1 * 20.0 / GEAR
        it.set_torque_code(ROTATOR, 0 if fast else 600, t * MS)
        it.advance_to((t + 1) * MS)
    assert max(abs(s.qd[ROTATOR]) for s in it.signals) > 1.08 * 20.0 / GEAR
    assert trips(it) == []


@pytest.mark.parametrize(("code", "trip"), [(2047, True), (-2048, True), (-2047, True), (2046, False)])
def test_half_a_second_at_the_largest_code_trips(code: int, trip: bool) -> None:
    it = dock(TRAVEL)
    it.set_torque_code(TRAVEL, code, 0)
    it.advance_to(700 * MS)
    # The code is taken at the latch after the write; 4000 intervals with it held make 0.5 s.
    assert trips(it) == ([(pytest.approx(0.5 + LATCH, abs=1e-9), TRAVEL, 1)] if trip else [])
    assert it.drive_trip(TRAVEL, 700 * MS) == (SATURATION if trip else 0)


def test_a_break_restarts_the_half_second() -> None:
    it = dock(TRAVEL)
    it.set_torque_code(TRAVEL, 2047, 0)
    it.set_torque_code(TRAVEL, 2040, 400 * MS)
    it.set_torque_code(TRAVEL, 2047, 401 * MS)
    it.advance_to(850 * MS)
    assert trips(it) == []
    it.advance_to(950 * MS)
    assert trips(it) == [(pytest.approx(0.901 + LATCH, abs=1e-9), TRAVEL, 1)]


def swinging(period_ms: int, swings: int) -> plant.Dock:
    """The code changes from one end of its range to the other `swings` times, every half period, and is 0
    afterwards."""
    it = dock(TRAVEL)
    it.enable_drives(1 << TRAVEL, 0)  # without torque the jib would fall
    for i in range(swings + 1):
        it.set_torque_code(TRAVEL, 2047 if i % 2 == 0 else -2047, i * period_ms // 2 * MS)
        it.set_torque_code(TRAVEL, 0, (i * period_ms // 2 + 3) * MS)
    it.advance_to(((swings + 1) * period_ms // 2 + 10) * MS)
    return it


@pytest.mark.parametrize("period_ms", [20, 80, 900])
def test_ten_swings_from_end_to_end_trip_however_short_each_stay(period_ms: int) -> None:
    assert trips(swinging(period_ms, 9)) == []
    [(at, joint, cause)] = trips(swinging(period_ms, 12))
    assert (joint, cause) == (TRAVEL, 1) and at == pytest.approx(10 * period_ms / 2e3 + 2 * LATCH, abs=1e-9)


def test_swings_more_than_half_a_second_apart_do_not() -> None:
    assert trips(swinging(1020, 14)) == []


def test_heat_follows_the_square_of_the_torque_warns_at_one_and_trips_at_its_limit() -> None:
    lag, limit = 0.2, 1.2
    it = dock(TRAVEL, thermal_time=lag, saturation_time=100.0)
    it.set_torque_code(TRAVEL, 2047, 0)
    it.advance_to(400 * MS)
    load = np.array([s.torque[TRAVEL] / 382.0 for s in it.signals]) ** 2
    times = np.array([s.time * 1e-12 for s in it.signals])
    # h(t) = 1/T int exp(-(t - s)/T) load(s) ds, by Simpson's rule over the recorded torques.
    (warm,) = [e.time * 1e-12 for e in it.events if e.kind == "drive_warm"]
    (trip,) = trips(it)

    def heat(t: float) -> float:
        n = round(t / LATCH) // 2 * 2
        weight = np.ones(n + 1)
        weight[1:-1:2], weight[2:-1:2] = 4, 2
        return float(np.sum(weight * load[: n + 1] * np.exp(-(times[n] - times[: n + 1]) / lag)) * LATCH / 3 / lag)

    assert heat(warm) == pytest.approx(1.0, abs=5e-3)
    assert heat(trip[0]) == pytest.approx(limit, abs=5e-3) and trip[1:] == (TRAVEL, 2)
    assert warm < trip[0]


def test_a_trip_ends_when_the_drive_is_switched_off_and_has_cooled() -> None:
    lag = 0.2
    it = dock(TRAVEL, thermal_time=lag, saturation_time=100.0)
    it.set_torque_code(TRAVEL, 2047, 0)
    it.advance_to(300 * MS)
    ((at, *_),) = trips(it)
    it.set_torque_code(TRAVEL, 0, 300 * MS)
    assert it.drive_status(TRAVEL, 400 * MS) == FAULT | BRAKE  # cool by now, but not switched off
    assert it.drive_heat(TRAVEL, 400 * MS) < 10_000
    assert it.drive_trip(TRAVEL, 400 * MS) == HEAT
    it.enable_drives(0x1E, 400 * MS)
    assert it.drive_status(TRAVEL, 401 * MS) == READY | BRAKE
    assert it.drive_trip(TRAVEL, 401 * MS) == HEAT  # the cause is shown until the drive is on again
    it.enable_drives(0x1F, 402 * MS)
    assert (it.drive_status(TRAVEL, 403 * MS), it.drive_trip(TRAVEL, 403 * MS)) == (READY, 0)

    hot = dock(TRAVEL, thermal_time=lag, saturation_time=100.0)
    hot.set_torque_code(TRAVEL, 2047, 0)
    hot.advance_to(int(at * 1e12) + MS)
    hot.enable_drives(0x1E, int(at * 1e12) + MS)
    hot.advance_to(int(at * 1e12) + 10 * MS)
    assert hot.drive_trip(TRAVEL, int(at * 1e12) + 10 * MS) == HEAT | WARNING
    assert hot.drive_status(TRAVEL, int(at * 1e12) + 10 * MS) & FAULT  # off, and still too warm
    cool = int((at + 0.010 + lag * np.log(1.2)) * 1e12)
    assert hot.drive_status(TRAVEL, cool + 2 * MS) == READY | BRAKE


def test_a_trip_of_a_warm_drive_that_is_no_overheating_ends_when_the_drive_is_switched_off() -> None:
    it = dock(SLEW, thermal_time=0.8)
    it.set_torque_code(SLEW, 2047, 0)
    it.advance_to(510 * MS)
    assert [(joint, cause) for _, joint, cause in trips(it)] == [(SLEW, 1)]
    assert 10_000 < it.drive_heat(SLEW, 510 * MS) < 12_000
    it.set_torque_code(SLEW, 0, 510 * MS)
    it.enable_drives(0x1F & ~(1 << SLEW), 510 * MS)
    assert it.drive_status(SLEW, 511 * MS) == READY | BRAKE
    assert it.drive_trip(SLEW, 511 * MS) == SATURATION | WARNING
    it.enable_drives(0x1F, 511 * MS)
    assert (it.drive_status(SLEW, 512 * MS), it.drive_trip(SLEW, 512 * MS)) == (READY, WARNING)


def test_a_drive_that_is_switched_on_while_it_is_too_hot_still_shows_why_it_is_tripped() -> None:
    it = dock(TRAVEL, thermal_time=0.2, saturation_time=100.0)
    it.set_torque_code(TRAVEL, 2047, 0)
    it.advance_to(300 * MS)
    ((at, *_),) = trips(it)
    hot = dock(TRAVEL, thermal_time=0.2, saturation_time=100.0)
    hot.set_torque_code(TRAVEL, 2047, 0)
    now = int(at * 1e12) + MS
    for enabled in (0x1E, 0x1F):
        hot.enable_drives(enabled, now)
        now += MS
        hot.advance_to(now)
    assert hot.drive_status(TRAVEL, now) == FAULT | BRAKE
    assert hot.drive_trip(TRAVEL, now) == HEAT | WARNING
    hot.advance_to(now + 200 * MS)  # cool, but not switched off
    assert hot.drive_status(TRAVEL, now + 200 * MS) == FAULT | BRAKE
    assert hot.drive_trip(TRAVEL, now + 200 * MS) == HEAT


def test_the_rated_torque_can_be_held_forever() -> None:
    """Code 1365 of 2047 is the rated torque at 1.5 times of it: heat comes to 1 and no further."""
    it = dock(TRAVEL, thermal_time=0.05, rated_speed=1e5)
    it.set_torque_code(TRAVEL, 1364, 0)
    it.advance_to(800 * MS)
    assert trips(it) == [] and not any(e.kind == "drive_warm" for e in it.events)
    assert it.drive_heat(TRAVEL, 800 * MS) == pytest.approx(10_000 * (1364 / 2047 * 1.5) ** 2, rel=1e-3)


def test_protection_is_part_of_the_state() -> None:
    it = dock(TRAVEL, thermal_time=0.2)
    it.set_torque_code(TRAVEL, 2047, 0)
    it.advance_to(300 * MS)
    kept, before = it.snapshot(), it.state_hash()
    it.advance_to(600 * MS)
    then = (it.state_hash(), trips(it)[-1])
    it.restore(kept)
    assert it.state_hash() == before
    it.advance_to(600 * MS)
    assert (it.state_hash(), trips(it)[-1]) == then


@pytest.mark.parametrize(("load", "rated", "torque"), [(40e3, 3185.0, 5323), (45e3, 5732.0, 5855)])
def test_what_the_hoist_cannot_hold_is_refused_with_the_torque_it_would_take(
    load: float, rated: float, torque: int
) -> None:
    """(10 t + load) g / (n eta): control-notes.md 2 has 5323 N m for 40 t."""
    config = plant.default_dock(1)
    crane = config.crane
    drives = crane.drives
    drives[3].rated_torque = rated
    crane.drives, crane.rated_load = drives, load
    config.crane = crane
    with pytest.raises(
        ValueError, match=f"the hoist needs {torque} N m, more than its rated torque of {rated:.0f} N m"
    ):
        plant.Dock(config)


@pytest.mark.parametrize(("mass", "carried"), [(40e3, True), (40_000.001, False)])
def test_a_container_of_the_rated_load_is_carried_and_a_gram_more_is_refused(mass: float, carried: bool) -> None:
    config = plant.default_dock(1)
    first, *others = config.layout.containers
    config.layout.containers = [plant.ContainerPlace(first.x, first.y, first.z, first.yaw, mass), *others]
    if carried:
        plant.Dock(config)
    else:
        with pytest.raises(ValueError, match=r"0 weighs 40000\.001 kg, more than the crane's rated_load of 40000 kg"):
            plant.Dock(config)


@pytest.mark.parametrize(("rated", "holds"), [(5323.5, True), (5322.5, False)])
def test_the_hoists_rated_torque_may_just_hold_the_rated_load(rated: float, holds: bool) -> None:
    """(10 t + 40 t) g / (104.712 x 0.88) = 5323.05 N m (control-notes.md 2: 5323 N m)."""
    config = plant.default_dock(1)
    crane = config.crane
    drives = crane.drives
    drives[3].rated_torque, drives[3].brake = rated, 2.0
    crane.drives = drives
    config.crane = crane
    if holds:
        plant.Dock(config)
    else:
        with pytest.raises(ValueError, match="the hoist needs 5323 N m, more than its rated torque"):
            plant.Dock(config)


def test_what_the_luff_drive_or_a_brake_cannot_hold_is_refused() -> None:
    config = plant.default_dock(1)
    crane = config.crane
    drives = crane.drives
    drives[2].rated_torque = 6500.0
    crane.drives = drives
    config.crane = crane
    # g (50 t 32 m + 22 t 14 m) cos 20 deg / (3140 x 0.85) = 6590 N m: 86 % of the default's 7643 (control-notes.md 2)
    with pytest.raises(ValueError, match="the luff drive needs 6590 N m, more than its rated torque of 6500 N m"):
        plant.Dock(config)
    drives[2].rated_torque, drives[3].brake = 7643.0, 0.5
    crane.drives = drives
    config.crane = crane
    with pytest.raises(ValueError, match="the hoist needs a brake of 0.82 times its rated force, not 0.50"):
        plant.Dock(config)
