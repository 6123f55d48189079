"""Rings of nasty programs (nasty_programs.py): each chip sends words to the next, by the processor or by DMA."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

from cmrc.network import Network
from nasty_programs import CYCLES, DATA, Program, constant, generate
from nasty_runs import Bench, assembled, prepare


def exchange(rng: random.Random) -> str:
    """Words to the next chip, from port 0, or from the one before, through port 3; by the processor, or by DMA when a
    FIFO is ready."""
    kind = rng.randrange(4)
    if kind == 0:
        return "        sti r1,*+ar6(42h)\n" * rng.randrange(1, 4)
    if kind == 1:
        return "        ldi *+ar6(71h),r7\n        xor r7,r3\n" * rng.randrange(1, 3)
    channel, die, sync = (0, 4, 1 << 7) if kind == 2 else (3, 1 << 14, 1 << 6)
    control = 3 << 22 | rng.choice([0, 1, 3]) | 1 << 2 | sync | rng.choice([0, 1 << 18])
    count = f"        ldi {rng.randrange(1, 9)},r9\n        sti r9,*+ar6({0xA3 + 16 * channel})\n"
    return (
        count
        + constant(control)
        + f"        sti r9,*+ar6({0xA0 + 16 * channel})\n"
        + constant(die)
        + "        or r9,die\n"
    )


def ring(seed: int) -> list[Program]:
    """Programs for a ring of two to four chips, port 0 of each to port 3 of the next."""
    rng = random.Random(seed)
    out = []
    for n in range(rng.randrange(2, 5)):
        program = generate(seed * 8 + n)
        fragments = [fragment for fragment in program.fragments if "*+ar6(66)" not in fragment]
        for _ in range(rng.randrange(1, 6)):
            fragments.insert(rng.randrange(len(fragments) + 1), exchange(rng))
        channels = {c: r for c, r in program.channels.items() if c != 0} | {
            0: {1: ("", DATA["chip"]), 2: ("", 1), 4: ("", 0x100042), 5: ("", 0), 3: ("", 4)},
            3: {1: ("", 0x100071), 2: ("", 0), 4: ("", DATA["local"] + 0x20), 5: ("", 1), 3: ("", 4)},
        }
        out.append(replace(program, fragments=tuple(fragments), channels=channels, pins=()))
    return out


END_US = CYCLES * 2 / 33


def ring_network(programs: list[Program], bench: Bench, turn_order: int = 0) -> Network:
    """The chips with their programs, at their start; words and peripherals are recorded."""
    images = [assembled(program) for program in programs]
    links = [f"{n}.0:{(n + 1) % len(images)}.3" for n in range(len(images))]
    boards, clocks = [bench.board(program) for program in programs], [program.clocks[0] for program in programs]
    network = Network(images, links=links, boards=boards, clocks_mhz=clocks, turn_order=turn_order, record_words=True, record_peripherals=True)  # fmt: skip
    for program, chip, image in zip(programs, network.chips, images, strict=True):
        prepare(chip._core, program, image.symbols)
    return network


def ring_disagreement(programs: list[Program], bench: Bench) -> str | None:
    """Whole, in slices, and with the chips advanced in another order: the same words, events and states."""
    seed = programs[0].seed
    found: list[Any] = []
    for way in ("whole", "slices", "another order", "slices in another order"):
        rng = random.Random(seed)
        network = ring_network(programs, bench, turn_order=seed + 1 if "order" in way else 0)
        now, reason = 0.0, "limit"
        while now < END_US and reason == "limit":
            now = min(END_US, now + rng.uniform(0.05, 8)) if "slices" in way else END_US
            reason = network.run(until_us=now).reason
        # The state of a chip at its last branch shows only when the chip continues.
        statuses = [
            ("", "") if chip.status in ("running", "halt") else (chip.status, chip.message) for chip in network.chips
        ]
        chips = [
            (*status, chip._core.cycle, chip._core.snapshot(), chip._core.digest())
            for status, chip in zip(statuses, network.chips, strict=True)
        ]
        found.append((reason, network.event_trace, chips))
        if found[-1] == found[0]:
            continue
        if found[-1][1] != found[0][1]:
            pair = next(
                pair for pair in zip([*found[0][1], None], [*found[-1][1], None], strict=False) if pair[0] != pair[1]
            )
            return f"ring {seed}, {way}: {pair}"
        return f"ring {seed}, {way}: {[(a[:3], b[:3]) for a, b in zip(found[0][2], chips, strict=True) if a != b]}, {found[0][0]} {reason}"
    return None
