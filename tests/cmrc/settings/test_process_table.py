"""The table of processes: the built-in table is the paper's, a user's own rows change what runs, and bad rows are
refused with their place."""

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from locations import AT_ONCE, AT_ONCE_OPTIONS, BUILD, ROOT
from traced_run import trace_of

cmrc = _core.cmrc
try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

EMULATOR = BUILD / "bin" / "emulator"


def built_in() -> dict[str, Any]:
    text = subprocess.run([EMULATOR, "config", "--processes"], capture_output=True, text=True, check=True).stdout
    assert text == (ROOT / "emulator" / "cmrc" / "configuration" / "rows" / "processes.toml").read_text()
    return tomllib.loads(text)


# paper section 3, typed from its table: process -> (sub-processes, must, may).
PAPER = {
    1: ([], [2], [7, 8]),
    2: ([], [], [3]),
    3: ([1, 2, 3, 4], [1], [4]),
    4: ([1, 2, 3, 4], [5], [7, 3]),  # 1 and 2 besides the paper's: ruling 38
    5: ([1, 2, 5], [6], [8]),
    6: ([1, 2, 5], [], [4]),
    7: (None, [], []),
    8: (None, [], []),
}


def test_what_is_built_in_is_the_papers_table() -> None:
    rows = {row["number"]: row for row in built_in()["processes"]}
    assert rows.keys() == PAPER.keys()
    for number, (subprocesses, must, may) in PAPER.items():
        row = rows[number]
        if subprocesses is not None:
            assert row.get("subprocesses", []) == subprocesses
        assert row.get("must", []) == must
        # One consent more than the paper's: 4 to 8 (docs/processes.md says why).
        assert sorted(row.get("may", [])) == sorted(may + ([8] if number == 4 else []))
    assert [row.get("must") for row in built_in()["subprocesses"]] == [[1, 2], None, None, None, None]


def test_the_whole_configuration_reads_back_as_itself() -> None:
    toml = cmrc.config().to_toml()
    assert toml.count("[[processes]]") == 8 and toml.count("[[subprocesses]]") == 5
    assert cmrc.config(toml=toml).to_toml() == toml
    last = 'steps = ["hold 0.03"]\ninitial = [1, 4, 5]\nreplaces = [6]\nfinal = true'
    own = cmrc.config(toml=row(8, "agv", last)).to_toml()
    assert "final = true\n" in own and cmrc.config(toml=own).to_toml() == own


def processes_of(toml: str, duration_s: float, tmp_path: Path, *more: str) -> list[tuple[float, int, int, int]]:
    """(second, process, started, robot) as the run's trace tells them."""
    trace, _report = trace_of(tmp_path, "--duration", duration_s, *AT_ONCE_OPTIONS, *more, toml=toml)
    found = re.findall(
        r"^([0-9.]+) \[host\] process number=(\d+) state=(\d) robot=(\d+)$", trace.read_text(), re.MULTILINE
    )
    return [(float(at), int(number), int(state), int(robot)) for at, number, state, robot in found]


TEMPLATE = """
[[processes]]
number = {number}
name = "{name}"
robot = "{robot}"
{rest}
"""


def row(number: int, robot: str, rest: str, name: str = "own") -> str:
    return TEMPLATE.format(number=number, name=name, robot=robot, rest=rest)


def test_the_order_of_the_start_is_1_2_3(tmp_path: Path) -> None:
    assert [entry[1:] for entry in processes_of("", 0.01, tmp_path)] == [
        (1, 1, 0),
        (1, 0, 0),
        (2, 1, 0),
        (2, 0, 0),
        (3, 1, 0),
    ]


def test_a_step_more_is_taken(tmp_path: Path) -> None:
    # Process 3 begins with a pause of 20 ms: its first point is planned that much later.
    steps = '["hold 0.02", "leg 1", "settle", "lower", "lock", "raise", "leg 2", "settle"]'
    grab = row(
        3,
        "crane",
        f'subprocesses = [1, 2, 3, 4]\nsteps = {steps}\nmust = [1]\nmay = [4]\ninitial = [4]\nclears = ["4->7", "4->8"]',
    )
    plain, held = (json.loads(run_report(toml, 0.1)) for toml in ("", grab))
    points = [report["tasks"]["trajectory_planning.crane"]["released"] for report in (plain, held)]
    assert points[0] - points[1] in (2, 3)  # 20 ms of 8 ms each


