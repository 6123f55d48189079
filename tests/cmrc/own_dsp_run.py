"""Runs with tasks that are bound to one DSP (docs/add-a-task.md); both replays check the trace of each."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import chain_replay
import scheduling_replay
from locations import AT_ONCE_OPTIONS, BUILD, ROOT
from scheduling_replay import Event, Replay, Rule, UserTask

US, MS = 10**6, 10**9  # ps
FIRST = 12  # KIND_USER

# TB_ARGUMENT cycles of work, counted in word 0 of its area.
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


def programs_in(directory: Path) -> Path:
    """The DSP programs with this kernel in them."""
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
        trace_of = chain_replay.Trace(
            self.events, dsps, 8, 8000, names, empty=len(self.report["dsps"]) - dsps, preloaded=True
        )
        self.chains = chain_replay.check(trace_of, self.report)

    def claims(self, name: str) -> list[tuple[int, int]]:
        """Time and slot of each claim of a task's blocks."""
        kind = FIRST + next(n for n, r in enumerate(self.rows) if r["name"] == name)
        return [
            (time, int(component.split()[1]))
            for time, component, what, n in self.events
            if what == "claim" and n["kind"] == kind
        ]

    def runs(self, name: str) -> list[tuple[int, int]]:
        """From claim to finish."""
        kind = FIRST + next(n for n, r in enumerate(self.rows) if r["name"] == name)
        ends = [time for time, _, what, n in self.events if what == "finish" and n["kind"] == kind]
        return [(claimed, end) for (claimed, _), end in zip(self.claims(name), ends, strict=False)]

    def task(self, name: str) -> dict[str, Any]:
        found: dict[str, Any] = self.report["tasks"][f"user.{name}"]
        return found
