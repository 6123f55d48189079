"""One task's work on one DSP, and split over two that hand the second half over in shared memory or by a link
(docs/add-a-task.md).

The work is a survey by a vehicle's range sensor (split_task/survey.asm): 180 rays, 36 sectors.
"""

import shutil
import tempfile
from pathlib import Path
from typing import Any

import cmrc

HERE = Path(__file__).resolve().parent
RANGE_SENSOR = 0x800  # of AGV 0 (devices.inc)
PERIOD_MS = 5
LOOKS = 100  # at the other half's word, about 10 us each


def programs(directory: Path) -> Path:
    """The DSP programs with the survey's among them."""
    shutil.copytree(HERE.parent / "c40_programs", directory)
    sources = sorted((HERE / "split_task").glob("*.asm"), reverse=True)  # survey.asm first
    for source in sources:
        shutil.copy(source, directory / "kernels")
    (directory / "kernels" / "user.asm").write_text("".join(f'        .include "{s.name}"\n' for s in sources))
    return directory


def task(name: str, kind: int, importance: int, dsp: int, looks: int = 0) -> str:
    """A row of [[tasks]]. Both halves are released at the same refresh, and so have the same TB_TICK."""
    return f"""
[[tasks]]
name = "{name}"
program = "kernel_survey_{name}"
kind = {kind}
importance = {importance}
period_ms = {PERIOD_MS}
deadline_ms = {PERIOD_MS}
heartbeat_ms = 0.5
dsp = {dsp}
parameter_0 = {RANGE_SENSOR}
parameter_1 = {looks}
"""


WHOLE = task("whole", 23, 0x7000, dsp=0)
HALVES = task("first", 23, 0x7001, dsp=0, looks=LOOKS) + task("second", 24, 0x7000, dsp=1)
LINKED = task("first_link", 23, 0x7001, dsp=0, looks=LOOKS) + task("second_link", 24, 0x7000, dsp=1)
LINK = {"machine.links": "0.0:1.4"}


def simulation(folder: Path, tasks: str, duration_s: float, **settings: Any) -> cmrc.Simulation:
    """A dock with two vehicles, two DSPs, and these tasks."""
    config = folder / "tasks.toml"
    config.write_text(f'[machine]\nprograms = "{folder / "programs"}"\n{tasks}')
    given = {"dock.agvs": 2, "report.reference": "none", **settings}
    return cmrc.Simulation(config=config, dsps=2, duration_s=duration_s, settings=given)


def survey(run: cmrc.Simulation, symbols: dict[str, int]) -> list[int]:
    """The last results in the first task's area: mm that the way is free, then the sectors' nearest echoes."""
    area = symbols["US_BASE"]
    sectors = [area + symbols["SU_SECTOR"] + k for k in range(symbols["SU_SECTORS"])]
    return [run.peek(place) for place in (area + symbols["SU_FREE"], *sectors)]


def line(name: str, report: dict[str, Any], kinds: list[str], base: dict[str, Any]) -> None:
    """Mean cycles of each task, median and worst response of the first, and what they add to the buses' load."""
    rows = [report["tasks"][f"user.{kind}"] for kind in kinds]
    cycles = [sum(row["execution_cycles"].values()) / row["response_ps"]["count"] for row in rows]
    response = rows[0]["response_ps"]
    buses = [report["buses"][bus]["utilisation"] - base["buses"][bus]["utilisation"] for bus in "AB"]
    print(
        f"{name:22} {' + '.join(f'{count:.0f}' for count in cycles):>12} cycles,"
        f" response {response['p50'] / 1e6:6.1f} us, worst {response['worst'] / 1e6:6.1f} us,"
        f" bus A +{100 * buses[0]:.2f} %, bus B +{100 * buses[1]:.2f} %"
    )


def main(duration_s: float = 0.5) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source = programs(folder / "programs") / "dsp.asm"
        symbols = cmrc.c40.assemble_file(source, entry="_start").symbols
        nothing = simulation(folder, "", duration_s).run().report
        whole, halves = (simulation(folder, tasks, duration_s) for tasks in (WHOLE, HALVES))
        linked = simulation(folder, LINKED, duration_s, **LINK)
        line("on one DSP", whole.run().report, ["whole"], nothing)
        line("by shared memory", halves.run().report, ["first", "second"], nothing)
        line("by a link", linked.run().report, ["first_link", "second_link"], nothing)
        print("the same results:", survey(whole, symbols) == survey(halves, symbols) == survey(linked, symbols))

        # In the middle of the second half: the first task waits as long as its parameter says, then does all the work.
        print("when the second's DSP dies:")
        halves, linked = simulation(folder, HALVES, duration_s), simulation(folder, LINKED, duration_s, **LINK)
        for run, way, suffix in ((halves, "by shared memory", ""), (linked, "by a link", "_link")):
            run.at(0.1002, "fail", dsp=1)
            report = run.run().report
            first, second = (report["tasks"][f"user.{name}{suffix}"] for name in ("first", "second"))
            line(way, report, [f"first{suffix}"], nothing)
            print(
                f"first: {first['misses']} misses; second: {second['released']} jobs,"
                f" of which {second['lost'] + second['never_started']} came to nothing"
            )
        print("the same results:", survey(whole, symbols) == survey(halves, symbols) == survey(linked, symbols))


if __name__ == "__main__":
    main()
