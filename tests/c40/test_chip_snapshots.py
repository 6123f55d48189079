"""A chip's state, saved and loaded: a run from the loaded state equals an uninterrupted run."""

import random

import pytest
from cmrc._core import c40
from nasty_programs import CYCLES, generate
from nasty_runs import Bench, assembled, made, state

SEEDS = range(60)
PAGE = 0x40000000  # the default board has memory there


def same(chip, other):
    return state(chip) == state(other) and chip.save_state() == other.save_state()


def advance(chip, program, until, pins):
    """To a cycle, with the program's pins; false where it stops for another reason."""
    while chip.cycle < until:
        while pins and pins[0][0] <= chip.cycle:
            pin = pins.pop(0)[1]
            if pin == 4:
                chip.raise_nmi()
            else:
                chip.raise_iiof(pin)
        stop = chip.run(max(1, min(until, pins[0][0] if pins else until) - chip.cycle))
        if stop["reason"] != "limit":
            return False
    return True


@pytest.mark.parametrize("seed", SEEDS)
def test_a_nasty_program_continues_from_random_instants_in_another_chip(seed, tmp_path):
    """At each of some random instants the state goes into a chip that has run something else before; it and the first
    then do the same for a while."""
    program = generate(seed)
    board, image = Bench(tmp_path).board(program), assembled(program)
    rng = random.Random(seed)
    chip = made(program, board, image)
    other = made(program, board, image)
    other.set_exact(seed % 3 == 0)
    other.run(rng.randrange(1, CYCLES))
    pins = list(program.pins)
    going = True
    while going and chip.cycle < CYCLES:
        going = advance(chip, program, chip.cycle + rng.choice([1, 2, 3, 7, 20, 64, 150]), pins)
        saved = chip.save_state()
        other.load_state(saved)
        assert same(chip, other), (seed, chip.cycle)
        assert other.save_state() == saved
        ahead = list(pins)
        span = rng.choice([1, 5, 30, 200])
        there = chip.cycle + span
        went = advance(chip, program, there, pins), advance(other, program, there, ahead)
        assert went[0] == went[1]
        assert same(chip, other), (seed, chip.cycle)
        going = going and went[0]


def flipped(saved, offset, size, path):
    """The lowest bit of the value's first byte: any number has one."""
    out = bytearray(saved)
    out[offset] ^= 1
    return bytes(out)


# Counts of elements, and what says which of several things there is, are no numbers that could be any other.
FIXED = (
    ".count",
    "waiting_access",
    "port_slot",
    "dma_request",
    "dma_stop",
    "undisturbed",
    "reported_breakpoint",
    "memory.pages",
    "memory.flat_pages",
)
# Of accesses that are not waited for, nothing is kept.
LEFT_OVER = ("access.", "port_access.", "held", "reported")


def test_every_value_that_is_saved_is_loaded(tmp_path):
    program = generate(3)
    board, image = Bench(tmp_path).board(program), assembled(program)
    chip, other = made(program, board, image), made(program, board, image)
    chip.run(CYCLES // 2)
    saved, leaves = chip.save_state(), chip.state_leaves()
    waits = False
    seen = 0
    for path, offset, size in leaves:
        if any(name in path for name in FIXED) or (not waits and path.startswith(LEFT_OVER)):
            continue
        changed = flipped(saved, offset, size, path)
        other.load_state(changed)
        again = other.save_state()
        differing = [p for p, o, s in leaves if again[o : o + s] != saved[o : o + s]]
        assert differing == [path], path
        seen += 1
    assert seen > 500


@pytest.mark.parametrize(("word", "words"), [(0x55555555, 1024), (0, 1023), (0xFFFFFFFF, 1)])
def test_a_page_of_equal_words_is_saved_and_only_one_of_zeros_is_left_out(word, words):
    """Pages of 1024 words; those of zeros are not saved (chip_state.cpp)."""
    page = [word] * words + [7] * (1024 - words)
    chip, other = c40.Processor("default"), c40.Processor("default")
    empty = len(chip.save_state())
    chip.load_words(PAGE, page)
    other.load_words(PAGE + 1024, [1])
    saved = chip.save_state()
    assert len(saved) > empty + 4 * 1024
    other.load_state(saved)
    assert list(other.read(PAGE, 2048)) == [*page, *[0] * 1024]
    chip.load_words(PAGE, [0] * 1024)
    assert len(chip.save_state()) == empty
