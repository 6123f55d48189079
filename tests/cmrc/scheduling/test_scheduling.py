"""Equation (7) against the paper's table, and the scheduling rule against the hand-worked tables of plant-and-bus.md
4.8."""

import pytest
from cmrc_test import scheduling

BASE = {
    "N_p": 8,
    "N_t": 64,
    "N_a": 160,
    "gamma": 0,
    "alpha": 24,
    "beta": 12,
    "p": 0x4000,
    "q": 0x2000,
    "b": 0x100,
    "a": 0x40,
}

# (x, y, t, restored, as printed): the rows of paper.md 6, at the first t at which they hold and the last before.
ROWS = [
    (1, 0, 0, 0xFFFE, 0xFFFE),
    (2, 0, 0, 0xFFFD, 0xFFFC),
    (21, 2, 0, 0xFFFB, 0xFFFC),
    (7, 1, 8, 0xFFF7, 0xFFF7),
    (7, 1, 7, 0, 0),
    (8, 1, 8, 0xFFEF, 0xFFEC),
    (8, 1, 7, 0, 0),
    (5, 1, 40, 0xFFDF, 0x4000),
    (5, 1, 39, 0x4000, 0x2000 + 0x40 * 39),
    (6, 1, 52, 0xFFBF, 0xFFBF),
    (6, 1, 51, 0x4100, 0x4100),
    (5, 2, 136, 0xFF7F, 0xFF7F),
    (5, 2, 135, 0x2000 + 0x40 * 135, 0x2000 + 0x40 * 135),
    (6, 2, 148, 0xFEFF, 0xFEFF),
    (6, 2, 147, 0x2100 + 0x40 * 147, 0x2100 + 0x40 * 147),
    (11, 0, 0, 0xFDFF, 0xFDFF),
    (12, 0, 0, 0xFBFF, 0xFBFF),
    (13, 1, 0, 0xF7FF, 0xF7FF),
    (22, 2, 0, 0xEFFF, 0xEFFF),
]


@pytest.mark.parametrize(("x", "y", "t", "restored", "printed"), ROWS)
def test_importance_is_the_papers_table(x: int, y: int, t: int, restored: int, printed: int) -> None:
    assert scheduling.importance(x, y, t, BASE) == restored
    assert scheduling.importance(x, y, t, BASE | {"as_printed": True}) == printed


def test_restored_urgent_values_clear_one_bit_each_in_order() -> None:
    urgent = [scheduling.importance(x, y, 10**6, BASE) for x, y in
              [(1, 0), (2, 0), (21, 2), (7, 1), (8, 1), (5, 1), (6, 1), (5, 2), (6, 2), (11, 0), (12, 0), (13, 1), (22, 2)]]  # fmt: skip
    assert urgent == [0xFFFF & ~(1 << bit) for bit in range(13)]


def test_gamma_makes_the_servo_due_early() -> None:
    assert [scheduling.importance(7, 1, t, BASE | {"gamma": 3}) for t in (4, 5)] == [0, 0xFFF7]


def test_a_kind_without_a_rank_is_an_error() -> None:
    with pytest.raises(ValueError, match="x = 9, robot class y = 1"):
        scheduling.importance(9, 1, 0, BASE)
    with pytest.raises(ValueError, match="x = 5, robot class y = 0"):
        scheduling.importance(5, 0, 0, BASE)


# The tables of 4.8, typed from the document: block:t[:J], * executing. Where the document leaves J out, it is not
# compared.
ONE_DSP = """\
TC:0:FFF7* TP:1:4000 ATP:1:2010 PID:2:0
PID:0:FFEF* TP:2:4000 ATP:2:2020 TC:1:0
TP:0:4000* ATP:3:2030 TC:2:0 PID:1:0
TC:3:FFF7 TP:1* ATP:4:2040 PID:2:0
TC:4:FFF7 PID:3:FFEF TP:2* ATP:5:2050
OBS:0:FFFB* TC:5:FFF7 PID:4:FFEF IK:1:4100 ATP:6:2060
OBS:1* TC:6 PID:5 IK:2 ATP:7
TC:0:FFF7* PID:6:FFEF IK:3:4100 ATP:8:2080
PID:0* IK:4 ATP:9:2090 TC:1:0
IK:0:4100* ATP:10:20A0 TC:2 PID:1
TC:0* ATP:11:20B0 PID:2
PID:0* ATP:12:20C0 TC:1
ATP:0:20D0* TC:2 PID:1"""

TWO_DSPS = """\
TC:0:FFF7* TP:0:4000* ATP:1:2010 PID:2:0
PID:0* TP:1* ATP:2:2020 TC:1
TP:2* ATP:0:2030* TC:2 PID:1
TC:0:FFF7* IK:1:4100 ATP:1* PID:2
PID:0* IK:2 ATP:2* TC:1
OBS:0:FFFB* IK:0:4100* AIK:1:2110 TC:2 PID:1
OBS:1* TC:0:FFF7* AIK:2:2120 PID:2
PID:0* AIK:0:2130* TC:1
TC:2 PID:1
TC:0* PID:2"""


def entry(text: str) -> tuple[str, int, str | None, bool]:
    name, t, *importance = text.rstrip("*").split(":")
    return name, int(t), importance[0] if importance else None, text.endswith("*")


@pytest.mark.parametrize(("dsps", "table"), [(1, ONE_DSP), (2, TWO_DSPS)])
def test_tick_tables_of_the_worked_example(dsps: int, table: str) -> None:
    parameters = {
        "N_p": 4,
        "N_t": 16,
        "N_a": 24,
        "gamma": 1,
        "alpha": 4,
        "beta": 2,
        "p": 0x4000,
        "q": 0x2000,
        "b": 0x100,
        "a": 0x10,
    }
    machine = scheduling.TickTable(parameters, [
        ("TC", 7, 1, 1, True, ""), ("PID", 8, 1, 1, True, ""), ("TP", 5, 1, 3, False, "IK"), ("IK", 6, 1, 1, False, ""),
        ("ATP", 5, 2, 3, False, "AIK"), ("AIK", 6, 2, 1, False, ""), ("OBS", 21, 2, 2, False, ""),
    ], dsps)  # fmt: skip
    for name, t in [("TC", 2), ("PID", 1), ("TP", 0), ("ATP", 0)]:
        machine.load(name, t)
    for k, line in enumerate(table.splitlines()):
        if k == 5:
            machine.load("OBS", 0)
        expected = [entry(word) for word in line.split()]
        got = [entry(word) for word in machine.tick()]
        masked = [(n, t, j if e[2] is not None else None, run) for (n, t, j, run), e in zip(got, expected, strict=True)]
        assert masked == expected, f"tick {k}"
