"""One TMS320C40: assemble, disassemble, run, and inspect.

program = cmrc.c40.assemble(text)
processor = cmrc.c40.Processor(program)
stop = processor.run(until="done")
processor.registers["R0"], processor.floats["R1"], processor.memory[0x300000]
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cmrc import _core, arguments, snapshots
from cmrc.chip_state import REGISTERS, AccessesToNothing, ChipState, word_of
from cmrc.debug import Debugger
from cmrc.devices import Device, Front, OneRun, attached, copied
from cmrc.floats import extended_to_float, float_to_extended, float_to_single, single_to_float
from cmrc.instructions import decode, disassemble, encodings
from cmrc.one_state import OneState
from cmrc.programs import (
    AssemblyError,
    CoffError,
    Path,
    Program,
    assemble,
    assemble_file,
    read_coff,
    read_rom,
    write_coff,
)
from cmrc.snapshots import ChipSnapshot, SnapshotError

BoardError = _core.c40.BoardError
BoardError.__doc__ = """Raised for a board that is not known, or whose file is wrong."""

INTERRUPT_PINS = ("IIOF0", "IIOF1", "IIOF2", "IIOF3")
INTERRUPT_TIMERS = ("TINT0", "TINT1")
INTERRUPT_FLAGS = {f"DMAINT{channel}": 25 + channel for channel in range(6)}
"""Bits of IIF that internal sources set (TMS320C4x User's Guide, IIF register)."""


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


class Processor(ChipState, AccessesToNothing, Front, OneRun, OneState):
    """One TMS320C40 with its board: ``default`` (the CMRC board's map), ``flat`` (zero-wait RAM everywhere, and the
    chip's own registers), or the path of a TOML file.

    ``boots_from`` is the address of the memory that the pins select for the boot ROM: call ``load_rom``, then ``boot``.
    ``devices`` are behind windows of the board, each from its word address on (``Device``), in addition to those of the
    board file. With ``checks`` the processor checks rules of the manual; ``diagnostics`` has those that the program
    broke. It is slower then, and nothing else changes.
    """

    def __init__(
        self,
        program: Program | Path | None = None,
        *,
        board: str | Path = "default",
        checks: bool = False,
        devices: Mapping[int, Device] | None = None,
        boots_from: int | None = None,
    ) -> None:
        self._devices = attached(devices)
        place = arguments.path("board", board, '"default", "flat" or the path of a board file')
        if boots_from is None:
            core = _core.c40.Processor(place, arguments.flag("checks", checks), self._devices)
        elif checks:
            raise ValueError("checks: not with boots_from; a processor without a boot ROM has them")
        else:
            core = _core.c40.Processor.bootable(
                place, arguments.whole("boots_from", boots_from, "a word address", 0, 2**32 - 1), self._devices
            )
        super().__init__(core, None)
        named = place in ("default", "flat")
        self._board, self._boots_from = place if named else os.path.abspath(place), boots_from  # for fork, after chdir
        if program is not None:
            self.load(program)

    def load(self, program: Program | Path) -> None:
        """Loads a program, or a COFF file, and sets PC to its entry. Raises CoffError; IndexError if there is no
        RAM."""
        self._refuse_inside("load")
        given = read_coff(program) if isinstance(program, (str, os.PathLike)) else program
        self.program = arguments.instance(
            "program", given, Program, "a program, as assemble gives it, or the path of a COFF file"
        )
        self._core.load_image(self.program)

    def load_rom(self, path: Path, address: int, *, width: int | None = None) -> None:
        """Puts the contents of an EPROM (Intel hex, S-records or bytes) into memory from a word address on.

        ``width`` is the memory's width, 8, 16 or 32 bits, if the image's first word does not give it; if the word
        contradicts it, ``width`` holds, with a UserWarning. Raises ValueError for a broken image; IndexError if there
        is no RAM.
        """
        self._refuse_inside("load_rom")
        words = read_rom(path, width=width)
        self._core.load_words(arguments.whole("address", address, "a word address", 0, 2**32 - 1), words)

    def boot(self) -> None:
        """Starts as the RESET pin does: with ``boots_from`` in the boot ROM, else at the board's reset vector."""
        self._refuse_inside("boot")
        self._core.boot()

    def run(self, max_cycles: int = 100_000_000, *, until: int | str | None = None) -> Stop:
        """Runs whole instructions for ``max_cycles`` cycles, or until PC is at ``until`` (an address or a symbol).
        Holds the GIL: other threads wait, so a long run beside them is one of many short ones."""
        target = None if until is None else self.address(until)
        with self._run("run"):
            stop = _stop(self._core.run(_cycles(max_cycles), target))
        if stop.reason == "breakpoint" and stop.pc == target:
            return Stop("until", stop.pc, stop.cycle)
        return stop

    def step(self) -> Stop:
        """Executes one instruction; reason ``limit`` if there was no fault."""
        with self._run("step"):
            return _stop(self._core.step())

    def trace(self, max_cycles: int, *, slot: int = 0, labels: bool = False) -> list[str]:
        """Runs like ``run`` and returns a line per instruction and interrupt (docs/trace.md), without the header; with
        ``labels``, the program's labels instead of addresses. Raises ValueError for ``labels`` without a program."""
        arguments.whole("slot", slot, "a number", 0, 2**31 - 1)
        names = None
        if arguments.flag("labels", labels):
            if self.program is None:
                raise ValueError("labels: no program has been loaded; load one first")
            names = _core.trace.Labels(self.program)
        with self._run("trace"):
            records = self._core.trace(_cycles(max_cycles))
        return [_core.trace.line(record, slot, names) for record in records]

    def complete_read(self, value: int, *, arbitration: int = 0, transfer: int = 0) -> None:
        """Answers the read that stopped a run: the word, and the cycles waited for the bus and its transfer."""
        self._refuse_inside("complete_read")
        self._core.complete_read(word_of(value), _cycles(arbitration, "arbitration"), _cycles(transfer, "transfer"))

    def complete_write(self, *, arbitration: int = 0, transfer: int = 0) -> None:
        """Completes the write that stopped a run."""
        self._refuse_inside("complete_write")
        self._core.complete_write(_cycles(arbitration, "arbitration"), _cycles(transfer, "transfer"))

    def raise_interrupt(self, source: str) -> None:
        """Requests an interrupt as its source would: an edge on ``IIOF0`` to ``IIOF3`` or ``NMI``, an event of
        the timer for ``TINT0`` and ``TINT1``, the flag in IIF for ``DMAINT0`` to ``DMAINT5``.

        The interrupt is taken when ST, IIE and IIF allow it. An edge or event that DIE selects for a DMA channel goes
        to the DMA instead. An IIOF pin that IIF does not make an interrupt pin ignores the edge. Raises ValueError for
        another source.
        """
        name = arguments.text("source", source, "the name of an interrupt").upper()
        if name == "NMI":
            self._core.raise_nmi()
        elif name in INTERRUPT_PINS:
            self._core.raise_iiof(INTERRUPT_PINS.index(name))
        elif name in INTERRUPT_TIMERS:
            self._core.raise_timer(INTERRUPT_TIMERS.index(name))
        elif name in INTERRUPT_FLAGS:
            self.registers["IIF"] |= 1 << INTERRUPT_FLAGS[name]
        else:
            raise ValueError(
                f"{source} is not an interrupt that can be raised; {', '.join(('NMI', *INTERRUPT_PINS, *INTERRUPT_TIMERS, *INTERRUPT_FLAGS))} are"
            )

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
        self._refuse_inside("debug")
        if self.program is None:
            raise ValueError("no program: load one first")
        return Debugger(self._core.debug(self.program), self)

    def reset(self) -> None:
        """Registers to 0; ends a fault. Memory and counters are kept."""
        self._refuse_inside("reset")
        self._core.reset()

    @property
    def pc(self) -> int:
        """Program counter; an address or a symbol may be assigned."""
        return super().pc

    @pc.setter
    def pc(self, where: int | str) -> None:
        self._refuse_inside("pc")
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
    "BoardError",
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
    "decode",
    "disassemble",
    "encodings",
    "extended_to_float",
    "float_to_extended",
    "float_to_single",
    "read_coff",
    "read_rom",
    "single_to_float",
    "write_coff",
]
