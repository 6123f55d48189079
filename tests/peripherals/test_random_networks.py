"""Random programs and DMA channels on random networks, with cuts, holds and resets: turn order changes nothing; lost
words are reported."""

import random
from typing import Any

import pytest
from cmrc.network import Network
from network_programs import IDLES, STOP, base, check_balance, program, state
from scenarios import RUN, STOP_AT_END, channel, die

DATA = 0x2FF800
PORTS = [0, 1, 3, 4]


def fragment(rng: random.Random, n: int) -> str:
    port = base(rng.choice(PORTS))
    return rng.choice(
        [
            lambda: port + "        ldi 5,r0\n" + "        sti r0,*+ar0(2)\n" * rng.randrange(1, 12),
            lambda: port + "        ldi *+ar0(1),r1\n" * rng.randrange(1, 6),
            lambda: f"        ldi {rng.randrange(1, 400)},rc\n        rptb x{n}\n        nop\nx{n}:    addi 1,r3\n",
            lambda: port + f"l{n}:    ldi *ar0,r2\n        and 1e00h,r2\n        bz l{n}\n        ldi *+ar0(1),r1\n",
            lambda: (
                port
                + "        ldi 8,r0\n        sti r0,*ar0\n"
                + "        nop\n" * rng.randrange(30)
                + "        ldi 0,r0\n        sti r0,*ar0\n"
            ),
            lambda: (
                "        ldhi 2fh,ar4\n        or 0f900h,ar4\n"
                + "        sti r3,*ar4++\n        ldi *ar4,r5\n" * rng.randrange(1, 20)
            ),
        ]
    )()


def start_channel(rng: random.Random, chip: Any, number: int) -> None:
    """From memory or an input FIFO to memory or an output FIFO, of any priority, synchronised or not."""
    source, source_index = rng.choice([(DATA, 1), (0x100041 + 0x10 * rng.choice(PORTS), 0)])
    destination, destination_index = rng.choice([(DATA + 0x40, 1), (0x100042 + 0x10 * rng.choice(PORTS), 0)])
    control = RUN | rng.choice([0, 1, 3]) | STOP_AT_END | rng.choice([0, 0, 1 << 6, 1 << 7])
    channel(
        chip, number, control, source=source, source_index=source_index, counter=rng.randrange(1, 40),
        destination=destination, destination_index=destination_index,
    )  # fmt: skip
    if rng.random() < 0.7:
        chip.registers["DIE"] = chip.registers["DIE"] | die(number, 1, 1)


def network(seed: int, turn_order: int) -> Network:
    rng = random.Random(seed)
    chips = rng.randrange(2, 5)
    programs = [
        program("".join(fragment(rng, n) for n in range(rng.randrange(2, 9))) + rng.choice([STOP, IDLES]))
        for _ in range(chips)
    ]
    links = []
    for n in range(chips):
        links += [f"{n}.{port}:{(n + 1) % chips}.{port + 3}" for port in (0, 1) if port == 0 or rng.random() < 0.5]
    clocks = [rng.choice([40, 50, 60, 33.333]) for _ in range(chips)]
    made = Network(
        programs, links=links, clocks_mhz=clocks, turn_order=turn_order, record_words=True, record_peripherals=True
    )
    for chip in made.chips:
        for number in range(6):
            if rng.random() < 0.25:
                start_channel(rng, chip, number)
    for _ in range(rng.choice([0, 0, 3])):
        action = getattr(made, rng.choice(["cut", "restore", "hold", "release", "reset"]))
        action(rng.randrange(min(chips, len(links))), rng.uniform(1, 60))
    return made


def outcome(made: Network) -> tuple[Any, ...]:
    return state(made), made.event_trace, [chip.peripherals for chip in made.chips]


def check(seed: int) -> None:
    one, other = network(seed, 0), network(seed, seed + 1)
    assert one.run(until_us=3000) == other.run(until_us=3000)
    assert outcome(one) == outcome(other)
    check_balance(one)


# 237: the DMA, at priority 3, accesses a link just when its processor has reached an access to a link, which nothing
# had announced.
# 390: a chip in a loop runs ahead of the end of its network.
@pytest.mark.parametrize("seed", [237, 390, *range(16)])
def test_the_order_of_turns_changes_nothing(seed: int) -> None:
    check(seed)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(16, 400))
def test_the_order_of_turns_changes_nothing_by_the_hundred(seed: int) -> None:
    check(seed)


def check_state(seed: int) -> None:
    """At an instant, a network is in one state, however it was brought there; if it has ended before, its time of
    stopping is one."""
    rng = random.Random(seed)
    instant = rng.randrange(100_000, 3_000_000)
    whole, cut = network(seed, 0), network(seed, seed + 1)
    stop = whole._core.run_until(instant)
    time = 0
    while time < instant:
        time = min(instant, time + rng.randrange(1, 400_000))
        stop_of_cut = cut._core.run_until(time)
    assert stop_of_cut == stop
    if stop[0] == "limit":
        assert whole._core._state_difference(cut._core) is None


# 73 and 351: what the DMA knew of the processor's accesses. 58: when a DMA that had ended was last looked at. 320: both
# at once.
@pytest.mark.parametrize("seed", [58, 73, 320, 351, *range(16)])
def test_a_network_has_one_state_at_an_instant(seed: int) -> None:
    check_state(seed)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(16, 2000))
def test_a_network_has_one_state_at_an_instant_by_the_thousand(seed: int) -> None:
    check_state(seed)
