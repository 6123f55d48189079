"""Bus B register by register, against its line in devices.inc and against the dock's own functions."""

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

import pytest
from cmrc._core import plant
from cmrc_test import machine
from programs import INCLUDE, MS, US, assemble, config, with_devices

DEVICES = 0x100000  # where the host finds offset 0 of window B
LATCH = 125 * US
SYMBOLS = assemble("").symbols
DONE, TARGET_ABORT = 0, 2


class Register(NamedTuple):
    name: str
    readable: bool
    offsets: dict[int, tuple[int, int]]  # to the number of a channel, sample or AGV, and of a ray


def registers(agvs: int) -> Iterator[Register]:
    """Each line of devices.inc whose comment says "read" or "write", with the offsets that it names."""
    base, words = 0, 0
    for line in (INCLUDE / "devices.inc").read_text().splitlines():
        if section := re.search(r"AGV i at (\w+) \+ i \* (\w+)", line):
            base, words = SYMBOLS[section[1]], SYMBOLS[section[2]]
        found = re.match(r"(\w+) +\.set \w+ +; (?:\+ (\w+), .*?)?(read|write):", line)
        if not found:
            continue
        name, number, way = found.groups()
        count = {None: 1, "j": 5, "i": 128, "ray": 180}[number]
        units = [base + agv * words for agv in range(agvs)] if words else [0]
        yield Register(
            name,
            way == "read",
            {
                unit + SYMBOLS[name] + i: (agv, i) if words else (i, 0)
                for agv, unit in enumerate(units)
                for i in range(count)
            },
        )


def dock_of(second_sway: bool) -> plant.Dock:
    layout = plant.default_dock()
    sensors = layout.sensors
    sensors.second_sway = second_sway
    layout.sensors = sensors
    layout.agv_count = 2
    return plant.Dock(layout)


Step = tuple[int, int, list[int], int]


def run(steps: list[Step], dock: plant.Dock, until: int) -> machine.Machine:
    """With the host's board on both buses, so that it reaches the devices."""
    topology = machine.Topology()
    topology.host = [0, 1]
    m = machine.Machine(assemble(""), config(dsps=1, topology=topology), dock=dock, host=steps, record=True)
    m.run_until(until)
    return m


@pytest.mark.parametrize("second_sway", [False, True])
def test_each_offset_answers_as_devices_inc_says(second_sway: bool) -> None:
    dock = dock_of(second_sway)
    there = {
        (offset, not one.readable)
        for one in registers(dock.agv_count)
        for offset in one.offsets
        if second_sway or not one.name.startswith("SWAY2_")
    }
    last = max(offset for offset, _ in there)
    assert (
        len(there) > 500
        and last == SYMBOLS["AGV_RANGE"] + SYMBOLS["AGV_RANGE_WORDS"] * (dock.agv_count - 1) + 0x10 + 179
    )
    steps: list[Step] = []
    for offset in range(last + 1):
        at = 4 * US * offset
        steps += [(at, DEVICES + offset, [], 1), (at + 2 * US, DEVICES + offset, [0], 0)]
    m = run(steps, dock, 4 * US * (last + 2))
    said = {(v[2], bool(v[4])): v[5] for _, what, v in m.events if what == "transaction" and v[0] == 1}
    assert len(said) == 2 * (last + 1)  # each by itself, none in a burst
    wrong = {
        f"{'write' if write else 'read'} of {offset:X}h": result
        for (offset, write), result in said.items()
        if result != (DONE if (offset, write) in there else TARGET_ABORT)
    }
    assert wrong == {}


def test_behind_the_last_register_is_nothing() -> None:
    dock = dock_of(False)
    end = max(offset for one in registers(dock.agv_count) for offset in one.offsets) + 1
    with pytest.raises(IndexError, match=f"{DEVICES + end:X}h, where no device answers"):
        run([(0, DEVICES + end, [], 1)], dock, MS)


Ask = Callable[[plant.Dock, int, int, int], int]


