"""Relocatable objects and the linker: compared with GNU as and ld, and with one assembly of all sources; what the
linker refuses."""

import random
import subprocess
from pathlib import Path

import pytest
from cmrc._core import isa, toolchain
from cmrc_test import forms
from linked import contents, link, link_errors
from locations import ROOT

HERE = Path(__file__).parent / "linking"
MAP = """
[memory]
local = { origin = 0x300000, length = 0x100000 }
[sections]
".text" = "local"
".data" = { address = 0x300100 }
"more" = { address = 0x300200 }
".bss" = { address = 0x300300 }
"""


def from_gnu(name: str) -> toolchain.Object:
    return forms.read_object((HERE / f"{name}.gnu.o").read_bytes(), name)


def from_us(name: str) -> toolchain.Object:
    return toolchain.assemble_object((HERE / f"{name}.s").read_text(), name=name, dialect="gnu")


@pytest.mark.parametrize("first", [from_gnu, from_us])
@pytest.mark.parametrize("second", [from_gnu, from_us])
@pytest.mark.parametrize("version", [0, 1, 2])
def test_objects_of_either_assembler_link_to_what_gnu_ld_makes_of_them(first, second, version: int) -> None:  # type: ignore[no-untyped-def]
    expected = toolchain.read_coff(HERE / "gnu.out")
    again = [forms.read_object(forms.object_bytes(o, version), o.name) for o in (first("a"), second("b"))]
    assert [o.version for o in again] == [version, version]
    image, _ = toolchain.link(again, map=MAP)
    assert contents(image) == contents(expected)
    assert image.entry == expected.entry
    assert all(
        image.symbols[name] == value
        for name, value in expected.symbols.items()
        if not name.startswith(".") and name != "more"
    )


def test_relocations_are_those_of_gnu_as() -> None:
    def of(o: toolchain.Object) -> list[tuple[str, int, str, str]]:
        return [
            (s.name, r.offset, r.type, "" if r.type.startswith("R_PCR") else o.symbols[r.symbol].name)
            for s in o.sections for r in s.relocations
        ]  # fmt: skip

    assert of(from_us("a")) == of(from_gnu("a"))
    assert {kind for _, _, kind, _ in of(from_us("a"))} == {
        "R_PARTMS8",
        "R_PARTLS16",
        "R_PCR24",
        "R_PCRWORD",
        "R_RELLONG",
    }


@pytest.mark.parametrize(
    "source",
    [*sorted((ROOT / "tests/toolchain/bench").glob("*.s")), ROOT / "c40_programs/dsp.asm"],
    ids=lambda p: p.name,
)
def test_one_object_linked_by_the_standard_map_is_the_program_assembled_at_once(
    source: Path, tmp_path: Path, emulator: Path
) -> None:
    include = ["-I", ROOT / "c40_programs/include", "-I", ROOT / "c40_programs"]
    at_once, linked = tmp_path / "at_once.out", tmp_path / "linked.out"
    subprocess.run([emulator, "asm", source, "-o", at_once, *include], check=True)
    subprocess.run([emulator, "asm", source, "-c", "-o", tmp_path / "x.o", *include], check=True)
    subprocess.run([emulator, "link", tmp_path / "x.o", "-o", linked], check=True)
    a, b = toolchain.read_coff(at_once), toolchain.read_coff(linked)
    assert contents(a) == contents(b) and a.entry == b.entry and len(contents(a)[".text"][1]) > 10
    assert {n: v for n, v in a.symbols.items() if not n.startswith(".")} == {
        n: v for n, v in b.symbols.items() if not n.startswith(".")
    }


def test_halves_of_addresses_carry_into_each_other() -> None:
    """The high half of table+8000h depends on the low half, so the object keeps the low half too."""
    use = "\t.ref table\n\tldhi hi16(table+8000h),ar0\n\tor lo16(table+8000h),ar0\n\tldp @table+8000h\n\tldhi table>>16,ar1\n\tor table&0FFFFh,ar1\n"
    image = link(use, "\t.def table\n\t.data\n\t.space 5\ntable: .word table\n", map="""
[memory]
all = { origin = 0, length = 0x100000000 }
[sections]
".text" = { address = 0x300000 }
".data" = { address = 0x8000FFF0 }
""")  # fmt: skip
    text = [isa.disassemble(word) for word in contents(image)[".text"][1]]
    assert text == ["ldhi 32769,ar0", "or 32757,ar0", "ldpk 32769", "ldhi 32768,ar1", "or 65525,ar1"]
    assert contents(image)[".data"][1][5] == 0x8000FFF5


