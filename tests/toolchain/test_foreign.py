"""Public sources that are not in the tree (docs/assembler.md, Old sources)."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from cmrc import c40
from locations import BUILD, ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import foreign_gcc

ASSEMBLED = {"helios": (151, 154), "cps": (73, 119), "cruisin": (61, 70)}


@pytest.mark.parametrize("name", sorted(ASSEMBLED))
def test_public_sources_assemble_as_the_page_says(name: str) -> None:
    if not (ROOT / "build-foreign" / name).is_dir():
        pytest.skip(f"scripts/foreign {name} has not been run here")
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "foreign", name], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    found = re.search(r"(\d+) of (\d+) files assemble", done.stdout)
    assert found and (int(found[1]), int(found[2])) == ASSEMBLED[name]


@pytest.mark.campaign
def test_programs_of_gcc_print_what_the_page_says() -> None:
    if not ((ROOT / "build-foreign" / "gcc").exists() or (ROOT / "build-gcc-c4x" / "cc1").exists()):
        pytest.skip("neither scripts/gcc_c4x nor scripts/foreign gcc --from FOLDER has been run here")
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "foreign", "gcc"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    page = (ROOT / "docs" / "from-c.md").read_text()
    counted = re.findall(r"(\d+ of \d+) (?:programs|with)", done.stdout)
    assert len(counted) == 2 and all(count in page for count in counted), done.stdout


def test_gcc_without_a_folder_says_what_is_missing(tmp_path) -> None:  # type: ignore[no-untyped-def]
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "foreign", "gcc", "--from", tmp_path / "none"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2 and "no folder" in done.stderr


def mandelbrot_line(program: Path, width: int) -> list[int]:
    """What the Hydra's Mandelbrot program computes when its host asks for one line."""
    chip = c40.Processor(c40.read_coff(program), board="flat")
    assert chip.run(100_000, until="_main").reason == "until"
    for name, value in {"_width": width, "_height": 1, "_maxit": 97, "_y_coord": 5, "_intpri": 1, "_intvec": 3}.items():
        chip.memory[chip.address(name)] = value
    for name, number in {"_x_start": -2.0, "_x_step": 2.5 / width, "_y_start": 0.37, "_y_step": 0.1}.items():
        chip.memory.write_floats(chip.address(name), [number])
    chip.memory[chip.address("_start_flag")] = 1
    for _ in range(2000):
        chip.run(500)
        if chip.memory[chip.address("_line_done")] == 1:
            break
    line = chip.address("_buf1")
    return chip.memory[line : line + width]


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
def test_what_tis_compiler_wrote_in_1992_computes_with_our_run_time_what_it_computes_with_tis(tmp_path: Path) -> None:
    folder = ROOT / "build-foreign" / "helios" / "arielhydra" / "source" / "mand"
    if not folder.is_dir():
        pytest.skip("scripts/foreign helios has not been run here")
    ours = tmp_path / "mand.out"
    done = subprocess.run(
        [
            sys.executable,
            ROOT / "scripts" / "link_c",
            folder / "manddsp.asm",
            folder / "interrup.asm",
            "-o",
            ours,
            "--arguments",
            "stack",
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    line = mandelbrot_line(ours, 64)
    assert line == mandelbrot_line(folder / "manddsp.x40", 64) and len(set(line)) > 10


HELLO = """
gcc2_compiled.:
\t.text
\t.ref _putchar
\t.global _main
_main:
\tldiu 72,ar2
\tcall _putchar
\tldiu 10,ar2
\tcall _putchar
\tldiu 0,r0
\trets
"""


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
def test_ready_made_programs_are_linked_run_and_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert foreign_gcc.report(tmp_path) == 2
    (tmp_path / "hello.s").write_text(HELLO)
    (tmp_path / "hello.expect").write_text("H\n")
    assert foreign_gcc.report(tmp_path) == 0
    (tmp_path / "hello.expect").write_text("J\n")
    assert foreign_gcc.report(tmp_path) == 1
    (tmp_path / "hello.s").write_text(HELLO.replace("call _putchar", "nonsense", 1))
    assert foreign_gcc.report(tmp_path) == 1
    printed = capsys.readouterr().out
    assert "1 of 1 ready-made programs" in printed and "'H', not 'J'" in printed and "hello.s:8" in printed


CC1 = """#!/usr/bin/env python3
import sys
if "-version" in sys.argv:
    sys.exit("GNU C version {version}.6 (c4x-unknown-coff)")
text = open(sys.argv[sys.argv.index("-o") - 1]).read()
if "-E" not in sys.argv:
    text = {program!r}
    if "-fno-branch-count-reg" in sys.argv:
        text = text.replace("72,ar2", "{right},ar2")
open(sys.argv[sys.argv.index("-o") + 1], "w").write(text)
"""


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
@pytest.mark.parametrize(
    ("version", "right", "flags", "explained"),
    [
        ("3.4", 73, "-O2 -funroll-loops", True),
        ("3.4", 74, "-O2 -funroll-loops", False),
        ("3.4", 73, "-O2", False),
        ("2.95", 73, "-O2 -funroll-loops", False),
    ],
)
def test_unrolling_explains_a_difference_only_of_gcc_3_4_and_only_if_the_program_is_right_without_the_loop_counter(
    tmp_path: Path, version: str, right: int, flags: str, explained: bool
) -> None:
    cc1 = tmp_path / "cc1"
    cc1.write_text(CC1.format(version=version, program=HELLO, right=right))
    cc1.chmod(0o755)
    source = tmp_path / "hello.c"
    source.write_text("a stand-in for C\n")
    compiler = foreign_gcc.Compiler(cc1, None)
    assert compiler.version() == version
    why = foreign_gcc.of_unrolling(compiler, source, [], flags, "I\n", tmp_path)
    assert why == (foreign_gcc.OF_UNROLLING if explained else None)


def test_the_compilers_own_errors_are_explained_and_others_are_not() -> None:
    count = foreign_gcc.Count()
    count.refuse("a", foreign_gcc.Refused("a.c:1: error: insn does not satisfy its constraints:"))
    count.refuse("b", foreign_gcc.Refused("b.s:2: error: 'ldx' is no instruction"))
    assert count.explained.total() == 1 and count.others == ("b: b.s:2: error: 'ldx' is no instruction",)
    assert count.line("programs").startswith("  0 of 2 programs\n    1 not: GCC 3.4 stops")
