"""Tasks with a DSP of their own (docs/add-a-task.md, dsp): judged from the event trace and the report alone."""

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import chain_replay
import pytest
import scheduling_replay
from cmrc import _core
from locations import AT_ONCE, AT_ONCE_OPTIONS, BUILD, ROOT
from scheduling_replay import Event, Replay, Rule, UserTask

cmrc = _core.cmrc
US, MS = 10**6, 10**9  # ps
FIRST = 12  # KIND_USER

# TB_ARGUMENT cycles of work, counted in word 0 of its area; `stuck`: for ever when word 1 is not 0 and word 0 is.
KERNELS = """
kernel_works:
        ldi     @TASK + TB_ARGUMENT, rc
        rpts    rc
        nop
        ldi     *ar6, r2
        addi    1, r2
        sti     r2, *ar6
        ldi     r2, r0
        ldi     0, r1
        rets
"""


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("own") / "programs"
    shutil.copytree(ROOT / "c40_programs", directory)
    (directory / "kernels" / "user.asm").write_text(KERNELS)
    return directory


def row(name: str, dsp: int | None, **fields: Any) -> dict[str, Any]:
    """A task of 500 us (12 500 cycles), every 5 ms, with a J between the servo's and that of planning."""
    given = {
        "name": name,
        "program": "kernel_works",
        "importance": 0x7000,
        "period_ms": 5,
        "deadline_ms": 4,
        "argument": 12500,
    }
    return given | ({} if dsp is None else {"dsp": dsp}) | fields


def toml_of(rows: list[dict[str, Any]], events: list[dict[str, Any]] | None = None) -> str:
    text = ""
    for n, fields in enumerate(rows):
        text += "[[tasks]]\n" + "".join(
            f"{key} = {json.dumps(value)}\n" for key, value in ({"kind": 23 + n} | fields).items()
        )
    for fields in events or []:
        text += "[[events]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in fields.items())
    return text


class Run:
    """A run by the command: its events and report, and what both replays say of it."""

    def __init__(
        self,
        tmp_path: Path,
        programs: Path,
        rows: list[dict[str, Any]],
        *options: str,
        events: list[dict[str, Any]] | None = None,
        rule: Rule | None = None,
    ) -> None:
        config, trace, report = tmp_path / "run.toml", tmp_path / "trace", tmp_path / "report.json"
        config.write_text(toml_of(rows, events))
        settings = (f"machine.programs={programs}", "report.misses_max=100000", "report.reference=none")
        command = [BUILD / "bin" / "emulator", "--quiet", "--config", config, "--trace", trace, "--report", report]
        command += [word for setting in settings for word in ("--set", setting)]
        command += [*AT_ONCE_OPTIONS, *options]
        finished = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
        assert finished.returncode in (0, 1), finished.stderr
        self.report: dict[str, Any] = json.loads(report.read_text())
        assert self.report["audit"]["violations"] == []
        with trace.open() as lines:
            self.events: list[Event] = list(scheduling_replay.events(lines))
        self.rows = rows
        tasks = {
            FIRST + n: UserTask(
                r["importance"], r.get("importance_waiting", r["importance"]), r.get("due_refreshes", 0), r.get("dsp")
            )
            for n, r in enumerate(rows)
        }
        self.replay = Replay(rule or Rule(), doorbells="--idle-policy" not in options)
        self.replay.rule.tasks = tasks
        self.replay.follow(self.events)
        assert self.replay.faults == []
        assert self.replay.claims == sum(dsp["claims"] for dsp in self.report["dsps"])
        names = {FIRST + n: (f"user.{r['name']}", r.get("dsp")) for n, r in enumerate(rows)}
        dsps = int(options[options.index("--dsps") + 1])
        trace_of = chain_replay.Trace(self.events, dsps, 8, 8000, names, empty=len(self.report["dsps"]) - dsps)
        self.chains = chain_replay.check(trace_of, self.report)

    def claims(self, name: str) -> list[tuple[int, int]]:
        """Time and slot of each claim of a task's blocks."""
        kind = FIRST + next(n for n, r in enumerate(self.rows) if r["name"] == name)
        return [
            (time, int(who.split()[1])) for time, who, what, n in self.events if what == "claim" and n["kind"] == kind
        ]

    def runs(self, name: str) -> list[tuple[int, int]]:
        """From claim to finish."""
        kind = FIRST + next(n for n, r in enumerate(self.rows) if r["name"] == name)
        ends = [time for time, _, what, n in self.events if what == "finish" and n["kind"] == kind]
        return [(claimed, end) for (claimed, _), end in zip(self.claims(name), ends, strict=False)]

    def task(self, name: str) -> dict[str, Any]:
        found: dict[str, Any] = self.report["tasks"][f"user.{name}"]
        return found


