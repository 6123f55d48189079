"""``python -m cmrc demo``: five scenes of a few simulated seconds each, with a page of their results, and one scene to
look at."""

from __future__ import annotations

import html
import multiprocessing
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cmrc import files, signals
from cmrc.result import Result
from cmrc.simulation import Setting, Simulation

Settings = Mapping[str, Setting]
QUIET: dict[str, Setting] = {"report.misses_max": 0, "report.signal_decimation": 80000}
"""The texts say only what the scenes show."""

TOGETHER: dict[str, Setting] = {
    "dock.agvs": 4,
    "load.driving": True,
    "kernels.avoidance": "dynamic_window",
    "scheduling.agv_phase": "together",
}
"""Four vehicles that drive and look for obstacles, all at the same instants."""


WIDTH = 79
COLUMN = 12
"""Characters of a line, and of a line of a run's name."""


@dataclass
class Scene:
    """One scene: a sentence, a table, and what follows from it."""

    title: str
    sentence: str
    header: Sequence[str]
    rows: list[list[str]] = field(default_factory=list)
    conclusion: str = ""

    def text(self) -> str:
        """For a terminal of 80 columns: a column for each run, a line for each measure."""
        names = [textwrap.wrap(row[0], COLUMN) or [""] for row in self.rows]
        deep = max(map(len, names))
        above = [[*[""] * (deep - len(name)), *name] for name in names]  # the names, on as many lines as they need
        labels = [*[""] * (deep - 1), *self.header]
        columns = [[*name, *row[1:]] for name, row in zip(above, self.rows, strict=True)]
        widths = [max(map(len, column)) for column in columns]
        lines = [
            "  ".join(
                [
                    "",
                    label.ljust(max(map(len, labels))),
                    *(column[n].rjust(w) for column, w in zip(columns, widths, strict=True)),
                ]
            )
            for n, label in enumerate(labels)
        ]
        return "\n".join(
            [self.title, *textwrap.wrap(self.sentence, WIDTH), *lines, *textwrap.wrap(self.conclusion, WIDTH), ""]
        )

    def page(self) -> str:
        """As HTML."""
        row = "<tr>{}</tr>"
        head = row.format("".join(f"<th>{html.escape(cell)}</th>" for cell in self.header))
        body = "".join(row.format("".join(f"<td>{html.escape(cell)}</td>" for cell in cells)) for cells in self.rows)
        return (
            f"<h2>{html.escape(self.title)}</h2><p>{html.escape(self.sentence)}</p>"
            f'<div class="wide"><table>{head}{body}</table></div><p><b>{html.escape(self.conclusion)}</b></p>'
        )


# ---- runs ------------------------------------------------------------------------------------------------------------

_reference: Any = None  # the ideal run that all runs of a scene share: children find it in the memory they inherit


def _one(job: tuple[dict[str, Setting], float]) -> dict[str, Any]:
    settings, duration_s = job
    return Simulation(settings={**settings, **QUIET, "duration_s": duration_s}, reference=_reference).run().report


def _side_by_side(
    settings: Settings, changes: Sequence[Settings], duration_s: float, *, shared: bool
) -> list[dict[str, Any]]:
    """The reports of runs that differ by ``changes``, two at a time; ``shared``: one ideal run serves all of them."""
    global _reference
    jobs = [({**settings, **change}, duration_s) for change in changes]
    reports = []
    _reference = None
    if shared:
        first = Simulation(settings={**jobs[0][0], **QUIET, "duration_s": duration_s})
        reports = [first.run().report]
        _reference = first.reference()
    with multiprocessing.get_context("fork").Pool(2, signals.end_quietly) as pool:
        reports += pool.map(_one, jobs[len(reports) :], chunksize=1)
    return reports


NONE = "0 %"


def _percent(share: float | None) -> str:
    if share is None:
        return "-"
    return NONE if share == 0 else "< 0.01 %" if share < 5e-5 else f"{100 * share:.2f} %"


def _hertz(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f} Hz"


def _length(metres: float) -> str:
    """With the unit that suits it, as the report on the terminal has it."""
    if metres == 0:
        return "0 m"
    return f"{metres * 1e6:.3g} um" if metres < 1e-3 else f"{metres * 1e3:.3g} mm" if metres < 1 else f"{metres:.4g} m"


