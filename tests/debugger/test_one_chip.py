"""One program in the debugger is the run that `exec` makes: registers, ends, messages."""

import json
from pathlib import Path

import pytest
from cmrc import c40
from command_line import emulator
from editor import Editor

COUNTS = """
        .data
v:      .word 0,0
third:  .word 33
        .text
start:  ldp v
        ldi 5,ar0
loop:   addi 1,r1
later:  nop
middle: sti r1,@v
        db ar0,loop
done:   b done
"""
MOVES = """
        .data
v:      .word 11,22,33,44
dst:    .space 2
third:  .space 2
        .text
start:  ldp v
        ldhi 10h,ar1
        or 0a0h,ar1
        ldhi hi16(v),r0
        or lo16(v),r0
        sti r0,*+ar1(1)
        addi 4,r0
        sti r0,*+ar1(4)
        ldi 1,r0
        sti r0,*+ar1(2)
        sti r0,*+ar1(5)
        ldi 4,r0
        sti r0,*+ar1(3)
        ldhi 0c4h,r0
        or 4,r0
        sti r0,*ar1
        rpts 20
        addi 1,r1
middle: rpts 20
later:  addi 1,r1
done:   b done
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "one.asm"
    path.write_text(COUNTS)
    return path


REGISTERS = ("r0", "r1", "r2", "r3", "ar0", "sp")


@pytest.mark.parametrize("source", [COUNTS, MOVES], ids=["processor", "DMA"])
@pytest.mark.parametrize(
    "until",
    [(), ("middle",), ("middle", "later"), ("v==3",), ("third==33",), ("v==3", "later"), ("v==0",)],
    ids=" ".join,
)
def test_the_run_ends_where_exec_ends(tmp_path: Path, source: str, until: tuple[str, ...]) -> None:
    path = tmp_path / "one.asm"
    path.write_text(source)
    ends = [word for text in until for word in ("--until", text)]
    end = json.loads(emulator("exec", path, "--json", *ends).stdout)
    assert end["stop"]["reason"] in ("until", "halt")
    shown = emulator(
        "debug", path, *ends, stdin="c\nprint cycle\nprint pc\nprint instructions\nc\n"
    ).stdout.splitlines()
    assert [line.split()[0] for line in shown[-5:-2]] == [
        str(end["cycles"]),
        str(end["stop"]["pc"]),
        str(end["instructions"]),
    ]
    assert shown[-2].startswith("over: ") and "all chips" not in shown[-2], shown


def test_registers_begin_as_in_exec(program: Path, tmp_path: Path) -> None:
    chip = c40.Processor(c40.assemble(COUNTS))
    debugger = chip.debug()
    numbers = [int(debugger.value(name)) for name in REGISTERS]
    prints = "".join(f"print {name}\n" for name in REGISTERS)
    lines = emulator("debug", program, stdin=prints).stdout.splitlines()
    assert [int(line.split()[0]) for line in lines[-len(REGISTERS) :]] == numbers
    in_network = emulator("debug", program, "--topology", "ring:1", stdin=prints).stdout.splitlines()
    assert [int(line.split()[0]) for line in in_network[-len(REGISTERS) :]] != numbers
    with Editor() as editor:
        editor.begin(program=str(program), stopOnEntry=True)
        editor.configured()
        editor.stopped()
        shown = editor.registers(editor.top().id)
        assert "(integer 0)" in shown["R1"].value and "(integer 0)" in shown["R3"].value


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--until", "50000041h==1"], "50000041h is no memory of this board"),
        (["--load", "rom.hex"], '--load: "rom.hex" is not FILE@ADDRESS'),
        (["--memory-max", "64"], "--memory-max: board default has as much RAM as it says"),
        (["--until", "nowhere==1"], "nowhere"),
    ],
)
def test_messages_are_of_one_chip(program: Path, arguments: list[str], message: str) -> None:
    said = emulator("debug", program, *arguments, stdin="c\n")
    assert said.returncode == 2 and message in said.stderr and "network" not in said.stderr, said.stderr
    assert emulator("exec", program, *arguments).returncode == 2


def test_a_word_that_holds_its_value_ends_the_run_again_after_going_back(program: Path) -> None:
    done = emulator(
        "debug", program, "--until", "v==3", stdin="c\nback\nc\nassert [v] == 3\nback\ngoto 1 s\nassert r1 == 3\n"
    )
    assert done.returncode == 0 and done.stdout.count("over: 00") == 3, done.stdout


@pytest.mark.parametrize("before", [True, False])
def test_a_fault_that_the_debugger_did_not_run_into_is_an_end(before: bool) -> None:
    program = c40.assemble("\t.text\nstart:\tnop\n\tnop\n")
    processor = c40.Processor(program)
    debugger = processor.debug() if before else None
    processor.pc = "start"
    processor.memory[processor.pc] = 0xFFFFFFFF
    assert processor.step().reason == "fault"
    debugger = debugger or processor.debug()
    assert [debugger.step().reason, debugger.go(0.001).reason] == ["over", "over"]
    assert debugger.step().text == "it is halted after a fault"
    processor.reset()
    processor.pc = program.symbols["start"] + 1
    assert debugger.step().reason == "step"
