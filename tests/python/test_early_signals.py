"""A signal while ``cmrc`` imports its modules ends it with its status and one line; in a program that imports the
package it stays KeyboardInterrupt."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from locations import BUILD

SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
LONG_IMPORT = "import time\nprint('imports', flush=True)\ntime.sleep(100)\n"
SCRIPT = "import sys\nfrom cmrc.__main__ import main\nsys.exit(main())\n"


def stopped(folder: Path, command: list[str], module: str, number: signal.Signals) -> tuple[int, str]:
    """The status and the errors of a Python that got the signal while it imported a module."""
    (folder / f"{module}.py").write_text(LONG_IMPORT)
    with subprocess.Popen(
        [sys.executable, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join((str(folder), str(BUILD / "python")))},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # noqa: PLW1509
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "imports\n"
        process.send_signal(number)
        _, errors = process.communicate(timeout=100)
        return process.returncode, errors


@pytest.mark.parametrize("module", ["numpy", "csv"])
@pytest.mark.parametrize("number", SIGNALS)
def test_a_command_that_still_imports_ends_in_one_line(module: str, number: signal.Signals, tmp_path: Path) -> None:
    """NumPy is imported by the package, csv by the commands and the claims."""
    for asked in (["-m", "cmrc", "compare", "-m", "--duration", "1"], ["-m", "cmrc.results", "--claim", "1"]):
        assert stopped(tmp_path, asked, module, number) == (SIGNALS[number], "cmrc: interrupted\n")
    (tmp_path / "cmrc").write_text(SCRIPT)
    assert stopped(tmp_path, [str(tmp_path / "cmrc"), "compare"], module, number) == (
        SIGNALS[number],
        "cmrc: interrupted\n",
    )


def test_a_program_that_imports_the_package_keeps_its_signals(tmp_path: Path) -> None:
    status, errors = stopped(tmp_path, ["-c", "import cmrc", "-m", "cmrc"], "numpy", signal.SIGINT)
    assert status != 130 and "KeyboardInterrupt" in errors
    for name in ("cmrc", "mine.py"):
        (tmp_path / name).write_text("import cmrc, signal\nprint(signal.getsignal(signal.SIGINT).__name__)\n")
        (tmp_path / "numpy.py").unlink(missing_ok=True)
        done = subprocess.run(
            [sys.executable, tmp_path / name],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        assert done.stdout == "default_int_handler\n", done.stderr
