"""A chip's state, saved and loaded: going on from it is going on."""

import random

import pytest
from nasty_programs import CYCLES, Bench, assembled, generate, made, state

SEEDS = range(60)


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
def test_a_nasty_program_goes_on_from_random_instants_in_another_chip(seed, tmp_path):
    """At each of some random instants the state goes into a chip that has run something else before; it and the first then do the same for a while."""
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
