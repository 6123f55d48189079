"""Text to words and back: against the GNU tools' encodings, and as a fixed point over every row and random words."""

import random
from pathlib import Path
from typing import Any

import corpus
import pytest
from cmrc._core import isa, toolchain

HERE = Path(__file__).parent
ORIGIN = 0x300000


def assemble_words(lines: list[str], origin: int = ORIGIN) -> list[int]:
    image = toolchain.assemble("".join(f"\t{line}\n" for line in lines), sections={".text": origin}, dialect="gnu")
    assert [section.name for section in image.sections] == [".text"]
    return list(image.sections[0].words)


def test_the_596_lines_of_the_gnu_tools_assemble_to_their_words() -> None:
    lines = [
        line.split(maxsplit=2)
        for line in (HERE.parent / "isa" / "encodings.txt").read_text().splitlines()
        if not line.startswith("#")
    ]
    source = "L0:\n" + "".join(f"\t{text}\n" for _, _, text in lines)
    words = toolchain.assemble(source, sections={".text": 0}, dialect="gnu").sections[0].words
    assert [f"{word:08x}" for word in words] == [word for _, word, _ in lines]


@pytest.mark.parametrize("name", ["fir", "branch", "controller"])
def test_gnu_sources_assemble_to_the_gnu_assemblers_words(name: str) -> None:
    image = toolchain.assemble_file(HERE / "bench" / f"{name}.s", sections={".text": 0x1000}, dialect="gnu")
    expected = [int(word, 16) for word in (HERE / "bench" / f"{name}.hex").read_text().split()]
    assert list(image.sections[0].words) == expected
    assert image.entry == 0x1000


def round_trip(words: list[int]) -> None:
    lines = [isa.disassemble(word, ORIGIN + i) for i, word in enumerate(words)]
    again = assemble_words(lines)
    wrong = [(f"{a:08x}", f"{b:08x}", line) for a, b, line in zip(words, again, lines, strict=True) if a != b]
    assert not wrong


def test_text_to_words_to_text_to_words_is_a_fixed_point_for_every_row_and_operand_form() -> None:
    words = corpus.every_form()
    texts = [isa.disassemble(word, ORIGIN + i) for i, word in enumerate(words)]
    again = assemble_words(texts)
    assert again == words
    assert [isa.disassemble(word, ORIGIN + i) for i, word in enumerate(again)] == texts


def test_the_corpus_covers_every_row_condition_and_addressing_form() -> None:
    rows = isa.rows()
    fields = [corpus.fields(row) for row in rows]
    words: list[list[int]] = [[] for _ in rows]
    conditions: list[set[Any]] = [set() for _ in rows]
    modes: list[set[int]] = [set() for _ in rows]
    for word in corpus.every_form():
        d = isa.decode(word)
        words[d["row"]].append(word)
        conditions[d["row"]].add(d["condition"])
        modes[d["row"]] |= {o["modn"] for o in (d["src1"], d["src2"], d["dst"]) if o and o["kind"] == "indirect"}
    for i, row in enumerate(rows):
        name = row["mnemonic"]
        assert words[i], name
        if "c" in fields[i]:
            assert len(conditions[i]) == 20, name
        if "s" in fields[i]:  # general addressing
            assert modes[i] in (set(), set(range(26))), name
        for letter in {"i", "j"} & fields[i].keys() - ({"i", "j"} if "t" in fields[i] else set()):
            shift = fields[i][letter][0]
            assert len({word >> shift & 255 for word in words[i]}) == 26 * 8, name


@pytest.mark.parametrize("letter", ["type1", "type2"])
def test_both_types_of_three_operands_occur_with_every_pair_of_kinds(letter: str) -> None:
    type2 = letter == "type2"
    pairs = {
        ((d["word"] >> 21) & 3, d["mnemonic"]) for d in map(isa.decode, corpus.every_form()) if d["word"] >> 28 == (3 if type2 else 2)
    }  # fmt: skip
    names = {mnemonic for _, mnemonic in pairs}
    floats = {"addf3", "cmpf3", "mpyf3", "subf3"}
    assert len(names) == 19
    for name in names:
        expected = {1, 3} if type2 and name in floats else {0, 1, 2, 3}
        assert {t for t, mnemonic in pairs if mnemonic == name} == expected, name


def test_parallel_halves_in_the_other_order_give_the_same_words() -> None:
    rng = random.Random(5)
    parallel = [word for word in corpus.every_form() if word >> 30 == 3 or word >> 28 == 8]
    words, swapped = rng.sample(parallel, 6000), []
    for word in words:
        first, second = isa.disassemble(word).split(" || ")
        if first.split()[0] == second.split()[0]:  # Two loads or two stores: numbers tell the halves apart.
            first, second = (half.replace(" ", f"{number} ", 1) for half, number in ((first, 2), (second, 1)))
        swapped.append(f"{second} || {first}")
    assert assemble_words(swapped) == words


