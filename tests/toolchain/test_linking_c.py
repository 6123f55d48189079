"""What the linker does for C programs: the table of initial values, and sections within one page (docs/from-c.md)."""

import pytest
from cmrc._core import toolchain
from linked import contents, link, link_errors


def warnings(*sources: str, model: str = "rom", memory: str = "origin = 0x300000, length = 0x100000") -> list[str]:
    image = link(*sources, map=f'c_model = "{model}"\n[memory]\nm = {{ {memory} }}\n')
    return list(image.warnings)


START = "\t.global _c_int00\n\t.text\n_c_int00:\tb $\n"
VALUE = '\t.bss x{0},1\n\t.sect ".cinit"\n\t.word 1,x{0},5\n'


@pytest.mark.parametrize("model", ["rom", "ram"])
@pytest.mark.parametrize(
    ("first", "second", "lost"),
    [
        (VALUE.format(1), VALUE.format(2), False),
        (VALUE.format(1), VALUE.format(2) + "\t.word 0\n", False),  # nothing is behind it
        (VALUE.format(1) + "\t.word 0\n", VALUE.format(2), True),
        (VALUE.format(1), VALUE.format(2).replace(".word", ".align 4\n\t.word"), True),
    ],
    ids=["two tables", "closed at the end", "closed before the end", "a gap"],
)
def test_initial_values_that_nothing_would_set_are_said(model: str, first: str, second: str, lost: bool) -> None:
    message = (
        "b.o: .cinit+0h: warning: the initial values from here on are not set; a 0 before them, in word 3 of .cinit, "
        "closes the table"
    )
    assert warnings(START + first, second, model=model) == ([message] if lost else [])


def test_a_record_that_asks_for_more_than_there_is() -> None:
    one, many = (VALUE.format(1).replace(".word 1", f".word {count}") for count in (2, 7))
    assert warnings(START + one) == [
        "the linked program: warning: the last record of .cinit asks for one word more than it has"
    ]
    message = "record 0 of .cinit asks for 7 words, but 2 are left"
    assert warnings(START + many) == [f"the linked program: warning: {message}"]
    with pytest.raises(toolchain.LinkError, match=message):
        warnings(START + many, model="ram")


def test_a_table_for_the_loader_takes_nothing_of_a_memory_at_0() -> None:
    objects = [toolchain.assemble_object(START + VALUE.format(1), name="a.o")]
    text = 'c_model = "ram"\n[memory]\nlow = { origin = 0, length = 64 }\nm = { origin = 0x300000, length = 64 }\n'
    _, map_text = toolchain.link(objects, map=text + '[sections]\n".text" = "m"\n".bss" = "m"\n')
    assert [line.split()[-1] for line in map_text.splitlines() if line.startswith(("low", "m "))] == ["0h", "2h"]


def test_bss_of_a_c_program_lies_in_one_page_where_there_is_room() -> None:
    source = START + "\t.bss a,100h\n"
    over = "origin = 0x30FFF0, length = {}"
    assert contents(link(source, map="[memory]\nm = { origin = 0x30FFF0, length = 0x1000 }\n"))[".bss"][0] == 0x30FFF1
    wide = link(source, map='c_model = "rom"\n[memory]\nm = { ' + over.format(0x1000) + " }\n")
    assert contents(wide)[".bss"][0] == 0x310000 and not wide.warnings
    (said,) = warnings(source, memory=over.format(0x105))
    assert ".bss (256 words at 0030FFF1h) lies in two pages of 64 K words" in said
    assert warnings(START + "\t.bss a,10000h\n", memory="origin = 0x300000, length = 0x20000") == []


@pytest.mark.parametrize(
    ("words", "pages"), [(0x10000, "two"), (0x10001, "two"), (0x10002, "3"), (70000, "3"), (200000, "5")]
)
def test_bss_that_no_page_can_hold_is_warned_of(words: int, pages: str) -> None:
    (said,) = warnings(START + f"\t.bss a,{words}\n", memory=f"origin = 0x30FFFE, length = {words + 1}")
    assert f".bss ({words} words at 0030FFFFh) lies in {pages} pages of 64 K words" in said
    assert ("The memory map may give another place" in said) == (words <= 0x10000)
    assert said.endswith("only the first, one of the big model all") == (words > 0x10000)


def test_a_blocked_section_is_refused_where_it_would_lie_in_two_pages() -> None:
    source = "\tnop\n\t.bss x,10,1\n"
    text = '[memory]\nm = {{ origin = 0x300000, length = 0x20000 }}\n[sections]\n".bss" = {{ address = {} }}\n'
    assert link(source, map=text.format(0x30FFF6)).sections
    assert link_errors(source, map=text.format(0x30FFFC)) == [
        "section .bss (10 words at 0030FFFCh) must lie in one page of 64 K words"
    ]
    assert toolchain.assemble(source, sections={".bss": 0x30FFF6}).sections
    with pytest.raises(toolchain.AssemblyError, match="must lie in one page of 64 K words"):
        toolchain.assemble(source, sections={".bss": 0x30FFFC})
