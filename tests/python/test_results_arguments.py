"""``python -m cmrc.results``: which numbers its parameters can have."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from cmrc import _core
from cmrc.results import __main__ as command
from cmrc.results.claim import Claim
from cmrc.results.cost import Cost
from cmrc.results.dsps import Dsps, rates
from cmrc.results.importance import Importance
from test_results import lost


def first_of(one: dataclasses.Field[Any]) -> Any:
    """Its default, of a list the first value."""
    return one.default[0] if isinstance(one.default, tuple) else one.default


PARAMETERS = [
    (claim, one) for claim in command.CLAIMS for one in dataclasses.fields(claim) if not isinstance(first_of(one), str)
]


def told(claim: type[Claim], option: str, value: str) -> Claim:
    given = command.parser().parse_args(["--quick", f"{option}={value}"])
    return command.chosen(claim, given)


@pytest.mark.parametrize(("claim", "one"), PARAMETERS, ids=lambda of: of.name if hasattr(of, "name") else of.NAME)
def test_a_parameter_has_a_least_number(claim: type[Claim], one: dataclasses.Field[Any]) -> None:
    option, least, default = f"--{one.name.replace('_', '-')}", one.metadata["least"], first_of(one)
    beyond = ["9223372036854775808"] if isinstance(default, int) else ["inf", "nan", "1e300"]
    if isinstance(default, int):
        beyond.append(str((least or 0) - 1))
    elif least is None:
        beyond.append("0")
    elif least == 0:
        beyond.append("-1")
    for value in beyond:
        with pytest.raises(ValueError, match=rf"{option}: '{value}'; a (whole )?number.* expected$"):
            told(claim, option, value)


def test_zero_and_what_is_west_are_still_possible() -> None:
    for number, option in (
        (7, "--job-limit-s"),
        (7, "--left-out"),
        (5, "--dead-band"),
        (5, "--lanes-m"),
        (2, "--trials"),
    ):
        told(next(claim for claim in command.CLAIMS if claim.NUMBER == number), option, "0")
    assert told(command.Learning, "--lanes-m", "-5,3") == dataclasses.replace(
        command.Learning.quick(), lanes_m=(-5.0, 3.0)
    )


def test_a_value_given_twice_is_refused() -> None:
    for option, value in (("--dsps", "1,1"), ("--servo-hz", "1000,1e3"), ("--releases", "together,together")):
        with pytest.raises(ValueError, match=f"^{option}: '{value}' has a value twice; each is run once$"):
            told(Dsps, option, value)


@pytest.mark.parametrize("claim", [
    Dsps(servo_hz=(0.001,)), Dsps(servo_hz=(1e18,), refreshes_per_servo=2**62), Importance(point_hz=1e-300), Importance(servo_hz=1e-3),
], ids=str)  # fmt: skip
def test_rates_beyond_the_configuration_are_refused_by_it(claim: Claim) -> None:
    made = [run for run in claim.runs() if run.label["part"] in ("rate", "gaps")]
    with pytest.raises(_core.cmrc.ConfigError):
        _core.cmrc.config(preset=made[0].preset, settings=made[0].all_settings())


def test_the_ageing_of_vehicles_is_that_of_the_longest_interval() -> None:
    settings = rates(1000.0, 4)
    assert settings["scheduling.agv_interval_max_refreshes"] == 160  # twice 1 / 50 Hz
    assert settings["scheduling.a"] == 64


def test_time_is_lost_above_a_tenth_of_a_second_only() -> None:
    for lag_s, said in (
        (
            0.000123,
            "Time: no. No crane is more than 0.1 s late after 5 s; the longest lag (slow clocks, n) is 0.000123 s.",
        ),
        (0.0999, "is 0.0999 s."),
        (None, "is not measured."),
        (0.15, "Time: yes. "),
    ):
        row = {**lost("slow clocks", 60, 2, 1.0), "name": "n", "lag_s": lag_s}
        verdict = Cost().verdict([row])
        assert said in verdict.why
        assert verdict.word == ("holds in part" if lag_s and lag_s > 0.1 else "fails")
