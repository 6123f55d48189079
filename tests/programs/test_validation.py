"""docs/validation.md is what scripts/validation makes, and the programs behind it do what they are said to do."""

import sys

import pytest
from cmrc import c40
from locations import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import measured

validation = measured.script("validation")


def test_the_page_is_the_commands() -> None:
    text = validation.PAGE.read_text(encoding="utf-8")
    assert validation.page(text) == text


def test_sections_without_their_programs_stay_and_are_not_invented(monkeypatch: pytest.MonkeyPatch) -> None:
    gone = tuple(
        validation.Section(section.name, section.make, section.needs and ROOT / "no such folder")
        for section in validation.SECTIONS
    )
    monkeypatch.setattr(validation, "SECTIONS", gone)
    text = validation.PAGE.read_text(encoding="utf-8")
    assert validation.page(text) == text
    with pytest.raises(LookupError, match="no such folder is not there"):
        validation.page("")


def test_rows_are_convolved_right() -> None:
    row = measured.convolved_row(100)
    assert row.values == row.expected and len(row.values) == 100


@pytest.mark.parametrize("kind", ["reduced", "c"])
def test_a_process_finds_its_registers_as_it_left_them(kind: str) -> None:
    """Two processes that fill every register they may keep with marks of their own before they give way, many times in
    turn."""
    kept = {"reduced": ["ar3"], "c": ["r4", "r5", "r8", "ar3", "ar4", "ar5", "ar6"]}[kind]
    lines = ["        .text"]
    for process, mark in (("one", 100), ("two", 200)):
        lines.append(f"{process}:")
        lines += [f"        ldi {mark + number},{register}" for number, register in enumerate(kept)]
        lines += [f"        call switch_{kind}", "        ldi 0,r0"]
        for number, register in enumerate(kept):
            lines += [f"        cmpi {mark + number},{register}", "        bne wrong"]
        lines += ["        addi 1,r10", f"        b {process}"]
    lines += ["wrong:  b wrong", measured.MEASURED.read_text()]
    chip = c40.Processor(c40.assemble("\n".join(lines)))
    first, second, stack = 0x2FF800, 0x2FF802, 0x2FFC80
    chip.memory[first], chip.memory[second] = second, first
    chip.memory[stack] = chip.address("two")
    chip.memory[second + 1] = stack + {"reduced": 1, "c": 10}[kind]
    chip.registers["SP"], chip.registers["AR7"] = 0x2FFC00, first
    chip.pc = "one"
    assert chip.run(5000, until="wrong").reason == "limit"
    assert chip.registers["R10"] & 0xFFFF_FFFF > 50


def test_operations_on_floats_are_the_executed_ones() -> None:
    fir = measured.executed(measured.script("published_counts").fir(16))
    assert (
        sum(times * len(measured.FLOAT_OPERATION.findall(text)) for text, times in fir.items()) == 2 * 16
    )  # 16 products, 15 sums, one with 0
    assert measured.Work(cycles=100, operations=50).of_peak == 0.25
    assert measured.Work(cycles=100, operations=50).megaflops(40) == pytest.approx(50 / 5.0)  # 100 cycles of 50 ns
