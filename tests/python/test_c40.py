"""cmrc.c40: a chip driven from Python."""

from pathlib import Path

import pytest
from cmrc import c40

SOURCE = """
        .text
start:  ldf   3.0,r0
        mpyf  r0,r0,r1
        ldi   @there,ar0
        stf   r1,*ar0
        addi  1,ar0
done:   b     done
there   .word 300100h
"""


@pytest.fixture
def program() -> "c40.Program":
    return c40.assemble(SOURCE.replace("start:", "start:  ldp there\n"))


def test_run_until_a_symbol(program) -> None:
    processor = c40.Processor(program)
    stop = processor.run(until="done")
    assert (stop.reason, stop.pc) == ("until", program.symbols["done"])
    assert processor.floats["R1"] == 9.0
    assert processor.registers["AR0"] == 0x300101
    assert processor.memory.read_floats(0x300100, 1) == [9.0]
    assert processor.memory[0x300100] == c40.float_to_single(9.0)
    assert processor.instructions == 6
    assert sum(processor.causes.values()) == processor.cycles == stop.cycle >= 6


def test_steps_and_trace_agree_with_run(program) -> None:
    stepped = c40.Processor(program)
    while stepped.pc != program.symbols["done"]:
        assert stepped.step().reason == "limit"
    ran = c40.Processor(program)
    ran.run(until="done")
    assert (stepped.cycles, stepped.causes, dict(stepped.registers)) == (ran.cycles, ran.causes, dict(ran.registers))
    traced = c40.Processor(program)
    lines = traced.trace(ran.cycles)
    assert [int(line.split()[3], 16) for line in lines[:6]] == [0x300000 + i for i in range(6)]
    assert "R1=0310000000" in next(line for line in lines if "mpyf" in line)
    assert f"@00300100={c40.float_to_single(9.0):08X}" in next(line for line in lines if "stf" in line)


def test_registers_as_integers_and_floats(program) -> None:
    processor = c40.Processor(program)
    processor.floats["R7"] = -1.5
    assert processor.registers["R7"] == 0x00C0000000
    processor.registers["R7"] = 0x0140000000
    assert processor.floats["R7"] == 3.0
    processor.floats["R11"] = 0.5
    assert processor.floats["R11"] == 0.5 and list(processor.floats)[-1] == "R11"
    processor.registers["AR3"] = 0xFFFFFFFF
    assert processor.registers["AR3"] == 0xFFFFFFFF
    assert set(processor.registers) == set(c40.REGISTERS)
    for name, value in (("AR0", 1 << 32), ("R0", 1 << 40), ("R0", -1)):
        with pytest.raises(ValueError, match="bits"):
            processor.registers[name] = value
    with pytest.raises(KeyError, match="R12"):
        processor.registers["R12"]
    with pytest.raises(KeyError, match="AR0 cannot hold a float"):
        processor.floats["AR0"]


def test_a_reset_clears_the_registers_and_keeps_memory_and_counters(program) -> None:
    processor = c40.Processor(program)
    processor.run(until="done")
    cycles, instructions = processor.cycles, processor.instructions
    assert processor.registers["R1"] and processor.registers["AR0"] and cycles > 0
    processor.reset()
    assert processor.floats["R1"] == processor.registers["AR0"] == 0
    assert processor.memory.read_floats(0x300100, 1) == [9.0]
    assert (processor.cycles, processor.instructions) == (cycles, instructions)


def test_memory(program) -> None:
    processor = c40.Processor(program)
    processor.memory[0x300200:0x300203] = [1, -1, 0xFFFFFFFE]
    assert processor.memory[0x300200:0x300203] == [1, 0xFFFFFFFF, 0xFFFFFFFE]
    processor.memory.write_floats(0x300200, [0.5, -2.0])
    assert processor.memory.read_floats(0x300200, 2) == [0.5, -2.0]
    with pytest.raises(IndexError):
        processor.memory[0xF0000000]
    with pytest.raises(ValueError, match="32-bit"):
        processor.memory[0x300200] = 1 << 32
    with pytest.raises(ValueError, match="length"):
        processor.memory[0x300200:0x300203] = [1]
    with pytest.raises(ValueError, match="length"):
        processor.memory[0x300200:0x300206:2] = [7] * 6
    assert processor.memory[0x300200] != 7
    processor.memory[0x300200] = -(1 << 31)
    with pytest.raises(ValueError, match="32-bit"):
        processor.memory[0x300200] = -(1 << 31) - 1
    assert processor.memory[0x300200] == 1 << 31


