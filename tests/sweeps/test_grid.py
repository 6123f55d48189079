"""The grid of a sweep: the runs that it makes, and the messages for a bad grid."""

from pathlib import Path
from typing import Any

import pytest
from cmrc.sweeps import GridError
from cmrc.sweeps import grid as grids


def text_of(tmp_path: Path, text: str) -> grids.Grid:
    path = tmp_path / "grid.toml"
    path.write_text(text)
    return grids.read(path)


def test_axes_are_multiplied_and_what_goes_together_is_not(tmp_path: Path) -> None:
    grid = text_of(
        tmp_path,
        """
        [fixed]
        preset = "saturated"
        duration_s = 0.5
        machine.idle_policy = "spin"
        [axes]
        dsps = [2, 3]
        "rates.servo_frequency_hz" = { from = 500, to = 1000, step = 250 }
        [[together]]
        agvs = [1, 2]
        agv_phase = ["together", "staggered"]
        [repeats]
        seeds = 2
        first = 7
        phases = true
        [[events]]
        at_s = 0.1
        action = "fail"
        dsp = 0
    """,
    )
    points = list(grid.points())
    assert len(points) == len(grid) == 2 * 3 * 2 * 2
    assert grid.names == ["machine.dsps", "rates.servo_frequency_hz", "dock.agvs", "scheduling.agv_phase"]
    first = points[0]
    assert first.place == {
        "machine.dsps": 2,
        "rates.servo_frequency_hz": 500.0,
        "dock.agvs": 1,
        "scheduling.agv_phase": "together",
    }
    assert first.settings == {
        **first.place,
        "run.duration_s": 0.5,
        "machine.idle_policy": "spin",
        "run.phase_jitter": True,
        "run.seed": 7,
    }
    assert first.preset == "saturated" and first.events == [{"at_s": 0.1, "action": "fail", "dsp": 0}]
    assert {(p.place["dock.agvs"], p.place["scheduling.agv_phase"]) for p in points} == {
        (1, "together"),
        (2, "staggered"),
    }
    assert [p.seed for p in points[:3]] == [7, 8, 7]


def test_ranges() -> None:
    def values(key: str, **of: Any) -> list[Any]:
        return [point.place[key] for point in grids.made({"axes": {key: of}}).points()]

    assert values("machine.dsps", **{"from": 1, "to": 8, "step": 3}) == [1, 4, 7]
    assert values("machine.cycle_time_factor", **{"from": 1, "to": 2, "step": 0.1})[-1] == 2.0
    assert len(values("machine.cycle_time_factor", **{"from": 1, "to": 2, "step": 0.1})) == 11
    assert values("machine.cycle_time_factor", **{"from": 1, "to": 4, "count": 3, "scale": "log"}) == [1.0, 2.0, 4.0]
    assert values("machine.cycle_time_factor", **{"from": 1, "to": 4, "count": 3}) == [1.0, 2.5, 4.0]


def test_values_of_ranges_are_those_that_were_written() -> None:
    def values(key: str, begin: float, end: float, **of: Any) -> list[Any]:
        return [point.place[key] for point in grids.made({"axes": {key: {"from": begin, "to": end, **of}}}).points()]

    rho = "report.control_cost_rho_m2"
    assert values(rho, 2.5e-12, 1e-11, step=2.5e-12) == [2.5e-12, 5e-12, 7.5e-12, 1e-11]
    assert values(rho, 1e-13, 5e-13, step=1e-13) == [1e-13, 2e-13, 3e-13, 4e-13, 5e-13]
    assert values(rho, 1e-13, 1e-9, count=5, scale="log") == [1e-13, 1e-12, 1e-11, 1e-10, 1e-9]
    assert values("run.duration_s", 0.1, 0.3, step=0.1) == [0.1, 0.2, 0.3]
    assert values("run.duration_s", 1, 2, step=1 / 3) == [1.0, 1 + 1 / 3, 1 + 2 / 3, 2.0]
    assert values("run.duration_s", 1, 1.9, step=0.1 * 3) == [1.0, 1.3, 1.6, 1.9]  # 0.30000000000000004
    assert values("run.seed", 1234567890123, 1234567890127, count=5) == list(range(1234567890123, 1234567890128))
    assert values("run.seed", 2**53 + 1, 2**53 + 4, step=1) == list(range(2**53 + 1, 2**53 + 5))
    assert values("run.seed", 1, 10**6, count=7, scale="log") == [10**n for n in range(7)]


def test_ten_million_runs_are_not_too_many() -> None:
    def runs(seeds: int) -> int:
        return len(
            grids.made(
                {"axes": {"cycle_time_factor": {"from": 1, "to": 2, "count": 10_000}}, "repeats": {"seeds": seeds}}
            )
        )

    assert runs(1000) == 10_000_000
    with pytest.raises(GridError, match="10010000 runs; at most 10000000"):
        runs(1001)


def test_a_preset_can_be_an_axis_and_a_file_stands_beside_the_grid(tmp_path: Path) -> None:
    grid = text_of(tmp_path, '[fixed]\nconfig = "base.toml"\n[axes]\npreset = ["base", "heavy"]\n')
    assert [point.preset for point in grid.points()] == ["base", "heavy"]
    assert next(grid.points()).config == str(tmp_path / "base.toml")
    assert "preset" not in next(grid.points()).settings


def test_a_grid_without_axes_or_with_one_value_on_each_is_one_run() -> None:
    assert grids.made({"axes": {"dsps": [2]}, "together": [{"agvs": [1], "seed": [3]}]}).names == [
        "machine.dsps",
        "dock.agvs",
        "run.seed",
    ]
    assert len(grids.made({"fixed": {}})) == len(list(grids.made({"fixed": {}}).points())) == 1