def test_the_3_of_three_operands_may_always_be_left_out() -> None:
    rng = random.Random(6)
    compares = ("cmpf3", "cmpi3", "tstb3")  # Of two operands, these would be general ones.
    three = [word for word in corpus.every_form() if word >> 29 == 1 or word >> 28 in (8, 12, 13, 14, 15)]
    words = [word for word in rng.sample(three, 4000) if not isa.disassemble(word).startswith(compares)]
    texts = [
        " || ".join(
            half.replace("3 ", " ", 1) if half.split()[0][-1] == "3" else half
            for half in isa.disassemble(word).split(" || ")
        )
        for word in words
    ]
    assert assemble_words(texts) == words


def field_values(width: int, rng: random.Random) -> list[int]:
    top = (1 << width) - 1
    return sorted({0, 1, top, top >> 1, min((top >> 1) + 1, top), rng.getrandbits(width), rng.getrandbits(width)})


def test_every_row_with_the_corner_values_of_every_field_is_a_fixed_point() -> None:
    rng = random.Random(40)
    words = []
    for row in isa.rows():
        picture = row["picture"].replace(" ", "")
        letters = [letter for letter in dict.fromkeys(picture) if letter.isalpha()]
        choices = [
            [value << (31 - picture.rindex(letter)) for value in field_values(picture.count(letter), rng)]
            for letter in letters
        ]
        tries = {row["match"] | sum(rng.choice(values) for values in choices) for _ in range(400)}
        legal = [word for word in sorted(tries) if isa.decode(word) is not None][:150]
        assert legal, row["mnemonic"]
        words += legal
    round_trip(words)


def test_every_indirect_form_is_a_fixed_point_in_every_place() -> None:
    general = [
        0x08400000 | modn << 11 | ar << 8 | disp for modn in range(26) for ar in (0, 7) for disp in (0, 1, 2, 255)
    ]
    type1 = [0x20E00000 | a << 11 | 1 << 8 | b << 3 | 2 for a in range(26) for b in range(26)]
    type2 = [0x31600000 | a << 8 | b for a in range(0, 256, 7) for b in range(256)]
    type2 += [0x31200000 | 5 << 8 | b for b in range(256)]
    round_trip([word for word in general + type1 + type2 if isa.decode(word) is not None])


def test_every_short_float_is_a_fixed_point() -> None:
    """All 65536 of LDF and LDM: non-canonical zeros and LDM's idle exponents come back by their bits."""
    round_trip([0x07600000 | bits for bits in range(65536)])
    round_trip([0x09600000 | bits for bits in range(65536)])


def test_ldm_takes_the_mantissa_alone() -> None:
    """c40-isa.md 6.1: the assembler clears the exponent's bits. A word that has them comes back as a field."""
    values = "3.0", "0.5712890625", "-1.5", "0.0"
    assert assemble_words([f"ldm {value},r0" for value in values]) == [0x09600400, 0x09600124, 0x09600C00, 0x09600000]
    assert isa.disassemble(0x09601400, 0) == "ldm =0x1400,r0"
    round_trip([0x09600000 | field for field in (0x1400, 0x8000, 0x0124, 0x0C00, 0xF7FF)])


def test_random_words_are_fixed_points_reserved_ones_as_data() -> None:
    rng = random.Random(1999)
    rows = isa.rows()
    words = [(rng.getrandbits(32) & ~row["mask"] & 0xFFFFFFFF) | row["match"] for row in rng.choices(rows, k=60_000)]
    words += [rng.getrandbits(32) for _ in range(40_000)]
    assert sum(isa.decode(word) is None for word in words) > 10_000
    assert sum(isa.decode(word) is not None for word in words) > 30_000
    round_trip(words)


