"""Consents, cycle times and learning, against hand-made timelines."""

import struct

import pytest
from cmrc import _core

cmrc = _core.cmrc


def test_a_process_starts_only_when_all_have_consented() -> None:
    consents = cmrc.Consents(2)
    for first, second, target in [(2, 4, 3), (3, 6, 4), (1, 4, 7)]:
        consents.give(first, target)
        assert not consents.all(target)
        consents.give(second, target)
        assert consents.all(target)


def test_a_consent_is_a_one_place_token() -> None:
    consents = cmrc.Consents(1)
    consents.give(2, 3)
    consents.give(2, 3)
    consents.give(4, 3)
    consents.consume(3)
    assert not consents.given(2, 3)


def test_consents_of_an_agv_are_its_own_and_the_end_of_the_job_is_everybodys() -> None:
    consents = cmrc.Consents(2)
    consents.give(6, 4, 1)
    consents.give(3, 4)
    assert not consents.all(4, 0)
    assert consents.all(4, 1)
    consents.give(1, 8)
    consents.give(4, 8)  # nothing hangs on the crane
    consents.give(5, 8, 0)
    consents.give(5, 8, 1)
    consents.consume(8, 0)
    assert not consents.all(8, 0)
    assert consents.all(8, 1)
    consents.clear(4, 8)
    assert not consents.all(8, 1)


def test_cycle_times_of_one_crane_and_one_agv() -> None:
    # Crane: 3 in 0..70, 4 in 75..85 (the AGV came at 75), next 3 in 85..160. AGV 0: 5 in 85..120, 6 in 120..150, loaded again at 160.
    cycles = cmrc.Cycles()
    for at, number, started, robot in [
        (0, 3, True, 0), (70, 3, False, 0), (75, 4, True, 1), (85, 4, False, 1), (85, 3, True, 0), (85, 5, True, 1),
        (120, 5, False, 1), (120, 6, True, 1), (150, 6, False, 1), (160, 3, False, 0), (160, 4, True, 1), (172, 4, False, 1),
    ]:  # fmt: skip
        cycles.process(number, started, robot, at)
    first = cycles.cycles()[0]
    expected = {"t3": 70, "t_v": 5, "t4": 10, "T_g": 85, "t5": 35, "t6": 30, "t_w": 10, "t_wait": 22, "T_a": 172 - 85}
    assert {name: first[name] for name in expected} == pytest.approx(expected)
    assert cycles.completed == 1
    assert cycles.cycles()[1]["t_v"] == 0


def test_an_agv_waits_in_its_slot_and_in_the_spot_until_it_has_been_loaded() -> None:
    # AGV 0: loaded 80..90, out 90..120, back from 120, in a slot 140..145, in the spot from 150, loaded again 185..197. AGV 1 stands in the way.
    cycles = cmrc.Cycles()
    for at, number, started, robot in [
        (0, 3, True, 0), (80, 3, False, 0), (80, 4, True, 1), (90, 4, False, 1), (90, 3, True, 0), (90, 5, True, 1), (120, 5, False, 1), (120, 6, True, 1),
    ]:  # fmt: skip
        cycles.process(number, started, robot, at)
    cycles.agv_waits(0, True, 140)
    cycles.agv_waits(0, False, 145)
    cycles.agv_waits(0, True, 150)
    cycles.process(6, False, 1, 150)
    assert cycles.cycles()[0]["t6"] == 30 - 5  # moving up belongs to it, standing in the slot does not
    cycles.process(3, False, 0, 185)
    cycles.process(4, True, 1, 185)
    assert (cycles.cycles()[0]["t_w"], cycles.cycles()[0]["T_a"]) == (5 + 35, None)
    cycles.process(4, False, 1, 197)
    first, second = cycles.cycles()
    # Equations (2) to (4): the whole way from 90, when it had been loaded, to 197.
    expected = {"t3": 80, "t_v": 0, "t4": 10, "T_g": 90, "t5": 30, "t6": 25, "t_w": 40, "t_wait": 52, "T_a": 197 - 90}
    assert {name: first[name] for name in expected} == pytest.approx(expected)
    assert (second["t3"], second["t_v"], second["t4"], second["T_g"]) == (95, 0, 12, 107)


def test_the_crane_stands_above_the_spot_while_one_that_waited_in_a_slot_moves_up() -> None:
    # With two AGVs both may wait: AGV 1 in its slot from 30 to 60, then the crane from 65 until AGV 1 has come at 70.
    cycles = cmrc.Cycles()
    cycles.process(3, True, 0, 0)
    cycles.process(3, False, 0, 10)
    cycles.process(4, True, 2, 10)
    cycles.process(4, False, 2, 20)
    cycles.process(3, True, 0, 20)
    cycles.process(5, True, 2, 20)
    cycles.process(5, False, 2, 22)
    cycles.process(6, True, 2, 22)
    cycles.agv_waits(1, True, 30)
    cycles.agv_waits(1, False, 60)
    cycles.process(3, False, 0, 65)
    cycles.agv_waits(1, True, 70)
    cycles.process(6, False, 2, 70)
    cycles.process(4, True, 2, 70)
    first, second = cycles.cycles()
    assert (first["t_w"], first["t6"], second["t_v"]) == (30, 8 + 10, 5)


@pytest.mark.parametrize(
    ("rule", "present", "agvs", "driving", "t_w", "t_v", "expected"),
    [
        ("off", 160, 1, 80, 40, 0, 160),
        ("proportional", 160, 1, 80, 8, 0, 168),  # N* = 160 * 88 / 80 = 176, half the way: +8
        ("proportional", 160, 1, 80, 40, 0, 176),  # +40 wanted, at most 10 %
        ("proportional", 200, 1, 80, 0, 8, 190),  # N* = 200 * 72 / 80 = 180, half the way
        ("proportional", 200, 2, 80, 0, 4, 190),  # two AGVs: t_v counts twice
        ("proportional", 160, 1, 80, 0, 8, 160),  # not below N_a
        ("proportional", 319, 1, 80, 40, 0, 320),  # not above N^_a,max
        ("proportional", 160, 1, 80, 1.9, 0, 160),  # inside the dead band of 2 % of T_g = 100
        ("unit", 160, 1, 80, 40, 0, 161),
        ("unit", 170, 1, 80, 0, 40, 169),
    ],
)
def test_learning(rule: str, present: int, agvs: int, driving: float, t_w: float, t_v: float, expected: int) -> None:
    assert cmrc.learned_interval(cmrc.config(), rule, present, 160, agvs, driving, t_w, t_v, 100.0) == expected


def from_ti(word: int) -> float:
    """The value of a TI single, by its definition in the manual."""
    exponent, sign, fraction = struct.unpack("b", bytes([word >> 24]))[0], word >> 23 & 1, word & 0x7FFFFF
    if exponent == -128:
        return 0.0
    return float(((-2 if sign else 1) + fraction / 2**23) * 2.0**exponent)


@pytest.mark.parametrize("value", [0.0, 1.0, -1.0, -2.0, 0.5, -0.5, 1.5, -1.5, 3.141592653589793, -123456.789, 1e-30, -1e30, 2.0**-127])
def test_floats_for_the_job_areas(value: float) -> None:
    assert from_ti(cmrc.ti_float(value)) == pytest.approx(value, rel=2**-24, abs=0)


def test_one_and_minus_one_have_the_manuals_words() -> None:
    assert [cmrc.ti_float(v) for v in (1.0, -1.0, 0.0)] == [0x00000000, 0xFF800000, 0x80000000]
