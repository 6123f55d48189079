"""Prints a table of docs/ that no command of the product prints, in the page's own form. tests/docs/test_printed.py
compares.

    CMRC_BUILD_DIR=build python scripts/documents/figures.py NAME      one of those in TABLES

Kernels run on one chip whose windows answer in one cycle, with the scenes that their tests have.
"""

from __future__ import annotations

import functools
import json
import random
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
for folder in ("tests/peripherals", "tests/machine", "tests/kernels", "tests"):
    sys.path.insert(0, str(ROOT / folder))
from locations import BUILD

sys.path.insert(0, str(BUILD / "python"))


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = ["| " + " | ".join(map(str, line)) + " |" for line in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]]).replace("|  |", "| |")


def thousands(number: float) -> str:
    return f"{number:,.0f}".replace(",", " ")


def usual_runs() -> str:
    """Shortest runs of 3 s, one DSP and four (docs/report.md, Usual)."""
    found: list[dict[str, int | None]] = []
    for dsps in (1, 4):
        with tempfile.TemporaryDirectory() as folder:
            report = Path(folder) / "report.json"
            options = ["--dsps", str(dsps), "--duration", "3", "--set", "report.reference=none", "--quiet"]
            subprocess.run([BUILD / "bin" / "emulator", *options, "--report", report], check=True)
            tasks = json.loads(report.read_text())["tasks"]
        found.append({kind: row["why_late"]["usual_ps"] for kind, row in tasks.items()})
    alone, together = found
    return table(
        ["kind", "1 DSP, µs", "4 DSPs, µs"],
        [[f"`{kind}`", f"{ps / 1e6:.2f}", f"{together[kind] / 1e6:.2f}"] for kind, ps in alone.items() if ps],
    )


def heartbeat() -> str:
    """How far apart the beats of long kernels are."""
    from harness_agv import Dsp
    from test_golden_kernels import agv, agv_facing_a_person, ship
    from test_grab_path import prepare, random_scene
    from test_heartbeat import beats, empty_bay, longest, walled_in

    rows = []

    def add(kernel: str, scene: str, at: list[list[int]]) -> None:
        gap, whole = max(map(longest, at)), max(one[-1] for one in at)
        rows.append([f"`{kernel}`", scene, thousands(max(map(len, at)) - 1), thousands(whole), thousands(gap)])

    for name, bay in (("a row, two containers", ship), ("two rows, empty bay", empty_bay)):
        add("identify", name, [beats(bay(), "identify")])
    for kernel in ("grab_path", "home_crane"):
        dsp, rng, at = Dsp(), random.Random(5), []
        for _ in range(40):
            boxes, bay, target, produced = random_scene(rng)
            prepare(dsp, boxes, bay, target, produced, (22.0, 8.0, 6.0, 0.0))
            at.append(beats(dsp, kernel))
        add(kernel, "the most of 40 random scenes", at)
    add("avoidance", "synthetic, 200 000 cycles asked for", [beats(agv(), "avoidance", 200_000)])
    for kernel in ("avoidance_potential", "avoidance_vfh", "avoidance_dwa"):
        add(kernel, "a person beside the lane", [beats(agv_facing_a_person(), kernel)])
        add(kernel, "every ray ends beside the lane in a bend", [beats(walled_in(), kernel)])
    return table(["kernel", "scene", "beats", "cycles of the run", "longest gap, cycles"], rows)


def range_of_cycles() -> str:
    """Kernels whose cycles depend on the scene."""
    import test_avoidance
    from agv_words import agv_dsp
    from harness_agv import Dsp
    from test_grab_path import prepare, random_scene

    rows: list[tuple[str, str, list[int]]] = []
    for kernel in ("grab_path", "home_crane"):
        dsp, rng, cycles = Dsp(), random.Random(5), []
        for _ in range(300):
            boxes, bay, target, produced = random_scene(rng)
            prepare(dsp, boxes, bay, target, produced, (22.0, 8.0, 6.0, 0.0))
            cycles.append(dsp.run(kernel)[2])
        rows.append((f"`{kernel}`", "300, of 1 to 5 boxes", cycles))
    for kernel, count in (("avoidance_potential", 120), ("avoidance_vfh", 120), ("avoidance_dwa", 40)):
        dsp, rng = agv_dsp(), random.Random(5)
        cycles = [test_avoidance.run(dsp, kernel, test_avoidance.random_view(rng))[2] for _ in range(count)]
        rows.append((f"`{kernel}`", f"{count}, of test_avoidance.py", cycles))
    return table(
        ["kernel", "random scenes", "least", "median", "most"],
        [[name, scenes, *map(thousands, (min(c), statistics.median_high(c), max(c)))] for name, scenes, c in rows],
    )


