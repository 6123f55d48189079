"""A debugger over all chips, forwards and backwards (docs/debugger.md).

For example::

    with cmrc.Simulation(dsps=4).debug() as debugger:
        debugger.break_at("kernel_pid", chip=2)
        for stop in debugger.run():
            print(stop.text, debugger.value("f(r0)"))
        debugger.back()
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any

from cmrc import _core, arguments

if TYPE_CHECKING:
    from typing_extensions import Self

    from cmrc.devices import OneRun

DebugError = _core.debug.DebugError
DebugError.__doc__ = """Raised for a command that makes no sense: a ValueError that says what would be right."""

MOST_PICOSECONDS = 9 * 10**18
CHIPS_MOST = 64


@dataclass(frozen=True)
class Hit:
    """A stop condition that was met: its ``number``, the chip (None: none), a sentence; for an access the word
    ``before`` and after (``value``), and the instruction's address."""

    number: int
    chip: int | None
    text: str
    before: int
    value: int
    pc: int


@dataclass(frozen=True)
class Stop:
    """Where the machine is. ``reason``: ``start``, ``breakpoint``, ``watchpoint``, ``event``, ``step``, ``moved``,
    ``paused``, ``over``, ``fault`` or ``software_interrupt`` (before SWI). ``chip`` is the one that stopped the
    machine."""

    reason: str
    time_ps: int
    chip: int | None
    text: str
    hits: tuple[Hit, ...]

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return self.time_ps / 1e12


@dataclass(frozen=True)
class Writer:
    """The last write to a word: its time, the chip (None: ``text`` names the writer), the instruction's address, the
    word before and after."""

    time_ps: int
    chip: int | None
    pc: int
    before: int
    value: int
    text: str


@dataclass(frozen=True)
class Frame:
    """A call: the routine's present place, as an address and as ``label+0x4``, and its source line (0: unknown)."""

    pc: int
    name: str
    file: str
    line: int


@dataclass(frozen=True)
class Register:
    """A register: its bits in hexadecimal, its value as text (for R0 to R11 the float), and its parts by name."""

    name: str
    hex: str
    value: str
    parts: dict[str, str]


def _condition(number: object) -> int:
    return arguments.whole("number", number, "the number of a stop condition", 0, 2**31 - 1)


def _kind_of_step(how: object) -> str:
    return arguments.text("how", how, 'a kind of step ("instruction", "over", "line")')


def _stop(given: dict[str, Any]) -> Stop:
    return Stop(
        given["reason"], given["time_ps"], given["chip"], given["text"], tuple(Hit(**hit) for hit in given["hits"])
    )