def test_memory_ends_at_its_last_address() -> None:
    memory = c40.Processor(board="flat").memory
    memory[0xFFFF_FFFE:0x1_0000_0000] = [1, 2]
    assert memory[0xFFFF_FFFE:0x1_0000_0000] == [1, 2] and memory[0xFFFF_FFFF] == 2
    memory[:2] = [3, 4]
    assert memory[:2] == [3, 4] == memory[0:2]
    for beyond in (0x1_0000_0000, -1):
        with pytest.raises(IndexError, match="is out of range; an address"):
            memory[beyond]


def test_a_window_stops_the_run_and_is_answered() -> None:
    program = c40.assemble("start: ldhi 0C000h,ar0\n ldi *ar0,r0\n addi 1,r0\n sti r0,*ar0\ndone: b done\n")
    processor = c40.Processor(program)
    stop = processor.run(until="done")
    assert stop.reason == "external_access"
    assert stop.details is not None
    assert (stop.details["address"], stop.details["write"]) == (0xC0000000, False)
    processor.complete_read(41, arbitration=5, transfer=7)
    stop = processor.run(until="done")
    assert stop.details is not None
    assert (stop.details["write"], stop.details["value"]) == (True, 42)
    processor.complete_write()
    assert processor.run(until="done").reason == "until"
    assert (processor.causes["bus_arbitration"], processor.causes["bus_transfer"]) == (5, 7)


def test_a_reserved_word_is_a_fault() -> None:
    processor = c40.Processor(c40.assemble("start: .word 0FFFFFFFFh\n"))
    stop = processor.run(100)
    assert stop.reason == "fault"
    assert "FFFFFFFF" in stop.message.upper()
    assert stop.details is not None
    assert stop.details["kind"] == "reserved_instruction"


def test_assembly_errors_carry_their_places() -> None:
    with pytest.raises(c40.AssemblyError, match="demo.asm:2:") as caught:
        c40.assemble("start: nop\n  bogus r1\n", name="demo.asm")
    assert caught.value.diagnostics[0]["line"] == 2


def test_disassemble() -> None:
    words = [int(word, 16) for word in ("08600005", "02600002")]
    assert c40.disassemble(words) == [c40.disassemble(words[0]), c40.disassemble(words[1], 1)]
    source = "".join(f" {text}\n" for text in c40.disassemble(words))
    assert list(c40.assemble(source).sections[0].words) == words


def test_coff_round_trip(program, tmp_path: Path) -> None:
    c40.write_coff(program, tmp_path / "p.out")
    again = c40.read_coff(tmp_path / "p.out")
    assert again.entry == program.entry
    assert {name: again.symbols[name] for name in program.symbols} == dict(program.symbols)
    processor = c40.Processor(tmp_path / "p.out")
    assert processor.run(until="done").reason == "until"
    (tmp_path / "junk.out").write_bytes(b"junk")
    with pytest.raises(c40.CoffError, match="junk.out"):
        c40.read_coff(tmp_path / "junk.out")
    with pytest.raises(KeyError, match="nowhere"):
        processor.run(until="nowhere")


def test_ports_and_peripheral_registers_can_be_looked_at() -> None:
    """c40-hardware.md 2.4: after reset ports 0 to 2 own the token; 1.3: the registers by name."""
    processor = c40.Processor()
    assert [processor.port(n)["token"] for n in range(6)] == [True] * 3 + [False] * 3
    processor.memory[0x100028] = 8250
    assert processor.peripheral("timer0.period") == 8250
    with pytest.raises(IndexError, match="timer0.period"):
        processor.peripheral("timer0.periode")


def test_a_fork_finds_its_board_after_a_change_of_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "board.toml").write_text(
        'name = "b"\n[[region]]\nname = "r"\nbase = 0x300000\nwords = 0x1000\nbus = "local"\n'
    )
    monkeypatch.chdir(tmp_path)
    processor = c40.Processor(c40.assemble("   .text\nx: b x\n"), board="board.toml")
    (tmp_path / "else").mkdir()
    monkeypatch.chdir(tmp_path / "else")
    assert processor.fork().pc == processor.pc