def copy_by_dma() -> str:
    from test_copy_by_dma import BY_DMA, BY_PROCESSOR, cycles

    counts = (16, 48, 128, 256)
    return table(["words", "processor", "DMA"], [[n, cycles(BY_PROCESSOR, n), cycles(BY_DMA, n)] for n in counts])


def trajectories() -> str:
    """Both builds of the crane's trajectory in closed loop."""
    import math

    from test_trajectory_shaper import travel

    blend, shaper = travel("trajectory_crane"), travel("trajectory_crane_shaper")
    rows = [
        ["to PID_SETTLED, s", *(f"{one[0]:.1f}" for one in (blend, shaper))],
        ["residual swing, m", *(f"{one[1]:.3f}" for one in (blend, shaper))],
        ["largest sway underway, degrees", *(f"{math.degrees(one[2]):.1f}" for one in (blend, shaper))],
    ]
    return table(["", "blend9 (default)", "quintic_shaper"], rows)


def round_trips() -> str:
    """Ping-pong of two chips, by the processor and by DMA (docs/networks.md)."""
    import test_network_examples as examples

    rows = []
    for name, program in (("processor", "bandwidth"), ("DMA", "bandwidth_dma")):
        network = examples.Network([examples.EXAMPLES / f"{program}.asm"] * 2, links=["0.0:1.3"])
        assert network.run().reason == "ended"
        rows.append([name, *examples.round_trips(network)])
    sizes = [2**n for n in range(9)]
    each = [[f"{row[0]}, a word", *(f"{c / 2 / n:.1f}" for c, n in zip(row[1:], sizes))] for row in rows]
    return table(["words", *sizes], [*rows, *each])


def speed_up() -> str:
    """Cycles of the slowest chip of the two parallel examples (docs/networks.md)."""
    import test_network_examples as examples

    took: dict[str, list[int]] = {}
    for program, kind in (("matrix_ring", "ring"), ("fft_hypercube", "hypercube")):
        for chips in examples.CHIPS:
            network = examples.Network(examples.EXAMPLES / f"{program}.asm", topology=f"{kind}:{chips}")
            assert network.run().reason == "ended"
            took.setdefault(program, []).append(max(chip.cycles for chip in network.chips))
    head = ["chips"] + [text for program in took for text in (f"`{program}.asm` cycles", "speed-up")]
    rows = []
    for i, chips in enumerate(examples.CHIPS):
        rows.append(
            [chips, *(cell for all_of in took.values() for cell in (all_of[i], f"{all_of[0] / all_of[i]:.2f}"))]
        )
    return table(head, rows)


def legs() -> str:
    """The four kernels of the crane on one DSP, around the plant's crane (docs/kernels.md, In closed loop)."""
    import math

    from test_closed_loop import RAMP_DONE, SETTLED, Crane

    class Watched(Crane):
        most = 0.0

        def step(self) -> None:
            super().step()
            self.most = max(self.most, math.hypot(*self.state.q[4:6]))

    crane = Watched([12.0, 16.0, 14.0, 0.0], 10e3)
    rows = []

    def part(name: str, seconds: float, target: Sequence[float]) -> None:
        off = math.dist(crane.load(), target[:3])
        rows.append([name, f"{seconds:.1f}", f"{1e3 * off:.0f}", f"{math.degrees(crane.most):.1f}"])
        crane.most = 0.0

    def leg(name: str, target: list[float]) -> None:
        crane.go([target])
        part(name, crane.run_until(SETTLED, 60.0), target)

    def ramp(name: str, base: float, delta: float, seconds: float, target: list[float]) -> None:
        crane.ramp(base, delta, seconds)
        crane.run_until(RAMP_DONE, seconds + 1)
        part(name, seconds, target)

    ship, spot, home = [0.0, 24.0, 10.0, 0.0], [22.0, 8.0, 6.0, 0.0], [12.0, 16.0, 14.0, 0.0]
    leg("home to ship, empty", ship)
    ramp("ramp down by 1.5 m", 0.0, 1.5, 8.0, [*ship[:2], ship[2] - 1.5])
    ramp("ramp up", 1.5, -1.5, 8.0, ship)
    leg("ship to loading spot", spot)
    leg("to home", home)
    return table(["", "duration, s", "load from the target at its end, mm", "largest sway underway, degrees"], rows)