class Debugger:
    """The result of ``Simulation.debug()``, ``Network.debug()`` and ``Processor.debug()``. A stop is one instant of the
    whole machine. Looking changes nothing.

    A breakpoint stops before its instruction, a watchpoint after the access. Going back reaches any instant since the
    debugger was made. During the debugger's lifetime, nothing else may run or change the machine.
    """

    def __init__(self, core: Any, owner: OneRun | None = None) -> None:
        """``owner``: what runs Python devices, which may not move it."""
        self._core, self._owner = core, owner
        self._calls: dict[int, Callable[[Stop], bool | None]] = {}
        self._heard: Callable[[str], None] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Removes all listeners. The machine stays at its instant, and may run on without the debugger."""
        self._core = None

    @property
    def open(self) -> bool:
        """It has not been closed."""
        return self._core is not None

    @property
    def _d(self) -> Any:
        if self._core is None:
            raise RuntimeError("this debugger is closed; debug() gives another one")
        return self._core

    # ---- stop conditions ----

    def places(self, place: int | str, chip: int = 0) -> list[int]:
        """The addresses of a place: a number, a label, ``label+4``, or ``file.asm:LINE``. Raises DebugError."""
        number = self._number(chip)
        if isinstance(place, int) and not isinstance(place, bool):
            return [arguments.whole("place", place, "an address", 0, 2**32 - 1)]
        return [
            int(address)
            for address in self._d.places(number, arguments.text("place", place, 'a label, a number or "FILE:LINE"'))
        ]

    def break_at(
        self, place: int | str, *, chip: int | None = None, condition: str = "", ignore: int = 0, log: str = ""
    ) -> int:
        """Stops before the instruction at a place, on one chip or (None) on every chip whose program has the place;
        returns the condition's number.

        ``condition``: an expression that must hold. ``ignore``: number of hits to ignore. ``log``: prints this text,
        with ``{expressions}``, instead of stopping.
        """
        where: dict[str, Any]
        if isinstance(place, int) and not isinstance(place, bool):
            where = {"address": arguments.whole("place", place, "an address", 0, 2**32 - 1)}
        else:
            where = {"place": arguments.text("place", place, 'a label, a number or "FILE:LINE"')}
        if chip is not None:
            self._number(chip)
        return self._add("code", chip=chip, **where, condition=condition, ignore=ignore, log=log, text=str(place))

    def watch(
        self,
        place: int | str,
        words: int = 1,
        *,
        on: str = "write",
        chip: int | None = 0,
        condition: str = "",
        ignore: int = 0,
        log: str = "",
    ) -> int:
        """Stops after an access to ``words`` words from a place on: ``write``, ``read``, ``access`` (both) or
        ``change`` (a write of another value).

        Memory, peripheral registers and windows as one chip (None: every chip) accesses them, by the processor or its
        DMA; words that chips share, by any chip or the host.
        """
        if not isinstance(on, str) or on not in ("write", "read", "access", "change"):
            raise ValueError(f"on: {on!r} is unknown; write, read, access or change is expected")
        count = arguments.whole("words", words, "a number of words", 1, 2**32 - 1)
        return self._add(
            "word",
            chip=chip,
            address=self.places(place, 0 if chip is None else chip)[0],
            words=count,
            on=on,
            condition=condition,
            ignore=ignore,
            log=log,
            text=str(place),
        )

    def watch_register(self, name: str, *, chip: int = 0, condition: str = "", ignore: int = 0, log: str = "") -> int:
        """Stops after an instruction that changes a register. The chip then runs instruction by instruction, many times
        slower."""
        return self._add(
            "register",
            chip=chip,
            name=arguments.text("name", name, "the name of a register"),
            condition=condition,
            ignore=ignore,
            log=log,
        )

    def on(
        self,
        kind: str,
        /,
        *,
        chip: int | None = None,
        condition: str = "",
        ignore: int = 0,
        log: str = "",
        **fields: str | int,
    ) -> int:
        """Stops at an event: ``claim``, ``miss``, ... (``event_kinds()``), with these fields: ``on("claim", chip=2,
        task="pid")``. Numbers are integers, or texts such as ``0x50`` and ``50h``. An unknown field, and a value that
        no event has, raise DebugError with those that there are."""
        return self._add(
            "event",
            chip=chip,
            name=arguments.text("kind", kind, "a kind of event, as event_kinds() has it,"),
            fields={k: str(v) for k, v in fields.items()},
            condition=condition,
            ignore=ignore,
            log=log,
        )

    def when(self, expression: str, *, chip: int = 0) -> int:
        """Stops when an expression becomes true, checked every 125 us: ``when("plant.payload_z_m < 1")``."""
        return self._add("value", chip=chip, name=arguments.text("expression", expression, "an expression"))

    def _add(self, kind: str, *, chip: int | None, **fields: Any) -> int:
        if chip is not None:
            arguments.whole("chip", chip, "the number of a chip", 0, CHIPS_MOST)
        for name in ("condition", "log"):
            if name in fields:
                arguments.text(name, fields[name])
        if "ignore" in fields:
            arguments.whole("ignore", fields["ignore"], "a number of hits")
        return int(self._d.add({"kind": kind, "chip": chip, **fields}))

    def remove(self, number: int) -> None:
        """Removes a stop condition."""
        self._d.remove(_condition(number))
        self._calls.pop(number, None)

    def call(self, number: int, function: Callable[[Stop], bool | None]) -> None:
        """Calls a function at every forward stop by this condition, with the machine at the stop. If it returns True,
        the machine runs on."""
        if _condition(number) not in self._d.hits():
            raise DebugError(f"there is no stop condition {number}; one of {sorted(self._d.hits())} is expected")
        arguments.function("function", function, "a function")
        self._calls[number] = function

    def enable(self, number: int, on: bool = True) -> None:
        """Switches a stop condition on or off."""
        self._d.enable(_condition(number), arguments.flag("on", on))

    def hits(self) -> dict[int, int]:
        """How often each stop condition was met, going forward."""
        return dict(self._d.hits())

    # ---- forward and backward ----

    @property
    def stop(self) -> Stop:
        """The last stop."""
        return _stop(self._d.stop())

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return self.stop.time_s

    def go(self, until_s: float | None = None) -> Stop:
        """Runs to the next stop, or to ``until_s``. If all functions of ``call`` return True at a stop, the machine
        runs on."""
        until = None if until_s is None else self._ps(until_s)
        while True:
            with self._moving("go"):
                stop = _stop(self._d.go(until))
            calls = [self._calls.get(hit.number) for hit in stop.hits]
            go_on = [call is not None and call(stop) is True for call in calls]  # each is called
            if not stop.hits or not all(go_on):
                return stop

    def run(self) -> Iterator[Stop]:
        """Every stop from here on until nothing more happens: ``for stop in debugger.run(): ...``. A chip that is left
        before SWI does not continue; where its PC is set in the loop, it does."""
        left = None
        while True:
            stop = self.go()
            if stop.reason == "over":
                return
            place = (stop.time_ps, self._pcs()) if stop.reason == "software_interrupt" else None
            if place is not None and place == left:  # nobody has moved since the last stop
                return
            left = place
            yield stop

    def _pcs(self) -> list[int]:
        return [int(self._d.evaluate(chip, "pc")) for chip in range(len(self._d.chip_names()))]

    def step(self, how: str = "instruction", *, chip: int | None = None) -> Stop:
        """One step of a chip, by default of the last stop's chip: ``instruction``, ``over`` a call, ``line``,
        ``next_line``, ``out`` of the routine, to its next ``claim`` of a task block, the next ``refresh`` of the list,
        or the next ``event`` of any kind."""
        with self._moving("step"):
            return _stop(self._d.step(self._chip(chip), _kind_of_step(how)))

    def back(self) -> Stop:
        """Goes back to the last stop condition met before now; if there is none, to the beginning."""
        with self._moving("back"):
            return _stop(self._d.go_back())

    def step_back(self, how: str = "instruction", *, chip: int | None = None) -> Stop:
        """The same steps, backwards."""
        with self._moving("step_back"):
            return _stop(self._d.step_back(self._chip(chip), _kind_of_step(how)))

    def go_to(self, time_s: float) -> Stop:
        """Goes to an instant since the debugger was made, before or after now. Stop conditions are not checked."""
        with self._moving("go_to"):
            return _stop(self._d.go_to(self._ps(time_s)))

    def go_to_ps(self, time_ps: int) -> Stop:
        """The same, in whole picoseconds like ``Stop.time_ps``."""
        with self._moving("go_to_ps"):
            return _stop(self._d.go_to(arguments.whole("time_ps", time_ps, "picoseconds", 0, MOST_PICOSECONDS)))

    def last_write(self, place: int | str, *, chip: int | None = None) -> Writer | None:
        """The last write to a word before now; None: no write since the debugger was made. The machine stays at its
        instant."""
        number = self._chip(chip)
        with self._moving("last_write"):
            found = self._d.last_write(number, self.places(place, number)[0])
        return None if found is None else Writer(**found)

    def _moving(self, call: str) -> AbstractContextManager[None]:
        return nullcontext() if self._owner is None else self._owner._run(f"debug().{call}")

    @staticmethod
    def _ps(time_s: float) -> int:
        right = "seconds, 0 to 9e6,"
        found = arguments.number("time_s", time_s, right, 0)
        if found * 1e12 > MOST_PICOSECONDS:
            raise ValueError(f"time_s: {time_s} is out of range; {right} is expected")
        return round(found * 1e12)

    def _chip(self, chip: int | None) -> int:
        if chip is None:
            return self.stop.chip or 0
        return self._number(chip)

    def _number(self, chip: object) -> int:
        found = arguments.whole("chip", chip, "the number of a chip", 0, 2**63 - 1)
        last = len(self._d.chip_names()) - 1
        if found > last:
            raise DebugError(f"there is no chip {found}; 0 to {last} is expected")
        return found

    # ---- views ----

    def value(self, expression: str, *, chip: int | None = None) -> int | float:
        """The value of an expression: ``r0``, ``f(r1)``, ``[label + 2]``, ``chip1.pc``, ``TIMER0.counter``,
        ``plant.payload_z_m``, with operators as in C."""
        result: int | float = self._d.evaluate(
            self._chip(chip), arguments.text("expression", expression, "an expression")
        )
        return result

    def word(self, place: int | str, *, chip: int | None = None) -> int | None:
        """The word that the chip's program would read, without time or effects; None: it cannot be read like this."""
        number = self._chip(chip)
        found = self._d.peek(number, self.places(place, number)[0])
        return None if found is None else int(found)

    def registers(self, *, chip: int | None = None) -> dict[str, Register]:
        """PC, R0 to R11, AR0 to AR7, and the other registers."""
        return {
            name: Register(name, bits, value, dict(parts))
            for name, bits, value, parts in self._d.registers(self._chip(chip))
        }

    def peripherals(self, *, chip: int | None = None) -> dict[str, Register]:
        """Peripheral registers with their fields, and the contents of the ports' FIFOs."""
        return {
            name: Register(name, bits, value, dict(parts))
            for name, bits, value, parts in self._d.peripherals(self._chip(chip))
        }

    def stack(self, *, chip: int | None = None) -> list[Frame]:
        """The calls of the present routine, the innermost first."""
        return [Frame(*frame) for frame in self._d.stack(self._chip(chip))]

    def disassemble(self, place: int | str, count: int = 8, *, chip: int | None = None) -> list[tuple[int, str]]:
        """Address and text of ``count`` words."""
        number = self._chip(chip)
        first = self.places(place, number)[0]
        return [
            (a, self._d.instruction(number, a) or "no memory")
            for a in range(first, first + arguments.whole("count", count, "a number of words", 1, 100_000))
        ]

    def describe(self, *, chip: int | None = None) -> str:
        """The state of a chip in one sentence."""
        return str(self._d.describe(self._chip(chip)))

    def chips(self) -> list[str]:
        """The chips' names."""
        return list(self._d.chip_names())

    def event_kinds(self) -> dict[str, str]:
        """The kinds of events for ``on``, with their descriptions."""
        return dict(self._d.event_kinds())

    def value_names(self) -> list[str]:
        """Values besides registers and memory, for expressions."""
        return list(self._d.value_names())

    def page(self, name: str) -> str:
        """A page of text: for the dock ``list``, ``dsps``, ``plant``; for a network ``chips``, ``events``."""
        return str(self._d.page(arguments.text("name", name, "the name of a page")))

    def history(self) -> dict[str, int]:
        """The number of snapshots, their bytes, and the instants of the first and the last one in ps."""
        return dict(self._d.history())

    # ---- changes by hand ----

    def set_word(self, place: int | str, value: int, *, chip: int | None = None) -> None:
        """Changes a word. Everything later is discarded: a new branch begins. The change is kept: every pass through
        this instant finds the word changed."""
        number = self._chip(chip)
        self._d.set_word(number, self.places(place, number)[0], arguments.whole("value", value, "a word", 0, 2**32 - 1))

    def set_register(self, name: str, value: float | str, *, chip: int | None = None) -> None:
        """Changes a register, to a number or an expression; R0 to R11 take floats. A new ``pc`` drops the instruction
        under way; it is refused for a chip with a fault, which only a reset ends, and for one that is held."""
        self._d.set_register(self._chip(chip), arguments.text("name", name, "the name of a register"), str(value))

    def listen(self, port: int = 0, *, told: Callable[[int], None] | None = None) -> bool:
        """Lets one editor attach to a port of this machine (docs/dap.md), and serves it until it disconnects. False:
        the editor wants the run to end.

        Port 0 is any free port; ``told`` is a function that is called with the number of the port. Raises OSError for a
        port in use.
        """
        arguments.function("told", told, "a function of the port's number")
        return bool(self._d.listen(arguments.whole("port", port, "a port", 0, 65535), told))

    def on_output(self, heard: Callable[[str], None] | None) -> None:
        """Sets the function that is called with the texts of log points, and of changes by hand."""
        arguments.function("heard", heard, "a function of a text")
        if heard is None:
            self._d.on_output(None)
        else:
            myself = weakref.ref(self)  # the core keeps no function that could know this debugger

            def tell(text: str) -> None:
                if (debugger := myself()) is not None and debugger._heard is not None:
                    debugger._heard(text)

            self._d.on_output(tell)
        self._heard = heard
