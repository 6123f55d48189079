"""A file without an end is refused by its size, by every command that reads files."""

from __future__ import annotations

import os
import resource
import subprocess
from pathlib import Path

import pytest

LIMIT = 1 << 30  # bytes of memory; 64 MiB is the largest file that is read whole


def bounded() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT))


@pytest.mark.parametrize("command", [
    ["--config", "/dev/zero"],
    ["--set", "dock.layout=/dev/zero"],
    ["--board", "endless.toml"],
    ["asm", "/dev/zero", "-o", "out"],
    ["asm", "includes.asm", "-o", "out"],
    ["link", "/dev/zero", "-o", "out"],
    ["link", "whole.o", "--map", "/dev/zero", "-o", "out"],
    ["disasm", "/dev/zero"],
    ["exec", "/dev/zero"],
    ["exec", "endless.asm"],
    ["exec", "--load-at", "0x300000", "endless.hex"],
    ["exec", "--board", "endless.toml", "includes.asm"],
    ["exec", "--network", "/dev/zero"],
    ["vectors", "/dev/zero"],
    ["trace-diff", "/dev/zero", "/dev/zero"],
    ["--resume", "/dev/zero"],
    ["debug", "whole.asm", "-x", "/dev/zero"],
], ids=lambda command: " ".join(command))  # fmt: skip
@pytest.mark.unsanitized
def test_a_file_without_an_end_is_refused(command: list[str], emulator: Path, tmp_path: Path) -> None:
    for name in ("endless.toml", "endless.asm", "endless.hex"):
        (tmp_path / name).symlink_to("/dev/zero")
    (tmp_path / "includes.asm").write_text('        .include "endless.asm"\n')
    (tmp_path / "whole.asm").write_text("        nop\n")
    subprocess.run([emulator, "asm", "-c", "whole.asm", "-o", "whole.o"], cwd=tmp_path, check=True)
    ended = subprocess.run(
        [emulator, *command], cwd=tmp_path, capture_output=True, text=True, preexec_fn=bounded, check=False
    )
    assert ended.returncode == 2, ended.stderr
    assert any(words in ended.stderr for words in ("is larger than 64 MiB", "a line longer than")), ended.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("endless", ["/dev/zero", "."])
@pytest.mark.unsanitized
def test_commands_without_an_end_are_refused(endless: str, emulator: Path, tmp_path: Path) -> None:
    (tmp_path / "whole.asm").write_text("start:  b start\n")
    where = os.open(tmp_path / endless, os.O_RDONLY)
    ended = subprocess.run(
        [emulator, "debug", "whole.asm"],
        cwd=tmp_path,
        stdin=where,
        capture_output=True,
        text=True,
        preexec_fn=bounded,
        check=False,
    )
    os.close(where)
    assert ended.returncode == 2, ended.stderr
    assert "standard input" in ended.stderr and "commands are expected" in ended.stderr
    sourced = subprocess.run(
        [emulator, "debug", "whole.asm", "-e", f"source {endless}"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        preexec_fn=bounded,
        check=False,
    )
    assert sourced.returncode == 2 and "a file of commands is expected" in sourced.stdout


@pytest.mark.parametrize(("size", "says"), [(70 << 20, "not a snapshot"), (5 << 30, "is larger than 4096 MiB")])
def test_a_snapshot_may_be_large(size: int, says: str, emulator: Path, tmp_path: Path) -> None:
    """A run with much memory writes more than the 64 MiB that other inputs have at the most."""
    with (tmp_path / "large.snap").open("wb") as file:
        file.truncate(size)
    ended = subprocess.run(
        [emulator, "--resume", "large.snap"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 2 and says in ended.stderr, ended.stderr