def test_the_end_of_a_process_names_the_robot_of_its_start(tmp_path: Path) -> None:
    """Process 8 of two vehicles: 30 ms each, by a table that lets it begin at once."""
    home = row(8, "agv", 'steps = ["hold 0.03"]\ninitial = [1, 4, 5]\nreplaces = [6]\nfinal = true')
    changes = [entry[1:] for entry in processes_of(home, 0.06, tmp_path, "--set", "dock.agvs=2") if entry[1] == 8]
    assert changes == [(8, 1, 1), (8, 1, 2), (8, 0, 1), (8, 0, 2)]


def run_report(toml: str, duration_s: float, **settings: Any) -> str:
    simulation = cmrc.Simulation(
        cmrc.config(toml=toml, settings={**AT_ONCE, "duration_s": duration_s, "report.reference": "none", **settings})
    )
    simulation.run()
    report = simulation.report_json()
    assert json.loads(report)["audit"]["violations"] == []
    return str(report)


def test_a_process_of_ones_own_runs_when_it_is_consented_to(tmp_path: Path) -> None:
    # 9 waits for 2's consent; when it has looked at the bay once more it consents to 3, which waits for it now.
    plan = row(2, "none", 'steps = ["task grab_path"]\nnotify = "task"\nmay = [3]\nmust = []', "plan the grab")
    weigh = row(9, "none", 'steps = ["task identify", "task identify"]\nmay = [3]\nloaded = true')
    order = [entry[1:3] for entry in processes_of(plan + weigh, 0.02, tmp_path)]
    assert order.index((9, 0)) < order.index((3, 1))
    assert order.index((2, 0)) < order.index((3, 1))
    assert order.count((9, 1)) == 1


def test_sub_process_5_is_released_where_its_row_and_the_processes_say() -> None:
    """A vehicle that stands is in no process that lists 5; one that drives is in process 6. load.parked says otherwise
    of row 5, whatever it has."""
    quiet = (
        '[[subprocesses]]\nnumber = 5\nname = "obstacle avoidance"\nagv = "obstacle_avoidance"\nrelease = "interval"\n'
    )
    parked = quiet + "between_processes = true\n"
    for rows, more, expected in [
        (quiet, {}, 0), ("", {}, 0), (parked, {}, 4), ("", {"load.driving": True}, 4), (quiet, {"load.driving": True}, 4), ("", {"load.parked": True}, 4),
    ]:  # fmt: skip
        report = json.loads(run_report(rows, 0.1, **{"load.avoidance_cycles": 1000, **more}))
        assert report["tasks"]["obstacle_avoidance"]["released"] == expected, (
            rows,
            more,
        )  # at refreshes 160, 320, 480, 640


def test_a_processs_steps_decide_when_the_servo_runs() -> None:
    # Literal reading of plant-and-bus.md 4.4 item 5: 3 and 4 only while a process that is made of them lives. Process 3
    # starts at 2.4 ms here.
    rows = "".join(
        f'[[subprocesses]]\nnumber = {n}\nname = "{name}"\ncrane = "{name}"\nrelease = "tick"\n'
        for n, name in ((3, "torque_compensation"), (4, "pid"))
    )
    released = json.loads(run_report(rows, 0.1))["tasks"]["pid"]["released"]
    assert released == 97  # ticks 3 ms, 4 ms, ..., 99 ms


