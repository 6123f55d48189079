"""The visible state of a chip: registers, memory, peripheral registers, counters."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping, Sequence
from typing import Any, overload

from cmrc import arguments
from cmrc.floats import extended_to_float, float_to_extended, float_to_single, single_to_float
from cmrc.programs import Program

REGISTERS = (
    *(f"R{n}" for n in range(12)),
    *(f"AR{n}" for n in range(8)),
    *("DP", "IR0", "IR1", "BK", "SP", "ST", "DIE", "IIE", "IIF", "RS", "RE", "RC", "IVTP", "TVTP"),
)
"""Names of all registers. R0 to R11 are 40 bits wide, all others 32."""


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
            self._core.poke(_place(where), word_of(value))
            return
        words = [word_of(one) for one in arguments.items("memory", value, "a list of words for a slice")]
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
        words = [
            float_to_single(arguments.number(f"values[{n}]", value))
            for n, value in enumerate(arguments.items("values", values, "a list of numbers"))
        ]
        start = _place(address)
        self[start : start + len(words)] = words


def _register(name: object) -> str:
    return arguments.text("registers", name, 'the name of a register ("R0")')


def _place(where: object) -> int:
    """An address. Raises IndexError for any other value."""
    try:
        return arguments.whole(
            "memory", where, 'an address (0 to FFFFFFFFh; address("label") gives a label\'s) or a slice of addresses'
        )
    except ValueError as error:
        raise IndexError(str(error)) from None


def _end(where: object) -> int:
    return arguments.whole("memory", where, "the end of a slice of addresses", 0, 1 << 32)


def _addresses(where: slice) -> range:
    if where.stop is None:
        raise ValueError("a slice of memory needs an end")
    step = 1 if where.step is None else arguments.whole("memory", where.step, "a step greater than 0", 1)
    return range(0 if where.start is None else _place(where.start), _end(where.stop), step)


def word_of(value: object) -> int:
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
        """A communication port: ``input`` and ``output`` (FIFO contents, oldest first), ``token``, halts, ``control``
        (CPCR), and words counted since the start."""
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