def test_the_high_half_of_an_address_in_the_same_object_follows_its_symbol() -> None:
    """The symbol's offset in the object is 5: the linker subtracts 5 before it adds the symbol's address."""
    image = link("\tldhi hi16(table+9),ar0\n\tor lo16(table+9),ar0\n\tldhi hi16(table+10),ar1\n\t.def table\n\tldhi hi16(table+11),ar2\n\t.data\n\t.space 5\ntable: .word table\n", map="""
[memory]
all = { origin = 0, length = 0x100000000 }
[sections]
".text" = { address = 0x300000 }
".data" = { address = 0x8000FFF0 }
""")  # fmt: skip
    text = [isa.disassemble(word) for word in contents(image)[".text"][1]]
    assert text == ["ldhi 32768,ar0", "or 65534,ar0", "ldhi 32768,ar1", "ldhi 32769,ar2"]


def test_branches_between_objects_reach_what_they_name_wherever_it_lies() -> None:
    far = "\t.def here,there\n\t.text\nhere: nop\n\t.space 40000\nthere: nop\n"
    for origin in (0x300000, 0x2FF800 - 20000):
        image = link(f"\t.ref here,there\n\tb here\n\tcall there\n\tbrd there\n\tnop\n\tnop\n\tnop\n\tbr 0x300000\n\tlaj {origin:#x}\n", far, map=f"""
[memory]
all = {{ origin = {origin:#x}, length = 0x100000 }}
""")  # fmt: skip
        words = contents(image)[".text"][1]
        here, there = image.symbols["here"], image.symbols["there"]
        targets = [
            isa.disassemble(word, origin + i).split()[1] for i, word in enumerate(words[:8]) if i not in (3, 4, 5)
        ]
        assert targets == [hex(here), hex(there), hex(there), "0x300000", hex(origin)]


def test_a_conditional_branch_into_a_section_of_more_than_32767_words() -> None:
    """An offset from the section's start would not fit into 16 bits. A reference to a symbol at the target does."""
    source = '\t.text\n\tbz target\n\t.sect "big"\n\t.space 40000\n\tnop\ntarget: nop\n'
    image = link(source, map='[memory]\nm = { origin = 0, length = 0x10000 }\n[sections]\n"big" = "m"\n')
    text_at, words = contents(image)[".text"]
    assert isa.disassemble(words[0], text_at) == f"beq {image.symbols['target']:#x}" == "beq 0x9c41"


def test_sections_of_one_name_follow_each_other_aligned() -> None:
    image = link(
        "\t.word 1\n\t.bss x,3\n", "\t.text\n\t.align 8\n\t.word 2\n\t.bss y,2,4\n\t.def y\n", "\t.word 3\n",
    )  # fmt: skip
    assert contents(image)[".text"][1] == [1, 0, 0, 0, 0, 0, 0, 0, 2, 3]
    assert image.symbols["y"] % 4 == 0 and image.symbols["y"] >= image.symbols["x"] + 3


def test_a_blocked_section_stays_within_a_page() -> None:
    image = link(
        '\t.space 65000\nx .usect "pagewise",1000,1\n\t.def x\n',
        map="[memory]\nm = { origin = 0x300000, length = 0x100000 }\n",
    )
    assert image.symbols["x"] == 0x310000


def test_local_symbols_of_several_objects_do_not_clash_and_global_ones_do() -> None:
    image = link("\t.ref f\nloop: b loop\n\tb f\n", "\t.def f\nloop: b loop\nf: rets\n")
    assert [isa.disassemble(w, 0x300000 + i) for i, w in enumerate(contents(image)[".text"][1])] == [
        "bu 0x300000", "bu 0x300003", "bu 0x300002", "retsu",
    ]  # fmt: skip
    assert link_errors("\t.def f\nf: nop\n", "\t.def f\nf: nop\n") == ["b.o: 'f' is defined already in a.o"]


