"""Where a program ends is judged when the instruction is executed, wherever it comes from: exec, networks, debugger."""

import json
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40

# Copies a routine into on-chip RAM and branches to it, as programs do.
COPIES = """
        .text
start:  ldi   2FFh,ar1
        lsh   12,ar1
        or    800h,ar1
        ldi   30h,ar0
        lsh   16,ar0
        or    routine,ar0
        ldi   3,rc
        ldi   ar1,r1
        rptb  copy
        ldi   *ar0++,r0
copy:   sti   r0,*ar1++
        bu    r1
routine:
        ldi   5,r2
        addi  1,r2
        nop
        {end}
"""
END = 0x2FF803
BRANCH_TO_ITSELF, LONG_BRANCH_TO_ITSELF, IDLE, IDLE2 = 0x6A00FFFF, 0x60FFFFFF, 0x06000000, 0x06000001


def stop(result: Any) -> dict[str, Any]:
    assert result.returncode == 0, result.stdout + result.stderr
    return json.loads(result.stdout)


@pytest.mark.parametrize(
    ("end", "reason"), [("b $", "halt"), ("br $", "halt"), ("idle", "idle"), ("idle2", "idle")], ids=str
)
def test_a_copied_routine_ends_the_run_where_its_end_is_reached(run, tmp_path: Path, end: str, reason: str) -> None:
    (tmp_path / "copies.asm").write_text(COPIES.format(end=end))
    ended = stop(run("exec", "copies.asm", "--json"))
    before = stop(run("exec", "copies.asm", "--json", "--until", hex(END)))
    waits = reason == "idle"  # it is executed, and nothing wakes it
    assert (ended["stop"]["reason"], ended["stop"]["pc"]) == (reason, END + waits)
    assert ended["instructions"] == before["instructions"] + waits
    assert ended["cycles"] - before["cycles"] in (range(1, 9) if waits else (0,))
    assert ended["registers"]["R2"] & 0xFFFFFFFF == 6


@pytest.mark.parametrize("options", [[], ["--trace", "t"], ["--check"], ["--pipeline", "0:40"], ["--profile"]], ids=str)
def test_whatever_looks_on_the_end_is_the_same(run, tmp_path: Path, options: list[str]) -> None:
    (tmp_path / "copies.asm").write_text(COPIES.format(end="b $"))
    ended = stop(run("exec", "copies.asm", "--json", *options))
    assert (ended["stop"]["reason"], ended["stop"]["pc"], ended["instructions"]) == ("halt", END, 21)


@pytest.mark.parametrize("word", [BRANCH_TO_ITSELF, LONG_BRANCH_TO_ITSELF, IDLE])
@pytest.mark.parametrize("by", ["poke", "load"])
def test_a_word_from_the_command_line_ends_the_run(run, tmp_path: Path, word: int, by: str) -> None:
    (tmp_path / "goes.asm").write_text("start:  ldhi 2Fh,ar0\n        or 0F800h,ar0\n        bu ar0\n")
    (tmp_path / "words").write_bytes(word.to_bytes(4, "little"))
    option = ["--poke", f"2FF800h={word}"] if by == "poke" else ["--load", "words@2FF800h"]
    ended = stop(run("exec", "goes.asm", "--json", *option))
    assert ended["stop"]["reason"] == ("idle" if word == IDLE else "halt") and ended["cycles"] < 30


def test_an_end_that_a_program_writes_over_its_own_text_ends_the_run(run, tmp_path: Path) -> None:
    """At the tenth pass: the loop has been executed before, with another word there."""
    (tmp_path / "writes.asm").write_text(
        "start:  ldp word\n        ldi @word,r1\n        ldi @place,ar0\n        ldi 0,r0\nloop:   addi 1,r0\n"
        "        cmpi 10,r0\n        bnz over\n        sti r1,*ar0\nover:   nop\n        nop\n        nop\n        nop\n"
        f"patch:  nop\n        b loop\nword:   .word {BRANCH_TO_ITSELF}\nplace:  .word patch\n"
    )
    ended = stop(run("exec", "writes.asm", "--json", "--max-cycles", 100000))
    assert ended["stop"]["reason"] == "halt" and ended["registers"]["R0"] & 0xFFFFFFFF == 10


def test_in_a_network_and_in_the_debugger_a_copied_end_is_the_same(run, tmp_path: Path) -> None:
    (tmp_path / "copies.asm").write_text(COPIES.format(end="b $"))
    alone = stop(run("exec", "copies.asm", "--json"))
    two = stop(run("exec", "copies.asm", "copies.asm", "--link", "0.0:1.3", "--json"))
    assert two["stop"]["reason"] == "ended"
    assert [(chip["status"], chip["cycles"]) for chip in two["chips"]] == [("halt", alone["cycles"])] * 2
    (tmp_path / "script").write_text(f"continue\nassert pc == {END}\nassert cycle < 100\n")
    debugged = run("debug", "copies.asm", "-x", "script")
    assert debugged.returncode == 0, debugged.stdout
    assert f"branches to itself at PC {END:08X}h" in debugged.stdout
    processor = c40.Processor(c40.assemble(COPIES.format(end="b $")))
    debugger = processor.debug()
    assert debugger.go(1e-3).text == f"branches to itself at {END:08X}h" and processor.cycles == alone["cycles"]
    debugger.close()
    assert processor.run(1000).reason == "limit"  # by itself a processor stops at no end


WAITS = """
        .text
start:  ldp   vectors
        ldi   @vectors,r0
        ldpe  r0,ivtp
        ldi   @israt,r0
        ldi   @vectors,ar1
        sti   r0,*+ar1(2)
        ldi   @stack,sp
        ldi   @timer,ar0
        ldi   20,r0
        sti   r0,*+ar0(8)
        ldi   @go,r0
        sti   r0,*ar0
        ldi   1,iie
        or    2000h,st
wait:   b     wait
isr:    addi  1,r5
        cmpi  3,r5
        bz    done
        reti
done:   b     done
vectors .word 2FFA00h
israt   .word isr
stack   .word 2FFB00h
timer   .word 100020h
go      .word 2C0h
        .global wait, done
"""


def test_a_branch_to_itself_that_an_interrupt_can_end_ends_no_run(run, tmp_path: Path) -> None:
    """Alone as in a network: three interrupts of the timer, then a branch to itself with interrupts off."""
    (tmp_path / "waits.asm").write_text(WAITS)
    alone = stop(run("exec", "waits.asm", "--json", "--max-cycles", 10000))
    two = stop(run("exec", "waits.asm", "waits.asm", "--link", "0.0:1.3", "--json", "--max-cycles", 10000))
    assert alone["stop"]["reason"] == "halt" and alone["registers"]["R5"] & 0xFFFFFFFF == 3
    assert alone["cycles"] > 3 * 40
    assert [(chip["status"], chip["cycles"]) for chip in two["chips"]] == [("halt", alone["cycles"])] * 2
