"""TI's run-time library, version 5.11 of 1999, through our assembler and linker (docs/assembler.md, Old sources).

The folder has the library's sources (rts.src, mathasm.src, prts40.src) and eight libraries that TI's own tools made of
rts.src: for the C40 and the C3x, arguments on the stack or in registers, and optimised or for a debugger. Each
assembler source is assembled as a library was, and the object is compared with TI's, word by word and relocation by
relocation. COFF is read here by a few lines of its own, not by what is under test.
"""

from __future__ import annotations

import struct
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EMULATOR = ROOT / "build" / "bin" / "emulator"
LIBRARIES = ("rts40", "rts40r", "rts40g", "rts40gr", "rts30", "rts30r", "rts30g", "rts30gr")
SOURCES = ("rts.src", "mathasm.src", "prts40.src")
OF_LDP = "words of LDP that 5.11 writes as LDIU (C40) or LDI (C3x)"
# Ours and theirs, without the page.
LDP = {(0x1F700000, 0x50700000), (0x50700000, 0x08700000)}
SECTION_NAME = 8  # as many characters as ours writes into a section's header; TI's has longer ones in the string table


def members(archive: bytes) -> Iterator[tuple[str, bytes]]:
    at = 8
    while at + 60 <= len(archive):
        name, size = archive[at : at + 16].decode("latin-1").rstrip().rstrip("/"), int(archive[at + 48 : at + 58])
        yield name, archive[at + 60 : at + 60 + size]
        at += 60 + size + size % 2


@dataclass(frozen=True)
class Section:
    words: tuple[int, ...]
    relocations: tuple[tuple[int, str, int], ...]
    """Offset, symbol, type."""


def sections(data: bytes) -> dict[str, Section]:
    """Of a COFF file of version 2, those that hold or reserve words."""
    _, count, _, symbols_at, symbols, optional, _ = struct.unpack_from("<HHIIIHH", data)
    strings = symbols_at + 18 * symbols

    def name(field: bytes) -> str:
        zeros, offset = struct.unpack("<II", field)
        raw = field if zeros or not offset else data[strings + offset : data.index(b"\0", strings + offset)]
        return raw.rstrip(b"\0").decode("latin-1")

    names, n = {}, 0
    while n < symbols:
        entry = data[symbols_at + 18 * n : symbols_at + 18 * (n + 1)]
        names[n] = name(entry[:8])
        n += 1 + entry[17]  # auxiliary entries follow
    found = {}
    for n in range(count):
        at = 22 + optional + 48 * n
        _, address, size, words_at, relocations_at, _, relocations = struct.unpack_from("<7I", data, at + 8)
        if size == 0:
            continue
        entries = [struct.unpack_from("<IIHH", data, relocations_at + 12 * r) for r in range(relocations)]
        found[name(data[at : at + 8])[:SECTION_NAME]] = Section(
            struct.unpack_from(f"<{size}I", data, words_at) if words_at else (),
            # A symbol of the section itself may be named by the symbol or by the section: the word holds the address.
            tuple((place - address, names.get(symbol, ""), kind) for place, symbol, _, kind in entries),
        )
    return found


@dataclass
class Count:
    objects: int = 0
    words: int = 0
    as_ldp: int = 0
    others: list[str] = field(default_factory=list)

    def compare(self, what: str, ours: dict[str, Section], theirs: dict[str, Section]) -> None:
        self.objects += 1
        if ours.keys() != theirs.keys():
            self.others.append(f"{what}: sections {sorted(ours)}, TI's {sorted(theirs)}")
        for name in ours.keys() & theirs.keys():
            mine, its = ours[name], theirs[name]
            self.words += len(its.words)
            if len(mine.words) != len(its.words):
                self.others.append(f"{what}: {name} has {len(mine.words)} words, TI's {len(its.words)}")
            for at, (one, other) in enumerate(zip(mine.words, its.words, strict=False)):
                if one == other:
                    continue
                if (one & 0xFFFF0000, other & 0xFFFF0000) in LDP and one & 0xFFFF == other & 0xFFFF:
                    self.as_ldp += 1
                else:
                    self.others.append(f"{what}: {name} word {at} is {one:08X}h, TI's {other:08X}h")
            if [(place, kind) for place, _, kind in mine.relocations] != [
                (place, kind) for place, _, kind in its.relocations
            ]:
                self.others.append(f"{what}: {name} has other relocations")


def options_of(library: str) -> list[str]:
    """As TI built it: interruptible code in the run-time (-mi), so RPTB instead of RPTS."""
    cpu = ["--cpu", "c3x"] if library.startswith("rts30") else []
    return [*cpu, "-D", ".C30INTERRUPT=1", *(["-D", ".REGPARM=1"] if "r" in library[len("rts40") :] else [])]


def assembled(source: bytes, name: str, options: list[str], folder: Path) -> bytes:
    """An object. Raises ValueError with the first error."""
    path, out = folder / name, folder / "out.o"
    path.write_bytes(source)
    done = subprocess.run(
        [EMULATOR, "asm", path, "-c", "-o", out, "--undefined-external", *options],
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode != 0:
        raise ValueError(next((line for line in done.stderr.splitlines() if "error" in line), done.stderr))
    return out.read_bytes()


def report(folder: Path) -> int:
    """Status 0: every source assembles, and every object is TI's except for what has its reason."""
    lib = folder / "Release" / "lib"
    sources = {
        name: {member: text for member, text in members((lib / name).read_bytes()) if member.endswith(".asm")}
        for name in SOURCES
    }
    count, refused, tried = Count(), [], 0
    with tempfile.TemporaryDirectory() as made:
        place = Path(made)
        for archive, files in sources.items():
            for name, text in files.items():
                for options in ([], ["-D", ".REGPARM=1"], ["-D", ".BIGMODEL=1"]):
                    tried += 1
                    try:
                        assembled(text, name, options, place)
                    except ValueError as error:
                        refused.append(f"{archive} {name}: {error}")
        for library in LIBRARIES:
            built = dict(members((lib / f"{library}.lib").read_bytes()))
            for name, text in sources["rts.src"].items():
                theirs = built[name.replace(".asm", ".obj")]
                count.compare(
                    f"{library} {name}", sections(assembled(text, name, options_of(library), place)), sections(theirs)
                )
    files_in_all = sum(map(len, sources.values()))
    print(
        f"ti: TI's run-time library, 5.11 of 1999\n  {tried - len(refused)} of {tried}: {files_in_all} sources assemble with arguments on the stack, in registers, and in the big model"
    )
    print(
        f"  {count.objects} objects, {count.words} words beside TI's own: {count.as_ldp} {OF_LDP}; {len(count.others)} other differences"
    )
    for message in [*refused, *count.others]:
        print(f"  not explained: {message}")
    return 1 if refused or count.others else 0
