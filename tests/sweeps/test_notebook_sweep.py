"""examples/notebook_sweep.py: its cells one after the other, as a stranger runs them."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from cmrc.sweeps import Sweep
from locations import BUILD, ROOT

for needed in ("distributed", "pyarrow", "pandas", "matplotlib"):
    pytest.importorskip(needed)


def test_the_cells_give_a_table_a_frame_a_picture_and_a_reason(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "notebook_sweep.py", tmp_path / "dead_dsps"],
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    sweep = Sweep(tmp_path / "dead_dsps")
    assert sweep.counts() == {"done": 18, "refused": 0, "failed": 0}
    assert sweep.axes == ["machine.dsps", "future"]
    assert (tmp_path / "dead_dsps" / "f_p_missed.png").read_bytes().startswith(b"\x89PNG")
    assert "the same run: True\nThe job " in done.stdout
    late = re.search(r"had its deadline at ([\d.]+) s", done.stdout)
    assert late is not None and float(late[1]) > 0.2, "a miss that the failure at 0.2 s has caused"
    # Four DSPs carry the load until one dies; three do not.
    missed = {tuple(place.values()): spread.mean for place, spread in sweep.summary("misses")}
    assert missed[4, "all is well"] == 0 < missed[4, "DSP 1 dies"] < missed[3, "all is well"]
