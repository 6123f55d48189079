"""Booting over the link adapter: words, time, and what is lost when a wire breaks."""

from typing import Any

import pytest
from cmrc_test import machine
from programs import ON_CHIP, US, assemble, config

STATUS, DATA, REQUEST = 0x11000, 0x11008, 0x11100
SLOT = 0x10  # words of a slot's registers

# Answers over port 3 with its slot + 1; then counts in shared memory.
PROGRAM = assemble("""
        ldhi    0010h, ar5
        or      0070h, ar5
        addi3   1, r7, r0
        sti     r0, *+ar5(2)
        sti     r0, *ar3
        addi3   ar0, r7, ar6
again:  addi    1, r1
        sti     r1, *+ar6(32)
        b       again
""")


def feed(
    stream: list[int], slot: int, start: int, every: int, at_once: int = 8
) -> list[tuple[int, int, list[int], int]]:
    """Steps of the host: it clears the request, sends words at intervals, and 20 us later reads the answer."""
    steps = [(start - US, REQUEST, [1 << slot], 0)]
    steps += [
        (start + i // at_once * every, DATA + SLOT * slot, stream[i : i + at_once], 0)
        for i in range(0, len(stream), at_once)
    ]
    return [*steps, (steps[-1][0] + 20 * US, DATA + SLOT * slot, [], 1)]


def booting(dsps: int = 1, **values: Any) -> machine.Config:
    return config(dsps=dsps, boot=machine.Boot.link, **values)


def stream_of(slot: int = 0, dsps: int = 1) -> list[int]:
    stream: list[int] = machine.Machine(PROGRAM, booting(dsps)).boot_stream(slot)
    return stream


def test_a_dsp_takes_its_program_from_the_host_and_answers() -> None:
    stream = stream_of()
    m = machine.Machine(
        PROGRAM, booting(), host=[(11 * US, REQUEST, [], 1), *feed(stream, 0, 15 * US, 8 * US)], record=True
    )
    m.run_until(12 * US)
    assert m.reads == [(11 * US, m.reads[0][1], [1])]  # reset takes 10 us: slot 0 asks
    assert not m.booted(0)
    m.run_until(500 * US)
    assert m.booted(0) and m.reads[-1][2] == [1] and m.chip_word(0, ON_CHIP) == 1
    assert m.statistics(0).words_to_dsp == len(stream) and m.statistics(0).words_from_dsp == 1
    text = next(section for section in PROGRAM.sections if section.name == ".text")
    assert [m.chip_word(0, text.address + i) for i in range(len(text.words))] == list(text.words)
    assert m.peek(32) > 100 and m.audit() == []
    changes = [(v[1], time) for time, what, v in m.events if what == "slot"]
    assert [change for change, _ in changes] == [3]  # booted


def test_a_word_takes_at_least_five_cycles_of_the_adapter_and_the_loader_more() -> None:
    """All words are there at once: the loader's pace, which is its code's. 5 adapter clocks of 30 ns are the least."""
    stream = stream_of()
    m = machine.Machine(PROGRAM, booting(), host=feed(stream, 0, 15 * US, 30_000), record=True)
    m.run_until(500 * US)
    booted = next(time for time, what, v in m.events if what == "slot" and v[1] == 3)
    assert 5 * 30_000 * len(stream) < booted - 15 * US < 20 * 40_000 * len(stream)
    retried = m.bus_statistics("A")
    assert retried.total() > 0 and m.statistics(0).words_to_dsp == len(stream)  # retried on the bus, and none lost


@pytest.mark.parametrize("order", [1, 2, 3, 12345])
def test_the_order_of_turns_changes_nothing(order: int) -> None:
    steps = [step for slot in range(3) for step in feed(stream_of(slot, 3), slot, (12 + 5 * slot) * US, 7 * US)]

    def run(turn_order: int) -> Any:
        m = machine.Machine(PROGRAM, booting(3, turn_order=turn_order), host=steps, record=True)
        m.run_until(600 * US)
        return m.events, m.state()

    assert run(order) == run(0)


@pytest.mark.parametrize("moment", range(0, 1100, 70))
def test_a_wire_that_breaks_loses_at_most_the_word_on_it(moment: int) -> None:
    stream = stream_of()
    setup = booting()
    setup.script(40 * US + moment * 1000, machine.Action.link, 0, 1)
    setup.script(80 * US, machine.Action.link, 0, 0)
    m = machine.Machine(PROGRAM, setup, host=feed(stream, 0, 15 * US, 8 * US), record=True)
    m.run_until(79 * US)
    before = m.statistics(0).words_to_dsp
    m.run_until(500 * US)
    lost = [(time, v) for time, what, v in m.events if what == "link_lost"]
    assert len(lost) == m.statistics(0).words_lost <= 1
    assert all(
        time == 40 * US + moment * 1000 and v[:2] == [0, 1] and v[2] in stream and 0 <= v[3] < 4 for time, v in lost
    )
    # In the cut nothing crosses; after it the rest does, and the loader, one word short, misreads its stream unless
    # none was lost.
    assert before < len(stream) and m.statistics(0).words_to_dsp + len(lost) == len(stream)
    assert m.booted(0) == (not lost) and m.audit() == []


def test_a_reset_drops_what_is_on_the_way_and_the_next_stream_boots() -> None:
    stream = stream_of()
    setup = booting()
    setup.script(50 * US, machine.Action.reset, 0)
    host = [*feed(stream, 0, 15 * US, 8 * US)[:4], (61 * US, REQUEST, [], 1), *feed(stream, 0, 90 * US, 8 * US)]
    m = machine.Machine(PROGRAM, setup, host=host, record=True)
    m.run_until(500 * US)
    assert m.booted(0) and m.statistics(0).boots == 1 and m.audit() == []
    assert m.chip_word(0, ON_CHIP) == 1


def test_a_request_does_not_stand_over_a_reset() -> None:
    """Slot 0 asks, is reset unanswered, and asks again as it leaves reset, 10 us later; slot 1 is left alone."""
    setup = booting(2)
    setup.script(20 * US, machine.Action.reset, 0)
    asked = [(at * US, REQUEST, [], 1) for at in (15, 21, 29, 32)]
    m = machine.Machine(PROGRAM, setup, host=asked, record=True)
    m.run_until(40 * US)
    assert [words for _, _, words in m.reads] == [[0b11], [0b10], [0b10], [0b11]]


def test_an_answer_to_a_request_of_before_the_reset_answers_nothing() -> None:
    stream = stream_of()
    setup = booting()
    setup.script(20 * US, machine.Action.reset, 0)
    # The host has seen the request of 10 us, and takes it away within the reset. The words after it have no receiver.
    late = [(22 * US, REQUEST, [1], 0), (24 * US, DATA, stream[:8], 0), (36 * US, REQUEST, [], 1)]
    host = [*late, *feed(stream, 0, 40 * US, 8 * US)]
    m = machine.Machine(PROGRAM, setup, host=host, record=True)
    m.run_until(500 * US)
    assert m.reads[0][2] == [1] and m.booted(0)
    assert m.statistics(0).words_to_dsp == len(stream) and m.audit() == []


def test_words_of_an_older_stream_do_not_reach_a_dsp_that_was_reset() -> None:
    stream = stream_of()
    setup = booting()
    setup.script(20 * US, machine.Action.reset, 0)
    m = machine.Machine(
        PROGRAM, setup, host=[*feed(stream, 0, 15 * US, 3 * US)[:-1], *feed(stream, 0, 90 * US, 8 * US)], record=True
    )
    m.run_until(500 * US)
    assert m.booted(0) and m.statistics(0).boots == 1 and not m.faults and m.audit() == []


def test_only_the_host_may_use_the_adapter() -> None:
    body = "        ldhi 0C001h, ar5\n        or 1000h, ar5\n"
    for access in ("sti r0, *+ar5(8)", "ldi *ar5, r0"):
        m = machine.Machine(assemble(body + "        " + access + "\n"), config(dsps=1))
        m.run_until(100 * US)
        assert "nothing on bus A" in m.faults[0].message and m.faults[0].address in (0xC0011000, 0xC0011008)


def test_the_host_may_not_write_where_the_adapter_has_no_register() -> None:
    m = machine.Machine(PROGRAM, booting(), host=[(20 * US, STATUS + 1, [0], 0)])
    with pytest.raises(IndexError, match="11001h"):
        m.run_until(100 * US)