# ---- who claims

MIXED = [row("high", 2, importance=0xFBFE), row("low", 2, importance=0x0100), row("other", 0), row("anybody", None)]


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        ("--dsps 4 --duration 0.3", Rule()),
        ("--dsps 3 --duration 0.3 --idle-policy spin", Rule()),
        ("--dsps 3 --duration 0.3 --idle-policy pause", Rule()),
        ("--dsps 4 --duration 0.2 --preset saturated", Rule()),
        ("--dsps 3 --duration 0.2 --preset saturated --set scheduling.slice_cycles=10000", Rule()),
        ("--dsps 16 --duration 0.1 --set dock.agvs=8", Rule()),
        ("--dsps 3 --duration 0.2 --set scheduling.gamma_refreshes=2", Rule(gamma=2)),
    ],
)
def test_only_its_dsp_ever_claims_a_block_and_the_order_of_all_is_by_importance(
    tmp_path: Path, programs: Path, options: str, rule: Rule
) -> None:
    run = Run(tmp_path, programs, MIXED, *options.split(), rule=rule)
    assert {slot for _, slot in run.claims("high")} == {slot for _, slot in run.claims("low")} == {2}
    assert {slot for _, slot in run.claims("other")} == {0}
    assert len(run.claims("high")) >= run.task("high")["released"] - 1 >= 18
    assert run.replay.refreshes == run.report["host"]["refreshes"]


def test_a_block_for_anybody_is_claimed_past_one_that_waits_for_its_dsp(tmp_path: Path, programs: Path) -> None:
    """DSP 1 has work for 4 ms and another block of its own behind it; of a lower J, blocks for anybody go on."""
    rows = [
        row("long", 1, argument=100_000, importance=0x7002),
        row("waits", 1, importance=0x7001),
        row("anybody", None, importance=0x7000),
    ]
    run = Run(tmp_path, programs, rows, "--dsps", "2", "--duration", "0.2")
    assert run.task("long")["on_time"] == 0 and run.task("waits")["late"] >= 18  # 4 ms and what stood before it
    assert run.task("anybody")["misses"] == 0
    for (waits, _), (anybody, slot) in zip(run.claims("waits"), run.claims("anybody"), strict=False):
        assert anybody < waits and slot == 0


def test_two_tasks_with_dsps_of_their_own_run_at_the_same_time(tmp_path: Path, programs: Path) -> None:
    run = Run(tmp_path, programs, [row("one", 0), row("two", 1)], "--dsps", "2", "--duration", "0.2")
    pairs = list(zip(run.runs("one"), run.runs("two"), strict=True))
    assert len(pairs) >= 38 and run.task("one")["misses"] == run.task("two")["misses"] == 0
    beside = [min(a[1], b[1]) - max(a[0], b[0]) for a, b in pairs]
    assert min(beside) > 300 * US  # of 500 us each, less what PID and planning take of either DSP before
    alone = Run(tmp_path, programs, [row("one", 0), row("two", 0)], "--dsps", "2", "--duration", "0.2")
    assert all(a[1] < b[0] for a, b in zip(alone.runs("one"), alone.runs("two"), strict=True))