def test_what_tis_linker_defines_by_itself() -> None:
    image = link('\t.ref cinit,etext,end\n\t.word cinit,etext,end\n\t.sect ".cinit"\n\t.word 1,x,5\n\t.bss x,1\n')
    (at, text), (cinit_at, cinit) = contents(image)[".text"], contents(image)[".cinit"]
    x = image.symbols["x"]
    assert (text, cinit) == ([cinit_at, at + 3, x + 1], [1, x, 5, 0])  # closed by a count of 0
    assert image.symbols["etext"] == at + 3 and "edata" not in image.symbols  # nobody refers to edata
    assert contents(link("\t.ref cinit\n\t.word cinit\n"))[".text"][1] == [0xFFFFFFFF]


def test_the_memory_map_gives_places_sizes_symbols_and_the_entry() -> None:
    image = link("\t.ref limit\n\t.def go\n\tnop\ngo: .word limit\n\t.sect \"vectors\"\n\t.word go\n", map="""
entry = "go"
others = "slow"
[memory]
fast = { origin = 0x2FF800, length = 0x800 }
slow = { origin = 0x40000000, length = 0x1000 }
[sections]
"vectors" = { memory = "fast", align = 0x200 }
".stack" = { memory = "fast", size = 0x100 }
[symbols]
limit = 0xDEADBEEF
""")  # fmt: skip
    assert {s.name: (s.address, s.size, s.loaded) for s in image.sections} == {
        "vectors": (0x2FF800, 1, True), ".stack": (0x2FF801, 0x100, False), ".text": (0x40000000, 2, True),
    }  # fmt: skip
    assert image.entry == 0x40000001 and contents(image)[".text"][1][1] == 0xDEADBEEF


@pytest.mark.parametrize(("given", "words"), [(0, 0x400), (1, 0x400), (2, 2)])
def test_a_stack_and_a_heap_without_a_size_get_one(given: int, words: int) -> None:
    """TI's run-time library has a stack of 0 words and a heap of 1."""
    image = link(f'\tnop\ns .usect ".stack",{given}\nh .usect ".sysmem",{given}\no .usect "other",{given}\n')
    sizes = {section.name: section.size for section in image.sections}
    assert (sizes[".stack"], sizes[".sysmem"], sizes.get("other", 0)) == (words, words, given)


def test_all_errors_of_a_link_come_at_once_with_object_and_place() -> None:
    errors = link_errors(
        "\t.ref lost,far\n\tnop\n\tcall lost\n\t.word lost\n",
        "\t.ref gone\n\t.def f\nf: .word gone\n",
        "\t.def f\nf: nop\n",
    )
    assert sorted(errors) == [
        "a.o: .text+1h: undefined symbol 'lost'", "b.o: .text+0h: undefined symbol 'gone'", "c.o: 'f' is defined already in b.o",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("instruction", "message"),
    [
        ("bz far", "a distance of 1048574 does not fit in the 16 bits of R_PCRWORD"),
        ("br away", "does not fit in the 24 bits of R_PCR24"),
        ("ldi far,r0", "the value 4194304 does not fit in the 16 bits of R_RELWORD"),
    ],
)
def test_relocations_out_of_reach(instruction: str, message: str) -> None:
    where = """
[memory]
all = { origin = 0, length = 0x100000000 }
[sections]
".text" = { address = 0x300000 }
"far" = { address = 0x400000 }
"away" = { address = 0x40000000 }
"""
    errors = link_errors(
        f"\t.ref far,away\n\tnop\n\t{instruction}\n",
        '\t.def far,away\n\t.sect "far"\nfar: nop\n\t.sect "away"\naway: nop\n',
        map=where,
    )
    assert len(errors) == 1 and errors[0].startswith("a.o: .text+1h: ") and message in errors[0]


@pytest.mark.parametrize(
    ("source", "placement", "message"),
    [
        ("\t.space 2000h\n", "", "section '.text' of 8192 words does not fit in the memory 'm' (4096 words at 00001000h, 4096 left)"),
        ("\t.space 20h\n\t.data\n\t.word 1\n", '".text" = { address = 0x1000 }\n".data" = { address = 0x1010 }', "overlap"),
        ("\t.space 20h\n", '".text" = { memory = "m", address = 0x1FF0 }', "does not lie in the memory 'm'"),
        ("\tnop\n\t.align 16\n", '".text" = { address = 0x1001 }', "must be aligned to 16 words"),
        ("\t.space 20h\n", '".text" = { address = 0xFFFFFFF0 }', "passes the end of the address space"),
    ],
)  # fmt: skip
def test_sections_that_cannot_be_placed(source: str, placement: str, message: str) -> None:
    errors = link_errors(source, map=f"[memory]\nm = {{ origin = 0x1000, length = 0x1000 }}\n[sections]\n{placement}\n")
    assert len(errors) == 1 and message in errors[0]