def bits(places: list[str], say: Callable[[plant.Dock, int, int], int]) -> Ask:
    """Bit n of what the dock says of each drive, at the n-th of the places plus the drive's number."""
    return lambda dock, _i, _ray, t: sum(
        (say(dock, j, t) >> n & 1) << SYMBOLS[place] + j for n, place in enumerate(places) for j in range(5)
    )


# What each readable register shows, by the dock's functions.
SHOWS: dict[str, Ask] = {
    "ENCODER": lambda d, j, _, t: d.encoder(j, t),
    "SWAY_ALPHA": lambda d, _i, _, t: d.sway(0, t),
    "SWAY_BETA": lambda d, _i, _, t: d.sway(1, t),
    "SWAY2_ALPHA": lambda d, _i, _, t: d.second_sway(0, t),
    "SWAY2_BETA": lambda d, _i, _, t: d.second_sway(1, t),
    "LOAD_CELL": lambda d, _i, _, t: d.load_cell(t),
    "WIND_MEAN": lambda d, _i, _, t: d.wind_mean(t),
    "SPREADER_STATUS": lambda d, _i, _, t: d.spreader_status(t),
    "DRIVE_STATUS": bits(["DRIVE_READY", "DRIVE_FAULT", "DRIVE_LATE", "DRIVE_BRAKE"], plant.Dock.drive_status),
    "DRIVE_TRIP": bits(["TRIP_OVERSPEED", "TRIP_SATURATION", "TRIP_HEAT", "TRIP_WARNING"], plant.Dock.drive_trip),
    "DRIVE_HEAT": lambda d, j, _, t: d.drive_heat(j, t),
    "DRIVE_SPEED": lambda d, j, _, t: d.drive_speed(j, t),
    "SCAN_ROWS": lambda d, _i, _, t: d.scan_rows(),
    "SCAN_Y": lambda d, _i, _, t: d.scan_y(t),
    "SCAN_X0": lambda d, _i, _, t: d.scan_x0(),
    "SCAN_DX": lambda d, _i, _, t: d.scan_dx(),
    "SCAN_DECK": lambda d, _i, _, t: d.scan_deck(),
    "SCAN_PROFILE": lambda d, i, _, t: d.profile(i, t),
    "AGV_X": lambda d, i, _, t: d.agv_x(i, t),
    "AGV_Y": lambda d, i, _, t: d.agv_y(i, t),
    "AGV_HEADING": lambda d, i, _, t: d.agv_heading(i, t),
    "AGV_SPEED": lambda d, i, _, t: d.agv_speed(i, t),
    "AGV_STATUS": lambda d, i, _, t: d.agv_status(i, t),
    "RANGE_COUNT": lambda d, _i, _, t: 180,
    "RANGE_FIRST": lambda d, _i, _, t: -1_562_070,  # -89.5 degrees, as docs/plant.md has the sensor
    "RANGE_STEP": lambda d, _i, _, t: 17_453,  # 1 degree
    "RANGE_MOUNT": lambda d, _i, _, t: d.range_mount,
    "RANGE_SCAN": lambda d, i, _, t: d.range_scan(i, t),
    "RANGE_WAY": lambda d, i, _, t: d.range_way(i, t),
    "RANGE_RAY": lambda d, i, ray, t: d.agv_range(i, ray, t),
}

CODES = [300, -250, 200, -150, 2047]
SPEEDS = [900, -300]  # mm/s, by AGV
PUSHES = 3
MOVING = 500 * MS