def test_a_dsp_is_left_to_its_own_block_where_another_can_do_what_stands_before_it(
    tmp_path: Path, programs: Path
) -> None:
    """Both sleep; the block for anybody comes first by J. The host rings DSP 1 for it and then DSP 0 for its own."""
    period = 41  # refreshes: most releases fall between two servo ticks, which are 8 apart
    rows = [
        row(name, dsp, importance=j, argument=50_000, period_ms=period / 8)
        for name, dsp, j in (("anybody", None, 0x7001), ("own", 0, 0x7000))
    ]
    run = Run(tmp_path, programs, rows, "--dsps", "2", "--duration", "0.3")
    quiet = [
        (a, b)
        for n, (a, b) in enumerate(zip(run.claims("anybody"), run.claims("own"), strict=False))
        if 2 <= period * (n + 1) % 8
    ]
    assert len(quiet) > 35
    assert [a[1] for a, _ in quiet] == [1] * len(quiet) and max(b[0] - a[0] for a, b in quiet) < 10 * US


# ---- its DSP is out


def test_what_is_for_a_dsp_that_fails_waits_and_says_so(tmp_path: Path, programs: Path) -> None:
    rows = [row("own", 1), row("anybody", None)]
    run = Run(
        tmp_path,
        programs,
        rows,
        "--dsps",
        "3",
        "--duration",
        "0.2",
        events=[{"at_s": 0.0802, "action": "fail", "dsp": 1}],
    )
    claims = run.claims("own")
    assert claims and max(time for time, _ in claims) < 81 * MS and {slot for _, slot in claims} == {1}
    assert run.task("anybody")["misses"] <= 1 and len(run.claims("anybody")) >= 38
    own = run.task("own")
    assert own["misses"] == own["never_started"] + own["lost"] == 1
    (miss,) = [miss for miss in run.report["misses"] if miss["kind"] == "user.own"]
    # Of the 120 ms that are left the watchdog takes 45, 3 x watchdog.long_run_us.
    assert 70 * MS < miss["parts_ps"]["own_dsp_out"] < 80 * MS and "no_dsp" not in miss["parts_ps"]
    assert run.chains >= 1


def test_the_watchdogs_second_try_is_for_the_same_dsp(tmp_path: Path, programs: Path) -> None:
    """It hangs in its own block: put back, passed by all others, and run by the same DSP after its reset."""
    rows = [row("own", 1, argument=25_000)]
    instant = 0.1002
    run = Run(
        tmp_path,
        programs,
        rows,
        "--dsps",
        "3",
        "--duration",
        "0.2",
        "--set",
        "watchdog.long_run_us=1500",
        events=[{"at_s": instant, "action": "hang", "dsp": 1}],
    )
    put_back = [(time, n) for time, _, what, n in run.events if what == "requeue" and n["kind"] == FIRST]
    assert len(put_back) == 1 and put_back[0][1]["owner"] == 1
    again = next((time, slot) for time, slot in run.claims("own") if time > put_back[0][0])
    assert again[1] == 1 and again[0] > 100 * MS
    booted = [time for time, who, what, n in run.events if what == "reset" and who == "dsp 1" and n["state"] == 1]
    assert booted and again[0] > booted[-1]
    assert (
        run.task("own")["released"]
        == run.task("own")["on_time"]
        + run.task("own")["late"]
        + run.task("own")["unfinished"]
        + run.task("own")["never_started"]
    )


def test_a_board_that_is_pulled_and_put_in_again_finds_its_block(tmp_path: Path, programs: Path) -> None:
    events = [{"at_s": 0.0511, "action": "unplug", "dsp": 1}, {"at_s": 0.1033, "action": "plug", "dsp": 1}]
    run = Run(
        tmp_path, programs, [row("own", 1), row("anybody", None)], "--dsps", "2", "--duration", "0.2", events=events
    )
    times = [time for time, _ in run.claims("own")]
    assert not [time for time in times if 51.1 * MS < time < 103.3 * MS]
    assert min(time for time in times if time > 103.3 * MS) < 108 * MS
    assert len([time for time in times if time > 103.3 * MS]) >= 18
    late = [miss for miss in run.report["misses"] if miss["kind"] == "user.own"]
    assert len(late) == 1 and 40 * MS < late[0]["parts_ps"]["own_dsp_out"] < 53 * MS