def explained() -> str:
    """A missed deadline in plain English (docs/experiments.md)."""
    import textwrap

    import cmrc

    return textwrap.fill(cmrc.run(dsps=1, duration_s=0.1).explain(), 118, initial_indent="> ", subsequent_indent="> ")


def causes() -> str:
    """The causes of a chip's cycles (docs/report.md)."""
    import cmrc_test

    return table(["cause", "meaning"], [[f"`{name}`", meaning] for name, _, meaning in cmrc_test.causes()])


def job_kinds() -> str:
    """The kinds of jobs (docs/report.md)."""
    import cmrc_test

    return table(
        ["kind", "program", "x", "importance", "step of a process"],
        [
            [
                f"`{row['name']}`",
                f"`{row['symbol']}`" if row["symbol"] else "that of the block it repeats",
                row["x"],
                f"{row['importance']:X}h" if row["importance"] else "equation (7)",
                " and ".join(robot for robot in ("crane", "AGV") if row[f"{robot.lower()}_step"]),
            ]
            for row in cmrc_test.job_kinds()
        ],
    )


def parameters(part: str) -> str:
    """The keys of the plant's parameters in a table of the configuration (docs/configuration.md). Keys that differ only
    in the joint are one line."""
    from cmrc import _core

    lines: dict[tuple[str, ...], list[dict[str, object]]] = {}
    for key in _core.cmrc.config_keys():
        first, *joint, last = key["name"].split(".")
        if first == part:
            lines.setdefault((first, str(bool(joint)), last), []).append(key)
    return table(
        ["key", "default", "unit", "meaning", "source"],
        [
            [key_of(keys), default_of(keys), keys[0]["unit"], meaning_of(keys[0]), keys[0]["source"]]
            for keys in lines.values()
        ],
    )


def key_of(keys: Sequence[dict[str, object]]) -> str:
    first, *joint, last = str(keys[0]["name"]).split(".")
    joints = ",".join(str(key["name"]).split(".")[1] for key in keys)
    return f"`{first}.{last}`" if not joint else f"`{first}.{joints if len(keys) == 1 else '{' + joints + '}'}.{last}`"


def default_of(keys: Sequence[dict[str, object]]) -> str:
    defaults = [f"{key['default']:.10g}" for key in keys]
    return defaults[0] if len(set(defaults)) == 1 else ", ".join(defaults)


def meaning_of(key: dict[str, object]) -> str:
    """With the range of the value; a maximum of 10^12 and more is no limit."""
    least, most = (
        f"{value:.0f}" if value == round(value) else f"{value:g}" for value in (key["minimum"], key["maximum"])
    )
    return f"{key['meaning']}. " + (f"At least {least}" if key["maximum"] >= 1e12 else f"From {least} to {most}")


TABLES: dict[str, Callable[[], str]] = {
    one.__name__: one
    for one in (
        usual_runs, heartbeat, range_of_cycles, copy_by_dma, trajectories, round_trips, speed_up, legs, explained, causes, job_kinds,
    )
} | {part: functools.partial(parameters, part) for part in ("slewing", "gantry", "agv", "landing")}  # fmt: skip


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in TABLES:
        sys.exit(f"{sys.argv[0]}: the name of one table is expected: {', '.join(TABLES)}")
    print(TABLES[sys.argv[1]]())