@pytest.mark.parametrize(("toml", "place", "says"), [
    (row(9, "none", 'steps = ["task identify"]'), "own.toml:2:1", "process 9: can never start: no process demands or consents to it"),
    (row(9, "none", 'steps = ["task identify"]\nmay = [10]') + row(10, "none", 'steps = ["task identify"]\nmay = [9]'), "own.toml:2:1",
     "process 9: can never start: it waits for process 10, which waits for others in a circle"),
    (row(9, "none", 'steps = ["task identify"]\nloaded = true\nmust = [12]'), "own.toml:2:1", "there is no process 12"),
    (row(9, "none", 'steps = ["task identify"]\nloaded = true\ninitial = [2]'), "own.toml:2:1", "process 2 never consents to it; 9 in `may` of process 2"),
    (row(9, "none", 'steps = ["task identify"]\nloaded = true\nclears = ["2->9"]'), "own.toml:2:1", "there is no consent 2->9"),
    (row(9, "none", 'steps = ["task identify"]\nloaded = true\nclears = ["29"]'), "own.toml:8:11", '"29" names no consent'),
    (row(9, "none", 'steps = ["task identify"]\nloaded = true\nmust = [5]'), "own.toml:2:1", "no AGV is named for process 5"),
    (row(9, "none", 'steps = ["task weigh"]\nloaded = true'), "own.toml:2:1", '"weigh" is not a possible task'),
    (row(9, "none", 'steps = ["leg 1"]\nloaded = true'), "own.toml:2:1", '"leg 1" is not for its robot'),
    (row(9, "none", 'steps = ["dance"]\nloaded = true'), "own.toml:6:10", '"dance" is not a step; "task", "leg", '),
    (row(9, "none", 'steps = ["leg 4"]\nloaded = true'), "own.toml:6:10", "1, 2 or 3 is expected after it"),
    (row(9, "none", "steps = []\nloaded = true"), "own.toml:2:1", "no step; at least one is expected"),
    (row(9, "ship", 'steps = ["leg 1"]'), "own.toml:5:9", '"ship" is not known; "none", "crane" or "agv" is expected'),
    (row(16, "none", 'steps = ["leg 1"]'), "own.toml:3:10", "an integer from 1 to 15 is expected"),
    (row(9, "none", 'stepps = ["leg 1"]'), "own.toml:6:10", "processes.stepps: no such field"),
    (row(3, "crane", 'subprocesses = [1, 2]\nsteps = ["leg 1"]\nmay = [4]\ninitial = [4]'), "own.toml:2:1", '"leg 1" needs sub-processes 3 and 4'),
    (row(3, "crane", 'subprocesses = [1, 2, 3, 4]\nsteps = ["align"]\nmay = [4]\ninitial = [4]'), "own.toml:2:1", '"align" without an AGV'),
    (row(4, "crane", 'subprocesses = [3, 4]\nsteps = ["align"]\nmay = [3, 7, 8]\nmust = [5]'), "own.toml:2:1", '"align" needs sub-processes 1 and 2'),
    (row(7, "crane", 'account = "t_3"\nsubprocesses = [1, 2, 3, 4]\nsteps = ["leg 3"]\nfinal = true'), "own.toml:2:1", "t_3 is already the time of process 3"),
    (row(5, "agv", 'account = "t_4"\nsubprocesses = [1, 2]\nsteps = ["leg 1"]\nmust = [6]\nmay = [8]'), "own.toml:2:1", "t_4 does not belong to its robot"),
    (row(4, "crane", 'account = "t_5"\nsteps = ["hold 1"]\nmay = [3, 7, 8]\nmust = [5]'), "own.toml:2:1", "t_5 does not belong to its robot; a process of an AGV"),
    (row(5, "agv", 'account = "t_7"\nsteps = ["hold 1"]'), "own.toml:6:11", '"none", "t_3", "t_4", "t_5" or "t_6" is expected'),
    ('[[subprocesses]]\nnumber = 1\nname = "x"\ncrane = "trajectory_planning.crane"\nagv = "trajectory_planning.agv"\nrelease = "point"\nmust = [2]\n', "own.toml:1:1",
     'without 1 "leg 1" of process 3 would never end'),
    ('[[subprocesses]]\nnumber = 1\nname = "x"\ncrane = "trajectory_planning.crane"\nagv = "trajectory_planning.agv"\nrelease = "point"\nmust = [1, 2, 3]\n', "own.toml:1:1",
     "its task cannot demand 3"),
    (row(9, "none", 'steps = ["task identify"]\nloaded = true') * 2, "own.toml:9:1", "processes.number: 9 is given twice"),
    ('[[subprocesses]]\nnumber = 1\nname = "x"\ncrane = "pid"\nrelease = "point"\n', "own.toml:1:1", "sub-process 1: only the name"),
    ('[[subprocesses]]\nnumber = 6\nname = "x"\nagv = "user.y"\nrelease = "interval"\n', "own.toml:1:1", '"user.y" is not a task for an AGV'),
    ("processes = 3\n", "own.toml:1:13", "[[processes]] begins each of them"),
    (row(4, "crane", 'subprocesses = [1, 2, 3, 4]\nsteps = ["leg 1"]\nmay = [3, 7, 8]\nmust = [3]\ninitial = [6]'), "built-in row of process 5 (emulator config --processes): processes.number",
     "process 5: can never start: no process demands or consents to it (rows of yours: process 4 at own.toml:2:1); "),
])  # fmt: skip
def test_a_table_without_sense_is_refused(toml: str, place: str, says: str) -> None:
    with pytest.raises(cmrc.ConfigError, match=re.escape(says)) as error:
        cmrc.config(toml=toml, name="own.toml")
    assert str(error.value).startswith(place + ":")