def test_a_slot_that_is_empty_from_the_start(tmp_path: Path, programs: Path) -> None:
    """The servo and others do as if the block were not there."""
    options = ["--dsps", "2", "--duration", "0.2", "--set", "machine.slots=3"]
    run = Run(tmp_path, programs, [row("own", 2), row("anybody", None)], *options)
    assert run.claims("own") == [] and run.task("own")["never_started"] == run.task("own")["misses"] == 1
    (miss,) = [miss for miss in run.report["misses"] if miss["kind"] == "user.own"]
    assert miss["parts_ps"]["own_dsp_out"] > 190 * MS
    assert run.report["tasks"]["pid"]["misses"] == 0 and run.task("anybody")["misses"] == 0
    filled = Run(
        tmp_path,
        programs,
        [row("own", 2), row("anybody", None)],
        *options,
        events=[{"at_s": 0.1, "action": "plug", "dsp": 2}],
    )
    assert len(filled.claims("own")) >= 19 and {slot for _, slot in filled.claims("own")} == {2}


def test_a_block_that_waits_for_ever_holds_back_no_long_ones(tmp_path: Path, programs: Path) -> None:
    """scheduling.long_blocks_max is for what anybody may run."""
    rows = [row("own", 2, argument=100_000), row("long", None, argument=40_000, importance=0x6000)]
    run = Run(
        tmp_path,
        programs,
        rows,
        "--dsps",
        "2",
        "--duration",
        "0.1",
        "--set",
        "machine.slots=3",
        "--set",
        "scheduling.long_blocks_max=1",
    )
    assert len(run.claims("long")) >= 18


# ---- rough treatment


@pytest.mark.parametrize("policy", ["doorbell", "spin"])
def test_failures_in_the_middle_of_claims(tmp_path: Path, programs: Path, policy: str) -> None:
    """Resets at instants that are spread over the claims of busy DSPs; every replay and the audit hold."""
    rows = [
        row("own", 1, period_ms=1, argument=5000, deadline_ms=1),
        row("other", 0, period_ms=1, argument=3000, deadline_ms=1),
        row("anybody", None, period_ms=1, argument=2000),
    ]
    events = [
        {
            "at_s": round(0.02 + 0.0071 * n + 1.37e-6 * n * n, 9),
            "action": ("reset", "hang", "freeze")[n % 3],
            "dsp": n % 2,
        }
        for n in range(20)
    ]
    options = ["--dsps", "3", "--duration", "0.2", *(["--idle-policy", policy] if policy != "doorbell" else [])]
    run = Run(tmp_path, programs, rows, *options, events=events)
    assert {slot for _, slot in run.claims("own")} == {1} and {slot for _, slot in run.claims("other")} == {0}
    assert len(run.claims("own")) > 50


def test_a_dsp_that_dies_with_the_list_in_its_hands(tmp_path: Path, programs: Path) -> None:
    """DSP 1 freezes between the write of 0Fh and the release of the list: the host frees it and finds every block."""
    rows = [row("own", 1), row("other", 0), row("anybody", None)]
    sound = Run(tmp_path, programs, rows, "--dsps", "3", "--duration", "0.1")
    claim = next(time for time, _ in sound.claims("own") if time > 50 * MS)
    for after_ns in (50, 150, 300, 600):
        at_s = round(claim * 1e-12 + after_ns * 1e-9, 10)
        run = Run(
            tmp_path,
            programs,
            rows,
            "--dsps",
            "3",
            "--duration",
            "0.1",
            "--set",
            "watchdog.long_run_us=1500",
            events=[{"at_s": at_s, "action": "freeze", "dsp": 1}],
        )
        assert {slot for _, slot in run.claims("own")} == {1}
        assert len(run.claims("own")) >= 16 and run.task("anybody")["misses"] <= 1


# ---- state, ideal run, words


def core(programs: Path, rows: list[dict[str, Any]], **settings: Any) -> Any:
    return cmrc.config(
        toml=toml_of(rows),
        settings={**AT_ONCE, "machine.programs": str(programs), "report.reference": "none", **settings},
    )


