"""The end of Python while a daemon thread is in C++: the work stops, and the process ends as if the thread had been in
Python. It used to be killed inside C++ ("terminate called without an active exception", status 134)."""

import os
import subprocess
import sys

import pytest
from locations import BUILD

WORK = {
    "run": "cmrc.Simulation(dsps=4, duration_s=600, settings={'report.reference': 'none'}).run(seen)",
    "run_until": "seen(); cmrc.Simulation(dsps=4, duration_s=600, settings={'report.reference': 'none'}).run_until(500)",
    "compare": "seen(); cmrc.compare(duration_s=600)",
    "assemble": "seen(); [cmrc.c40.assemble('_start: b _start') for _ in iter(int, 1)]",
    "crane": "seen(); cmrc.plant.Crane().run([0] * 5, 0.001, 10**9)",
}
PROGRAM = """
import threading, time
import cmrc

began = threading.Event()

def seen(*_):
    began.set()

def work():
    {work}
    print("the work came to its end")

threading.Thread(target=work, daemon=True).start()
began.wait()
time.sleep(0.1)
{end}
"""


def run(program: str) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program],
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
    )
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(("end", "status"), [("pass", 0), ("raise SystemExit(3)", 3)])
@pytest.mark.parametrize("name", WORK)
def test_the_end_stops_a_daemon_thread(name: str, end: str, status: int) -> None:
    assert run(PROGRAM.format(work=WORK[name], end=end)) == (status, "", "")


def test_a_forked_child_does_not_wait_for_its_parents_threads() -> None:
    fork = "import os, sys\nif os.fork() == 0: sys.exit()\nprint(os.wait()[1])"
    assert run(PROGRAM.format(work=WORK["run"], end=fork)) == (0, "0\n", "")
