"""scripts/link_c: from what a compiler writes to a program that runs, and what it refuses (docs/from-c.md)."""

import subprocess
import sys
from pathlib import Path

import pytest
from cmrc import c40
from locations import BUILD, ROOT

COMPILED = """
gcc2_compiled.:
\t.data
\t.global _table
_table:
\t.word 30
\t.word 12
\t.text
\t.ref ___udivqi3
\t.global _main
_main:
\tldhi ^_table,ar0
\tor #_table,ar0
\tlda *ar0,ar2
\tldiu *+ar0(1),r2
\tlaj ___udivqi3
\tnop
\tnop
\tpush r11
\trets
"""


def link_c(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, ROOT / "scripts" / "link_c", *arguments], capture_output=True, text=True, check=False
    )


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
@pytest.mark.parametrize("model", ["rom", "ram"])
def test_what_gcc_writes_links_with_what_it_calls_and_no_more(model: str, tmp_path: Path) -> None:
    (tmp_path / "compiled.s").write_text(COMPILED)
    done = link_c(tmp_path / "compiled.s", "-o", tmp_path / "a.out", "--c-model", model)
    assert done.returncode == 0, done.stderr
    image = c40.read_coff(tmp_path / "a.out")
    assert "DIV_U" in image.symbols and "_malloc" not in image.symbols and "_putchar" not in image.symbols
    chip = c40.Processor(image)
    assert chip.run(10_000, until="c_exit").reason == "until"
    assert chip.registers["R0"] & 0xFFFF_FFFF == 30 // 12


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
def test_bad_input_is_named_and_nothing_is_written(tmp_path: Path) -> None:
    (tmp_path / "bad.s").write_text("_main:\tnonsense r0\n")
    done = link_c(tmp_path / "bad.s", "-o", tmp_path / "a.out")
    assert done.returncode == 2 and "bad.s:1" in done.stderr and not (tmp_path / "a.out").exists()
    done = link_c(tmp_path / "none.s", "-o", tmp_path / "a.out")
    assert done.returncode == 2 and f"no file {tmp_path / 'none.s'}" in done.stderr
    (tmp_path / "lost.s").write_text("\t.global _helper\n\t.text\n_helper:\trets\n")
    done = link_c(tmp_path / "lost.s", "-o", tmp_path / "a.out")
    assert done.returncode == 2 and "undefined symbol '_main'" in done.stderr and not (tmp_path / "a.out").exists()
