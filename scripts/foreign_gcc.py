"""What GCC's port for the C4x makes of C, through our assembler, linker, run-time and emulator (docs/from-c.md).

The folder that is given holds either the compiler, `cc1` and of version 2.95 `cccp`, wherever in it: then the programs
of tests/programs/c are compiled in twelve sets of flags, and each has to print what the host's own build of it prints;
with `config/c4x/libgcc.S` beside, also linked with GCC's own library. Or it holds programs, NAME.s or NAME.o with what
they print as NAME.expect.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EMULATOR = ROOT / "build" / "bin" / "emulator"
PROGRAMS = ROOT / "tests" / "programs" / "c"
FLAGS = (
    "-O0",
    "-O1",
    "-O2",
    "-O3",
    "-Os",
    "-O0 -mmemparm",
    "-O2 -mmemparm",
    "-O2 -msmall",
    "-O2 -fomit-frame-pointer -funroll-loops",
    "-O2 -mrpts",
    "-O2 -mno-rptb -mno-parallel-insns",
    "-O2 -mti",
)
BOARD = ROOT / "examples" / "console.toml"
OF_LIBGCC = "libgcc's remainder of -2^31 by a negative number is wrong: it takes the divisor with its sign"
OF_UNROLLING = "GCC 3.4 unrolls counted loops with one pass too many; with -fno-branch-count-reg the program is right"
REFUSED = {
    "insn does not satisfy its constraints": "GCC 3.4 stops with an error of its own: insn does not satisfy its constraints"
}


class Refused(Exception):
    """What a tool said."""


def run(*command: str | Path, most_s: float = 120) -> str:
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False, timeout=most_s)
    if done.returncode != 0:
        raise Refused(
            next(
                (line for line in done.stderr.splitlines() if "rror" in line),
                done.stderr.strip() or f"status {done.returncode}",
            )
        )
    return done.stdout


@dataclass(frozen=True)
class Compiler:
    cc1: Path
    cccp: Path | None  # from version 3 on a part of cc1

    def preprocess(self, source: Path, out: Path, *options: str) -> Path:
        if self.cccp is not None:
            run(self.cccp, *options, source, out)
        else:
            run(self.cc1, "-E", "-quiet", *options, source, "-o", out)
        return out

    def compile(self, source: Path, flags: str, folder: Path) -> Path:
        text, out = self.preprocess(source, folder / f"{source.stem}.i"), folder / f"{source.stem}.s"
        run(self.cc1, "-quiet", *flags.split(), text, "-o", out)
        return out

    def version(self) -> str:
        done = subprocess.run(
            [self.cc1, "-version"],
            input="",
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=60,
            cwd=tempfile.gettempdir(),
        )
        found = re.search(r"version (?:gcc-)?(\d+\.\d+)", done.stdout + done.stderr)
        return found[1] if found else ""


def compiler_in(folder: Path) -> Compiler | None:
    found = [
        next(iter(sorted(path for path in folder.rglob(name) if path.is_file())), None) for name in ("cc1", "cccp")
    ]
    return Compiler(found[0], found[1]) if found[0] else None


def printed(program: Path, inputs: list[Path], flags: str, folder: Path) -> str:
    """What the console is sent by the program, linked and run."""
    out = folder / "program.out"
    way = "stack" if "-mmemparm" in flags else "registers"
    run(
        sys.executable, ROOT / "scripts" / "link_c", program, *inputs, "-o", out, "--arguments", way, "--dialect", "gnu"
    )
    report_text = run(EMULATOR, "exec", out, "--board", BOARD, "--max-cycles", "1000000000", "--json")
    return str(json.loads(report_text)["console"])


def of_host(source: Path, folder: Path) -> str:
    host = folder / f"{source.stem}.host"
    run("cc", "-w", "-O1", "-fwrapv", source, "-o", host)
    return run(host)


def libgcc(source: Path, compiler: Compiler, flags: str, folder: Path) -> list[Path]:
    """Each function of libgcc.S as an object."""
    out = []
    for name in sorted(set(re.findall(r"^#ifdef L(_\w+)", source.read_text(encoding="latin-1"), re.MULTILINE))):
        text, made = folder / f"{name}.s", folder / f"{name}.o"
        compiler.preprocess(source, text, "-lang-asm", "-D_TMS320C4x", f"-DL{name}")
        run(
            EMULATOR,
            "asm",
            "-c",
            "--dialect",
            "gnu",
            "-D",
            f".REGPARM={0 if '-mmemparm' in flags else 1}",
            text,
            "-o",
            made,
        )
        out.append(made)
    return out


@dataclass
class Count:
    same: int = 0
    explained: Counter[str] = field(default_factory=Counter)
    others: tuple[str, ...] = ()

    def take(self, name: str, found: str, expected: str, why: str | None = None) -> None:
        if found == expected:
            self.same += 1
        elif why is not None:
            self.explained[why] += 1
        else:
            self.others += (
                f"{name}: {next((f'{a!r}, not {b!r}' for a, b in zip(found.splitlines(), expected.splitlines(), strict=False) if a != b), 'another length')}",
            )

    def refuse(self, name: str, refusal: Refused) -> None:
        why = next((reason for part, reason in REFUSED.items() if part in str(refusal)), None)
        if why is None:
            self.others += (f"{name}: {refusal}",)
        else:
            self.explained[why] += 1

    def line(self, what: str) -> str:
        all_of_them = self.same + self.explained.total() + len(self.others)
        return "\n".join(
            [
                f"  {self.same} of {all_of_them} {what}",
                *(f"    {number} not: {why}" for why, number in sorted(self.explained.items())),
            ]
        )


def of_unrolling(
    compiler: Compiler, source: Path, inputs: list[Path], flags: str, expected: str, folder: Path
) -> str | None:
    """Whether the loop counter alone is to blame: the same flags without it must give a program that is right
    (docs/from-c.md)."""
    if "-funroll-loops" not in flags or compiler.version() != "3.4":
        return None
    without = f"{flags} -fno-branch-count-reg"
    (folder / "without").mkdir(exist_ok=True)
    return (
        OF_UNROLLING
        if printed(compiler.compile(source, without, folder / "without"), inputs, without, folder) == expected
        else None
    )


def compiled(compiler: Compiler, library: Path | None, folder: Path) -> tuple[Count, Count]:
    with_ours, with_libgcc = Count(), Count()
    sources = sorted(PROGRAMS.glob("*.c"))
    for number, flags in enumerate(FLAGS, start=1):
        if sys.stderr.isatty():
            print(f"\r{number} of {len(FLAGS)} sets of flags", end="", file=sys.stderr, flush=True)
        own = libgcc(library, compiler, flags, folder) if library else []
        for source in sources:
            name, expected = f"{source.name} {flags}", of_host(source, folder)
            try:
                program = compiler.compile(source, flags, folder)
            except Refused as refusal:
                with_ours.refuse(name, refusal)
                continue
            for count, inputs, what in ((with_ours, [], name), (with_libgcc, own, f"{name}, libgcc")):
                if count is with_libgcc and not own:
                    continue
                try:
                    found = printed(program, inputs, flags, folder)
                    why = OF_LIBGCC if inputs and source.stem == "whole" else None
                    if found != expected and why is None:
                        why = of_unrolling(compiler, source, inputs, flags, expected, folder)
                    count.take(what, found, expected, why)
                except Refused as refusal:
                    count.refuse(what, refusal)
    if sys.stderr.isatty():
        print(file=sys.stderr)
    return with_ours, with_libgcc


def ready_made(folder: Path, work: Path) -> Count:
    count = Count()
    for expected in sorted(folder.rglob("*.expect")):
        program = next(
            (expected.with_suffix(suffix) for suffix in (".s", ".o") if expected.with_suffix(suffix).exists()), None
        )
        if program is None:
            continue
        try:
            count.take(program.name, printed(program, [], "", work), expected.read_text())
        except Refused as refusal:
            count.others += (f"{program.name}: {refusal}",)
    return count


def report(folder: Path) -> int:
    """Prints the counts; status 0: all as it should be, or explained."""
    if shutil.which("cc") is None:
        print("scripts/foreign gcc: no cc on this machine, which says what the programs should print", file=sys.stderr)
        return 2
    compiler = compiler_in(folder)
    library = next(iter(sorted(folder.rglob("config/c4x/libgcc.S"))), None)
    with tempfile.TemporaryDirectory(prefix="foreign_gcc") as name:
        work = Path(name)
        counts = []
        print(f"gcc: C programs through our tools, from {folder.name}")
        if compiler is not None:
            ours, own = compiled(compiler, library, work)
            counts = [ours, own]
            print(ours.line(f"programs and flags ({len(FLAGS)} sets) print what the host's build prints"))
            if library is not None:
                print(own.line("with GCC's own libgcc"))
        else:
            counts = [ready_made(folder, work)]
            print(counts[0].line("ready-made programs print what is expected"))
            if not counts[0].same and not counts[0].others:
                print("  neither cc1 of GCC for the C4x, nor NAME.s or NAME.o with NAME.expect, is in the folder")
                return 2
    for count in counts:
        for other in count.others:
            print(f"  not explained: {other}")
    return 1 if any(count.others for count in counts) else 0