@pytest.mark.parametrize(
    ("instruction", "target", "reaches"),
    [
        ("bz far", 0x1000002 + 0x7FFF, True), ("bz far", 0x1000002 + 0x8000, False),  # 16 bits from the next word on
        ("bz far", 0x1000002 - 0x8000, True), ("bz far", 0x1000002 - 0x8001, False),
        ("br far", 0x1000002 + 0x7FFFFF, True), ("br far", 0x1000002 + 0x800000, False),  # 24 bits
        ("br far", 0x1000002 - 0x800000, True), ("br far", 0x1000002 - 0x800001, False),
        ("ldi far,r0", 0xFFFF, True), ("ldi far,r0", 0x10000, False), ("ldi far,r0", 0xFFFF8000, True),
        ("ldi far,r0", 0xFFFF7FFF, False),
    ],
)  # fmt: skip
def test_the_last_places_within_reach(instruction: str, target: int, reaches: bool) -> None:
    source = f"\t.ref far\n\tnop\n\t{instruction}\n"
    where = f"""
[memory]
all = {{ origin = 0, length = 0x100000000 }}
[sections]
".text" = {{ address = 0x1000000 }}
[symbols]
far = {target:#x}
"""
    if not reaches:
        [error] = link_errors(source, map=where)
        assert "does not fit in the" in error
        return
    word = contents(link(source, map=where))[".text"][1][1]
    if instruction.startswith("ldi"):
        assert word & 0xFFFF == target & 0xFFFF
    else:
        assert isa.disassemble(word, 0x1000001).split()[1] == hex(target)


MEMORY = "[memory]\nm = {{ origin = 0x1000, length = {length} }}\n[sections]\n{sections}\n"


def test_a_section_may_fill_its_memory_to_the_last_word_and_no_further() -> None:
    for placement in ('".text" = "m"', '".text" = { memory = "m", address = 0x1000 }', ""):
        full = link("\t.space 20h\n", map=MEMORY.format(length=0x20, sections=placement))
        assert [(s.address, s.size) for s in full.sections] == [(0x1000, 0x20)]
        [error] = link_errors("\t.space 21h\n", map=MEMORY.format(length=0x20, sections=placement))
        assert "33 words" in error and "32 words at 00001000h" in error


def test_the_second_section_of_a_memory_may_fill_what_is_left() -> None:
    both = MEMORY.format(length=0x20, sections='".text" = "m"\n".data" = "m"')
    full = link("\t.space 18h\n\t.data\n\t.space 8\n", map=both)
    assert [(s.name, s.address, s.size) for s in full.sections] == [(".text", 0x1000, 0x18), (".data", 0x1018, 8)]
    [error] = link_errors("\t.space 18h\n\t.data\n\t.space 9\n", map=both)
    assert error == "section '.data' of 9 words does not fit in the memory 'm' (32 words at 00001000h, 8 left)"


def test_sections_at_given_places_may_touch_and_not_share_a_word() -> None:
    def places(data: int) -> str:
        both = f'".text" = {{ address = 0x1010 }}\n".data" = {{ address = {data:#x} }}'
        return MEMORY.format(length=0x100, sections=both)

    source = "\t.space 10h\n\t.data\n\t.space 4\n"
    for data in (0x1020, 0x100C):
        assert len(link(source, map=places(data)).sections) == 2
    for data in (0x101F, 0x100D, 0x1010, 0x1014):
        assert link_errors(source, map=places(data)) == [
            f"the sections .text (16 words at 00001010h) and .data (4 words at {data:08X}h) overlap"]  # fmt: skip


def test_a_free_section_goes_into_the_gap_only_where_it_fits() -> None:
    """Behind .text at 1000h there are 8 words before `fixed`."""

    def at(words: int) -> int:
        image = link(f'\t.space 10h\n\t.data\n\t.space {words}\n\t.sect "fixed"\n\t.space 4\n', map=MEMORY.format(
            length=0x100, sections='"fixed" = { address = 0x1018 }\n".text" = "m"\n".data" = "m"'))  # fmt: skip
        return int(contents(image)[".data"][0])

    assert (at(8), at(9)) == (0x1010, 0x101C)


