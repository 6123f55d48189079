"""The registers of the shared memory one by one, each against its line in task_block.inc."""

from pathlib import Path

import pytest
from cmrc._core import toolchain
from cmrc_test import machine
from programs import HEAD, INCLUDE, ON_CHIP, TAIL, US, assemble, config

SYMBOLS = assemble("").symbols
COUNT = SYMBOLS["SEMAPHORE_COUNT"]
DONE, TARGET_ABORT = 0, 2
HOST = 0xFF

# Who may read and write each register: "+ n, n = 0..31" and "host writes" of the comments.
READ, WRITE = "read", "write"
BY_ANYBODY = {
    READ: {SYMBOLS[name] + n for name in ("SEMAPHORE", "SEMAPHORE_OWNER", "SEMAPHORE_HELD") for n in range(COUNT)}
    | {SYMBOLS["DOORBELL_IDLE"], SYMBOLS["FENCE_MASK"]},
    WRITE: {SYMBOLS["SEMAPHORE"] + n for n in range(COUNT)} | {SYMBOLS["DOORBELL_IDLE"], SYMBOLS["DOORBELL_BUSY"]},
}
BY_HOST = {
    READ: BY_ANYBODY[READ],
    WRITE: BY_ANYBODY[WRITE] | {SYMBOLS[name] for name in ("DOORBELL_RING", "FENCE_MASK", "RESET_DSP")},
}
PLACES = sorted(
    {SYMBOLS[name] + n for name in ("SEMAPHORE", "SEMAPHORE_OWNER", "SEMAPHORE_HELD") for n in (0, 1, COUNT - 1, COUNT)}
    | {SYMBOLS[name] + n for name in ("DOORBELL_RING", "DOORBELL_IDLE", "DOORBELL_BUSY", "FENCE_MASK", "RESET_DSP") for n in (-1, 0, 1)}
    | {0x10FFF}
)  # fmt: skip

Step = tuple[int, int, list[int], int]


def run(body: str = "", host: tuple[Step, ...] = (), dsps: int = 2, until: int = 60 * US) -> machine.Machine:
    made = machine.Machine(assemble(body), config(dsps=dsps), host=list(host), record=True)
    made.run_until(until)
    return made


def results(made: machine.Machine) -> list[tuple[int, bool, int]]:
    """(offset, is a write, how it ended) of each transaction on bus A."""
    return [(v[2], bool(v[4]), v[5]) for _, what, v in made.events if what == "transaction" and v[0] == 0]


@pytest.mark.parametrize("way", [READ, WRITE])
def test_each_offset_answers_a_dsp_as_task_block_inc_says(way: str) -> None:
    for place in PLACES:
        access = "ldi *ar1, r1" if way == READ else "sti r1, *ar1"
        made = run(
            f"        ldhi {place >> 16}, r0\n        or {place & 0xFFFF}, r0\n        or 0, r0\n        ldhi 0C000h, ar1\n        addi r0, ar1\n        {access}\n",
            dsps=1,
        )
        if place in BY_ANYBODY[way]:
            assert results(made) == [(place, way == WRITE, DONE)] and not made.faults, hex(place)
        else:  # a write is refused before it is posted
            assert results(made) == ([(place, False, TARGET_ABORT)] if way == READ else []), hex(place)
            assert [fault.address for fault in made.faults] == [0xC0000000 + place]


@pytest.mark.parametrize("way", [READ, WRITE])
def test_each_offset_answers_the_host_as_task_block_inc_says(way: str) -> None:
    for place in PLACES:
        step = (0, place, [], 1) if way == READ else (0, place, [0], 0)
        if place in BY_HOST[way]:
            assert results(run(host=(step,))) == [(place, way == WRITE, DONE)], hex(place)
        else:
            with pytest.raises(IndexError, match=f"{place:X}h, where no device answers"):
                run(host=(step,))


def answers(made: machine.Machine) -> list[int]:
    return [words[0] for _, _, words in made.reads]


