"""Prints what every kernel costs, beside plant-and-bus.md 2.2; with --update writes it into docs/kernels.md.

    CMRC_BUILD_DIR=build python scripts/kernel_cycles.py --update

Each kernel runs once, on one chip whose windows answer in one cycle, with the inputs of its golden trace
(tests/kernels/test_golden_kernels.py).
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- cycles: scripts/kernel_cycles.py --update -->", "<!-- end of cycles -->"

# kernel: the document's estimate in cycles, None where it has none
ESTIMATES: dict[str, int | None] = {
    "trajectory_crane": 6_000, "trajectory_crane_shaper": 6_000, "inverse_crane": 600, "torque": 700, "torque_newton_euler": 2_300, "pid": 650,
    "trajectory_gantry": 6_000, "inverse_gantry": 600, "torque_gantry": 700, "pid_gantry": 650, "identify": 120_000,
    "grab_path": 220_000, "home_crane": None, "trajectory_agv": 3_000, "inverse_agv": 700, "home_agv": None, "avoidance": None,
    "avoidance_potential": 1_200, "avoidance_vfh": 9_000, "avoidance_dwa": 150_000, "error": None,
}  # fmt: skip


def table() -> str:
    for folder in ("tests/kernels", "tests"):
        sys.path.insert(0, str(ROOT / folder))
    from locations import BUILD

    sys.path.insert(0, str(BUILD / "python"))
    from test_golden_kernels import CASES

    lines = ["| kernel | cycles | estimate of plant-and-bus.md 2.2 | ratio |", "|---|---|---|---|"]
    for kernel, prepare, argument, tick in CASES:
        *_, cycles = prepare().run(kernel, argument, tick)
        estimate = ESTIMATES[kernel]
        beside = "| |" if estimate is None else f"{estimate:,} | {cycles / estimate:.2f} |".replace(",", " ")
        lines.append(f"| `{kernel}` | {cycles:,} | ".replace(",", " ") + beside)
    return "\n".join(lines)


def documented() -> str:
    page = (ROOT / "docs" / "kernels.md").read_text()
    return page[page.index(BEGIN) + len(BEGIN) : page.index(END)].strip()


def update() -> None:
    path = ROOT / "docs" / "kernels.md"
    page = path.read_text()
    path.write_text(page[: page.index(BEGIN) + len(BEGIN)] + "\n\n" + table() + "\n\n" + page[page.index(END) :])


if __name__ == "__main__":
    if "--update" in sys.argv[1:]:
        update()
    print(table())
