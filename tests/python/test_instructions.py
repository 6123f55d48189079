"""cmrc.c40: a word as an instruction, the table of encodings, the words of an EPROM, traces with labels."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from cmrc import c40

LOOP = """
        .text
start:  ldi     2,r0
again:  addi    1,r1
        subi    1,r0
        bnz     again
done:   b       done
"""


def test_a_word_has_its_operands() -> None:
    found = c40.decode(0x02200007)  # addi @7,r0
    assert found is not None
    assert (found["mnemonic"], found["operation"], found["mnemonic2"]) == ("addi", "addi", "")
    assert found["src2"] == {"kind": "direct", "value": 7} and found["dst"] == {"kind": "register", "register": "r0"}
    assert found["hazards"]["memory_reads"] == 1 and found["hazards"]["execute_writes"] == ["r0"]
    assert c40.encodings()[found["row"]]["picture"].startswith("000 000100 gg")


def test_behind_the_last_address_comes_the_first() -> None:
    branch = c40.assemble("start: b start\n").sections[0].words[0]
    assert c40.disassemble([branch, branch], 0xFFFF_FFFF) == [c40.disassemble(branch, pc) for pc in (0xFFFF_FFFF, 0)]


def test_a_reserved_word_is_no_instruction() -> None:
    assert c40.disassemble(0xFFFFFFFF).startswith(".word") and c40.decode(0xFFFFFFFF) is None


@pytest.mark.parametrize("cpu", ["c40", "c3x"])
def test_a_word_is_found_by_mask_and_match(cpu: str) -> None:
    rows = c40.encodings(cpu=cpu)
    assert len(rows) > 100 and "6.1" in {row["section"] for row in rows}
    rng = random.Random(5)
    decoded = 0
    for row in rows:
        bits = row["picture"].replace(" ", "")
        assert row["mask"] == int("".join("1" if bit in "01" else "0" for bit in bits), 2)
        word = row["match"] | rng.getrandbits(32) & ~row["mask"]
        found = c40.decode(word, cpu=cpu)
        if found is not None:
            of_it = [each for each in rows if word & each["mask"] == each["match"]]
            assert rows[found["row"]] == max(of_it, key=lambda each: each["mask"].bit_count())
            decoded += 1
    assert decoded > len(rows) // 2  # the others: fields that are not legal


def test_words_of_an_eprom(tmp_path: Path) -> None:
    (tmp_path / "rom.bin").write_bytes(bytes([8, 0, 0, 0, 0x78, 0x56, 0x34, 0x12]))
    assert c40.read_rom(tmp_path / "rom.bin", width=8) == [8, 0, 0, 0, 0x78, 0x56, 0x34, 0x12]
    with pytest.warns(UserWarning, match="its first word says 8 bits, as to a boot loader, and width 32"):
        assert c40.read_rom(tmp_path / "rom.bin", width=32) == [8, 0x12345678]
    flat = c40.Processor(board="flat")
    with pytest.warns(UserWarning, match="its first word says 8 bits") as told:
        flat.load_rom(tmp_path / "rom.bin", 0x300000, width=32)
    assert [one.filename for one in told] == [__file__]  # the line that called the package
    with pytest.raises(ValueError, match="width 9: 8, 16 or 32 is expected"):
        c40.read_rom(tmp_path / "rom.bin", width=9)


def test_a_trace_with_labels_does_not_change_when_the_program_moves() -> None:
    traces = []
    for address in (0x300000, 0x310000):
        processor = c40.Processor(c40.assemble(LOOP, sections={".text": address}))
        traces.append(processor.trace(12, labels=True))
    assert traces[0] == traces[1] and "again+0x1 -  subi 1,r0" in traces[0][2]
    plain = c40.Processor(c40.assemble(LOOP)).trace(12)
    assert len(plain) == len(traces[0]) and "00300001 " in plain[1]


def test_labels_need_a_program() -> None:
    with pytest.raises(ValueError, match="labels: no program has been loaded; load one first"):
        c40.Processor().trace(1, labels=True)