@pytest.mark.parametrize(
    ("written", "same_as"),
    [
        # The 3 of three-operand mnemonics may be left out, and the destination if it is the last source.
        ("addi r1,r2,r3", "addi3 r1,r2,r3"),
        ("addi3 r1,r2", "addi3 r1,r2,r2"),
        ("cmpi *ar0,*ar1", "cmpi3 *ar0,*ar1"),
        ("mpyf *ar0++,*ar1++,r0 || addf r0,r2,r2", "mpyf3 *ar0++(1),*ar1++(1),r0 || addf3 r0,r2,r2"),
        ("mpyf3 *ar0,*ar1,r0 || addf3 r1,r2", "mpyf3 *ar0,*ar1,r0 || addf3 r1,r2,r2"),
        # One operand where source and destination are the same register.
        ("absi r1", "absi r1,r1"),
        ("negf f3", "negf r3,r3"),
        # Commutative operands in either order, where one order has an encoding.
        ("addi3 r1,5,r0", "addi3 5,r1,r0"),
        ("addi3 r1,*+ar2(9),r0", "addi3 *+ar2(9),r1,r0"),
        ("addf3 r4,*ar1,r5 || stf r6,*ar2", "addf3 *ar1,r4,r5 || stf r6,*ar2"),
        ("mpyf3 r5,*ar2,r1 || subf3 r4,*ar1,r3", "mpyf3 *ar2,r5,r1 || subf3 r4,*ar1,r3"),
        # Halves in either order, numbered halves.
        ("stf r6,*ar2 || mpyf3 *ar1,r4,r5", "mpyf3 *ar1,r4,r5 || stf r6,*ar2"),
        ("sti1 r6,*ar2 || sti2 r5,*ar1", "sti r5,*ar1 || sti r6,*ar2"),
        ("sti2 r5,*ar1 || sti1 r6,*ar2", "sti r5,*ar1 || sti r6,*ar2"),
        ("ldf1 *ar2,r3 || ldf2 *ar1,r5", "ldf *ar1,r5 || ldf *ar2,r3"),
        # A displacement that is left out is 1; of 0 it is none.
        ("ldi *+ar0,r0", "ldi *+ar0(1),r0"),
        ("ldi *ar0--%,r0", "ldi *ar0--(1)%,r0"),
        ("ldi *+ar0(0),r0", "ldi *ar0,r0"),
        ("LDI *AR0++(IR0)B,R0", "ldi *ar0++(ir0)b,r0"),
        # Short forms and synonyms of conditions.
        ("rets", "retsu"),
        ("reti", "retiu"),
        ("retid", "retiud"),
        ("trap 5", "trapu 5"),
        ("b r11", "bu r11"),
        ("bd r11", "bud r11"),
        ("db ar0,r1", "dbu ar0,r1"),
        ("dbd ar0,r1", "dbud ar0,r1"),
        ("bz r1", "beq r1"),
        ("bnzd r1", "bned r1"),
        ("bnnat r1", "bgeat r1"),
        ("ldip r1,r2", "ldigt r1,r2"),
        ("ldfc r1,r2", "ldflo r1,r2"),
        # STIK by STI, LDP by LDIU, float operands under either name.
        ("sti -5,@6", "stik -5,@6"),
        ("ldp 30h,dp", "ldiu 30h,dp"),
        ("addf f1,f2", "addf r1,r2"),
        ("ldf 1,r0", "ldf 1.0,r0"),
        # Numbers.
        ("ldi 0FFh,r0", "ldi 255,r0"),
        ("ldi 101b,r0", "ldi 5,r0"),
        ("ldi 0b101,r0", "ldi 5,r0"),
        ("ldi 17q,r0", "ldi 15,r0"),
        ("ldi 017,r0", "ldi 17,r0"),
        ("ldi 08,r0", "ldi 8,r0"),
        ("ldi 017q,r0", "ldi 15,r0"),
        ("ldi 'A',r0", "ldi 65,r0"),
        ("ldi ';',r0", "ldi 59,r0"),
        ("ldi (2+3)*4-1<<2,r0", "ldi 76,r0"),
        ("ldi ~5&0Fh|30h,r0", "ldi 58,r0"),
        ("ldi 7%4+(5==5)+(1<2),r0", "ldi 5,r0"),
        ("ldi -7/2,r0", "ldi -3,r0"),
        ("ldf 3.0/4,r0", "ldf 0.75,r0"),
        ("ldf 0.5*-3,r0", "ldf -1.5,r0"),
    ],
)
def test_optional_forms_mean_what_their_full_forms_mean(written: str, same_as: str) -> None:
    assert assemble_words([written]) == assemble_words([same_as])


def test_type_1_is_preferred_and_type_2_can_be_forced() -> None:
    """As GNU as chooses; words in the style of c40-isa.md 13: type 2 has bit 28."""
    assert assemble_words(["addi3 *+ar4(1),r1,r2"])[0] >> 28 == 2
    assert assemble_words(["addi3 *+ar4(=1),r1,r2"])[0] >> 28 == 3
    assert assemble_words(["addi3 *+ar4(2),r1,r2"])[0] >> 28 == 3
    assert assemble_words(["addi3 *ar4,*+ar5(7),r2"])[0] >> 28 == 3
    assert assemble_words(["ldi *+ar0(=0),r0"]) == [0x08400000]


def test_parallel_bars_may_stand_on_the_next_line() -> None:
    source = "start:  mpyf3 *ar0++(1),*ar1++(1),r0   ; product\n\n; a comment between\n   ||   addf3 r0,r2,r2\n|| \n"
    with pytest.raises(toolchain.AssemblyError):
        toolchain.assemble(source)
    image = toolchain.assemble(source.replace("|| \n", ""))
    assert list(image.sections[0].words) == assemble_words(["mpyf3 *ar0++,*ar1++,r0 || addf3 r0,r2,r2"])


def test_branch_targets_are_labels_addresses_or_registers() -> None:
    words = assemble_words(["b 0x300000", "bd $", "call $+2", "dbnzd ar3,$-3", "rptb $+1"])
    targets = [isa.decode(word)["src1"]["value"] + i for i, word in enumerate(words)]
    assert targets == [0, 1, 4, 0, 5]
