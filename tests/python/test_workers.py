"""Workers of a pool end with it and print nothing, at any point of their work."""

import subprocess
import sys
from pathlib import Path

import cmrc
import pytest

POOL = """
import multiprocessing, time
from cmrc import signals

with signals.raised(), multiprocessing.get_context("fork").Pool(2, signals.end_quietly) as pool:
    pool.map_async(time.sleep, [60, 60, 60])
    time.sleep(0.3)
print("left")
"""


@pytest.mark.unsanitized
def test_a_pool_that_is_left_ends_its_workers_without_a_traceback() -> None:
    env = {"PYTHONPATH": str(Path(cmrc.__file__).parent.parent)}
    done = subprocess.run(
        [sys.executable, "-c", POOL], env=env, capture_output=True, text=True, check=False, timeout=50
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "left\n", "")
    loud = POOL.replace(", signals.end_quietly", "")
    assert (
        "SIGTERM"
        in subprocess.run(
            [sys.executable, "-c", loud], env=env, capture_output=True, text=True, check=False, timeout=50
        ).stderr
    )


def test_the_pools_of_the_package_have_such_workers() -> None:
    sources = [path.read_text() for path in Path(cmrc.__file__).parent.rglob("*.py")]
    pools = [line for source in sources for line in source.splitlines() if "Pool(" in line]
    assert len(pools) == 2 and all("signals.end_quietly)" in line for line in pools)
