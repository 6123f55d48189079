"""The network file of docs/networks.md runs, with programs that end at once."""

import subprocess
import textwrap
from pathlib import Path

from locations import BUILD, ROOT

PROGRAM = "        .text\nstart:  nop\ndone:   b done\n"
BOARD = """
[[region]]
name = "SRAM"
base = 0x300000
words = 0x8000
bus = "local"
[[region]]
name = "memories"
kind = "window"
base = 0xC0000000
words = 0x20000000
bus = "global"
"""


def test_the_network_file_of_the_page_runs(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "networks.md").read_text(encoding="utf-8")
    lines = page.partition("\n## Files\n\n")[2].splitlines()
    block = lines[: next(i for i, line in enumerate(lines) if line[:1].strip())]
    text = textwrap.dedent("\n".join(block))
    assert all(f"[[{table}]]" in text for table in ("chip", "link", "memory", "memory.place", "net", "event"))
    for name, content in (
        ("robot.toml", text), ("root.asm", PROGRAM), ("worker.asm", PROGRAM), ("board.toml", BOARD),
    ):  # fmt: skip
        (tmp_path / name).write_text(content, encoding="utf-8")
    command = [BUILD / "bin" / "emulator", "exec", "--network", "robot.toml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert not done.stderr, done.stderr
    assert "chip 0 (root): until: reached PC" in done.stdout
    # The worker boots through port 3, whose link is cut before a program comes; the index pin gets three pulses.
    assert "stop: deadlock" in done.stdout and "event 12500000 cut 0.0:1.3" in done.stdout
    assert "net index (>1.IIOF3): high, 6 edges" in done.stdout
