"""A sweep in a notebook: which failures can 2, 3 and 4 DSPs carry? (docs/sweeps.md)

Each block under `# %%` is a cell in VS Code, Spyder, PyCharm or Jupyter with Jupytext. As a script it does the same:
`python examples/notebook_sweep.py [FOLDER]` keeps the runs in FOLDER (default: dead_dsps) and draws a picture there."""

# %% What is run: three machines, each with and without a failure, three drawings of the clocks' phases.
import sys
from pathlib import Path

import cmrc
from cmrc import plot

grid = {
    "fixed": {"preset": "saturated", "duration_s": 0.4, "phase_jitter": True},
    "axes": {"dsps": [2, 3, 4]},
    "repeats": {"seeds": 3},
    "futures": [
        {"name": "all is well"},
        {"name": "DSP 1 dies", "events": [{"at_s": 0.2, "action": "fail", "dsp": 1}]},
    ],
    "fork": {"at_s": 0.2},  # both futures of a machine share their first 0.2 s
}
folder = Path(sys.argv[1] if len(sys.argv) == 2 else "dead_dsps")

# %% Run it. The same cell again runs nothing; a longer list of DSPs or seeds runs what is new.
sweep = cmrc.sweep(grid, folder, workers=2, on_progress=cmrc.show_progress("sweep"))
sweep  # a notebook shows it as a table  # noqa: B018
print(sweep.text("any_miss", "f_p_missed", "load_peak"))

# %% One row per run, as pandas has it.
frame = sweep.to_frame("misses", "tasks.pid.response_ps.p99")
print(frame.pivot_table(index="machine.dsps", columns="future", values="misses"))

# %% A picture: the share of the servo's deadlines that were missed.
from matplotlib.figure import Figure

figure = Figure(figsize=(7, 4), layout="constrained")
plot.grid(sweep, figure.subplots(), x="machine.dsps", lines="future", metric="f_p_missed")
figure.savefig(folder / "f_p_missed.png", dpi=120)

# %% Four DSPs miss nothing until one dies. One such run again, with its signals: why was the first deadline missed?
row = next(run for run in sweep.runs if run["place"] == {"machine.dsps": 4, "future": "DSP 1 dies"})
again = sweep.rerun(row)
print("the same run:", again.hash == row["hash"])
print(again.explain())
