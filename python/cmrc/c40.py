"""One TMS320C40: assemble, disassemble, run, and inspect.

program = cmrc.c40.assemble(text)
processor = cmrc.c40.Processor(program)
stop = processor.run(until="done")
processor.registers["R0"], processor.floats["R1"], processor.memory[0x300000]
"""

from __future__ import annotations

import numbers
import os
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from typing import Any, overload

from cmrc import _core, arguments, snapshots
from cmrc.debug import Debugger
from cmrc.devices import Device, Front, OneRun, attached, copied
from cmrc.floats import extended_to_float, float_to_extended, float_to_single, single_to_float
from cmrc.snapshots import ChipSnapshot, SnapshotError

AssemblyError = _core.toolchain.AssemblyError
"""Raised with all errors of a source; ``diagnostics`` is a list of dicts (file, line, column, message, text)."""
CoffError = _core.toolchain.CoffError
"""Raised for a file that is not a COFF executable of this family, or is damaged."""
Program = _core.toolchain.Image
"""An assembled program: ``sections``, ``symbols`` (name to 32-bit word), ``entry``, ``listing()``."""

Path = str | os.PathLike[str]

REGISTERS = (
    *(f"R{n}" for n in range(12)),
    *(f"AR{n}" for n in range(8)),
    *("DP", "IR0", "IR1", "BK", "SP", "ST", "DIE", "IIE", "IIF", "RS", "RE", "RC", "IVTP", "TVTP"),
)
"""Names of all registers. R0 to R11 are 40 bits wide, all others 32."""

A_WORD = "a 32-bit word (0 to FFFFFFFFh)"
A_CPU = '"c40" or "c3x"'

INTERRUPT_PINS = ("IIOF0", "IIOF1", "IIOF2", "IIOF3")
INTERRUPT_FLAGS = {"TINT0": 24, **{f"DMAINT{channel}": 25 + channel for channel in range(6)}, "TINT1": 31}
"""Bits of IIF that internal sources set (TMS320C4x User's Guide, IIF register)."""


def _options(
    include_dirs: object, symbols: object, sections: object, entry: object, dialect: object, cpu: object
) -> tuple[list[Path], dict[str, int], dict[str, int], str, str | None, str]:
    """The options of ``assemble`` besides the source."""
    folders: list[Path] = [arguments.path(f"include_dirs[{n}]", folder, "a folder") for n, folder in enumerate(arguments.items("include_dirs", include_dirs, "a list of folders"))]

    def words(name: str, given: object, right: str) -> dict[str, int]:
        found = arguments.mapping(name, given, f"a dictionary of names and {right}s")
        return {key: arguments.whole(f"{name}[{key!r}]", value, f"a {right} (0 to FFFFFFFFh)") for key, value in found.items()}

    way = None if dialect is None else arguments.text("dialect", dialect, '"ti" or "gnu"')
    start = arguments.text("entry", entry, "the name of a symbol")
    return folders, words("symbols", symbols, "number"), words("sections", sections, "32-bit address"), start, way, arguments.text("cpu", cpu, A_CPU)


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
    return _core.toolchain.assemble(source, arguments.text("name", name), *_options(include_dirs, symbols, sections, entry, dialect, cpu))


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
    return _core.toolchain.assemble_file(arguments.path("path", path), *_options(include_dirs, symbols, sections, entry, dialect, cpu))


def read_coff(path: Path) -> Program:
    """Reads a COFF executable of version 0, 1 or 2. Raises CoffError."""
    return _core.toolchain.read_coff(arguments.path("path", path))


def write_coff(program: Program, path: Path) -> None:
    """Writes a COFF version-2 executable with all symbols, whole or not at all."""
    _core.toolchain.write_coff(arguments.instance("program", program, Program, "a program, as assemble gives it,"), arguments.path("path", path))


