"""Simulations in several threads of one process know nothing of each other."""

import subprocess

from locations import BUILD


def test_four_simulations_at_once_end_as_alone() -> None:
    program = BUILD / "bin" / "four_at_once"
    done = subprocess.run([program, "0.15"], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    hashes = [line.split()[2].rstrip(",") for line in done.stdout.splitlines()]
    assert len(hashes) == len(set(hashes)) == 4 and all(len(value) == 64 for value in hashes)
