"""The self-checks name the instruction and the rule; programs that keep the rules get no diagnostic."""

import json
import subprocess
from pathlib import Path

import pytest
import small_programs
from cmrc import c40
from locations import BUILD, ROOT

CODE, DATA = 0x2FFC00, 0x2FF800


def checked(text: str, cycles: int = 300, **registers: int) -> list[c40.Diagnostic]:
    chip = c40.Processor(c40.assemble(text, sections={".text": CODE}), checks=True)
    chip.pc = CODE
    for name, value in {"SP": 0x2FF900, "AR0": DATA, **registers}.items():
        chip.registers[name] = value
    chip.run(cycles)
    return chip.diagnostics


BROKEN = [
    ("a branch in a slot", " brd x\n nop\n br x\n nop\nx: nop\nstop: b stop", "delay_slot", 2, "program control may not stand in slot 2 of brd"),
    ("IDLE in a slot of a branch that is not taken", " cmpi 1,r0\n beqd x\n nop\n nop\n idle\nx: nop\nstop: b stop", "delay_slot", 4, "slot 3 of beqd"),
    ("R11 in a slot of LAJ", " laj x\n ldi 0,r11\n nop\n nop\nx: nop\nstop: b stop", "delay_slot", 1, "R11 holds the return address"),
    ("RC in a slot of RPTBD", " ldi 1,rc\n rptbd x\n ldi 2,rc\n nop\n nop\nx: nop\nstop: b stop", "delay_slot", 2, "RS, RE and RC may not be written"),
    ("a block that ends before it begins", "x: nop\n ldi 0,rc\n rptb x\n nop\nstop: b stop", "repeat_block", 2, "before it begins"),
    ("a branch at the end of a block", " ldi 0,rc\n rptb x\n nop\nx: b stop\nstop: b stop", "repeat_block", 3, "may not end with program control"),
    ("a delayed branch near the end", " ldi 0,rc\n rptb x\n cmpi 1,r0\n beqd stop\n nop\n nop\nx: nop\nstop: b stop", "repeat_block", 3, "none of the last four"),
    ("RC written at the end", " ldi 1,rc\n rptb x\n nop\nx: ldi 0,rc\nstop: b stop", "repeat_block", 3, "may not write RS, RE or RC"),
    ("a block inside a block", " ldi 1,rc\n rptb outer\n ldi 1,rc\n rptb inner\ninner: nop\n nop\nouter: nop\nstop: b stop", "repeat_nesting", 6, "a repeat inside it has taken"),
    ("RPTS inside a block", " ldi 1,rc\n rptb outer\n rpts 3\n nop\n nop\nouter: nop\nstop: b stop", "repeat_nesting", 5, "a repeat inside it has taken"),
    ("RPTS of a branch", " rpts 3\n b stop\nstop: b stop", "repeat_single", 1, "may not repeat program control"),
    ("a store two words ahead", " ldi 0,r0\n ldhi 2fh,ar1\n or 0fc05h,ar1\n sti r0,*ar1\n nop\nnear: nop\n nop\nstop: b stop", "self_modifying", 3, "2 words ahead"),
    ("a store at a block's end to its first word", " ldi 1,rc\n ldhi 2fh,ar1\n or 0fc04h,ar1\n rptb x\n addi 1,r0\nx: sti r1,*ar1\nstop: b stop", "self_modifying", 5, "1 words ahead"),
    ("a store in a slot to the branch's target", " ldhi 2fh,ar1\n or 0fc06h,ar1\n bud x\n nop\n nop\n sti r1,*ar1\nx: nop\nstop: b stop", "self_modifying", 5, "1 words ahead"),
    ("STII straight before LDII", " ldi 1,r0\n stii r0,*ar0\n ldii *ar0,r1\n stii r0,*ar0\nstop: b stop", "interlocked", 2, "straight behind the interlocked store"),
    ("STFI straight before SIGI", " stfi r0,*ar0\n sigi *ar0,r1\nstop: b stop", "interlocked", 1, "straight behind the interlocked store"),
    ("a circular step without BK", " ldi *ar0++(1)%,r0\nstop: b stop", "circular", 0, "BK is 0"),
    ("a circular step longer than the buffer", " ldi 4,bk\n ldi *ar0++(5)%,r0\nstop: b stop", "circular", 1, "a step of 5 in a circular buffer of BK = 4"),
    ("a pointer behind its buffer", " ldi 3,bk\n addi 3,ar0\n nop\n nop\n ldi *ar0++(1)%,r0\nstop: b stop", "circular", 4, "ar0 points 3 words into a circular buffer of BK = 3"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "rule", "where", "message"), BROKEN, ids=[row[0] for row in BROKEN])
def test_a_broken_rule_is_named_with_its_place(name: str, text: str, rule: str, where: int, message: str) -> None:
    found = [d for d in checked(text) if d.rule == rule]
    assert [d.pc for d in found] == [CODE + where]
    assert message in found[0].message
    assert found[0].section.startswith("7.4" if rule == "interlocked" else ("8.", "3.9"))
    word = c40.assemble(text, sections={".text": CODE}).sections[0].words[where]
    assert found[0].instruction == c40.disassemble(word, CODE + where)


def test_the_rule_behind_a_chip_that_stops_at_the_end_of_a_block_is_named() -> None:
    """Ruling 42: a branch that becomes a block's last instruction by what is written to RE, not by RPTB."""
    found = checked(
        " ldi 2,rc\n ldhi 2fh,rs\n or 0fc06h,rs\n ldhi 2fh,re\n or 0fc07h,re\n or 100h,st\n nop\nend: b stop\nstop: b stop"
    )
    assert [(d.rule, d.pc) for d in found] == [("repeat_block", CODE + 7)]
    assert "may not end with program control" in found[0].message


