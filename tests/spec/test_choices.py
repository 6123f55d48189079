"""Choices that no document makes: each has a name in the source and a line in docs/fidelity.md, and acts as stated."""

from __future__ import annotations

import re
from typing import Any

import pytest
from cmrc._core import c40, toolchain
from locations import ROOT

FIDELITY = (ROOT / "docs" / "fidelity.md").read_text()
CHOICES = (ROOT / "emulator" / "c40" / "instructions" / "choices.hpp").read_text()
SOURCES = "\n".join(
    path.read_text()
    for room in ("c40", "isa")
    for path in (ROOT / "emulator" / room).rglob("*")
    if path.suffix in (".cpp", ".hpp")
)


def instruction_lines() -> list[list[str]]:
    """The cells of the table under `## Instructions`."""
    section = FIDELITY.split("## Instructions")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


def test_every_named_choice_has_a_line() -> None:
    names = re.findall(r"inline constexpr \w+ (\w+) =", CHOICES)
    assert len(names) >= 10
    assert [name for name in names if f"`choices::{name}`" not in FIDELITY] == []


def test_every_line_says_what_is_known_what_was_chosen_and_where() -> None:
    lines = instruction_lines()
    assert len(lines) >= 35
    for choice, known, chosen, where in lines:
        assert choice and known and chosen, choice
        names = re.findall(r"`([\w:]+)`", where)
        assert names, choice
        for name in names:
            assert name.split("::")[-1] in SOURCES, f"{choice}: {name}"


def test_every_named_choice_is_used() -> None:
    users = SOURCES.replace(CHOICES, "")
    for name in re.findall(r"inline constexpr \w+ (\w+) =", CHOICES):
        assert f"choices::{name}" in users, name


def run(text: str, steps: int, **registers: int) -> Any:
    image = toolchain.assemble("        .text\n" + text, "choice.asm", sections={".text": 0x1000})
    processor = c40.Processor("flat")
    processor.load_image(image)
    processor.pc = 0x1000
    for name, value in registers.items():
        processor.set(name, value)
    for _ in range(steps):
        assert processor.step()["reason"] == "limit"
    return processor


SLOT = "        {}\n"


@pytest.mark.parametrize("slot", [1, 2, 3])
@pytest.mark.parametrize(
    ("instruction", "register", "before", "effect", "slots"),
    [
        ("ldi *ar3++(5),r0", "AR3", 0x2000, 0x2005, {1, 2}),
        ("sti r1,*ar3--(5)", "AR3", 0x2000, 0x1FFB, {1, 2}),
        ("ldpk 77h", "DP", 0, 0x77, {1, 2}),
        ("lda 5,ar4", "AR4", 0, 5, {1}),
        ("lda ar3,ar4", "AR4", 0, 0x2000, {1}),
        ("lda *ar3,ar4", "AR4", 0, 0x1234, {1}),
        ("ldi 5,ar4", "AR4", 0, 0, set()),
        ("ldi 5,r1", "R1", 7, 7, set()),
        ("cmpi r0,r0", "ST", 0, 0, set()),
        ("push r0", "SP", 0x3000, 0x3000, set()),
    ],
)
def test_an_annulled_slot_keeps_what_its_early_stages_did(
    instruction: str, register: str, before: int, effect: int, slots: set[int], slot: int
) -> None:
    body = "".join(SLOT.format(instruction if n == slot else "nop") for n in (1, 2, 3))
    registers = {"AR3": 0x2000, "SP": 0x3000, register: before}
    processor = c40.Processor("flat")
    image = toolchain.assemble(
        f"        .text\n        buat go\n{body}        nop\ngo:     nop\n", "annulled.asm", sections={".text": 0x1000}
    )
    processor.load_image(image)
    processor.poke(0x2000, 0x1234)
    for name, value in registers.items():
        processor.set(name, value)
    processor.pc = 0x1000
    for _ in range(4):
        assert processor.step()["reason"] == "limit"
    assert processor.pc == image.symbols["go"]
    assert processor.get(register) == (effect if slot in slots else before)
    assert processor.peek(0x2000) == 0x1234 and processor.peek(0x3001) == 0


def test_swi_stops_before_itself() -> None:
    processor = run("        swi\n", 0)
    assert processor.step()["reason"] == "software_interrupt"
    assert (processor.pc, processor.instructions) == (0x1000, 0)


@pytest.mark.parametrize("instruction", ["idle", "idle2"])
def test_idle_and_idle2_enable_interrupts_and_wait(instruction: str) -> None:
    processor = run(f"        {instruction}\n        nop\n", 3)
    assert processor.idle and processor.pc == 0x1001
    assert processor.get("ST") == 1 << 13


def test_interlocked_accesses_are_marked_on_the_bus_and_move_data_as_their_plain_forms() -> None:
    image = toolchain.assemble(
        "        .text\n        ldii *ar0,r1\n        stii r1,*+ar0(1)\n        ldfi *ar0,r2\n        stfi r2,*ar0\n"
        "        sigi *ar0,r3\n        ldi *ar0,r4\n        sti r4,*ar0\n",
        "lock.asm",
        sections={".text": 0x2FFC00},
    )
    processor = c40.Processor("default")
    processor.load_image(image)
    processor.pc = 0x2FFC00
    processor.set("AR0", 0xC0000000)
    seen = []
    for value in (0x1111, None, 0x00400000, None, 0x2222, 0x3333, None):
        stop = processor.step()
        assert stop["reason"] == "external_access"
        seen.append((stop["interlocked"], stop["write"], stop["value"] if stop["write"] else 0))
        if value is None:
            processor.complete_write()
        else:
            processor.complete_read(value)
        assert processor.step()["reason"] == "limit"
    assert seen == [(True, False, 0), (True, True, 0x1111), (True, False, 0), (True, True, 0x00400000), (True, False, 0),
                    (False, False, 0), (False, True, 0x3333)]  # fmt: skip
    assert [processor.get(f"R{n}") & 0xFFFFFFFF for n in (1, 3, 4)] == [0x1111, 0x2222, 0x3333]
    assert processor.get("R2") == 0x0040000000
