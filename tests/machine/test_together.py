"""Several DSPs at once: mutual exclusion, doorbells, fences, boards that come and go, and the same run in every
order."""

import random
from itertools import pairwise

import pytest
from cmrc._core import plant
from cmrc_test import machine
from programs import DOORBELL, MS, US, assemble, config

ROUNDS = 60

# Each DSP counts a shared word up ROUNDS times, read and write apart, under semaphore 0.
COUNTER = f"""
        ldi     {ROUNDS - 1}, ar5
again:  ldi     *ar1, r0
        bnz     again
        ldi     *+ar0(8), r1
        addi    1, r1
        sti     r1, *+ar0(8)
        sti     r0, *ar1
        dbu     ar5, again
        ldi     1, r1
        addi3   ar0, r7, ar5
        sti     r1, *+ar5(16)           ; done, at 16 + slot
"""

# Idle until IIOF0; then write the number of wake-ups to 32 + slot.
SLEEPER = """
        ldhi    002Fh, ar5
        or      0FA00h, ar5             ; interrupt vectors in on-chip RAM
        ldi     ar5, r0
        ldpe    ar5, ivtp
        ldhi    0030h, ar6
        or      0F010h, ar6
        sti     ar6, *+ar5(3)           ; IIOF0
        ldi     9, iif
        ldi     0, r5
        addi3   ar0, r7, ar5
        ldi     DOORBELL_IDLE - SEMAPHORE, ir0
sleep:  sti     r7, *+ar1(ir0)
        idle
        addi    1, r5
        sti     r5, *+ar5(32)
        b       sleep
        .sect   ".handlers"
        reti
        .text
"""


def sleeper() -> object:
    """SLEEPER with its handler at 30F010h, where the parameters are not."""
    from cmrc._core import toolchain
    from programs import HEAD, INCLUDE, TAIL

    sections = {".text": 0x300000, ".parameters": 0x30F000, ".handlers": 0x30F010}
    return toolchain.assemble(
        HEAD + SLEEPER + TAIL, "sleeper.asm", include_dirs=[INCLUDE], sections=sections, entry="_start"
    )


def sums_hold(m: machine.Machine, dsps: int) -> None:
    for slot in range(dsps):
        assert sum(m.causes(slot).values()) == m.cycle(slot)


@pytest.mark.parametrize("dsps", [2, 3, 4])
def test_the_semaphore_lets_one_dsp_at_a_time(dsps: int) -> None:
    m = machine.Machine(assemble(COUNTER), config(dsps=dsps), record=True)
    m.run_until(3 * MS)
    assert [m.peek(16 + slot) for slot in range(dsps)] == [1] * dsps
    assert m.peek(8) == dsps * ROUNDS
    sums_hold(m, dsps)
    holder = 0
    for _, what, v in m.events:
        if what == "semaphore":
            _, event, owner = v
            assert (event == 0) == (holder == 0) or event == 1
            if event == 0:
                holder = owner
            elif event == 2:
                assert owner == holder
                holder = 0
    refused = sum(what == "semaphore" and v[1] == 1 for _, what, v in m.events)
    assert refused > 10
    assert sum(m.causes(slot)["bus_arbitration"] for slot in range(dsps)) > 0


def test_without_the_semaphore_counts_are_lost() -> None:
    """Without the semaphore the DSPs do race: so the test above shows an effect of the semaphore."""
    m = machine.Machine(assemble(COUNTER.replace("bnz     again", "nop")), config(dsps=4))
    m.run_until(3 * MS)
    assert m.peek(8) < 4 * ROUNDS


def test_the_doorbell_wakes_the_dsp_that_is_rung() -> None:
    rings = [(100 * US, 0x10100, [2], 0), (200 * US, 0x10100, [0], 0), (300 * US, 0x10100, [2], 0)]
    looks = [(time, 0x10101, [], 1) for time in (90 * US, 101 * US, 150 * US)]
    m = machine.Machine(sleeper(), config(dsps=3), host=rings + looks, record=True)
    m.run_until(MS)
    assert m.faults == []
    assert [m.peek(32 + slot) for slot in range(3)] == [1, 0, 2]
    assert [words for _, _, words in m.reads] == [[0b111], [0b011], [0b111]]
    interrupts = [(v[0], time) for time, what, v in m.events if what == "interrupt"]
    assert [slot for slot, _ in interrupts] == [2, 0, 2]
    for (_, time), (rung, *_) in zip(interrupts, rings, strict=True):
        assert rung + 300_000 < time < rung + 700_000  # bridge 5 clocks, processor 2, bus 5 to 7, line 2
    assert m.causes(1)["idle"] > 24_000 and all(m.idle(slot) for slot in range(3))
    sums_hold(m, 3)