@overload
def disassemble(words: int, pc: int = 0, *, cpu: str = "c40") -> str: ...
@overload
def disassemble(words: Sequence[int], pc: int = 0, *, cpu: str = "c40") -> list[str]: ...
def disassemble(words: int | Sequence[int], pc: int = 0, *, cpu: str = "c40") -> str | list[str]:
    """The instruction of a word, or of each word from address ``pc`` on, for the processor ``cpu`` (``c40``, ``c3x``).
    Reserved words give ``.word``."""
    processor = arguments.text("cpu", cpu, A_CPU)
    at = arguments.whole("pc", pc, "an address (0 to FFFFFFFFh)")
    if isinstance(words, numbers.Integral):
        return str(_core.isa.disassemble(arguments.whole("words", words, A_WORD), at, cpu=processor))
    all_words = arguments.items("words", words, "a word or a list of words")
    checked = [arguments.whole(f"words[{i}]", word, A_WORD) for i, word in enumerate(all_words)]
    return [str(_core.isa.disassemble(word, at + i & 0xFFFF_FFFF, cpu=processor)) for i, word in enumerate(checked)]


def register_page() -> str:
    """The peripheral registers as in docs/peripherals.md: tables of names, addresses and fields, in Markdown."""
    return _core.c40.register_page()


@dataclass(frozen=True)
class Stop:
    """Why a run ended.

    ``reason`` is ``until``, ``limit`` (of cycles), ``breakpoint``, ``external_access`` (a bus window: answer with
    ``complete_read`` or ``complete_write`` and run again), ``software_interrupt`` (before SWI; to continue after it,
    set ``pc``) or ``fault``.
    """

    reason: str
    pc: int
    cycle: int
    message: str = ""
    details: Mapping[str, Any] | None = None
    """For an external access: address, write, interlocked, value, access_cycle. For a fault: kind, word, address."""


@dataclass(frozen=True)
class Diagnostic:
    """A rule of the manual that a program broke: ``rule`` is its name, ``section`` its section in the description of
    the instruction set, ``cycle`` the time when it was first broken."""

    rule: str
    section: str
    pc: int
    cycle: int
    instruction: str
    message: str
    count: int


