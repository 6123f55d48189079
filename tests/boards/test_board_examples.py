"""The boards of examples/ that do not exist, as a stranger would use them: by the commands in their heads."""

import re
import shlex
import subprocess
from pathlib import Path

from locations import BUILD, ROOT

COMMAND = re.compile(r"^[;#]   build/bin/emulator (.*)$", re.MULTILINE)


def run(file: str, folder: Path, stdin: str = "", console: str | None = None) -> str:
    """What the last of a file's commands prints. ``console``: other options in place of --console-input."""
    (folder / "examples").symlink_to(ROOT / "examples")
    output = ""
    for command in COMMAND.findall((ROOT / file).read_text()):
        if console is not None:
            command = command.replace("--console-input -", console)
        done = subprocess.run(
            [BUILD / "bin" / "emulator", *shlex.split(command)],
            input=stdin,
            capture_output=True,
            text=True,
            check=False,
            cwd=folder,
            timeout=60,
        )
        assert done.returncode == 0, (command, done.stderr)
        output = done.stdout
    assert output
    return output


def test_the_logger_boots_echoes_and_counts(tmp_path: Path) -> None:
    output = run("examples/logger/logger.asm", tmp_path, "hello.")
    assert output.startswith("HELLO\n") and "halt: branch to itself" in output
    changes = [int(value, 16) for value in re.findall(r"led leds: ([0-9A-F]+)h at cycle", output)]
    assert len(changes) > 3 and changes == list(range(changes[0], changes[0] + len(changes)))


def test_the_loggers_interrupts_keep_the_flags_of_the_program(tmp_path: Path) -> None:
    """It waits for characters in a loop of a test and a branch, and interrupts come between the two."""
    (tmp_path / "script").write_text('at 2000 "a"\nat 9000 "b."\n')
    output = run("examples/logger/logger.asm", tmp_path, console="--device-script uart=script")
    assert output.startswith("AB\n") and "halt: branch to itself" in output


def test_the_carriers_add_and_tell(tmp_path: Path) -> None:
    (tmp_path / "words").write_text("1 2 3 0\n")
    output = run("examples/carriers/carriers.toml", tmp_path)
    assert "led lamp of chip b: 6h at cycle" in output and "mailbox box of chip b: sent 1 words: 00000006" in output