def test_a_fenced_dsp_changes_nothing() -> None:
    body = """
        ldi     0, r5
loop:   addi    1, r5
        sti     r5, *+ar0(5)
        ldi     *ar1, r6                ; never released
        b       loop
    """
    host = [
        (100 * US, 0x10110, [0xFFFFFFFE], 0),
        (110 * US, 5, [], 1),
        (150 * US, 5, [], 1),
        (160 * US, 0x10040, [], 1),
        (200 * US, 0x10110, [0xFFFFFFFF], 0),
        (250 * US, 5, [], 1),
    ]
    m = machine.Machine(assemble(body), config(dsps=1), host=host, record=True)
    m.run_until(300 * US)
    before, during, owner, after = (words[0] for _, _, words in m.reads)
    assert 0 < before == during < after and owner == 1
    dropped = [time for time, what, _ in m.events if what == "dropped"]
    assert m.statistics(0).dropped_writes == len(dropped) > 10
    assert 100 * US < dropped[0] and dropped[-1] < 202 * US


@pytest.mark.parametrize("moment", range(0, 400, 37))
def test_a_board_pulled_in_mid_transaction_leaves_the_bus_to_others(moment: int) -> None:
    setup = config(dsps=2, slots=2)
    setup.script(50 * US + moment * 1000, machine.Action.unplug, 0)
    setup.script(100 * US, machine.Action.plug, 0)
    m = machine.Machine(
        assemble(
            "again:  sti     r7, *+ar0(3)\n        ldi     *+ar0(9), r1\n        sti     r1, *+ar0(2)\n        b again\n"
        ),
        setup,
        record=True,
    )
    m.run_until(99 * US)
    assert not m.plugged(0)
    own = [time for time, what, v in m.events if what == "transaction" and v[0] == 0 and v[1] == 1]
    assert max(own) <= 50 * US + moment * 1000 + 60_000
    others = [time for time, what, v in m.events if what == "transaction" and v[1] == 2 and time > 52 * US]
    assert len(others) > 40
    assert max(after - before for before, after in pairwise(others)) < 2 * US
    assert m.causes(0)["halted"] > 1000
    m.run_until(200 * US)
    assert m.plugged(0) and m.statistics(0).boots == 2
    assert [v[1] for _, what, v in m.events if what == "slot" and v[0] == 0] == [1, 0, 2, 3]
    assert m.bus_statistics("A").total() >= 200 * US // 30_000 - 2
    sums_hold(m, 2)


def test_the_host_resets_a_dsp_that_stands_still_and_none_that_is_broken() -> None:
    for action, alive in ((machine.Action.freeze, True), (machine.Action.fail, False)):
        setup = config(dsps=2)
        setup.script(100 * US, action, 1)
        m = machine.Machine(
            assemble(
                "        ldi 0, r5\nagain:  addi 1, r5\n        addi3 ar0, r7, ar5\n        sti r5, *+ar5(32)\n        b again\n"
            ),
            setup,
            host=[(200 * US, 0x10111, [1], 0), (190 * US, 33, [], 1), (150 * US, 33, [], 1)],
        )
        m.run_until(199 * US)
        assert m.standing(1) and m.reads[0][2] == m.reads[1][2]
        m.run_until(MS)
        assert m.standing(1) != alive
        assert m.statistics(1).boots == 1 + alive
        assert (m.instructions(1) > 5000) == alive
        sums_hold(m, 2)


@pytest.mark.parametrize(
    ("repeat", "body"),
    [
        ("rpts 60000", "addi 1, r5"),
        ("ldi 10000, rc", "rptb last\nlast:   addi 1, r5"),
        ("br d", "d:  b d"),
        ("bd e", "nop\n nop\n nop\ne: bd e\n nop\n nop\n nop"),
    ],
)
def test_a_program_hangs_wherever_it_is(repeat: str, body: str) -> None:
    # In the repeat of one instruction, of a block, at a branch, in its delay slots: the DSP executes, and only a reset
    # ends that.
    for moment in range(0, 400, 37):
        setup = config(dsps=1)
        setup.script(100 * US + moment * 1000, machine.Action.hang, 0)
        m = machine.Machine(assemble(f"again:  {repeat}\n        {body}\n        b again\n"), setup)
        m.run_until(300 * US)
        assert m.faults == [] and not m.idle(0)
        assert m.causes(0)["execute"] + m.causes(0)["branch"] > 0.9 * 300 * US / 40_000 - 100