def test_a_snapshot_in_the_middle_goes_on_bit_for_bit(programs: Path) -> None:
    config = core(programs, MIXED, **{"machine.dsps": 3, "run.duration_s": 0.06})
    whole = cmrc.Simulation(config)
    whole.run()
    told = json.loads(whole.report_json())["hash"]
    for at_s in (0.0200301, 0.0400017, 0.0400023, 0.0400031):
        first, second = cmrc.Simulation(config), cmrc.Simulation(config)
        first.run_until(at_s)
        second.restore(first.snapshot())
        second.run()
        assert json.loads(second.report_json())["hash"] == told


def test_the_ideal_run_has_one_dsp_that_does_it_all(programs: Path) -> None:
    simulation = cmrc.Simulation(
        core(programs, MIXED, **{"machine.dsps": 3, "run.duration_s": 0.05, "report.reference": "ideal"})
    )
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["reference_problem"] in ("", None) and report["errors"] is not None


def test_without_a_dsp_the_words_are_as_ever(programs: Path) -> None:
    """The image of a configuration without `dsp` has no code for it, and one with it has all else in its place."""
    without, within = (cmrc.dsp_image(core(programs, [row("one", dsp)])) for dsp in (None, 0))
    assert "own_claim" not in without.symbols
    others = {
        name: value for name, value in within.symbols.items() if not name.startswith("own_") and name != "OWN_BLOCKS"
    }
    assert others == without.symbols
    assert "dsp" not in cmrc.config(toml=toml_of([row("one", None)])).to_toml().split("[[tasks]]")[1].split("[[")[0]


def test_the_row_is_written_back() -> None:
    config = cmrc.config(toml=toml_of([row("one", 3), row("two", 0)]))
    assert cmrc.config(toml=config.to_toml()).to_toml() == config.to_toml()
    assert re.findall(r"^dsp = (\d)$", config.to_toml(), re.MULTILINE) == ["3", "0"]


# ---- bad input


@pytest.mark.parametrize(
    ("dsp", "settings", "says"),
    [
        ("-1", {}, "tasks.dsp: -1 is out of range; a number from 0 to 15 is expected"),
        ("16", {}, "tasks.dsp: 16 is out of range; a number from 0 to 15 is expected"),
        ("1.5", {}, "tasks.dsp: 1.5 is no integer; an integer is expected"),
        ("nan", {}, "tasks.dsp: nan is out of range; a number from 0 to 15 is expected"),
        ('"0"', {}, 'tasks.dsp: "0" is a string; a number from 0 to 15 is expected'),
        ("true", {}, "tasks.dsp: true is a boolean; a number from 0 to 15 is expected"),
        (
            "4",
            {},
            'tasks.dsp: "one" is for DSP 4, and there is no such slot; '
            "0 to 3 is expected, or more machine.dsps or machine.slots",
        ),
        ("1", {"machine.dsps": 1}, "0 is expected: there is one slot"),
        ("6", {"machine.slots": 6}, "0 to 5 is expected"),
    ],
)
def test_a_slot_that_is_none_is_refused_with_its_place(dsp: str, settings: dict[str, Any], says: str) -> None:
    toml = toml_of([row("one", None)]) + f"dsp = {dsp}\n"
    with pytest.raises(cmrc.ConfigError, match=re.escape(says)) as error:
        cmrc.config(toml=toml, settings=settings, name="my.toml")
    assert str(error.value).startswith(f"my.toml:{toml.count(chr(10))}:")


def test_programs_whose_executive_does_not_know_it_are_refused(tmp_path: Path, programs: Path) -> None:
    old = tmp_path / "old"
    shutil.copytree(programs, old)
    main = old / "dsp.asm"
    main.write_text(main.read_text().replace(".ifdef  OWN_BLOCKS", ".ifdef  OTHER"))
    executive = old / "executive.asm"
    executive.write_text(executive.read_text().replace(".ifdef  OWN_BLOCKS", ".ifdef  OTHER"))
    with pytest.raises(cmrc.ConfigError, match="knows no blocks for one DSP alone"):
        cmrc.Simulation(core(old, [row("one", 0)]))
    cmrc.Simulation(core(old, [row("one", None)]))
