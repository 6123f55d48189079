"""Random instructions without branches: recorded blocks, run again with other data, against the specification."""

from random import Random
from typing import Any

import pytest
from cmrc._core import c40

from spec.encodings import encodings
from spec.fields import Encoding
from spec.machine import Machine
from spec.state import DIE, IIE, NAMES, ST
from spec.vectors import CODE, START, Memory, Registers, random_registers

LENGTH = 24
STOP = 0x60FFFFFF  # BR to itself
CONTROL = """br brd call laj b bd bat baf callcond lajcond db dbd trap lat reti retid rets
rptb rptbd rpts repeat idle idle2 swi"""
STRAIGHT = [encoding for encoding in encodings() if encoding.name not in CONTROL.split()]


def word_of(rng: Random, encoding: Encoding) -> int:
    while True:
        word = encoding.build(rng).words[0]
        if word >> 16 & 31 not in (DIE, IIE):  # nothing is to ask for anything
            return word


def run_both(processor: Any, words: list[int], rng: Random) -> bool:
    """False if the program came across its own words; a program that has done so is left out."""
    before = random_registers(rng)
    before[IIE] = 0  # an instruction may set GIE, and the empty output FIFOs ask at once
    memory = Memory(rng, {START + n: word for n, word in enumerate(words)})
    machine = Machine(r=Registers(before), memory=memory)
    for _ in range(LENGTH):
        machine.step()
        if any(address in CODE for _, address, _ in machine.bus):
            return False
    processor.set("RC", 1)
    processor.set("ST", before[ST])
    for code, name in enumerate(NAMES):
        if code != ST:
            processor.set(name, before[code])
    for name in ("IVTP", "TVTP"):
        processor.set(name, 0)
    for address, word in memory.initial.items():
        if address not in CODE:
            processor.poke(address, word)
    processor.pc = START
    processor.run(2000)
    assert processor.pc == START + LENGTH
    actual = {name: f"{processor.get(name):X}" for name in NAMES} | {
        n: f"{processor.get(n):X}" for n in ("IVTP", "TVTP")
    }
    expected = {name: f"{machine.r[code]:X}" for code, name in enumerate(NAMES)}
    assert actual == expected | {"IVTP": f"{machine.ivtp:X}", "TVTP": f"{machine.tvtp:X}"}
    for address, word in memory.items():
        if address not in CODE:
            assert processor.peek(address) == word, f"{address:08X}"
            processor.poke(address, 0)
    return True


@pytest.mark.parametrize("seed", range(20))
def test_a_program_met_again_with_other_data_does_what_the_specification_says(seed: int) -> None:
    rng = Random(seed)
    processor = c40.Processor("flat")
    compared = 0
    for _ in range(4):
        words = [word_of(rng, rng.choice(STRAIGHT)) for _ in range(LENGTH)] + [STOP]
        processor.load_words(START, words)
        compared += sum(run_both(processor, words, rng) for _ in range(6))
    assert compared > 10
