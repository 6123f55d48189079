"""Random networks whose chips are connected by nets: the order of turns, cuts and snapshots change nothing."""

from __future__ import annotations

import random
from typing import Any

import pytest
from cmrc.network import Network
from net_programs import COUNT, assembled, clock


def random_network(seed: int, turn_order: int, *, branches: bool = False, resets: bool = False) -> Network:
    """``branches``: every chip branches to itself. ``resets``: nets lead to RESET pins, too."""
    rng = random.Random(seed)
    chips = rng.randrange(2, 5)
    programs, nets, taken = [], [], set()
    linked = rng.random() < 0.5  # words go round a ring: chips wait at their ports while their pins change
    for _ in range(chips):
        text = clock(rng.randrange(3, 60)) if rng.random() < 0.6 else ""
        text += clock(rng.randrange(3, 60), 1).replace("3c1h", rng.choice(["3c1h", "2c1h", "0c1h", "1c1h"]))
        text += f"        ldhi 8000h,iie\n        ldhi 0,iif\n        or {rng.choice([0x9900, 0xB900, 0x9B00, 0x9960]):#x},iif\n"
        service = rng.choice([COUNT, "isr:    addi 1,r2\n        xor 40h,iif\n        reti\n"])
        relay = f"        ldhi 10h,ar3\n        or 40h,ar3\n        ldi {rng.randrange(2)},r7\n        bz wait\n        sti r7,*+ar3(2)\nwait:   ldi *+ar3(31h),r7\n        addi 1,r7\n        sti r7,*+ar3(2)\n        b wait\n"
        body = (
            relay
            if linked and rng.random() < 0.7
            else rng.choice(
                [
                    "wait:   idle\n        b wait\n",
                    "wait:   addi 1,r4\n        b wait\n",
                    "wait:   ldi *+ar0(24h),r5\n        addi r5,r6\n        b wait\n",
                ]
            )
        )
        body = "wait:   b wait\n" if branches else body
        vectors = "".join(f"        sti r0,*+ar1({vector:x}h)\n" for vector in (1, 2, 3, 4, 5, 6, 0x2B))
        programs.append(
            assembled(
                text
                + "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n"
                + vectors
                + "        or 2000h,st\n"
                + body
                + service
            )
        )

    def pin(names: list[str]) -> str:
        free = [f"{chip}.{name}" for chip in range(chips) for name in names if f"{chip}.{name}" not in taken]
        chosen = rng.choice(free)
        taken.add(chosen)
        return chosen

    received = ["IIOF2", "IIOF3", "NMI", "TCLK1", *(["RESET"] * 3 if resets else [])]
    for _ in range(rng.randrange(1, 2 * chips)):
        receivers = "+".join(pin(received) for _ in range(rng.choice([1, 1, 2])))
        drivers = (
            "&".join(pin(["TCLK0", "IIOF1"]) for _ in range(rng.choice([1, 1, 2])))
            if len(taken) < 3 * chips and rng.random() < 0.8
            else ""
        )
        nets.append(f"{drivers}>{receivers}")
    links = [f"{n}.0:{(n + 1) % chips}.3" for n in range(chips)] if linked else []
    made = Network(
        programs,
        links=links,
        nets=nets,
        clocks_mhz=[rng.choice([40, 50, 60, 33.333]) for _ in range(chips)],
        turn_order=turn_order,
        record_words=True,
        record_peripherals=True,
    )
    for number, net in enumerate(nets):
        if net.startswith(">"):
            made.pulse(number, rng.uniform(1, 20), width_us=rng.uniform(0.01, 1), period_us=rng.uniform(2, 20))
    for _ in range(rng.choice([0, 0, 2])):
        action = getattr(made, rng.choice(["hold", "release", "reset"]))
        action(rng.randrange(chips), rng.uniform(1, 60))
    return made


def outcome(made: Network) -> tuple[Any, ...]:
    chips = [
        (chip.status, chip.message, chip.pc, chip.cycles, chip.instructions, chip.causes, chip.peripherals)
        for chip in made.chips
    ]
    return made.now_ps, made.nets, chips, made.event_trace


def check(seed: int) -> None:
    one, other = random_network(seed, 0), random_network(seed, seed + 1)
    assert one.run(until_us=150) == other.run(until_us=150)
    assert outcome(one) == outcome(other)
    cut = random_network(seed, 0)
    rng = random.Random(seed)
    for at in sorted(rng.uniform(0, 150) for _ in range(5)):
        cut.run(until_us=at)
    resumed = random_network(seed, 2)
    resumed.restore(cut.snapshot())
    resumed.run(until_us=150)
    assert outcome(one) == outcome(resumed)


# 2389: a chip in IDLE that nothing can wake, held and released.
@pytest.mark.parametrize("seed", [*range(12), 2389])
def test_the_order_of_turns_and_cuts_change_nothing(seed: int) -> None:
    check(seed)


def check_pauses(seed: int, **kinds: bool) -> None:
    """Pauses at every 61.1 ns meet most edges in the cycle before they act."""
    one, other, paused = (random_network(seed, order, **kinds) for order in (0, seed + 1, 0))
    for n in range(1, 800):
        paused.run(until_us=n * 0.0611)
    for made in (one, other, paused):
        made.run(until_us=50)
    assert outcome(one) == outcome(other)
    assert outcome(one) == outcome(paused)


# 155 and 799: a timer takes a chip out of IDLE in the cycle in which an edge reaches its pin. 351 and 569: a chip that
# drove its own RESET pin is reset. 477: a timer changes a pin in the cycle in which its chip is held.
@pytest.mark.parametrize("seed", [*range(12), 155, 351, 477, 569, 799])
@pytest.mark.parametrize("kind", ["branches", "resets"])
def test_pauses_change_nothing_of_branches_and_resets(seed: int, kind: str) -> None:
    check_pauses(seed, **{kind: True})


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(12, 1000))
@pytest.mark.parametrize("kind", ["branches", "resets"])
def test_pauses_change_nothing_of_branches_and_resets_by_the_hundred(seed: int, kind: str) -> None:
    check_pauses(seed, **{kind: True})


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(12, 4000))
def test_the_order_of_turns_and_cuts_change_nothing_by_the_hundred(seed: int) -> None:
    check(seed)
