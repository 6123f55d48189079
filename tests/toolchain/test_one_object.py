"""One object, linked without a map, is the program that the same source makes at once (docs/assembler.md): sources that
are drawn at random, and those that were not so."""

import random
from pathlib import Path

import pytest
from cmrc._core import toolchain

SECTIONS = (".text", ".data", '.sect "tab"', '.sect "a_long_section"', '.sect "dat"')
# What a place is used for: each field of an address, branches, words.
USES = (
    ".word {place}", "ldp {place}", "ldp {place},ar0", "ldpk {place}", "ldi @{place},r0", "sti r0,@{place}",
    "ldhi {place},ar2", "ldhi hi16({place}),ar1", "or lo16({place}),ar1", "or {place},ar0", "and {place},r1",
    "andn {place},r2", "xor {place},r1", "tstb {place},r1", "br {label}", "bu {label}", "call {label}", "rptb {label}",
    "dbu ar0,{label}", ".word {label}-{label}",
)  # fmt: skip


def drawn(seed: int) -> str:
    draw = random.Random(seed)
    lines: list[str] = []
    labels = ["first"]
    uses = 0
    for _ in range(draw.randint(2, 8)):
        lines.append(f"\t{draw.choice(SECTIONS)}")
        for _ in range(draw.randint(0, 5)):
            if draw.random() < 0.5:
                labels.append(f"l{len(labels)}")
                lines.append(f"{labels[-1]}:")
            contents = ["nop", f".word {draw.randint(0, 9)}", f".align {2 ** draw.randint(0, 9)}",
                        f".space {draw.randint(0, 300)}", f".field 1,{draw.randint(1, 20)}", ".float 1.5"]  # fmt: skip
            lines.append("\t" + (draw.choice(contents) if draw.random() < 0.6 else f"USE{uses}"))
            uses += 1
    for number in range(draw.randint(0, 3)):
        labels.append(f"b{number}")
        size = f"{draw.randint(0, 40)},{2 ** draw.randint(0, 6)}"
        reserve = f".bss {labels[-1]},{size}" if draw.random() < 0.5 else f'.usect "{draw.choice("st")}",{size}'
        lines.append(f"\t{reserve}" if reserve.startswith(".bss") else f"{labels[-1]}\t{reserve}")
    label = lambda: draw.choice(labels)
    text = ["first:", *(
        "\t" + draw.choice(USES).format(label=(at := label()), place=at + draw.choice(("", "+1", "-1", "+7", "-3")))
        if line.startswith("\tUSE") else line for line in lines
    )]  # fmt: skip
    return "\n".join(text) + "\n\tnop\n"


def words(image: toolchain.Image) -> dict[int, int]:
    return {section.address + n: word for section in image.sections for n, word in enumerate(section.words)}


def check(source: str) -> None:
    at_once = toolchain.assemble(source)
    linked, _ = toolchain.link([toolchain.assemble_object(source, name="a.o")])
    assert (words(linked), linked.entry) == (words(at_once), at_once.entry), source
    assert {name: linked.symbols[name] for name in at_once.symbols} == at_once.symbols, source


def test_drawn_sources() -> None:
    checked = 0
    for seed in range(400):
        source = drawn(seed)
        try:
            toolchain.assemble(source)
        except toolchain.AssemblyError:  # a distance that does not fit, .word of places in two sections
            continue
        check(source)
        checked += 1
    assert checked > 300


@pytest.mark.parametrize(
    "source",
    [
        pytest.param("start: ldp tab,ar0\n lsh 16,ar0\n or tab,ar0\n .data\ntab: .float 1.5\n", id="low half by OR"),
        pytest.param('start: ldp tab-1\n ldf @tab-1,r0\n .sect "t"\ntab: .float 1,2\n', id="before a section"),
        pytest.param("start: nop\n nop\n .data\nl8:\n .text\n nop\n .word l8\n", id="a label of an empty section"),
        pytest.param('start: nop\n .data\n .align 32\n .word 1\n .sect "tab"\nt: .word t\n', id="a gap"),
    ],
)
def test_sources_that_were_not_so(source: str) -> None:
    check(source)


def test_a_place_before_its_section_on_the_c3x() -> None:
    source = 'start: ldp tab-1\n ldf @tab-1,r0\n .sect "t"\ntab: .float 1,2\n'
    at_once = toolchain.assemble(source, cpu="c3x")
    linked, _ = toolchain.link([toolchain.assemble_object(source, cpu="c3x")])
    assert words(linked) == words(at_once)


def test_the_ends_of_empty_sections() -> None:
    source = ' .global end,edata,etext\nstart: .word end,edata,etext\n .sect "x"\n .word 1\n'
    linked, map_text = toolchain.link([toolchain.assemble_object(source)])
    # .data would lie behind .text, .bss behind x; they are no rows of the map.
    assert words(linked) == {0x300000: 0x300004, 0x300001: 0x300003, 0x300002: 0x300003, 0x300003: 1}
    assert ".data" not in map_text and ".bss" not in map_text


@pytest.mark.parametrize("reserve", [' .sect "dat"\n .align 65536\nx: .word x\n', 'x .usect "dat",3,20000h\n'])
def test_an_alignment_that_an_object_cannot_hold(reserve: str) -> None:
    assert toolchain.assemble(f"start: nop\n{reserve}").symbols["x"] % 65536 == 0
    with pytest.raises(toolchain.AssemblyError, match=r"aligned to \d+ words; an object holds alignments up to 32768"):
        toolchain.assemble_object(f"start: nop\n{reserve}")


def test_no_address_is_left() -> None:
    source = ' .sect "reset"\n .word 1\n .sect "zz"\n .word 5\n .bss v,4\n'
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble(source, sections={"reset": 0xFFFFFFFF})
    assert [row["message"] for row in caught.value.diagnostics] == [
        f"no address is left for the section '{name}' behind 0ffffffffh; --section gives it another place"
        for name in ("zz", ".bss")
    ]


def test_the_whole_name_of_a_section_in_a_program(tmp_path: Path) -> None:
    source = 'start: nop\n .sect "constants_a"\nx: .word 1\n .sect "constants_b"\ny: .word 2\n'
    image = toolchain.assemble(source, sections={"constants_a": 0x300100, "constants_b": 0x300200})
    toolchain.write_coff(image, tmp_path / "a.out")
    again = toolchain.read_coff(tmp_path / "a.out")
    assert [s.name for s in again.sections] == [".text", "constants_a", "constants_b"]
    assert again.symbols == image.symbols
