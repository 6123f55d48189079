"""TI's run-time library of 1999: our assembler's words against TI's, and TI's objects through our linker on the
emulated chip (docs/assembler.md, Old sources)."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from c_library import Library, link
from cmrc import c40
from locations import BUILD, ROOT

FOLDER = ROOT / "build-foreign" / "ti"
EMULATOR = BUILD / "bin" / "emulator"
here = pytest.mark.skipif(not FOLDER.is_dir(), reason="scripts/foreign ti has not been run here")

STACKED = ("rts40", "rts40g")
IN_REGISTERS = ("rts40r", "rts40gr")
FUNCTIONS: dict[str, Callable[..., float]] = {
    "_sin": math.sin, "_cos": math.cos, "_tan": math.tan, "_asin": lambda x: math.asin(x / 8), "_atan": math.atan, "_exp": math.exp, "_sinh": math.sinh, "_tanh": math.tanh,
    "_log": lambda x: math.log(abs(x) + 1), "_sqrt": lambda x: math.sqrt(abs(x)), "_fabs": abs, "_floor": math.floor, "_ceil": math.ceil,
}  # fmt: skip
FITTED = {"_asin": lambda x: x / 8, "_log": lambda x: abs(x) + 1, "_sqrt": abs}  # into what the function is defined for
TWO: dict[str, Callable[[float, float], float]] = {"_pow": math.pow, "_atan2": math.atan2, "_fmod": math.fmod}
WHOLE = ("_abs", "_sprintf", "_strlen", "_qsort", "_strcmp")
POINTS = (-7.3, -2.0, -0.625, 0.001, 0.5, 1.0, 3.25, 6.0)


class OfTi(Library):
    """Functions of one of TI's libraries, started by TI's own boot routine."""

    def __init__(self, library: str, folder: Path) -> None:
        names = [*FUNCTIONS, *TWO, *WHOLE]
        (folder / "main.asm").write_text(
            f"\t.global _main, {', '.join(names)}\n\t.text\n_main:\trets\n\t.word {','.join(names)}\n"
        )
        assert (
            subprocess.run(
                [EMULATOR, "asm", "-c", folder / "main.asm", "-o", folder / "main.o"], check=False
            ).returncode
            == 0
        )
        assert (
            link(
                [folder / "main.o", FOLDER / "Release" / "lib" / f"{library}.lib"],
                folder / "all.out",
                "--c-model",
                "rom",
                "--map-output",
                folder / "map",
            )
            == ""
        )
        self.convention = "stack" if library in STACKED else "registers"
        self.chip = c40.Processor(c40.read_coff(folder / "all.out"))
        assert self.chip.pc == self.chip.address("_c_int00") and re.search(
            r"^\.stack .* 400h", (folder / "map").read_text(), re.MULTILINE
        )
        assert self.chip.run(100_000, until="_main").reason == "until"  # boot.asm has copied the initial values

    def enter(self, name: str, pushed: list[int], kept: tuple[str, ...]) -> None:
        """In the small memory model DP is that of .bss, for all functions. R4, R5 and R8 are kept as integers, R6 and
        R7 as floats."""
        super().enter(name, pushed, tuple(register for register in kept if register.startswith("AR")))


@here
@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
def test_every_source_assembles_and_every_object_is_tis_but_for_how_ldp_is_written() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "foreign", "ti"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    page = (ROOT / "docs" / "assembler.md").read_text()
    objects, words, as_ldp = re.search(
        r"(\d+) objects, (\d+) words beside TI's own: (\d+) words of LDP .*; 0 other differences", done.stdout
    ).groups()  # type: ignore[union-attr]
    assert f"{objects} objects, {int(words):,} words" in page and f"{as_ldp} words" in page


@pytest.mark.skipif(
    not all((ROOT / "build-foreign" / name).is_dir() for name in ("helios", "cps", "cruisin", "ti")),
    reason="scripts/foreign has not been run for all four here",
)
def test_the_page_has_the_directives_of_all_four_collections_and_all_are_known() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "foreign", "directives"], capture_output=True, text=True, check=False
    )
    page = (ROOT / "docs" / "assembler.md").read_text()
    assert done.returncode == 0 and f"<!-- directives -->\n{done.stdout}<!-- end -->" in page
    for name in re.findall(r"^\| `(\.\w+)`", done.stdout, re.MULTILINE):
        try:
            c40.assemble(f"\t{name} ((\n")
        except c40.AssemblyError as error:  # of its operands
            assert not any("no directive is called" in str(found["message"]) for found in error.diagnostics), name
    with pytest.raises(c40.AssemblyError, match="no directive is called"):
        c40.assemble("\t.nonsense ((\n")


@here
@pytest.mark.parametrize("library", [*STACKED, *IN_REGISTERS])
def test_tis_mathematics_runs_here(library: str, tmp_path: Path) -> None:
    """TI's polynomials are of 32-bit floats: a few units of the last place."""
    own = OfTi(library, tmp_path)
    for name, function in FUNCTIONS.items():
        for x in POINTS:
            own.call(name, float(FITTED.get(name, lambda x: x)(x)))
            assert own.float() == pytest.approx(function(x), rel=4e-6, abs=4e-7), (name, x)
    for name, two in TWO.items():
        for x, y in ((2.0, 3.0), (0.5, -1.5), (9.75, 2.5)):
            own.call(name, x, y)
            assert own.float() == pytest.approx(two(x, y), rel=4e-6), (name, x, y)
    own.call("_abs", -17)
    assert own.chip.registers["R0"] & 0xFFFF_FFFF == 17


@here
@pytest.mark.parametrize("library", STACKED)
def test_tis_sprintf_writes_what_the_hosts_does(library: str, tmp_path: Path) -> None:
    own = OfTi(library, tmp_path)
    buffer, format_at, text = 0x3D0000, 0x3D1000, "%5d|%-8s|%08X|%e|%.3f|%g|%c|%%|%u"
    for at, string in ((format_at, text), (0x3D2000, "crane")):
        own.chip.memory[at : at + len(string) + 1] = [*string.encode(), 0]
    own.call("_sprintf", buffer, format_at, -42, 0x3D2000, 0xBEEF, 1234.5, -2.75, 1e-5, ord("x"), 4000000000)
    length = own.chip.registers["R0"] & 0xFFFF_FFFF
    written = bytes(own.chip.memory[buffer : buffer + length]).decode()
    assert written == text % (-42, "crane", 0xBEEF, 1234.5, -2.75, 1e-5, "x", 4000000000)
    own.call("_strlen", buffer)
    assert own.chip.registers["R0"] & 0xFFFF_FFFF == length == len(written)


@here
@pytest.mark.parametrize("library", ["rts30", "rts30gr"])
def test_a_library_of_the_c3x_is_linked_for_the_c3x_alone(library: str, tmp_path: Path) -> None:
    (tmp_path / "main.asm").write_text("\t.global _main, _sprintf\n\t.text\n_main:\tcall _sprintf\n\trets\n")
    for cpu, refused in (("c3x", False), ("c40", True)):
        assert (
            subprocess.run(
                [EMULATOR, "asm", "-c", tmp_path / "main.asm", "-o", tmp_path / "main.o", "--cpu", cpu], check=False
            ).returncode
            == 0
        )
        said = link(
            [tmp_path / "main.o", FOLDER / "Release" / "lib" / f"{library}.lib"],
            tmp_path / "all.out",
            "--c-model",
            "ram",
        )
        assert ("all objects of a program must be for one processor" in said) == refused
    done = subprocess.run([EMULATOR, "exec", tmp_path / "all.out"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "C3x" in done.stderr