def test_an_aligned_section_stays_where_its_alignment_is_met() -> None:
    both = '".data" = { memory = "m", align = 16 }\n".text" = { address = 0x1000 }'
    for words, start in ((16, 0x1010), (17, 0x1020), (15, 0x1010)):
        source = f"\t.space {words}\n\t.data\n\t.word 1\n"
        assert contents(link(source, map=MEMORY.format(length=0x100, sections=both)))[".data"][0] == start
    assert contents(link("\t.data\n\tnop\n", map=MAP.replace("0x300100", "0xFFFFFFFF")))[".data"][0] == 0xFFFFFFFF


def test_a_blocked_section_of_a_whole_page_and_one_that_just_fits_before_its_end() -> None:
    """A blocked section crosses no border of 64 K words, unless it is longer than a page."""

    def at(space: int, words: int) -> int:
        source = f'\t.space {space}\nx .usect "pagewise",{words},1\n\t.def x\n'
        image = link(source, map="[memory]\nm = { origin = 0x300000, length = 0x100000 }\n")
        return int(image.symbols["x"])

    assert at(0x10000 - 1000, 1000) == 0x30FC18  # up to the page's last word
    assert at(0x10000 - 999, 1000) == 0x310000
    assert at(8, 0x10000) == 0x310000
    assert at(8, 0x10001) == 0x300008


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("memory = 3", "<map>:1: memory: a table, [memory], is expected"),
        ("[memory]\nm = { origin = 0 }", "<map>:2: memory.m: length is missing"),
        (
            "[memory]\nm = { origin = 0, length = 0x100000001 }",
            "<map>:2: memory.m.length: an integer from 1 to 4294967296 is expected",
        ),
        ("[memory]\na = { origin = 0, length = 8 }\nb = { origin = 4, length = 8 }", "'a' and 'b' overlap"),
        (
            '[memory]\nm = { origin = 0, length = 8 }\n[sections]\n".text" = "n"',
            "<map>:4: .text: there is no memory 'n'; m is expected",
        ),
        (
            "[memory]\nm = { origin = 0, length = 8, speed = 3 }",
            "<map>:2: no such key memory.m.speed; known are origin, length",
        ),
        (
            "[memory]\nm = { origin = -1, length = 8 }",
            "<map>:2: memory.m.origin: an integer from 0 to 4294967295 is expected",
        ),
        (
            "[memory]\nm = { origin = 0, length = 8 }\n[sections]\nx = { align = 3 }",
            "<map>:4: x.align: a power of 2 is expected",
        ),
        ("# empty", "<map>: there is no memory; [memory] with NAME = "),
        ("[memory]", "<map>: there is no memory; [memory] with NAME = "),
        (
            "[memory]\nm = { origin = 0 }\nn = 3\n[sektions]",
            (
                "<map>:2: memory.m: length is missing\n<map>:3: memory.n: { origin = ADDRESS, length = WORDS } is expected\n"
                "<map>:4: no such key sektions; known are entry, others, c_model, memory, sections, symbols; did you mean"
            ),
        ),
        ("[memory", "<map>:1:"),
    ],
)
def test_faulty_memory_maps_are_refused_at_their_place(text: str, message: str) -> None:
    with pytest.raises(toolchain.MemoryMapError, match="<map>") as caught:
        toolchain.link([toolchain.assemble_object("\tnop\n")], map=text)
    assert message in str(caught.value)