def written(agvs: int) -> Iterator[tuple[int, list[tuple[str, int, int]], Callable[[plant.Dock, int], None]]]:
    """Writes (register, number, word) behind a latch, and the same as calls of a dock."""
    unit, words = SYMBOLS["AGV_UNIT"], SYMBOLS["AGV_UNIT_WORDS"]
    for agv in range(agvs):
        at = unit + agv * words
        yield agv, [("AGV_PERIOD", at, 200_000)], lambda d, t, agv=agv: d.agv_period(agv, 200_000, t)
        for n in range(PUSHES):
            push = SPEEDS[agv] + n, 300_000 + n, -200_000 - n
            names = ["AGV_SPEED_COMMAND", "AGV_FRONT_COMMAND", "AGV_REAR_COMMAND"]
            yield (
                10 + 10 * agv + n,
                [(name, at, word & 0xFFFFFFFF) for name, word in zip(names, push, strict=True)],
                lambda d, t, agv=agv, push=push: d.agv_push(agv, *push, t),
            )
    yield 100, [("SCAN_ROW", 0, 1)], lambda d, t: d.select_row(1, t)
    yield 101, [("SPREADER_COMMAND", 0, 1)], lambda d, t: d.spreader_command(1, t)
    yield MOVING // LATCH - 301, [("DRIVE_ENABLE", 0, 0b10111)], lambda d, t: d.enable_drives(0b10111, t)
    for latch in range(MOVING // LATCH - 300, MOVING // LATCH):
        for j, code in enumerate(CODES):
            yield (
                latch,
                [("DRIVE_TORQUE", j, code & 0xFFFFFFFF)],
                lambda d, t, j=j, code=code: d.set_torque_code(j, code, t),
            )


def test_each_register_shows_and_does_what_the_dock_does() -> None:
    dock, twin = dock_of(True), dock_of(True)
    agvs = dock.agv_count
    steps: list[Step] = []
    calls: list[tuple[int, Callable[[plant.Dock, int], None]]] = []
    for latch, words, call in written(agvs):
        at = latch * LATCH + 10 * US + 10 * US * sum(before // LATCH == latch for before, _ in calls)
        for name, place, word in words:
            steps.append((at, DEVICES + SYMBOLS[name] + place, [word], 0))
        calls.append((at, call))
    reads: list[tuple[int, Register, int]] = []
    for one in registers(agvs):
        for offset in one.offsets if one.readable else ():
            latch, within = divmod(len(reads), 40)
            reads.append((MOVING + latch * LATCH + 20 * US + 2 * US * within, one, offset))
    steps += [(at, DEVICES + offset, [], 1) for at, _, offset in reads]
    end = reads[-1][0] + LATCH
    m = run(steps, dock, end)

    for at, call in sorted(calls, key=lambda pair: pair[0]):
        call(twin, at)
    assert [step for step, _, _ in m.reads] == [at for at, _, _ in reads]
    shown: dict[str, set[int]] = {}
    for (at, one, offset), (_, _, [word]) in zip(reads, m.reads, strict=True):
        index, ray = one.offsets[offset]
        expected = SHOWS[one.name](twin, index, ray, at + US // 2) & 0xFFFFFFFF
        # An encoder counts on between the read and our guess at its instant.
        slack = 2 if one.name == "ENCODER" else 0
        assert abs(word - expected) <= slack, (one.name, index, ray, word, expected)
        shown.setdefault(one.name, set()).add(word)
    twin.advance_to(dock.time)
    assert dock.time == twin.time and dock.state_hash() == twin.state_hash()
    # Nothing was compared at rest: what has several numbers showed several values.
    for name in ("ENCODER", "DRIVE_SPEED", "AGV_X", "AGV_SPEED", "AGV_HEADING", "SCAN_PROFILE", "RANGE_RAY"):
        assert len(shown[name]) > 1, name
    assert shown["SCAN_Y"] == {twin.scan_y(end)} and twin.scan_y(end) != dock_of(True).scan_y(0)


def test_every_readable_register_has_an_oracle() -> None:
    assert {one.name for one in registers(2) if one.readable} == set(SHOWS)


def test_a_program_with_two_registers_at_one_offset_is_refused() -> None:
    text = (INCLUDE / "devices.inc").read_text()
    program = with_devices(text.replace("ENCODER             .set 010h", "ENCODER             .set 018h"))
    with pytest.raises(ValueError, match="two devices share offset 24 of bus B"):
        machine.Machine(program, dock=dock_of(False))
