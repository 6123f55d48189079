"""Workers of a pool end with it and print nothing, at any point of their work."""

import os
import signal
import subprocess
import sys
import threading
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


@pytest.mark.unsanitized
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGKILL, -9)])  # fmt: skip
def test_a_signal_ends_the_experiments_and_their_workers(number: int, status: int, tmp_path: Path) -> None:
    """Each run of claim 1 takes longer than it takes to look."""
    experiment = subprocess.Popen(
        [sys.executable, "-m", "cmrc.results", "--claim", "1", "--jobs", "2"],
        env={"PYTHONPATH": str(Path(cmrc.__file__).parent.parent)}, stderr=subprocess.PIPE, text=True, cwd=tmp_path,
    )  # fmt: skip

    def children() -> list[str]:
        return Path(f"/proc/{experiment.pid}/task/{experiment.pid}/children").read_text().split()

    def works(child: str) -> bool:
        stat = Path(f"/proc/{child}/stat")
        return stat.exists() and int(stat.read_text().rsplit(")", 1)[1].split()[11]) > os.sysconf("SC_CLK_TCK") // 5

    workers: list[str] = []
    while len(workers) < 2 or not all(map(works, workers)):
        assert experiment.poll() is None
        workers = children()
        threading.Event().wait(0.02)
    experiment.send_signal(number)
    _, said = experiment.communicate(timeout=60)
    assert experiment.returncode == status and said == ("" if status < 0 else "cmrc.results: interrupted\n")
    while any(Path(f"/proc/{worker}").exists() for worker in workers):
        threading.Event().wait(0.02)
