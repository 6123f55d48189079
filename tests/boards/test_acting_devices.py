"""Devices that act on other chips of their network: the network orders their accesses by time, in every turn order."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from board_parts import END, assembled, board, low, vector
from cmrc.network import Network

PLACE = 0xA0000000
ORDERS = (0, 1, 2, 3, 7, 99)


class Supervisor:
    """A write of n acts on chip 1 n microseconds later. A read gives the number of writes."""

    words = 4
    acts_on_others = True

    def __init__(self, act: Callable[[Any, float], None]) -> None:
        self.act, self.writes, self.network = act, 0, None

    def join(self, network: Any) -> None:
        self.network = network

    def read(self, offset: int, cycle: int) -> int:
        return self.writes

    def write(self, offset: int, value: int, cycle: int) -> None:
        self.writes += 1
        self.act(self.network, self.network.now_ps / 1e6 + value)  # type: ignore[attr-defined]

    def save(self) -> bytes:
        return bytes([self.writes])

    def load(self, state: bytes) -> None:
        self.writes = state[0]


ACTS = (
    "        ldi {loops},rc\n        rptb last\nlast:   nop\n        ldi {after},r0\n        sti r0,*ar2\n        ldi *ar2,r4\n"
    + END
)
# Chip 1 counts in R6 and in memory (which a reset leaves alone); an NMI ends it.
COUNTS = (
    vector(1)
    + "        ldhi 30h,ar3\n        or 8000h,ar3\n        ldi *ar3,r7\n        addi 1,r7\n        sti r7,*ar3\n        ldi 0,r6\ncount:  addi 1,r6\n        sti r6,*+ar3(1)\n        cmpi 4000,r6\n        blt count\n"
    + END
    + "isr:    ldi r6,r5\n"
    + "stays:  b stays\n"
)


def outcome(
    tmp_path: Path,
    act: Callable[[Any, float], None],
    order: int,
    loops: int,
    after: int,
    nets: tuple[str, ...] = (),
    fork_us: float | None = None,
) -> tuple[Any, ...]:
    network = Network(
        [assembled(ACTS.format(loops=loops, after=after)), assembled(COUNTS)],
        boards=str(board(tmp_path)),
        clocks_mhz=[40, 33],
        nets=nets,
        devices={0: {PLACE: Supervisor(act)}},
        turn_order=order,
    )
    if fork_us is not None:
        network.run(until_us=fork_us)
        network = network.fork()
    stop = network.run(until_us=2000)
    chips = [(chip.cycles, chip.pc, chip.status, *(low(chip, f"R{n}") for n in (4, 5, 6, 7))) for chip in network.chips]
    return (
        stop.reason,
        chips,
        network.chips[1].memory[0x308001],
        [(event.kind, event.time_ps) for event in network.events],
    )


def reset(network: Any, at_us: float) -> None:
    network.reset(1, at_us)


def nmi(network: Any, at_us: float) -> None:
    network.pulse("bell", at_us, width_us=1.0)


@pytest.mark.parametrize(("loops", "after"), [(3, 0), (401, 0), (401, 1), (900, 7)])
@pytest.mark.parametrize(("act", "nets"), [(reset, ()), (nmi, ("bell: >1.NMI",))])
def test_a_reset_or_nmi_from_a_device_comes_when_it_is_written(
    tmp_path: Path, act: Callable[[Any, float], None], nets: tuple[str, ...], loops: int, after: int
) -> None:
    first = outcome(tmp_path, act, 0, loops, after, nets)
    counted = first[1][1]
    assert first[0] == "ended" and first[1][0][3] == 1
    if act is reset:
        assert counted[6] == (2 if loops > 100 else 1), "started twice, unless the reset came before it counted"
    else:
        microseconds = counted[4] * 7 / 16.5  # a round of the loop takes 7 cycles
        assert counted[4] == counted[5] and microseconds == pytest.approx((loops + 15) / 20 + after, abs=1.5)
    for order in ORDERS[1:]:
        assert outcome(tmp_path, act, order, loops, after, nets) == first
    for fork_us in (0.5, (loops + 30) / 20):
        assert outcome(tmp_path, act, 3, loops, after, nets, fork_us) == first


class Box:
    """A mailbox between two chips: a word that one chip writes pulls the pin of both until it is read."""

    words = 2
    pin = "IIOF1"
    acts_on_others = True

    def __init__(self) -> None:
        self.word: int | None = None

    def read(self, offset: int, cycle: int) -> int:
        word, self.word = self.word, None
        return 0xFFFF_FFFF if word is None else word

    def write(self, offset: int, value: int, cycle: int) -> None:
        self.word = value

    def interrupts(self) -> bool:
        return self.word is not None

    def save(self) -> bytes:
        return repr(self.word).encode()

    def load(self, state: bytes) -> None:
        self.word = eval(state)


SENDER = (
    "        ldi 500,rc\n        rptb last\nlast:   nop\n        ldi 77,r0\n        sti r0,*ar2\n        ldi 300,rc\n        rptb lost\nlost:   nop\n        ldi *ar2,r4\n"
    + END
)
TAKER = (
    vector(4)
    + "        ldi 0b0h,iif\n        or 2000h,st\nwait:   idle\n"
    + END
    + "isr:    ldi *ar2,r4\n        addi 1,r2\n        reti\n"
)
POLLER = "poll:   ldi *ar2,r4\n        addi 1,r2\n        cmpi 77,r4\n        bnz poll\n" + END


@pytest.mark.parametrize(("taker", "times"), [(TAKER, 1), (POLLER, None)])
def test_one_device_at_two_chips_is_one_in_every_order(tmp_path: Path, taker: str, times: int | None) -> None:
    outcomes = []
    for order in ORDERS:
        box = Box()
        network = Network(
            [assembled(SENDER), assembled(taker)],
            boards=str(board(tmp_path)),
            clocks_mhz=[40, 50],
            devices={0: {PLACE: box}, 1: {PLACE: box}},
            turn_order=order,
        )
        network.run(until_us=20)
        if order == 7:
            network = network.fork()
        assert network.run(until_us=500).reason == "ended"
        outcomes.append([(chip.cycles, low(chip, "R2"), low(chip, "R4")) for chip in network.chips])
    assert all(each == outcomes[0] for each in outcomes)
    assert outcomes[0][1][2] == 77 and outcomes[0][0][2] == 0xFFFFFFFF and (times is None or outcomes[0][1][1] == times)


class Watchdog:
    """Resets chip 1 once, when chip 0 has not written for a given number of cycles."""

    words = 1
    acts_on_others = True

    def __init__(self) -> None:
        self.due: int | None = None
        self.network: Any = None

    def join(self, network: Any) -> None:
        self.network = network

    def read(self, offset: int, cycle: int) -> int:
        return 0

    def write(self, offset: int, value: int, cycle: int) -> None:
        self.due = cycle + value

    def next_event(self) -> int | None:
        return self.due

    def advance_to(self, cycle: int) -> None:
        if self.due is not None and self.due <= cycle:
            self.due = None
            self.network.reset(1, self.network.now_ps / 1e6)


@pytest.mark.parametrize("counts", [COUNTS, COUNTS.replace("4000", "4")])
def test_a_device_acts_by_itself_also_when_every_program_has_ended(tmp_path: Path, counts: str) -> None:
    outcomes = []
    for order in ORDERS:
        program = "        ldi 3000,r0\n        sti r0,*ar2\n" + END
        network = Network(
            [assembled(program), assembled(counts)],
            boards=str(board(tmp_path)),
            devices={0: {PLACE: Watchdog()}},
            turn_order=order,
        )
        assert network.run(until_us=5000).reason == "ended"
        outcomes.append(
            ([(chip.cycles, low(chip, "R7")) for chip in network.chips], [event.time_ps for event in network.events])
        )
    assert all(each == outcomes[0] for each in outcomes)
    assert outcomes[0][0][1][1] == 2 and outcomes[0][1][0] == pytest.approx(150e6, rel=0.01)


def test_a_device_that_does_not_say_so_may_not(tmp_path: Path) -> None:
    class Quiet(Supervisor):
        acts_on_others = False

    network = Network(
        [assembled(ACTS.format(loops=1, after=0)), assembled(COUNTS)],
        boards=str(board(tmp_path)),
        devices={0: {PLACE: Quiet(reset)}},
    )
    with pytest.raises(
        RuntimeError, match=r"reset\(\) from inside the device Quiet at A0000000h: .* acts_on_others = True"
    ):
        network.run()

    class Shared(Box):
        acts_on_others = False

    one = Shared()
    with pytest.raises(ValueError, match="Shared at A0000000h is attached to chips 0 and 1; .* acts_on_others = True"):
        Network([assembled(END)] * 2, boards=str(board(tmp_path)), devices={0: {PLACE: one}, 1: {PLACE: one}})


def test_what_such_a_device_raises_comes_out_and_can_be_fixed(tmp_path: Path) -> None:
    def wrong(network: Any, at_us: float) -> None:
        network.reset(1, at_us - 1)

    supervisor = Supervisor(wrong)
    network = Network(
        [assembled(ACTS.format(loops=100, after=0)), assembled(COUNTS)],
        boards=str(board(tmp_path)),
        devices={0: {PLACE: supervisor}},
    )
    for _ in range(2):
        with pytest.raises(ValueError, match="has already run to"):
            network.run()
    assert network.chips[0].message.startswith("waits for device Supervisor at A0000000h since cycle")
    supervisor.act = reset
    assert network.run().reason == "ended" and low(network.chips[1], "R7") == 2
