"""States between a stop and its answer, and states that only debuggers and pins set: the second chip gets the answer
without having run."""

import pytest
from cmrc import c40 as package
from cmrc._core import c40

HEAD = """        .text
start:  ldhi 10h,ar6
        ldhi 7000h,ar0
        ldhi 30h,ar1
        ldhi 8000h,ar2
        ldi 20,r1
"""
LOOP = """
again:  addi 1,r2
        ldi *ar2,r3
        sti r2,*ar2++(1)
        subi 1,r1
        bnz again
done:   b done
"""


def pair(body, prepare=lambda chip: None):
    """Two chips with the program; the second has run another way before."""
    image = package.assemble(HEAD + body + LOOP)
    chips = []
    for _ in range(2):
        chip = c40.Processor("default")
        chip.load_image(image)
        prepare(chip)
        chips.append(chip)
    chips[1].run(3)
    return chips


def seen(chip):
    return chip.snapshot(), chip.digest(), chip.save_state(), chip.settled


def moved(chip, other):
    saved = chip.save_state()
    other.load_state(saved)
    assert other.save_state() == saved
    assert seen(other) == seen(chip)


def together(chip, other, cycles=200):
    assert chip.run(cycles) == other.run(cycles)
    assert seen(chip) == seen(other)


@pytest.mark.parametrize("instruction", ["ldi *ar0,r4", "ldii *ar0,r4"])
def test_a_read_of_a_window_is_answered_in_the_other_chip(instruction):
    chip, other = pair(f"        {instruction}\n")
    assert chip.run(100)["reason"] == "external_access"
    moved(chip, other)
    for each in (chip, other):
        each.complete_read(0x1234, 3, 2)
    moved(chip, other)  # answered, and not yet gone on
    together(chip, other, 1)
    together(chip, other)
    assert other.get("R4") & 0xFFFFFFFF == 0x1234
    assert other.locked(False) == (instruction[:4] == "ldii")


def test_a_write_to_a_window_is_asked_for_again():
    chip, other = pair("        sti r1,*ar0\n")
    stop = chip.run(100)
    moved(chip, other)
    assert other.run(100) == stop == chip.run(100)
    for each in (chip, other):
        each.complete_write(1, 4)
    together(chip, other)


def test_a_write_is_no_read_in_the_other_chip_either():
    chip, other = pair("        sti r1,*ar0\n")
    chip.run(100)
    moved(chip, other)
    with pytest.raises(RuntimeError, match="does not wait for a read"):
        other.complete_read(1)


def copies(source, destination):
    def prepare(chip):
        for register, value in ((1, source), (2, 1), (4, destination), (5, 1), (3, 6)):
            chip.poke(0x1000A0 + register, value)
        chip.poke(0x1000A0, 3 << 22 | 1 << 2)

    return prepare


@pytest.mark.parametrize(("source", "destination"), [(0x70000000, 0x80000100), (0x80000000, 0x70000000)])
def test_the_dma_is_answered_in_the_other_chip(source, destination):
    chip, other = pair("", copies(source, destination))
    for word in range(6):
        stop = chip.run(300)
        assert stop["reason"] == "external_access" and stop["channel"] == 0
        moved(chip, other)
        for each in (chip, other):
            if stop["write"]:
                each.complete_write(word, 2)
            else:
                each.complete_read(100 + word, word, 2)
        moved(chip, other)
    together(chip, other)
    assert chip.dma_active is False


def test_both_wait_for_windows():
    """The processor's access is held off by the one that the DMA has just made."""
    chip, other = pair("        ldi *ar0,r4\n        sti r4,*ar0\n", copies(0x70000010, 0x80000100))
    for _ in range(20):
        chip.run(300)
        moved(chip, other)
        stop = chip.run(300)
        assert other.run(300) == stop
        if stop["reason"] != "external_access":
            break
        for each in (chip, other):
            if stop["write"]:
                each.complete_write(2, 7)
            else:
                each.complete_read(stop["address"], 2, 7)
    assert stop["reason"] == "limit" and other.get("R4") & 0xFFFFFFFF == 0x70000000
    together(chip, other)


def test_a_port_is_read_in_the_other_chip():
    chip, other = pair("        ldi *+ar6(41h),r4\n")
    stop = chip.run(100)
    assert stop["reason"] == "port_wait"
    moved(chip, other)
    for each in (chip, other):
        each.deliver(0, 77)
        each.complete_port(stop["access_cycle"] + 9)
    moved(chip, other)
    together(chip, other)
    assert other.get("R4") & 0xFFFFFFFF == 77 and other.causes["comm_port"] == 9


def test_pins_holds_and_the_last_breakpoint():
    chip, other = pair("")
    for each in (chip, other):
        each.add_breakpoint(package.assemble(HEAD + LOOP).symbols["again"])
    assert chip.run(100)["reason"] == "breakpoint"
    chip.set_iiof(1, True)
    chip.set_timer_pin(0, True)
    moved(chip, other)
    for each in (chip, other):
        each.set("IIF", 0x90)  # IIOF1: an interrupt by its level
    together(chip, other)  # does not stop where the chip is
    chip.hold(True)
    moved(chip, other)
    together(chip, other, 50)
    assert other.halted


def test_interface_control_that_was_written_and_does_not_act_yet():
    chip, other = pair("")
    chip.run(20)
    chip.poke(0x100000, 0x1DEA4000 | 0x1D << 4 | 7 << 8)  # seven software wait states on the global bus
    moved(chip, other)
    together(chip, other, 100)
    moved(chip, other)
    together(chip, other)


def test_a_flat_board_has_the_same_pages_afterwards():
    image = package.assemble(HEAD + LOOP)
    chip, other = c40.Processor("flat"), c40.Processor("flat")
    chip.load_image(image)
    chip.run(100)
    other.load_image(image)
    for address in (0x12345678, 0x2FF000, 0x2FFFFF, 0x100200):
        other.poke(address, 99)
    moved(chip, other)
    assert other.peek(0x12345678) == 0
    together(chip, other)
