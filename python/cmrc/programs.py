"""Programs: assembled from sources, read from files and written to them; contents of EPROMs."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from cmrc import _core, arguments

AssemblyError = _core.toolchain.AssemblyError
AssemblyError.__doc__ = (
    """Raised with all errors of a source; ``diagnostics`` is a list of dicts (file, line, column, message, text)."""
)
CoffError = _core.toolchain.CoffError
CoffError.__doc__ = """Raised for a file that is not a COFF executable of this family, or is damaged."""
Program = _core.toolchain.Image
"""An assembled program: ``sections``, ``symbols`` (name to 32-bit word), ``entry``, ``listing()``."""

Path = str | os.PathLike[str]

A_WIDTH = "8, 16 or 32 bits"
A_CPU = '"c40" or "c3x"'


def _options(
    include_dirs: object, symbols: object, sections: object, entry: object, dialect: object, cpu: object
) -> tuple[list[Path], dict[str, int], dict[str, int], str, str | None, str]:
    """The options of ``assemble`` besides the source."""
    folders: list[Path] = [
        arguments.path(f"include_dirs[{n}]", folder, "a folder")
        for n, folder in enumerate(arguments.items("include_dirs", include_dirs, "a list of folders"))
    ]

    def words(name: str, given: object, right: str) -> dict[str, int]:
        found = arguments.mapping(name, given, f"a dictionary of names and {right}s")
        return {
            key: arguments.whole(f"{name}[{key!r}]", value, f"a {right} (0 to FFFFFFFFh)")
            for key, value in found.items()
        }

    way = None if dialect is None else arguments.text("dialect", dialect, '"ti" or "gnu"')
    start = arguments.text("entry", entry, "the name of a symbol")
    return (
        folders,
        words("symbols", symbols, "number"),
        words("sections", sections, "32-bit address"),
        start,
        way,
        arguments.text("cpu", cpu, A_CPU),
    )


def assemble(
    text: str,
    *,
    name: str = "<text>",
    include_dirs: Sequence[Path] = (),
    symbols: Mapping[str, int] | None = None,
    sections: Mapping[str, int] | None = None,
    entry: str = "",
    dialect: str | None = None,
    cpu: str = "c40",
) -> Program:
    """Assembles a text in TI's syntax (docs/assembler.md).

    ``symbols`` are predefined constants. ``sections`` gives sections addresses (default of ``.text``: 300000h).
    ``entry`` names the symbol at which the program starts. ``dialect`` (``ti``, ``gnu``) is for files that do not name
    it themselves. ``cpu`` (``c40``, ``c3x``) is the processor; a C3x program can be assembled and disassembled, but no
    ``Processor`` runs it. Raises AssemblyError; ValueError for another dialect or processor.
    """
    source = arguments.text("text", text, "the source as a text (assemble_file takes a path)")
    return _core.toolchain.assemble(
        source, arguments.text("name", name), *_options(include_dirs, symbols, sections, entry, dialect, cpu)
    )


def assemble_file(
    path: Path,
    *,
    include_dirs: Sequence[Path] = (),
    symbols: Mapping[str, int] | None = None,
    sections: Mapping[str, int] | None = None,
    entry: str = "",
    dialect: str | None = None,
    cpu: str = "c40",
) -> Program:
    """Assembles a file; see ``assemble``. Included files are looked for first in the file's folder. Raises
    AssemblyError."""
    return _core.toolchain.assemble_file(
        arguments.path("path", path), *_options(include_dirs, symbols, sections, entry, dialect, cpu)
    )


def read_coff(path: Path) -> Program:
    """Reads a COFF executable of version 0, 1 or 2. Raises CoffError."""
    return _core.toolchain.read_coff(arguments.path("path", path))


def write_coff(program: Program, path: Path) -> None:
    """Writes a COFF version-2 executable with all symbols, whole or not at all."""
    _core.toolchain.write_coff(
        arguments.instance("program", program, Program, "a program, as assemble gives it,"),
        arguments.path("path", path),
    )


def read_rom(path: Path, *, width: int | None = None) -> list[int]:
    """The 32-bit words of an EPROM's contents: Intel hex, S-records or plain bytes.

    ``width`` is the memory's width, 8, 16 or 32 bits, if the image's first word does not give it; if the word
    contradicts it, ``width`` holds, with a UserWarning. Raises ValueError for a broken image.
    """
    lanes = None if width is None else arguments.whole("width", width, A_WIDTH)
    return _core.toolchain.rom_words(arguments.path("path", path), lanes)
