"""Where sections lie, and what they may not be: with addresses of options or of a memory map, and without."""

import random

import pytest
from cmrc._core import toolchain
from linked import link, link_errors

START = 0x300000
ORDER = (".text", ".data", "tab", ".bss", "room")
SOURCE = """
        .text
        .space  {0}
        .data
        .space  {1}
        .sect   "tab"
        .space  {2}
        .bss    v,{3}
w       .usect  "room",{4}
"""


def places(sizes: list[int], given: dict[str, int]) -> dict[str, int] | None:
    """Word by word: sections with an address first, each other one where its words are free. None if two meet."""
    taken: set[int] = set()
    at = dict(given)
    for name, size in zip(ORDER, sizes, strict=True):
        if name in given:
            own = set(range(given[name], given[name] + size))
            if own & taken:
                return None
            taken |= own
    begin = START
    for name, size in zip(ORDER, sizes, strict=True):
        if name in given:
            begin = given[name] + size if size else given[name]
            continue
        at[name] = next(a for a in range(begin, START + 1000) if taken.isdisjoint(range(a, a + size)))
        taken |= set(range(at[name], at[name] + size))
    return {name: at[name] for name, size in zip(ORDER, sizes, strict=True) if size}


def test_a_section_with_an_address_is_in_nobodys_way() -> None:
    accepted = 0
    for seed in range(300):
        draw = random.Random(seed)
        sizes = [draw.randint(0, 6) for _ in ORDER]
        sizes[0] += 1
        given = {name: START + draw.randint(0, 16) for name in ORDER if draw.random() < 0.4}
        given.setdefault(".text", START)  # as the assembler has it
        expected = places(sizes, given)
        source = SOURCE.format(*sizes)
        if expected is None:
            with pytest.raises(toolchain.AssemblyError, match="overlap"):
                toolchain.assemble(source, sections=given)
            continue
        image = toolchain.assemble(source, sections=given)
        assert {section.name: section.address for section in image.sections} == expected, (sizes, given)
        accepted += 1
    assert accepted > 150


def test_assembler_and_linker_leave_out_the_same_words() -> None:
    source = "start: nop\n .data\n .word 1,2,3\n .bss q,4\n"
    at_once = toolchain.assemble(source, sections={".bss": 0x300002})
    linked = link(
        source, map='[memory]\nm = {origin = 0x300000, length = 0x100}\n[sections]\n".bss" = {address = 0x300002}\n'
    )
    expected = {".text": 0x300000, ".bss": 0x300002, ".data": 0x300006}
    assert [{section.name: section.address for section in image.sections} for image in (at_once, linked)] == [
        expected
    ] * 2


MAP = "[memory]\nm = {{ origin = 0, length = 0xFFFFFFFF }}\n[sections]\n{}\n"


@pytest.mark.parametrize("size", ["0x1000001", "0x8000000", "0xFFFFFFFF"])
@pytest.mark.parametrize("where", ['memory = "m"', "address = 0"])
def test_a_loaded_section_of_a_memory_map_has_the_assemblers_limit(size: str, where: str) -> None:
    (error, *_) = link_errors("start: nop\n", map=MAP.format(f'".text" = {{ {where}, size = {size} }}'))
    assert error == f"section '.text' has {int(size, 0)} words; 16777216 are the most of a loaded section"
    # A reserved section takes no memory of the host.
    image = link(
        "start: nop\n .bss v,1\n", map=MAP.format(f'".bss" = {{ address = 0x400000, size = {int(size, 0) >> 1} }}')
    )
    assert image.sections[1].size == int(size, 0) >> 1


def test_loaded_sections_of_objects_have_the_limit_together() -> None:
    half = ".text\n nop\n .space 7FFFFFh\n"
    (error,) = link_errors(f"start: {half}", f" {half}", f" {half}", map=MAP.format(""))
    assert error == "section '.text' has 25165824 words; 16777216 are the most of a loaded section"


MEMORIES = (
    "[memory]\na = {{ origin = 0x300000, length = 0x1000 }}\nb = {{ origin = 0x310000, length = 100 }}\n[sections]\n"
)


@pytest.mark.parametrize(("address", "size", "fits"), [
    (0x310000, 100, True), (0x310000, 101, False), (0x31005E, 6, True), (0x31005E, 7, False), (0x310063, 1, True),
    (0x310064, 200, True), (0x30FFFF, 1, True), (0x2FFF00, 1000, True),
])  # fmt: skip
def test_a_section_that_begins_in_a_memory_ends_in_it(address: int, size: int, fits: bool) -> None:
    source = f'start: nop\n .sect "vecs"\n .space {size}\n'
    text = MEMORIES.format() + f'"vecs" = {{ address = 0x{address:X} }}\n'
    if fits:
        assert {s.name: s.address for s in link(source, map=text).sections}["vecs"] == address
    else:
        assert link_errors(source, map=text) == [
            f"section vecs ({size} words at {address:08X}h) does not lie in the memory 'b' (100 words at 00310000h)"
        ]


def test_a_memory_with_an_error_is_not_called_missing() -> None:
    with pytest.raises(toolchain.MemoryMapError) as caught:
        link("start: nop\n", map="[memory]\nm = { origin = 0, length = 0 }\n")
    assert str(caught.value) == "<map>:2: memory.m.length: an integer from 1 to 4294967296 is expected"