@pytest.mark.parametrize(("tables", "says"), [
    ({}, "the grid is empty; at least one of "),
    ({"axis": {}}, 'axis: no such table; did you mean "axes"?'),
    ({"axes": 3}, "axes: a table is expected"),
    ({"axes": {"dsps": []}}, "axes.dsps: the list is empty"),
    ({"axes": {"dsps": 3}}, "axes.dsps: a list of values"),
    ({"axes": {"dsps": [1, [2]]}}, "axes.dsps[1]: list cannot be used"),
    ({"axes": {"dsps": [1, 2, 1]}}, "axes.dsps[2]: 1 is given twice"),
    ({"axes": {"dsps": [1, 1.0]}}, "axes.dsps[1]: 1.0 is given twice"),
    ({"axes": {"servo_frequency_hz": [1000, 500, 1000.0]}}, "axes.servo_frequency_hz[2]: 1000.0 is given twice"),
    ({"axes": {"dsps": [1], "machine": {"dsps": [2]}}}, "machine.dsps is also given at axes.dsps"),
    ({"fixed": {"dsps": 1}, "axes": {"machine.dsps": [2]}}, "axes.machine.dsps: machine.dsps is also given at fixed.dsps"),
    ({"fixed": {"seed": 1}, "repeats": {"seeds": 2}}, "repeats.seeds: run.seed is also given at fixed.seed"),
    ({"fixed": {"phase_jitter": False}, "repeats": {"seeds": 2, "phases": True}}, "run.phase_jitter is also given at"),
    ({"axes": {"dspss": [1]}}, 'axes.dspss: no such key; did you mean "machine.dsps"?'),
    ({"axes": {"rated_load_kgg": [1]}}, "axes.rated_load_kgg: no such key; "),
    ({"axes": {"config": ["a", "b"]}}, "axes.config: no such key; docs/configuration.md lists the keys"),
    ({"axes": {"dsps": {"from": 4, "to": 1, "step": 1}}}, "from < to is expected"),
    ({"axes": {"dsps": {"from": 1, "to": 4}}}, "either step or count"),
    ({"axes": {"dsps": {"from": 1, "to": 4, "step": 0}}}, "axes.dsps.step: 0"),
    ({"axes": {"dsps": {"from": 1, "to": 4, "step": 1e-9}}}, "axes.dsps.step: 3000000001 values"),
    ({"axes": {"dsps": {"from": 1, "to": 4, "count": 3}}}, "2.5 is among its values; machine.dsps is a whole number"),
    ({"axes": {"seed": {"from": 1, "to": 10, "count": 3, "scale": "log"}}}, "3.16227766017 is among its values"),
    ({"axes": {"duration_s": {"from": 1e9, "to": 1.0000000000000002e9, "count": 9}}}, "axes.duration_s: neighbours are one number"),
    ({"axes": {"dsps": {"from": 1, "to": 4, "count": 1}}}, "axes.dsps.count: 1"),
    ({"axes": {"dsps": {"from": 1, "to": 4, "counts": 3}}}, "axes.dsps.counts: unknown"),
    ({"axes": {"cycle_time_factor": {"from": 0, "to": 4, "count": 3, "scale": "log"}}}, "begins above 0"),
    ({"axes": {"cycle_time_factor": [float("nan")]}}, "nan is not a number"),
    ({"together": [{"dsps": [1, 2], "agvs": [1]}]}, "together[0]: settings that go together have equally many values"),
    ({"together": [{"dsps": [1, 1], "agvs": [2, 2]}]}, "together[0]: a combination is given twice"),
    ({"together": {"dsps": [1]}}, "together: a list of tables"),
    ({"repeats": {"seeds": 0}}, "repeats.seeds: a whole number from 1"),
    ({"repeats": {"seeds": [1, 1]}}, "repeats.seeds: a seed is given twice"),
    ({"repeats": {"seeds": [1, 2**63]}}, "repeats.seeds: whole numbers from 0 to 2^63 - 1"),
    ({"axes": {"dsps": [1, -(2**70)]}}, "axes.dsps[1]: -1180591620717411303424 is beyond 64 bits"),
    ({"repeats": {"seeds": []}}, "repeats.seeds: whole numbers"),
    ({"repeats": {"first": 3}}, "repeats.first: needs repeats.seeds"),
    ({"repeats": {"times": 3}}, "repeats.times: unknown"),
    ({"events": [3]}, "events: a list of tables"),
    ({"axes": {"seed": {"from": 1, "to": 10_000, "step": 1}, "dsps": {"from": 1, "to": 10_000, "step": 1}}}, "100000000 runs; at most"),
])  # fmt: skip
def test_a_bad_grid_says_where_and_what_would_be_right(tables: dict[str, Any], says: str) -> None:
    with pytest.raises(GridError) as error:
        grids.made(tables, name="bad.toml")
    assert str(error.value).startswith("bad.toml: ") and says in str(error.value)


def test_bad_toml_is_named_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(GridError, match=r"grid.toml: no TOML: .*line 2"):
        text_of(tmp_path, "[axes]\ndsps = [1,,2]\n")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(GridError, match=r"binary.toml: no TOML"):
        grids.read(tmp_path / "binary.toml")
    with pytest.raises(GridError, match="/dev/zero: is larger than 16 MiB"):
        grids.read("/dev/zero")
    with pytest.raises(FileNotFoundError):
        grids.read(tmp_path / "missing.toml")


def test_a_hostile_name_is_shown_and_not_obeyed() -> None:
    with pytest.raises(GridError) as error:
        grids.made({"axes": {"\x1b[2Jdsps": [1]}})
    assert "\x1b" not in str(error.value) and "\\x1B" in str(error.value)