def test_a_semaphore_is_had_by_one_and_released_by_its_owner_or_the_host() -> None:
    at = SYMBOLS["SEMAPHORE"] + 3
    owner = SYMBOLS["SEMAPHORE_OWNER"] + 3
    reads = [(0, at, [], 1), (2 * US, at, [], 1), (4 * US, owner, [], 1), (6 * US, at, [0], 0), (8 * US, owner, [], 1)]
    # The host acquires the semaphore; reads it again as its owner; releases it; the semaphore has no owner.
    assert answers(run(host=tuple(reads))) == [0, 1, HOST, 0]
    # DSP 0 gets it and keeps it: DSP 1 cannot release it, the host can.
    body = """
        cmpi    0, r7
        bnz     other
        ldi     *+ar1(3), r1
        b       halt
other:  rpts    99
        nop
        sti     r1, *+ar1(3)
    """
    later = [(30 * US, owner, [], 1), (32 * US, at, [], 1), (34 * US, at, [0], 0), (36 * US, owner, [], 1)]
    assert answers(run(body, tuple(later))) == [1, 1, 0]


def test_numbers_of_slots_that_are_not_there_do_nothing() -> None:
    ring, reset, idle, busy = (
        SYMBOLS[name] for name in ("DOORBELL_RING", "RESET_DSP", "DOORBELL_IDLE", "DOORBELL_BUSY")
    )
    steps = [
        (n * 2 * US, register, [number], 0)
        for n, (register, number) in enumerate((r, k) for r in (ring, reset) for k in (2, 31, 32, 0xFFFFFFFF))
    ]
    steps += [(20 * US, idle, [32], 0), (22 * US, busy, [0xFFFFFFFF], 0), (24 * US, idle, [], 1)]
    quiet, plain = run(host=tuple(steps)), run()
    assert answers(quiet) == [0]
    for slot in range(2):
        assert quiet.statistics(slot).boots == plain.statistics(slot).boots
    assert not [values for _, what, values in quiet.events if what == "interrupt"]
    rung = run(host=((2 * US, ring, [1], 0),))
    assert [values for _, what, values in rung.events if what == "interrupt"] == [[1, 0]]


def test_what_a_dsp_that_is_fenced_off_writes_to_a_register_is_dropped_and_its_semaphores_are_the_hosts() -> None:
    body = """
        cmpi    0, r7
        bnz     halt
        ldi     *+ar1(3), r1            ; it has the semaphore
        rpts    199
        nop
        sti     r7, *+ar1(3)            ; fenced off by now: neither released
        ldi     1, r2
        ldhi    0C001h, ar5
        or      101h, ar5
        sti     r7, *ar5                ; nor idle
        ldi     *+ar1(4), r1            ; nor does it get another one
        sti     r1, *ar3
    """
    steps = [
        (5 * US, SYMBOLS["FENCE_MASK"], [0xFFFFFFFE], 0), (40 * US, SYMBOLS["SEMAPHORE_OWNER"] + 3, [], 1), (42 * US, SYMBOLS["DOORBELL_IDLE"], [], 1),
        (44 * US, SYMBOLS["FENCE_MASK"], [], 1), (46 * US, SYMBOLS["SEMAPHORE"] + 3, [], 1), (48 * US, SYMBOLS["SEMAPHORE_OWNER"] + 3, [], 1),
    ]  # fmt: skip
    made = run(body, tuple(steps))
    assert answers(made) == [1, 0, 0xFFFFFFFE, 0, HOST]
    assert made.chip_word(0, ON_CHIP) == 1


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("SEMAPHORE_COUNT     .set 65", "SEMAPHORE_COUNT is at most 64"),
        ("RESET_DSP           .set 11000h", "offsets 10000h to 10FFFh"),
    ],
)
def test_a_program_whose_registers_cannot_be_is_refused(tmp_path: Path, line: str, message: str) -> None:
    name = line.split()[0]
    text = [
        line if old.startswith(name + " ") else old for old in (INCLUDE / "task_block.inc").read_text().splitlines()
    ]
    for file in INCLUDE.glob("*.inc"):
        (tmp_path / file.name).write_text("\n".join(text) + "\n" if file.name == "task_block.inc" else file.read_text())
    image = toolchain.assemble(
        HEAD + TAIL,
        "test.asm",
        include_dirs=[tmp_path],
        sections={".text": 0x300000, ".parameters": 0x30F000},
        entry="_start",
    )
    with pytest.raises(ValueError, match=message):
        machine.Machine(image, config(dsps=1))