# A mixture: counting under the semaphore, posted bursts, reads from the line, devices, sleeping, ringing.
MIXTURE = f"""{DOORBELL}
outer:  ldi     {ROUNDS // 6}, ar5
again:  ldi     *ar1, r0
        bnz     again
        ldi     *+ar0(8), r1
        addi    1, r1
        sti     r1, *+ar0(8)
        sti     r0, *ar1
        addi3   ar0, r7, ar6
        sti     r1, *+ar6(64)
        ldi     *+ar6(65), r2
        addi    *+ar6(66), r2
        sti     r2, *+ar3(1)
        ldi     *+ar2(ENCODER + 1), r3
        mpyi    17, r3
        and     63, r3
        rpts    r3
        nop
        ldi     *+ar2(SPREADER_STATUS), r3
        sti     r1, *+ar2(DRIVE_TORQUE)
        sti     r2, *+ar2(DRIVE_TORQUE + 1)
        sti     r7, *+ar2(DRIVE_TORQUE + 2)
        dbu     ar5, again
        ldi     DOORBELL_IDLE - SEMAPHORE, ir0
        sti     r7, *+ar1(ir0)
        idle
        ldi     7, ar5
        b       again
        .sect   ".handlers"
        reti
        .text
"""


def mixture(turn_order: int, cuts: list[int], instant: bool) -> tuple[list[int], list[object]]:
    """(final state, events) of one and the same run of 2 ms, done in one way or another."""
    from cmrc._core import toolchain
    from programs import HEAD, INCLUDE, TAIL

    draw = random.Random(3)
    host = []
    for i in range(300):
        time = 20 * US + i * 6 * US + draw.randrange(US)
        host.append(
            draw.choice(
                [
                    (time, 0x10100, [draw.randrange(4)], 0),
                    (time, 8, [], 3),
                    (time, 100 + i, [i, i + 1, i + 2], 0),
                    (time, 0x10101, [], 1),
                ]
            )
        )
    host += [
        (700 * US, 0x10110, [0xD], 0),
        (800 * US, 0x10111, [1], 0),
        (900 * US, 0x10110, [0xF], 0),
        (905 * US, 0x10000, [0], 0),
    ]
    setup = config(dsps=4, turn_order=turn_order, instant_access=instant)
    setup.script(500 * US + 7, machine.Action.unplug, 2)
    setup.script(500 * US + 9, machine.Action.freeze, 3)
    setup.script(520 * US, machine.Action.plug, 2)
    sections = {".text": 0x300000, ".parameters": 0x30F000, ".handlers": 0x30F010}
    program = toolchain.assemble(
        HEAD + MIXTURE + TAIL, "mixture.asm", include_dirs=[INCLUDE], sections=sections, entry="_start"
    )
    m = machine.Machine(program, setup, plant.Dock(plant.default_dock()), host, record=True)
    for cut in [*sorted(cuts), 2 * MS]:
        m.run_until(cut)
    assert m.faults == []
    sums_hold(m, 4)
    return m.state(), m.events


Plain = dict[bool, tuple[list[int], list[object]]]
INSTANT = pytest.mark.parametrize("instant", [False, True])


@pytest.fixture(scope="module")
def plain() -> Plain:
    """The mixture, done in one go; by whether accesses take no time."""
    return {instant: mixture(0, [], instant) for instant in (False, True)}


@INSTANT
def test_the_mixture_has_what_it_should_have(instant: bool, plain: Plain) -> None:
    kinds = [what for _, what, _ in plain[instant][1]]
    for kind, least in (
        ("transaction", 0 if instant else 3000),
        ("write", 1000),
        ("interrupt", 20),
        ("semaphore", 500),
        ("slot", 6),
        ("dropped", 1),
    ):
        assert kinds.count(kind) >= least, kind
    # In order of time, except for writes, which are reported when their burst has ended.
    times = [time for time, what, _ in plain[instant][1] if what in ("transaction", "interrupt", "semaphore")]
    assert times == sorted(times)


@INSTANT
@pytest.mark.parametrize("turn_order", [1, 2, 3, 123456789])
def test_the_order_in_which_chips_are_advanced_changes_nothing(turn_order: int, instant: bool, plain: Plain) -> None:
    assert mixture(turn_order, [], instant) == plain[instant]


@INSTANT
@pytest.mark.parametrize("seed", range(3))
def test_cutting_the_run_changes_nothing(seed: int, instant: bool, plain: Plain) -> None:
    draw = random.Random(seed)
    cuts = [draw.randrange(2 * MS) for _ in range(draw.choice([3, 50, 1000]))]
    assert mixture(seed, cuts, instant) == plain[instant]
