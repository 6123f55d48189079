"""The error block: it decides by the table of docs/controller.md, and keeps a log: in order, the oldest overwritten, no
entry twice when it is run again."""

import itertools
import re

import pytest
from harness import WINDOW_A, Dsp
from locations import ROOT

ORIGINS = {"following error": 1, "drive fault": 2, "drive time-out": 3, "encoder": 4, "sway sensor": 5, "landing": 6, "block given up": 7,
           "drive overspeed": 8, "drive saturated": 9, "drive overheated": 10}  # fmt: skip
RESPONSES = {"stop": 1, "hold": 2, "set down": 3, "retry": 4, "second sensor": 5}
SITUATIONS = {"tries left": 0x10000, "lowering": 0x20000, "second sensor free": 0x80000}
HOIST = 8 << 4


def documented() -> list[tuple[str, set[str], set[str], str]]:
    """Rows of the page: origin, what has to be so, what must not, response."""
    text = (ROOT / "docs" / "controller.md").read_text(encoding="utf-8")
    table = text.split("| origin | where | response |")[1].split("\n\n")[0]
    rows = []
    for line in table.splitlines()[2:]:
        origin, where, response = (cell.strip() for cell in line.strip("|").split("|")[:3])
        conditions = [] if where == "else" else where.split(" and ")
        needs = {c for c in conditions if not c.startswith("not ")}
        forbids = {c.removeprefix("not ") for c in conditions if c.startswith("not ")}
        rows.append((origin, needs, forbids, re.sub(r"\*", "", response)))
    return rows


def test_it_decides_as_the_page_says() -> None:
    dsp = Dsp()
    rows = documented()
    assert {row[0] for row in rows} == set(ORIGINS)
    for origin, number in ORIGINS.items():
        for facts in itertools.chain.from_iterable(itertools.combinations(SITUATIONS, n) for n in range(4)):
            for hoist in (False, True):
                true = set(facts) | ({"the hoist"} if hoist else set())
                want = next(
                    response
                    for o, needs, forbids, response in rows
                    if o == origin and needs <= true and not forbids & true
                )
                argument = number | (HOIST if hoist else 0x20) | sum(SITUATIONS[f] for f in facts)
                result, notify, _ = dsp.run("error", argument=argument, tick=1)
                assert (result >> 16, notify) == (RESPONSES[want], 0), (origin, facts, hoist)


@pytest.mark.parametrize("argument", [0, 11, 15])
def test_an_origin_that_it_does_not_know_is_held(argument: int) -> None:
    assert Dsp().run("error", argument=argument)[0] >> 16 == RESPONSES["hold"]


def test_the_log_keeps_the_last_sixteen() -> None:
    dsp = Dsp()
    s = dsp.symbols
    log = WINDOW_A + s["ER_BASE"]
    errors = [(100 + 7 * n, 7 | (n % 12) << 4, 0x1000 + 0x100 * n, n + 1) for n in range(21)]
    for n, (tick, what, area, generation) in enumerate(errors):
        dsp.chip.poke(s["TASK"] + s["TB_AREA"], area)
        dsp.chip.poke(s["TASK"] + s["TB_GENERATION"], generation)
        for _ in range(2 if n % 3 == 0 else 1):
            result, notify, _ = dsp.run("error", argument=what, tick=tick)
            assert (result & 0xFFFF, notify) == (n + 1, 0)
        assert dsp.chip.peek(log) == n + 1
    for n in range(5, 21):
        tick, what, area, generation = errors[n]
        assert tuple(dsp.chip.read(log + s["ER_LOG"] + 4 * (n % 16), 4)) == (
            tick,
            what | RESPONSES["stop"] << 28,
            area,
            generation,
        )
