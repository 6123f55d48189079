"""The description of a network: its checked form, as the core takes it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from cmrc import _core, arguments
from cmrc.devices import PINS, Attached, attached
from cmrc.network.records import SharedMemory
from cmrc.programs import Path, Program, assemble_file, read_coff

Checked = TypeVar("Checked")
NetworkError = _core.network.NetworkError
NetworkError.__doc__ = (
    """Raised for an impossible network: a ValueError that names chip, port or link, and what would be right."""
)


def program(given: Program | Path) -> Program:
    """A program; a path is that of a source or a COFF file."""
    if isinstance(given, Program):
        return given
    arguments.path("programs", given, "a program, as cmrc.c40.assemble gives it, or the path of a source or COFF file")
    return assemble_file(given) if str(given).endswith((".asm", ".s", ".S")) else read_coff(given)


def programs(given: Any, topology: str | None) -> list[Program]:
    """The program of each chip: one for all chips of the topology, or one for each."""
    alone = isinstance(given, (str, os.PathLike, Program))
    each = [given] if alone else arguments.items("programs", given, "a program or a list of programs")
    images = [program(one) for one in each]
    if not images:
        raise NetworkError("programs: there is none; a program, or one for each chip, is expected")
    if topology is None:
        return images
    count = int(_core.network.chips_of(arguments.text("topology", topology, 'a topology ("ring:4")')))
    return images * count if len(images) == 1 else images


def address(program: Program, where: int | str | None) -> int | None:
    """The address at which a chip has ended: a number, or a label of its program."""
    if where is None:
        return where
    if not isinstance(where, str):
        return arguments.whole("until", where, "an address (0 to FFFFFFFFh) or a label")
    if where not in program.symbols:
        raise KeyError(f"the program has no symbol {where}")
    return int(program.symbols[where])


def instant(name: str, microseconds: float) -> int:
    """An instant in ps, within 64 bits."""
    found = arguments.number(name, microseconds, "an instant in us, 0 to 9e12,", 0.0) * 1e6
    if found > 9e18:
        raise ValueError(f"{name}: {microseconds} us is out of range; an instant in us, 0 to 9e12, is expected")
    return round(found)


def link(name: str, given: object) -> tuple[str, dict[str, Any]]:
    """A link as text, and its settings."""
    right = 'a link as "0.3:1.0", or ("0.3:1.0", {"word_cycles": 5}),'
    if isinstance(given, str):
        return given, {}
    if not isinstance(given, (tuple, list)) or len(given) != 2 or not isinstance(given[0], str):
        arguments.refuse(name, given, right)
    cycles = arguments.mapping(name, given[1], right)
    return given[0], {
        key: arguments.whole(f"{name}, {key}", value, "a number of cycles", 0, 2**31 - 1)
        for key, value in cycles.items()
    }


def shared_memory(name: str, memory: object) -> dict[str, Any]:
    """A shared memory with its places as pairs of chip and address, and a pin for each place."""
    m = arguments.instance(name, memory, SharedMemory, "a cmrc.network.SharedMemory")
    if not isinstance(m.places, Mapping):
        arguments.refuse(f"{name}.places", m.places, "a dictionary of chips and addresses")
    pins = arguments.chips(f"{name}.pins", m.pins, "a dictionary of chips and pins")
    for chip in pins:
        if chip not in m.places:
            raise NetworkError(
                f"{name}.pins: the memory has no place at chip {chip}; it has places at {', '.join(map(str, m.places))}"
            )
    return {
        "name": arguments.text(f"{name}.name", m.name),
        "words": arguments.whole(f"{name}.words", m.words, "a number of words"),
        "waits": arguments.whole(f"{name}.waits", m.waits, "a number of cycles", 0, 2**31 - 1),
        "dual_port": arguments.flag(f"{name}.dual_port", m.dual_port),
        "pins": [_pin(f"{name}.pins", pins.get(chip)) for chip in m.places],
        "places": [
            (
                arguments.whole(f"{name}.places", chip, "the number of a chip"),
                arguments.whole(f"{name}.places", at, "an address"),
            )
            for chip, at in m.places.items()
        ],
    }


def _pin(name: str, pin: object) -> str | None:
    if pin is not None and pin not in PINS:
        raise ValueError(f"{name}: {', '.join(PINS)} is expected, not {pin!r}")
    return None if pin is None else str(pin)


def devices(given: object, count: int) -> list[list[Attached]]:
    """The devices of each chip. Only a device that acts on other chips may be attached to several."""
    if not isinstance(given, Mapping | None):
        arguments.refuse("devices", given, "a dictionary of chips, each with a dictionary of addresses and devices,")
    own: list[list[Attached]] = [[] for _ in range(count)]
    for chip, places in (given or {}).items():
        own[arguments.whole("devices", chip, f"the number of a chip, 0 to {count - 1},", 0, count - 1)] = attached(
            places
        )
    seen: dict[int, int] = {}
    for number, mine in enumerate(own):
        for place in mine:
            if seen.setdefault(id(place.device), number) != number and not place.acts_on_others:
                raise ValueError(
                    f"devices: {place.where} is attached to chips {seen[id(place.device)]} and {number}; only a device with acts_on_others = True can be (docs/boards.md)"
                )
    return own


def each(name: str, given: object, right: str, checked: Callable[[str, Any], Checked]) -> list[Checked]:
    """Each of a list in its checked form."""
    return [checked(f"{name}[{n}]", one) for n, one in enumerate(arguments.items(name, given, right))]


def net(name: str, given: object) -> str:
    return arguments.text(name, given, 'a net as "0.TCLK0>1.IIOF1"')


def chips(
    images: list[Program], boards: object, clocks_mhz: object, names: object, until: int | str | None, boots: object
) -> list[dict[str, Any]]:
    """The chips, without their devices."""
    count = len(images)
    board = [
        arguments.path("boards", one, '"default", "flat" or the path of a board file')
        for one in each_chip(boards, count, "boards")
    ]
    clock = [
        None if one is None else arguments.number("clocks_mhz", one, "a number of MHz")
        for one in each_chip(clocks_mhz, count, "clocks_mhz")
    ]
    name = [
        arguments.text("names", one, "the name of a chip") for one in arguments.items("names", names, "a list of names")
    ] or [""] * count
    booted = each(
        "boots",
        boots,
        "a list of the numbers of chips",
        lambda place, chip: arguments.whole(place, chip, f"the number of a chip, 0 to {count - 1},", 0, count - 1),
    )
    if len(name) != count:
        raise NetworkError(f"{len(name)} names for {count} chips")
    return [
        {
            "program": image,
            "board": board[n],
            "clock_mhz": clock[n],
            "name": name[n],
            "until": address(image, until),
            "boot": n in booted,
        }
        for n, image in enumerate(images)
    ]


def each_chip(given: Any, count: int, what: str) -> list[Any]:
    """One value for each chip, from one for all or from a list."""
    one = given is None or isinstance(given, (str, int, float, os.PathLike))
    values = [given] * count if one else arguments.items(what, given, "one value for all chips, or a list,")
    if len(values) != count:
        raise NetworkError(f"{what}: one for all chips or {count} are expected, not {len(values)}")
    return values