@pytest.mark.parametrize("before", [1, 2, 3])
def test_the_rule_behind_a_chip_that_stops_at_a_delayed_branch_near_the_end_of_a_block_is_named(before: int) -> None:
    found = checked(
        f" ldi 2,rc\n ldhi 2fh,rs\n or 0fc06h,rs\n ldhi 2fh,re\n or 0fc{7 + before:02x}h,re\n or 100h,st\n nop\n beqd stop\n nop\n nop\n nop\nstop: b stop",
        R0=1,
    )
    assert [(d.rule, d.pc) for d in found] == [("repeat_block", CODE + 7)]
    assert f"may not stand {before} word" in found[0].message


RESERVED = [
    ("opcode", 0x3E000000, "12", "no instruction has this operation"),
    ("indirect mode 26", 0x0840D000, "3.9", "modes 26 to 31 are reserved"),
    ("a register code above 31", 0x08000020, "3", "bits that must be 0"),
    ("a float operand in an address register", 0x07000008, "1.1", "is not possible in this place"),
    ("condition 11", 0x6A0B0000, "4", "conditions 11 and 21 to 31"),
]


@pytest.mark.parametrize(("name", "word", "section", "message"), RESERVED, ids=[row[0] for row in RESERVED])
def test_a_reserved_word_is_named_with_its_rule(name: str, word: int, section: str, message: str) -> None:
    found = checked(f" nop\n .word {word}\nstop: b stop")
    assert [(d.rule, d.section, d.pc, d.count) for d in found] == [("reserved", section, CODE + 1, 1)]
    assert message in found[0].message


def test_each_place_is_reported_once_and_counted() -> None:
    found = checked(" ldi 9,ar5\nagain: ldi *ar0++(1)%,r0\n db ar5,again\nstop: b stop", 500)
    assert [(d.rule, d.count) for d in found] == [("circular", 10)]


GOOD = {
    "nested blocks with all four saved": small_programs.NESTED_BLOCKS + "\nstop: b stop",
    "an annulled interlocked store before a load": " buat x\n nop\n nop\n stii r0,*ar0\nx: ldii *ar0,r1\n stii r1,*ar0\nstop: b stop",
    "an interlocked store before an annulled load": " stii r0,*ar0\n buat x\n ldii *ar0,r1\n nop\n nop\nx: nop\nstop: b stop",
    "a circular step in a slot that gets no address": " ldi 8,bk\n buat x\n nop\n nop\n ldi *ar0++(9)%,r0\nx: nop\nstop: b stop",
    "a circular buffer": " ldi 4,bk\n ldi 9,rc\n rptb x\nx: ldi *ar0++(1)%,r0\nstop: b stop",
    "a store far ahead": " ldi 0,r0\n ldhi 2fh,ar1\n or 0fc10h,ar1\n sti r0,*ar1\nstop: b stop",
}


@pytest.mark.parametrize("name", GOOD)
def test_what_keeps_the_rules_is_not_blamed(name: str) -> None:
    assert checked(GOOD[name]) == []


@pytest.mark.parametrize("path", sorted((ROOT / "c40_programs" / "examples").glob("*.asm")), ids=lambda path: path.stem)
def test_the_examples_keep_all_rules_and_run_the_same_when_watched(path: Path) -> None:
    program = c40.assemble_file(path, entry="start")
    outcomes = []
    for checks in (False, True):
        chip = c40.Processor(program, checks=checks)
        chip.run(2_000_000, until="done")
        assert chip.diagnostics == []
        outcomes.append((chip.cycles, chip.causes, dict(chip.registers)))
    assert outcomes[0] == outcomes[1]


def test_on_the_command_line(tmp_path: Path) -> None:
    source = tmp_path / "bad.asm"
    source.write_text(" .text\nstart: ldi *ar0++(1)%,r0\nstop: b stop\n")
    command = [BUILD / "bin" / "emulator", "exec", source, "--board", "flat"]
    text = subprocess.run([*command, "--check"], capture_output=True, text=True, check=True).stdout
    assert "checks: 1 found" in text and "circular (c40-isa.md 3.9): BK is 0" in text
    found = json.loads(
        subprocess.run([*command, "--check", "--json"], capture_output=True, text=True, check=True).stdout
    )["diagnostics"]
    assert [(d["rule"], d["pc"]) for d in found] == [("circular", 0x300000)]
    assert "checks" not in subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_an_interrupt_between_an_interlocked_store_and_a_load_parts_them() -> None:
    """The timer interrupts among the stores, and its service begins with the load."""
    found = checked(
        " ldhi 2fh,ar1\n or 0fa00h,ar1\n ldpe ar1,ivtp\n ldhi hi16(isr),r0\n or lo16(isr),r0\n sti r0,*+ar1(2)\n"
        " ldhi 10h,ar2\n or 20h,ar2\n ldi 10,r3\n sti r3,*+ar2(8)\n ldi 2c1h,r3\n sti r3,*ar2\n"
        " ldi 1,iie\n or 2000h,st\n"
        + " stii r0,*ar0\n" * 40
        + "stop: b stop\n"
        + "isr: ldii *ar0,r1\n ldi 0,iie\n sti r0,*+ar1(2)\n reti\n"
    )
    assert found == []
