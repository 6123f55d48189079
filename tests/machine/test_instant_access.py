"""Accesses that take no time, as in the ideal run: the targets get the same words in the same order, and no bus carries
anything."""

from itertools import pairwise
from typing import Any

import pytest
from cmrc._core import plant, toolchain
from cmrc_test import machine
from programs import DOORBELL, HEAD, INCLUDE, MS, ON_CHIP, TAIL, US, assemble, config

CLOCK = 30_000  # a target sees bus clocks: the first one at or after the access

# Copies word 5 to words 6 and 8, and counts in word 7.
COPIER = """
again:  ldi     *+ar0(5), r0
        sti     r0, *+ar0(6)
        addi    1, r1
        sti     r1, *+ar0(7)
        sti     r0, *+ar0(8)
        b       again
"""


def run(body: str, until: int, host: list[Any] | None = None, **values: Any) -> machine.Machine:
    m = machine.Machine(
        assemble(body), config(dsps=1, **{"instant_access": True} | values), host=host or [], record=True
    )
    m.run_until(until)
    return m


def busy(m: machine.Machine) -> int:
    """Clocks with a transaction, on both buses."""
    return sum(m.bus_statistics(bus).address + m.bus_statistics(bus).data for bus in "AB")


def test_words_arrive_and_nobody_waits() -> None:
    host = [(time, 5, [time // US], 0) for time in range(10 * US, 90 * US, 10 * US)]
    looks = [(time + US, 5, [], 4) for time, *_ in host]
    slow, quick = (run(COPIER, 100 * US, sorted(host + looks), instant_access=instant) for instant in (False, True))
    assert busy(slow) > 1000 and busy(quick) == 0
    assert quick.causes(0)["bus_arbitration"] == quick.causes(0)["bus_transfer"] == 0
    assert slow.causes(0)["bus_transfer"] > 1000
    assert quick.peek(7) > 1.5 * slow.peek(7)
    for time, _, words in quick.reads:
        assert words[:2] == [time // US - 1] * 2 and words[3] == words[0]
    asked = [time for time, *_ in looks]
    assert all(0 <= at - ask < CLOCK for (_, at, _), ask in zip(quick.reads, asked, strict=True))
    assert quick.audit() == []


def test_a_write_is_seen_at_its_own_instant() -> None:
    m = run(COPIER, 100 * US)
    writes = [(time, v[4]) for time, what, v in m.events if what == "write"]
    assert len(writes) > 700 and all(0 <= time - issued < CLOCK for time, issued in writes)


def test_a_doorbell_reaches_the_dsp_after_its_line_and_nothing_else() -> None:
    body = (
        DOORBELL
        + """
sleep:  idle
        addi    1, r5
        sti     r5, *+ar0(32)
        b       sleep
    """
    )
    m = run(body, 300 * US, [(100 * US, 0x10100, [0], 0)])
    edges = [time for time, what, _ in m.events if what == "interrupt"]
    assert len(edges) == 1 and 2 * CLOCK <= edges[0] - 100 * US < 5 * CLOCK


def test_a_doorbell_interrupts_a_program_that_uses_nothing_outside() -> None:
    """It must not have run past the doorbell. The count of its loop at each interrupt is that of a run in pieces."""
    body = (
        DOORBELL
        + """
        or      2000h, st               ; GIE
again:  addi    1, r5
        b       again
        .sect   ".handlers"
        sti     r5, *ar3++
        reti
        .text
"""
    )
    sections = {".text": 0x300000, ".parameters": 0x30F000, ".handlers": 0x30F010}
    program = toolchain.assemble(
        HEAD + body + TAIL, "count.asm", include_dirs=[INCLUDE], sections=sections, entry="_start"
    )
    rings = [(20 * US + 4_123_000 * n + 7_000 * n * n, 0x10100, [0], 0) for n in range(20)]
    found = []
    for step in (400 * US, 40_000, 330_000):
        m = machine.Machine(program, config(dsps=1, instant_access=True), host=rings)
        for end in range(step, 400 * US + 1, step):
            m.run_until(end)
        found.append([m.chip_word(0, ON_CHIP + n) for n in range(20)])
    assert found[0] == found[1] == found[2]
    between = [after - before for before, after in pairwise(found[0])]
    assert 15 < min(between) <= max(between) < 25  # of 5 cycles each: 4 us less the interrupt


@pytest.mark.parametrize(
    ("access", "words"),
    [("ldi     *+ar1(ir0), r0", "a read that nothing on bus A answers"), ("sti     r0, *+ar1(ir0)", "a write that")],
)
def test_an_access_that_nothing_answers_stops_the_dsp_as_ever(access: str, words: str) -> None:
    body = f"        ldi     0FFFh, ir0\n        {access}\n"
    slow, quick = (run(body, 100 * US, instant_access=instant) for instant in (False, True))
    for m in (slow, quick):
        assert len(m.faults) == 1 and words in m.faults[0].message
    assert (slow.faults[0].pc, slow.faults[0].address) == (quick.faults[0].pc, quick.faults[0].address)


def test_what_the_link_adapter_does_not_take_now_waits_on_the_bus_and_keeps_its_order() -> None:
    """The FIFO has 8 words. The host writes 40 at once, and then a word of shared memory."""
    body = """
        ldhi    0010h, ar5
        or      0070h, ar5
        ldi     39, ar6
take:   ldi     *+ar5(1), r0            ; port 3
        sti     r0, *ar3++
        ldi     *+ar0(5), r1
        sti     r1, *ar3++
        dbu     ar6, take
    """
    sent = list(range(100, 140))
    m = run(
        body,
        MS,
        [(50 * US, 0x11008, sent[:8], 0)]
        + [(50 * US, 0x11008, [word], 0) for word in sent[8:]]
        + [(50 * US, 5, [7], 0), (900 * US, 5, [], 1)],
    )
    assert m.faults == [] and m.audit() == []
    got = [m.chip_word(0, ON_CHIP + i) for i in range(80)]
    assert got[::2] == sent
    assert got[1] == 0 and got[79] == 7  # after the last of the 40, not before the first of them
    assert 0 < busy(m)


@pytest.mark.parametrize("boards", [[0], [0, 1]])
def test_a_target_behind_a_bridge_between_buses_is_reached_at_once(boards: list[int]) -> None:
    topology = machine.Topology()
    topology.dsps = boards
    topology.bridges = [(0, 1)]
    topology.devices_at = [0x100000] * 3
    body = """
        ldi     77, r0
        sti     r0, *+ar2(DRIVE_TORQUE)
        ldi     *+ar2(ENCODER), r1
        sti     r1, *+ar0(5)
        ldi     1, r2
        sti     r2, *+ar0(6)
    """
    setup = config(dsps=1, topology=topology, instant_access=True)
    m = machine.Machine(assemble(body), setup, plant.Dock(plant.default_dock()), record=True)
    m.run_until(100 * US)
    assert m.faults == [] and m.peek(6) == 1 and busy(m) == 0
    assert ("write", 1) in {(what, v[1]) for _, what, v in m.events if what == "write"}