COST = (
    "f_p missed",
    "f_p realised",
    "worst second",
    "f_t missed",
    "f_t realised",
    "load error",
    "of doing nothing",
    "lag",
)


def _cost(report: Mapping[str, Any]) -> list[str]:
    f_p, f_t, errors = report["rates"]["f_p"], report["rates"]["f_t"], report["errors"]
    return [
        _percent(f_p["missed_share"]), _hertz(f_p["realised_hz"]), _hertz(f_p["realised_worst_hz"]), _percent(f_t["missed_share"]),
        _hertz(f_t["realised_hz"]), _length(errors["load_m"]["rms"]), _percent(errors["load_of_doing_nothing"]), f"{errors['lag']['crane']['end_s']:.3f} s",
    ]  # fmt: skip


def _dsp_at_work(simulation: Simulation, time_s: float) -> int:
    """The DSP that runs a block at that instant; if there are several, the lowest slot."""
    simulation.run_until(time_s)
    states = [str(dsp["state"]) for dsp in simulation.result().report["dsps"]]
    return states.index("running")


# ---- scenes ----------------------------------------------------------------------------------------------------------


def one_long_block() -> Scene:
    """1 and 2 DSPs at base: what one block of 2 ms does to the servo."""
    reports = _side_by_side({}, [{"machine.dsps": n} for n in (1, 2)], 1.0, shared=True)
    scene = Scene(
        "1. One long block and one DSP",
        "The default load: the crane is servoed at f_p = 1 kHz, and one identify block of 2 ms comes first. A DSP runs a block to its end.",
        ("DSPs", "servo missed", "identify takes", *COST),
    )
    for n, report in zip((1, 2), reports, strict=True):
        servo = sum(int(report["tasks"][kind]["misses"]) for kind in ("pid", "torque_compensation"))
        identify = report["tasks"]["identify"]["response_ps"]["worst"] * 1e-9
        scene.rows.append([str(n), str(servo), f"{identify:.2f} ms", *_cost(report)])
    missed = [row[1] for row in scene.rows]
    scene.conclusion = (
        f"With one DSP {missed[0]} blocks of the servo wait too long behind identify; a second DSP leaves {missed[1]}."
    )
    return scene


def vehicles_together() -> Scene:
    """1 to 6 DSPs with four vehicles that look for obstacles at the same instants."""
    counts = range(1, 7)
    reports = _side_by_side(TOGETHER, [{"machine.dsps": n} for n in counts], 2.0, shared=True)
    scene = Scene(
        "2. Four vehicles drive, all looking at once",
        "Each vehicle looks for obstacles every 20 ms (dynamic window, a long block), all four at the same refresh.",
        ("DSPs", "avoidance missed", *COST),
    )
    for n, report in zip(counts, reports, strict=True):
        scene.rows.append(
            [str(n), _percent(report["errors"]["demand"]["obstacle_avoidance"]["missed_share"]), *_cost(report)]
        )
    enough = next((row[0] for row in scene.rows if {row[1], row[2], row[5]} == {NONE}), None)
    scene.conclusion = f"{enough} DSPs are needed for no miss." if enough else "Not even 6 DSPs do without a miss."
    return scene


def vehicles_apart() -> Scene:
    """The same load with the scheduler's remedies."""
    remedies: dict[str, Settings] = {
        "together": {},
        "staggered": {"scheduling.agv_phase": "staggered"},
        "together, at most 2 long blocks at a time": {"scheduling.long_blocks_max": 2},
        "together, in slices of 10000 cycles": {"scheduling.slice_cycles": 10000},
    }
    scene = Scene(
        "3. The same load, scheduled better",
        "The vehicles' instants are staggered over the 20 ms; or at most 2 long blocks run at a time; or long blocks are cut into slices of 0.4 ms.",
        ("3 DSPs", "avoidance missed", *COST),
    )
    for (name, remedy), report in zip(
        remedies.items(),
        _side_by_side({**TOGETHER, "machine.dsps": 3}, list(remedies.values()), 2.0, shared=False),
        strict=True,
    ):
        scene.rows.append(
            [name, _percent(report["errors"]["demand"]["obstacle_avoidance"]["missed_share"]), *_cost(report)]
        )
    good = [row[0] for row in scene.rows[1:] if {row[1], row[2], row[5]} == {NONE}]
    scene.conclusion = f"No miss with 3 DSPs: {'; '.join(good)}." if good else "With 3 DSPs no remedy is enough."
    return scene


