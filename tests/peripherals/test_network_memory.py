"""Shared memories of a network, and their locks."""

from __future__ import annotations

from cmrc.network import Network, SharedMemory
from network_programs import STOP, program, state


def counting(rounds: int) -> str:
    """Adds one to word 0 of the memory at C0000000h `rounds` times, under a lock."""
    return f"""
        ldhi 0c000h,ar0
        ldi {rounds - 1},ar1
loop:   ldii *ar0,r4
        addi 1,r4
        nop
        stii r4,*ar0
        db ar1,loop
{STOP}"""


def test_a_lock_keeps_the_others_out() -> None:
    results = []
    for seed in range(4):
        memory = SharedMemory("counter", 16, {0: 0xC0000000, 1: 0xC0000000, 2: 0xC0000000}, waits=1)
        network = Network([program(counting(50))] * 3, memories=[memory], clocks_mhz=[40, 50, 60], turn_order=seed)
        assert network.run().reason == "ended"
        assert network.memory(0)[0] == 150
        results.append(state(network))
    assert all(result == results[0] for result in results)
    assert any(chip.causes["bus_arbitration"] > 0 for chip in network.chips)


def test_a_reset_releases_the_lock_of_its_chip_and_no_other() -> None:
    memory = SharedMemory("counter", 16, {0: 0xC0000000, 1: 0xC0000000, 2: 0xC0000000})
    taker = "        ldhi 0c000h,ar0\n        ldii *ar0,r4\n" + STOP
    late = "        nop\n" * 20 + "        ldhi 0c000h,ar0\n        ldi *ar0,r4\n" + STOP
    for reset, waits in ((0, None), (2, 0)):  # the holder; one that has nothing to do with it
        network = Network([program(taker), program(late), program(STOP)], memories=[memory])
        network.hold(reset, 5)  # it does not take the lock again
        network.reset(reset, 5)
        network.hold(reset, 5)
        network.run(until_us=20)
        assert network.chips[1].waits_for == waits, reset


def test_a_lock_never_given_back_is_a_deadlock() -> None:
    memory = SharedMemory("counter", 16, {0: 0xC0000000, 1: 0xC0000000})
    taker = "        ldhi 0c000h,ar0\n        ldii *ar0,r4\n" + STOP
    late = "        nop\n" * 20 + "        ldhi 0c000h,ar0\n        ldi *ar0,r4\n" + STOP
    network = Network([program(taker), program(late)], memories=[memory])
    assert network.run().reason == "deadlock"
    assert network.chips[1].waits_for == 0 and "which chip 0 has locked" in network.chips[1].message
