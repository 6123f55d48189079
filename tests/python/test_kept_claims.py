"""What the claims ask for, and what they tell of cycles, as it is kept in tests/golden."""

import dataclasses
import shlex
from collections.abc import Callable
from typing import Any

import pytest
from cmrc.results import __main__ as command
from cmrc.results.claim import Claim
from cmrc.results.failures import Failures
from cmrc.results.fleet import Fleet
from cmrc.results.learning import Learning
from digests import digest
from drawn import described
from matplotlib.figure import Figure

NEGATIVE = Fleet(lanes_m=(-5.0, 3.0))


@pytest.mark.parametrize("claim", [*(claim.quick() for claim in command.CLAIMS), NEGATIVE], ids=lambda one: one.NAME)
def test_what_stands_behind_again_makes_the_same_experiment(claim: Claim) -> None:
    given = command.parser().parse_args(shlex.split(command.options(claim)))
    assert command.chosen(type(claim), given) == claim


@pytest.mark.golden
def test_the_experiments_of_the_page_are_those_that_are_kept(golden: Callable[[str, str], None]) -> None:
    """What each claim asks for with its own parameters; what it has on its page was measured in these runs."""
    lines = []
    for claim in command.CLAIMS:
        asked = dataclasses.asdict(claim())
        lines.append(f"{claim.NAME} parameters {digest(asked)}\n")
        if claim is not Failures:  # which makes runs of its own, to see when a kernel runs
            runs = [dataclasses.asdict(run) for run in claim().runs()]
            lines.append(
                f"{claim.NAME} {len(runs)} runs {sum(run['duration_s'] for run in runs):.6g} s {digest(runs)}\n"
            )
    golden("claims/asked.digests", "".join(lines))


@pytest.mark.golden
def test_work_cycles_are_told_and_drawn_as_it_is_kept(golden: Callable[[str, str], None]) -> None:
    """No cycle closes in the second that the experiments in small last."""

    def cycle(number: int, t_w: float | None, T_g: float | None, t_v: float = 5.0) -> dict[str, Any]:
        # fmt: off
        return {"number": number, "agv_interval_refreshes": 40 + number, "t_5_s": 30.0, "t_6_s": 50.0, "t_w_s": t_w, "t_v_s": t_v, "T_g_s": T_g, "delivered_s": 100.0 * number + 40}
        # fmt: on

    report = {"cycles": [cycle(0, 9.0, 90.0, 60.0), cycle(1, 3.0, 100.0), cycle(2, None, 104.0), cycle(3, 1.0, None)]}
    told = []
    for claim in (Learning(), Fleet()):
        runs = [run for run in claim.runs() if run.label.get("rule") != "off"]
        rows = claim.rows([(run, [{**report, "tasks": {"pid": {"misses": 2}}}]) for run in runs])
        claim.draw(rows, figure := Figure())
        told.append(claim.section(rows) + described(figure))
    golden("claims/cycles.text", "\n".join(told))