def killed() -> Scene:
    """A DSP dies in the middle of PID, and in the middle of identify."""
    scene = Scene(
        "4. A DSP is killed",
        "One of two DSPs dies while it runs a block: of the servo, or identify. The host's watchdog gives the block to the other one.",
        ("killed in", "noticed after", "blocks run again", *COST),
    )
    lost = 0
    for name, time_s in (("the servo", 0.50007), ("identify", 0.021)):
        simulation = Simulation(dsps=2, duration_s=1.0, settings=QUIET)
        slot = _dsp_at_work(simulation, time_s)
        simulation.at(time_s + 1e-6, "fail", dsp=slot)
        report = simulation.run().report
        noticed = [failure["time_s"] for failure in report["failures"] if failure["kind"] == "watchdog"]
        after = f"{(noticed[0] - time_s) * 1e3:.2f} ms" if noticed else "-"
        scene.rows.append([name, after, str(report["host"]["recomputed"]), *_cost(report)])
        lost += sum(int(task["lost"]) for task in report["tasks"].values())
    scene.conclusion = (
        f"{lost} blocks are lost." if lost else "No block is lost: the DSP that is left runs every block to its end."
    )
    return scene


def plugged_in(recorded: Path) -> Scene:
    """A second DSP is plugged in when one is not enough. ``recorded`` is called with the page of this run."""
    scene = Scene(
        "5. A DSP is plugged in",
        "One DSP whose cycles take 10 times as long misses much of the servo. After 2 s a second one of the kind is put into the empty slot, and boots by itself.",
        ("", "blocks taken by the new DSP", *COST),
    )
    slow: dict[str, Setting] = {
        "machine.dsps": 1,
        "machine.slots": 2,
        "machine.cycle_time_factor": 10,
        "duration_s": 6.0,
        "report.misses_max": 0,
    }
    alone = Simulation(settings=slow)
    without = alone.run()
    helped = Simulation(
        settings={**slow, "report.misses_max": 1000},
        events=[{"at_s": 2.0, "action": "plug", "dsp": 1}],
        reference=alone.reference(),
    )
    helped.record()
    result: Result = helped.run()
    helped.write_page(recorded, "Scene 5: a DSP is plugged in")
    for name, report in (("one DSP", without.report), ("a second from 2 s on", result.report)):
        dsps = report["dsps"]
        scene.rows.append([name, str(dsps[1]["claims"]) if len(dsps) > 1 else "-", *_cost(report)])
    taken = scene.rows[-1][1]
    scene.conclusion = f"The new DSP takes {taken} blocks without any command of the operator."
    return scene


PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1"><title>CMRC emulator: five scenes</title>
<style>body{{font:15px/1.5 sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem}}table{{border-collapse:collapse;margin:.5rem 0}}
th,td{{border:1px solid #ccc;padding:.2rem .6rem;text-align:right}}td{{white-space:nowrap}}th:first-child,td:first-child{{text-align:left;white-space:normal}}th{{background:#f0f0f0}}.wide{{overflow-x:auto}}</style>
<h1>CMRC emulator: five scenes</h1>
<p>Every number was measured just now, in runs of real C40 code on emulated DSPs. <i>missed</i>: share of the jobs that a machine without delay would
have released in time. <i>load error</i>: RMS distance of the crane's load from where it would then be. <i>lag</i>: how far the crane's work was behind at the end.</p>
{scenes}
<p><a href="{page}">Scene 5 to look at</a>: the dock in 3-D, what each DSP did, why deadlines were missed (works offline). What all numbers mean: docs/report.md.</p></html>
"""


def main(folder: Path, tell: Callable[[str], None] = print) -> Path:
    """Runs the scenes, prints each, and writes the page. Returns its path. Raises OSError if the folder cannot be
    written."""
    recorded = folder / "scene5.html"
    fresh = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    scenes = []
    try:
        for make in (one_long_block, vehicles_together, vehicles_apart, killed, lambda: plugged_in(recorded)):
            scenes.append(make())
            tell(scenes[-1].text())
    except BaseException:
        if fresh and not any(folder.iterdir()):
            folder.rmdir()
        raise
    page = folder / "demo.html"
    files.write(page, PAGE.format(scenes="\n".join(scene.page() for scene in scenes), page=recorded.name))
    tell(f"Open {page}")
    return page