def test_members_of_a_library_come_in_when_they_are_wanted(tmp_path: Path, emulator: Path) -> None:
    sources = {
        "main": "\t.ref f\n\tcall f\n", "a_member_of_a_long_name": "\t.def f\n\t.ref g\nf: b g\n",
        "g": "\t.def g\ng: rets\n", "h": "\t.def h\n\t.ref lost\nh: b lost\n",
    }  # fmt: skip
    for name, text in sources.items():
        (tmp_path / f"{name}.asm").write_text(text)
        subprocess.run([emulator, "asm", f"{name}.asm", "--object", "-o", f"{name}.o"], cwd=tmp_path, check=True)
    subprocess.run(["ar", "rc", "lib.a", "h.o", "g.o", "a_member_of_a_long_name.o"], cwd=tmp_path, check=True)
    subprocess.run(
        [emulator, "link", "main.o", "lib.a", "-o", "p.out", "--map-output", "p.map"], cwd=tmp_path, check=True
    )
    image = toolchain.read_coff(tmp_path / "p.out")
    text = [isa.disassemble(w, 0x300000 + i) for i, w in enumerate(image.sections[0].words)]
    assert text == ["call 0x300001", "bu 0x300002", "retsu"]
    listed = (tmp_path / "p.map").read_text()
    assert "lib.a(a_member_of_a_long_name.o)" in listed and "00300002h  g" in listed and "h.o" not in listed
    damaged = (tmp_path / "lib.a").read_bytes()
    for length in (9, 40, 70, 200, len(damaged) - 1):
        (tmp_path / "cut.a").write_bytes(damaged[:length])
        failed = subprocess.run(
            [emulator, "link", "main.o", "cut.a", "-o", "q.out"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert failed.returncode == 2 and "cut.a" in failed.stderr
    assert not list(tmp_path.glob("q.out*"))


def test_the_command_lines_errors(tmp_path: Path, emulator: Path) -> None:
    (tmp_path / "a.asm").write_text("\t.ref f\n\tcall f\n")

    def run(*arguments: str) -> tuple[int, str]:
        done = subprocess.run([emulator, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    status, message = run("asm", "a.asm", "-o", "a.out")
    assert status == 2 and "a.asm:2:7: error: undefined symbol 'f', which another object is to define" in message
    assert run("asm", "a.asm", "-c", "-o", "a.o") == (0, "")
    status, message = run("link", "a.o", "-o", "a.out")
    assert status == 2 and message == "emulator: a.o: .text+0h: undefined symbol 'f'\n"
    status, message = run("exec", "a.o")
    assert status == 2 and message == "emulator: a.o: .text+0h: undefined symbol 'f'\n"
    for arguments, expected in [
        (("link", "none.o", "-o", "x"), "none.o: no such file"),
        (("link", "a.asm", "-o", "x"), "not a COFF file"),
        (("link", "a.o", "-o", "x", "--map", "none.toml"), "none.toml: no such file"),
        (("link", "a.o", "-o", "none/x"), "undefined symbol"),
        (("asm", "a.asm", "-c", "-o", "x", "--coff-version", "3"), "--coff-version"),
        (("asm", "a.asm", "-c", "-o", "x", "-D", "=3"), "NAME=NUMBER"),
    ]:
        status, message = run(*arguments)
        assert status == 2 and expected in message, arguments
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.asm", "a.o"]


def test_damaged_objects_are_refused_or_linked_but_harm_nothing() -> None:
    rng = random.Random(22)
    good = (HERE / "a.gnu.o").read_bytes()
    other = from_gnu("b")
    outcomes = {"refused": 0, "not linked": 0, "linked": 0}
    for _ in range(4000):
        bad = bytearray(good)
        for _ in range(rng.randint(1, 6)):
            bad[rng.randrange(len(bad))] = rng.choice([0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)])
        try:
            toolchain.link([forms.read_object(bytes(bad), "bad"), other], map=MAP)
            outcomes["linked"] += 1
        except toolchain.CoffError:
            outcomes["refused"] += 1
        except toolchain.LinkError:
            outcomes["not linked"] += 1
    assert min(outcomes.values()) > 50, outcomes
    for length in range(0, len(good) - 8, 5):  # Its last bytes are an empty string table.
        with pytest.raises(toolchain.CoffError):
            forms.read_object(good[:length], "cut")


def test_a_word_may_hold_half_of_an_address() -> None:
    far = "\t.global far\n\t.data\n\t.space 0FFF0h\nnear:\t.word 1\n\t.space 20h\nfar:\t.word 2\n"
    halves = "\t.word {0},hi16({0}),lo16({0}),page({0}),({0}+3) >> 16,({0}-1) & 0FFFFh\n"
    for name, source in (("near", halves.format("near") + far), ("far", "\t.ref far\n" + halves.format("far"))):
        image = link(source, *([far] if name == "far" else []))
        at = image.symbols[name]
        words = contents(image)[".text"][1]
        assert words == [at, at >> 16, at & 0xFFFF, at >> 16, at + 3 >> 16, (at - 1) & 0xFFFF], name