class _Registers(MutableMapping[str, int]):
    """Registers by name as integers: R0 to R11 have 40 bits, exponent in 39 to 32; all others 32."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def __getitem__(self, name: str) -> int:
        return int(self._core.get(_register(name)))

    def __setitem__(self, name: str, value: int) -> None:
        width = 40 if _register(name).upper() in REGISTERS[:12] else 32
        self._core.set(name, arguments.whole(name, value, f"a whole number of {width} bits", 0, (1 << width) - 1))

    def __delitem__(self, name: str) -> None:
        raise TypeError("a register cannot be removed")

    def __iter__(self) -> Iterator[str]:
        return iter(REGISTERS)

    def __len__(self) -> int:
        return len(REGISTERS)


class _Floats(MutableMapping[str, float]):
    """R0 to R11 by name as floats. Reading is exact; writing rounds to the nearest 40-bit value."""

    def __init__(self, core: Any) -> None:
        self._core = core

    def _check(self, name: str) -> str:
        if _register(name).upper() not in REGISTERS[:12]:
            raise KeyError(f"{name} cannot hold a float; only R0 to R11 can")
        return name

    def __getitem__(self, name: str) -> float:
        return extended_to_float(int(self._core.get(self._check(name))))

    def __setitem__(self, name: str, value: float) -> None:
        self._core.set(self._check(name), float_to_extended(arguments.number(name, value)))

    def __delitem__(self, name: str) -> None:
        raise TypeError("a register cannot be removed")

    def __iter__(self) -> Iterator[str]:
        return iter(REGISTERS[:12])

    def __len__(self) -> int:
        return 12


class _Memory:
    """Memory by word address, as a debugger sees it: ``memory[a]``, ``memory[a:b]``, and assignment of words or lists
    of words.

    Raises IndexError for reserved addresses and bus windows, ValueError for a value that is not a 32-bit word.
    """

    def __init__(self, core: Any) -> None:
        self._core = core

    @overload
    def __getitem__(self, where: int) -> int: ...
    @overload
    def __getitem__(self, where: slice) -> list[int]: ...
    def __getitem__(self, where: int | slice) -> int | list[int]:
        if isinstance(where, slice):
            return [int(self._core.peek(address)) for address in _addresses(where)]
        return int(self._core.peek(_place(where)))

    @overload
    def __setitem__(self, where: int, value: int) -> None: ...
    @overload
    def __setitem__(self, where: slice, value: Sequence[int]) -> None: ...
    def __setitem__(self, where: int | slice, value: int | Sequence[int]) -> None:
        if not isinstance(where, slice):
            self._core.poke(_place(where), _word(value))
            return
        words = [_word(word) for word in arguments.items("memory", value, "a list of words for a slice")]
        start = 0 if where.start is None else _place(where.start)
        if where.step not in (None, 1) or (where.stop is not None and _end(where.stop) - start != len(words)):
            raise ValueError("the slice and the list of words differ in length")
        for offset, word in enumerate(words):
            self._core.poke(_place(start + offset), word)

    def read_floats(self, address: int, count: int) -> list[float]:
        """Words in the 32-bit single format, converted to floats. Exact."""
        start, number = _place(address), arguments.whole("count", count, "a number of words")
        return [single_to_float(word) for word in self[start : start + number]]

    def write_floats(self, address: int, values: Sequence[float]) -> None:
        """Writes floats as words of the 32-bit single format, each rounded to the nearest."""
        words = [float_to_single(arguments.number(f"values[{n}]", value)) for n, value in enumerate(arguments.items("values", values, "a list of numbers"))]
        start = _place(address)
        self[start : start + len(words)] = words


def _register(name: object) -> str:
    return arguments.text("registers", name, 'the name of a register ("R0")')


def _place(where: object) -> int:
    """An address. Raises IndexError for any other value."""
    try:
        return arguments.whole("memory", where, "an address (0 to FFFFFFFFh; address(\"label\") gives a label's) or a slice of addresses")
    except ValueError as error:
        raise IndexError(str(error)) from None


def _end(where: object) -> int:
    return arguments.whole("memory", where, "the end of a slice of addresses", 0, 1 << 32)


def _addresses(where: slice) -> range:
    if where.stop is None:
        raise ValueError("a slice of memory needs an end")
    step = 1 if where.step is None else arguments.whole("memory", where.step, "a step greater than 0", 1)
    return range(0 if where.start is None else _place(where.start), _end(where.stop), step)


def _word(value: object) -> int:
    return arguments.whole("a word", value, "a 32-bit word", -(1 << 31), (1 << 32) - 1) & 0xFFFF_FFFF


class ChipState:
    """The visible state of a chip, alone or in a network: registers, memory, ports, counters."""

    def __init__(self, core: Any, program: Program | None) -> None:
        self._core = core
        self.program = program
        """The program loaded last."""
        self.registers = _Registers(core)
        self.floats = _Floats(core)
        self.memory = _Memory(core)

    def address(self, where: int | str) -> int:
        """The address of a symbol of the program; an address is returned unchanged. Raises KeyError for an unknown
        symbol."""
        if not isinstance(where, str):
            return arguments.whole("address", where, "an address (0 to FFFFFFFFh) or a label")
        if self.program is None or where not in self.program.symbols:
            raise KeyError(f"the program has no symbol {where}")
        return int(self.program.symbols[where])

    def port(self, number: int) -> dict[str, Any]:
        """A communication port: ``input`` and ``output`` (FIFO contents, oldest first), ``token``, halts, ``control`` (CPCR), and words counted since the start."""
        return dict(self._core.port(arguments.whole("number", number, "a port, 0 to 5,", 0, 5)))

    def peripheral(self, name: str) -> int:
        """A peripheral register by its name in the manual (docs/peripherals.md). Raises IndexError for an unknown name,
        with the nearest one."""
        return int(self._core.peripheral(arguments.text("name", name, "the name of a peripheral register")))

    def fields(self, name: str) -> dict[str, int]:
        """The fields of a peripheral register, with the manual's names. Raises IndexError for an unknown register."""
        return dict(self._core.fields(arguments.text("name", name, "the name of a peripheral register")))

    @property
    def peripherals(self) -> dict[str, int]:
        """Every peripheral register by name; the FIFOs are in ``port``."""
        return dict(self._core.peripherals())

    @property
    def pc(self) -> int:
        """Program counter."""
        return int(self._core.pc)

    @property
    def cycles(self) -> int:
        """Instruction cycles so far, of the chip's own clock: the sum of ``causes``."""
        return int(self._core.cycle)

    @property
    def instructions(self) -> int:
        """Instructions executed so far."""
        return int(self._core.instructions)

    @property
    def causes(self) -> dict[str, int]:
        """Cycles by cause."""
        return dict(self._core.causes)


class AccessesToNothing:
    """Accesses to addresses without memory, of a chip on a board with ``reserved = "ignore"``."""

    _core: Any

    @property
    def reserved_accesses(self) -> list[dict[str, Any]]:
        """Accesses to addresses without memory, if the board's file says ``reserved = "ignore"``: one dict for each
        address (of the first thousand), in the order of the first access.

        ``address``, ``reads``, ``writes`` (numbers), and of the first access ``first`` (``read``, ``write``),
        ``value``, ``pc``, ``cycle``, ``dma_channel`` (None: the processor).
        """
        return [dict(note) for note in self._core.reserved_accesses]


class Processor(ChipState, AccessesToNothing, Front, OneRun):
    """One TMS320C40 with its board: ``default`` (the CMRC board's map), ``flat`` (zero-wait RAM everywhere, and the
    chip's own registers), or the path of a TOML file.

    ``boots_from`` is the address of the memory that the pins select for the boot ROM: call ``load_rom``, then ``boot``.
    ``devices`` are behind windows of the board, each from its word address on (``Device``), in addition to those of the
    board file. With ``checks`` the processor checks rules of the manual; ``diagnostics`` has those that the program
    broke. It is slower then, and nothing else changes.
    """

    def __init__(
        self, program: Program | Path | None = None, *, board: str | Path = "default", checks: bool = False, devices: Mapping[int, Device] | None = None, boots_from: int | None = None
    ) -> None:
        self._devices = attached(devices)
        place = arguments.path("board", board, '"default", "flat" or the path of a board file')
        if boots_from is None:
            core = _core.c40.Processor(place, arguments.flag("checks", checks), self._devices)
        elif checks:
            raise ValueError("checks: not with boots_from; a processor without a boot ROM has them")
        else:
            core = _core.c40.Processor.bootable(place, arguments.whole("boots_from", boots_from, "a word address", 0, 2**32 - 1), self._devices)
        super().__init__(core, None)
        self._board, self._boots_from = place, boots_from
        if program is not None:
            self.load(program)

    def load(self, program: Program | Path) -> None:
        """Loads a program, or a COFF file, and sets PC to its entry. Raises CoffError; IndexError if there is no
        RAM."""
        given = read_coff(program) if isinstance(program, (str, os.PathLike)) else program
        self.program = arguments.instance("program", given, Program, "a program, as assemble gives it, or the path of a COFF file")
        self._core.load_image(self.program)

    def load_rom(self, path: Path, address: int, *, width: int | None = None) -> None:
        """Puts the contents of an EPROM (Intel hex, S-records or bytes) into memory from a word address on.

        ``width`` is the memory's width, 8, 16 or 32 bits, if the image's first word does not give it. Raises ValueError
        for a broken image; IndexError if there is no RAM.
        """
        words = _core.toolchain.rom_words(arguments.path("path", path), width)
        self._core.load_words(arguments.whole("address", address, "a word address", 0, 2**32 - 1), words)

    def boot(self) -> None:
        """Starts as the RESET pin does: with ``boots_from`` in the boot ROM, else at the board's reset vector."""
        self._core.boot()

    def run(self, max_cycles: int = 100_000_000, *, until: int | str | None = None) -> Stop:
        """Runs whole instructions for ``max_cycles`` cycles, or until PC is at ``until`` (an address or a symbol)."""
        target = None if until is None else self.address(until)
        with self._run("run"):
            stop = _stop(self._core.run(_cycles(max_cycles), target))
        if stop.reason == "breakpoint" and stop.pc == target:
            return Stop("until", stop.pc, stop.cycle)
        return stop

    def step(self) -> Stop:
        """Executes one instruction; reason ``limit`` if there was no fault."""
        return _stop(self._core.step())

    def trace(self, max_cycles: int, *, slot: int = 0) -> list[str]:
        """Runs like ``run`` and returns a line per instruction (docs/trace.md), without the header."""
        arguments.whole("slot", slot, "a number", 0, 2**31 - 1)
        return [_core.trace.line(record, slot) for record in self._core.trace(_cycles(max_cycles)) if "pc" in record]

    def complete_read(self, value: int, *, arbitration: int = 0, transfer: int = 0) -> None:
        """Answers the read that stopped a run: the word, and the cycles waited for the bus and its transfer."""
        self._core.complete_read(_word(value), _cycles(arbitration, "arbitration"), _cycles(transfer, "transfer"))

    def complete_write(self, *, arbitration: int = 0, transfer: int = 0) -> None:
        """Completes the write that stopped a run."""
        self._core.complete_write(_cycles(arbitration, "arbitration"), _cycles(transfer, "transfer"))

    def raise_interrupt(self, source: str) -> None:
        """Requests an interrupt as its source would: an edge on ``IIOF0`` to ``IIOF3`` or ``NMI``, the flag of
        ``TINT0``, ``TINT1`` or ``DMAINT0`` to ``DMAINT5`` in IIF.

        The interrupt is taken when ST, IIE and IIF allow it. An IIOF pin that IIF does not make an interrupt pin
        ignores the edge. Raises ValueError for another source.
        """
        name = arguments.text("source", source, "the name of an interrupt").upper()
        if name == "NMI":
            self._core.raise_nmi()
        elif name in INTERRUPT_PINS:
            self._core.raise_iiof(INTERRUPT_PINS.index(name))
        elif name in INTERRUPT_FLAGS:
            self.registers["IIF"] |= 1 << INTERRUPT_FLAGS[name]
        else:
            raise ValueError(f"{source} is not an interrupt that can be raised; {', '.join(('NMI', *INTERRUPT_PINS, *INTERRUPT_FLAGS))} are")

    def snapshot(self) -> ChipSnapshot:
        """The whole state: registers, memory, pipeline, cache, peripherals, and the unanswered access. Raises
        SnapshotError with ``checks`` on, or for a Python device without ``save`` and ``load``, by its name."""
        self._refuse_inside("snapshot")
        return ChipSnapshot(self._core.save(self.program))

    def restore(self, snapshot: ChipSnapshot) -> None:
        """Goes back to a snapshot of a processor with the same board and program; from there it continues bit for bit
        as that processor did.

        Raises SnapshotError for any other snapshot, before anything is changed.
        """
        self._refuse_inside("restore")
        self._core.load(snapshots.sealed(snapshot), self.program)

    def fork(self) -> Processor:
        """A second processor with the same past. Later changes of one do not affect the other. Python devices are
        copied (copy.deepcopy), and their state is loaded."""
        other = Processor(self.program, board=self._board, boots_from=self._boots_from, devices=copied(self._devices))
        other.restore(self.snapshot())
        return other

    def debug(self) -> Debugger:
        """A debugger, forwards and backwards from here on (docs/debugger.md). Its time is that of a chip at 40 MHz, 50
        ns per cycle.

        If the processor needs an answer (a window, a port) the debugger stops with ``over``; after ``complete_read`` or
        ``complete_write`` it can continue.
        """
        if self.program is None:
            raise ValueError("no program: load one first")
        return Debugger(self._core.debug(self.program))

    def reset(self) -> None:
        """Registers to 0; ends a fault. Memory and counters are kept."""
        self._core.reset()

    @property
    def pc(self) -> int:
        """Program counter; an address or a symbol may be assigned."""
        return super().pc

    @pc.setter
    def pc(self, where: int | str) -> None:
        self._core.pc = self.address(where)

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """The broken rules found by the checks (docs/fidelity.md, Self-checks), each rule and place once."""
        return [Diagnostic(**found) for found in self._core.diagnostics()]

    @property
    def idle(self) -> bool:
        """In IDLE, with no interrupt to take."""
        return bool(self._core.idle)


def _cycles(value: object, name: str = "max_cycles") -> int:
    return arguments.whole(name, value, "a number of cycles", 0, 2**62)


def _stop(core: Mapping[str, Any]) -> Stop:
    rest = {key: value for key, value in core.items() if key not in ("reason", "pc", "cycle", "message")}
    return Stop(core["reason"], core["pc"], core["cycle"], core.get("message", ""), rest or None)


__all__ = [
    "REGISTERS",
    "AccessesToNothing",
    "AssemblyError",
    "ChipSnapshot",
    "ChipState",
    "CoffError",
    "Device",
    "Diagnostic",
    "Processor",
    "Program",
    "SnapshotError",
    "Stop",
    "assemble",
    "assemble_file",
    "disassemble",
    "extended_to_float",
    "float_to_extended",
    "float_to_single",
    "read_coff",
    "single_to_float",
    "write_coff",
]
