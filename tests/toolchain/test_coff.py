"""COFF: files of the GNU linker, our own round trip, older versions built by hand, and damage of every kind."""

import random
import re
import struct
import subprocess
from pathlib import Path

import pytest
from cmrc._core import isa, toolchain

HERE = Path(__file__).parent
BUILD_BIN = "c40_asm"


@pytest.mark.parametrize(
    ("name", "text_words", "main", "bss_words"),
    [("p_crc.O2.out", 320, 0x300099, 1280), ("p_sort.O2.out", 671, 0x3001F4, 4010)],
)  # sizes and addresses by GNU objdump -h -t
def test_executables_of_the_gnu_linker_are_read(name: str, text_words: int, main: int, bss_words: int) -> None:
    image = toolchain.read_coff(HERE / "coff" / name)
    sections = {s.name: s for s in image.sections}
    assert (sections[".text"].address, sections[".text"].size) == (0x300000, text_words)
    assert sections[".const"].address == 0x310000
    assert (sections[".bss"].loaded, sections[".bss"].size) == (False, bss_words)
    assert image.entry == image.symbols["_start"] == 0x300000
    assert (image.symbols["_halt"], image.symbols["_main"]) == (0x300008, main)
    # crt0.s: ldpk @sp_init, then a call of _main at the fifth word, _halt branches to itself.
    text = sections[".text"].words
    assert isa.disassemble(text[0]) == "ldpk 49"
    assert isa.disassemble(text[4], 0x300004) == f"call {main:#x}"
    assert isa.disassemble(text[8], 0x300008) == "bu 0x300008"
    assert sections[".const"].words[0] == 0x320000


@pytest.mark.parametrize("form", ["coff0", "coff0-beh", "coff1", "coff1-beh", "coff2-beh"])
def test_every_version_and_byte_order_of_gnu_ld_is_read(form: str) -> None:
    linking = HERE / "linking"
    image, expected = toolchain.read_coff(linking / f"gnu.{form}.out"), toolchain.read_coff(linking / "gnu.out")
    assert [(s.name, s.address, s.size, s.words, s.loaded) for s in image.sections] == [
        (s.name, s.address, s.size, s.words, s.loaded) for s in expected.sections
    ]
    assert (image.entry, image.symbols) == (expected.entry, expected.symbols)


SOURCE = """
        .global _start
a_name_longer_than_eight .set 12345678h
_start: ldi     5,r0
        b       $
        .sect   ".const"
c:      .word   1,2,-1
        .bss    buffer,100
        .sect   ".a_long_section_name"
        .float  1.5
"""


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    image = toolchain.assemble(SOURCE, sections={".const": 0x80000000})
    toolchain.write_coff(image, tmp_path / "a.out")
    again = toolchain.read_coff(tmp_path / "a.out")
    shape = [(s.name, s.address, s.size, list(s.words), s.loaded) for s in image.sections]
    assert [(s.name, s.address, s.size, list(s.words), s.loaded) for s in again.sections] == shape
    assert (again.symbols, again.entry) == (image.symbols, image.entry)
    assert list(tmp_path.iterdir()) == [tmp_path / "a.out"]


@pytest.mark.parametrize("version", ["0", "1", "2"])
def test_names_keep_their_letters(tmp_path: Path, emulator: Path, version: str) -> None:
    """The eighth byte of the first name is in the middle of a letter: older versions have it in the header."""
    names = ["of secté and more", "né", "odd name 温度"]
    (tmp_path / "a.asm").write_text("".join(f'\t.sect "{name}"\n\tnop\n' for name in names), encoding="utf-8")
    link = ["link", "a.obj", "-o", "a.out", "--map-output", "a.map", "--coff-version", version]
    for command in (["asm", "--object", "a.asm", "-o", "a.obj"], link):
        subprocess.run([emulator, *command], cwd=tmp_path, check=True, capture_output=True)
    assert [s.name for s in toolchain.read_coff(tmp_path / "a.out").sections] == names
    listing = subprocess.run([emulator, "disasm", "a.out"], cwd=tmp_path, check=True, capture_output=True).stdout
    for name in names:
        assert name in listing.decode() and name in (tmp_path / "a.map").read_text("utf-8")


@pytest.mark.parametrize(
    ("name", "shown"),
    [(b".caf\xe9", ".caf\\xE9"), (b"a\nb\tc\x1bd", "a\\x0Ab\\x09c\\x1Bd"), (b"caf\xc3\xa9", "caf\u00e9")],
)
def test_a_name_that_is_no_text_is_shown_by_its_bytes(name: bytes, shown: str) -> None:
    data = old_executable(0).replace(b".text\0\0\0", name.ljust(8, b"\0"))
    assert toolchain.read_coff_bytes(data).sections[0].name == shown


def test_equal_programs_give_equal_files_and_the_header_is_that_of_version_2(tmp_path: Path) -> None:
    for name in ("a", "b"):
        toolchain.write_coff(toolchain.assemble(SOURCE), tmp_path / name)
    data = (tmp_path / "a").read_bytes()
    assert data == (tmp_path / "b").read_bytes()
    magic, sections, _, _, _, optional, flags, target = struct.unpack_from("<HHIIIHHH", data)
    assert (magic, sections, optional, flags, target) == (
        0xC2,
        4,
        28,
        0x0113,
        0x93,
    )  # executable, no relocations, lines


def test_the_optional_header_has_sizes_entry_and_starts(tmp_path: Path) -> None:
    source = "\tnop\nstart:\tnop\n\t.data\n\t.word 1,2,3\n\t.bss x,5\n"
    toolchain.write_coff(toolchain.assemble(source, entry="start"), tmp_path / "a")
    header = struct.unpack_from("<HHIIIIII", (tmp_path / "a").read_bytes(), 22)
    assert header == (0x108, 0, 2, 3, 5, 0x300001, 0x300000, 0x300002)


COPIES = (2, 0x2000, 77, 78, 1, 0x2010, 79, 0)  # What the loader sets: records up to a count of 0.


def old_executable(version: int, copies: tuple[int, ...] = COPIES) -> bytes:
    """A version-0 or version-1 file by the tables of the format: one loaded section, one COPY section, two symbols."""
    header = 20 if version == 0 else 22
    contents = header + 28 + 2 * 40
    strings = b"a_long_symbol_name\0"
    symbols = struct.pack("<8sIhHBB", b"start", 0x1001, 1, 0, 2, 1) + bytes(18)  # with an auxiliary entry
    symbols += struct.pack("<IIIhHBB", 0, 4, 0x77, -1, 0, 2, 0) + struct.pack("<8sIhHBB", b"extern", 0, 0, 0, 2, 0)
    out = struct.pack("<HHIIIHH", 0x93 if version == 0 else 0xC1, 2, 0, contents + 8 + 4 * len(copies), 4, 28, 0x0113)
    if version == 1:
        out += struct.pack("<H", 0x93)
    out += struct.pack("<HHIIIIII", 0x108, 0, 2, 0, 0, 0x1001, 0x1000, 0)
    for name, size, flags in ((b".text", 2, 0x20), (b".cinit", len(copies), 0x50)):
        where = contents if name == b".text" else contents + 8
        out += struct.pack("<8sIIIIIIHHHBB", name, 0x1000, 0x1000, size, where, 0, 0, 0, 0, flags, 0, 0)
    out += struct.pack(f"<{2 + len(copies)}I", 0x0C800000, 0x6A00FFFF, *copies)
    return out + symbols + struct.pack("<I", 4 + len(strings)) + strings


@pytest.mark.parametrize("version", [0, 1])
def test_older_versions_are_read(version: int) -> None:
    image = toolchain.read_coff_bytes(old_executable(version))
    assert [(s.name, s.address, list(s.words), s.loaded) for s in image.sections] == [
        (".text", 0x1000, [0x0C800000, 0x6A00FFFF], True),
        (".cinit", 0x1000, [], False),
        (".cinit.0", 0x2000, [77, 78], True),
        (".cinit.1", 0x2010, [79], True),
    ]
    assert image.entry == 0x1001 and image.symbols == {"start": 0x1001, "a_long_symbol_name": 0x77}


@pytest.mark.parametrize(("second", "overlap"), [
    (0x2002, None), (0x1FFF, None), (0x1002, None), (0x0FFF, None),
    (0x2001, ".cinit.0 (2 words at 00002000h) and .cinit.1 (1 words at 00002001h)"),
    (0x2000, ".cinit.0 (2 words at 00002000h) and .cinit.1 (1 words at 00002000h)"),
    (0x1001, ".text (2 words at 00001000h) and .cinit.1 (1 words at 00001001h)"),
])  # fmt: skip
def test_initial_values_may_touch_other_words_and_not_overlap_them(second: int, overlap: str | None) -> None:
    data = old_executable(1, (2, 0x2000, 77, 78, 1, second, 79, 0))
    if overlap is None:
        assert {s.address for s in toolchain.read_coff_bytes(data).sections} == {0x1000, 0x2000, second}
    else:
        with pytest.raises(toolchain.CoffError, match=re.escape(f"the sections {overlap} overlap")):
            toolchain.read_coff_bytes(data)


@pytest.mark.parametrize(
    ("place", "overlaps"), [(0x300007, True), (0x300008, False), (0x2FFFFC, False), (0x2FFFFD, True)]
)
def test_overlapping_sections_of_a_file_are_refused_where_it_is_used(
    place: int, overlaps: bool, tmp_path: Path, emulator: Path
) -> None:
    """.text of 8 words at 300000h; .data of 4 words is moved in the file: its header names the place twice."""
    source = "\t.space 7\n\tidle\n\t.data\n\t.word 1,2,3,4\n"
    toolchain.write_coff(toolchain.assemble(source, sections={".data": 0x380000}), tmp_path / "p.out")
    before, after = struct.pack("<II", 0x380000, 0x380000), struct.pack("<II", place, place)
    data = (tmp_path / "p.out").read_bytes()
    assert data.count(before) == 1
    (tmp_path / "p.out").write_bytes(data.replace(before, after))
    for command in ("disasm", "exec"):
        arguments = [emulator, command, "p.out", *(["--max-cycles", "10"] if command == "exec" else [])]
        done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True, check=False)
        in_message = ("p.out", "(8 words at 00300000h)", f"(4 words at {place:08X}h)", "overlap")
        assert (done.returncode == 2) == overlaps and all((word in done.stderr) == overlaps for word in in_message)


def test_what_is_no_executable_of_this_family_is_refused(tmp_path: Path) -> None:
    good = bytearray((HERE / "coff" / "p_crc.O2.out").read_bytes())
    for patch, message in [
        ({0: 0x92}, "starts with 0092h"),
        ({20: 0x99}, "target 0099h"),
        ({18: good[18] & ~2}, "not linked"),
    ]:
        bad = bytearray(good)
        for offset, value in patch.items():
            bad[offset] = value
        with pytest.raises(toolchain.CoffError, match=message):
            toolchain.read_coff_bytes(bytes(bad))
    for content in (b"", b"\x7fELF" + bytes(60), b"not a coff file, but some text that is long enough"):
        with pytest.raises(toolchain.CoffError, match="not a COFF file"):
            toolchain.read_coff_bytes(content)
    with pytest.raises(toolchain.CoffError, match="missing.out"):
        toolchain.read_coff(tmp_path / "missing.out")
    with pytest.raises(toolchain.CoffError, match="directory"):
        toolchain.read_coff(tmp_path)


@pytest.mark.parametrize("name", ["p_crc.O2.out", "p_sort.O2.out"])
def test_a_file_cut_anywhere_is_refused_with_a_reason(name: str) -> None:
    good = (HERE / "coff" / name).read_bytes()
    for length in range(0, len(good) - 1, 3):
        with pytest.raises(toolchain.CoffError, match="cut short|not a COFF|no sections"):
            toolchain.read_coff_bytes(good[:length])


def test_a_file_cut_short_says_what_should_be_where() -> None:
    good = (HERE / "coff" / "p_crc.O2.out").read_bytes()
    for length, part in (
        (21, "the target should be at bytes 20 to 22"),
        (30, "the optional header should be at bytes 22 to 50"),
        (3146, "the string table should be at bytes 3122 to 3151"),
    ):
        with pytest.raises(toolchain.CoffError, match=f"cut short: {part}, but the file has {length}"):
            toolchain.read_coff_bytes(good[:length])


def test_damaged_files_are_read_or_refused_but_harm_nothing() -> None:
    rng = random.Random(93)
    good = (HERE / "coff" / "p_sort.O2.out").read_bytes()
    refused = 0
    for _ in range(5000):
        bad = bytearray(good)
        for _ in range(rng.randint(1, 8)):
            bad[rng.randrange(300 if rng.random() < 0.7 else len(bad))] = rng.choice(
                [0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)]
            )
        try:
            toolchain.read_coff_bytes(bytes(bad))
        except toolchain.CoffError:
            refused += 1
    assert 500 < refused < 5000


def test_the_build_tools_status_and_files(tmp_path: Path, emulator: Path) -> None:
    tool = emulator.parent / BUILD_BIN
    source = tmp_path / "p.asm"
    source.write_text('\t.include "n.inc"\n\tldi N,r0\n')
    (tmp_path / "inc").mkdir()
    (tmp_path / "inc" / "n.inc").write_text("N .set 5\n")
    command = [tool, source, "-o", tmp_path / "p.out"]
    failed = subprocess.run(command, capture_output=True, text=True, check=False)
    assert failed.returncode == 2 and "p.asm:1:11: error: no file 'n.inc'" in failed.stderr
    assert not list(tmp_path.glob("p.out*"))
    done = subprocess.run(
        [*command, "-I", tmp_path / "inc", "--listing", tmp_path / "p.lst"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert list(toolchain.read_coff(tmp_path / "p.out").sections[0].words) == [0x08600005]
    assert "08600005" in (tmp_path / "p.lst").read_text()
    for bad in (
        [],
        ["-o"],
        [source, "--frob", "-o", "x"],
        [source, "-o", tmp_path / "none" / "x", "-I", tmp_path / "inc"],
    ):
        assert subprocess.run([tool, *bad], check=False, capture_output=True).returncode == 2


def test_a_section_with_a_load_address_of_its_own_is_loaded_there(tmp_path: Path) -> None:
    """Another linker may give a section a run address (its virtual one): the program moves it there itself."""
    toolchain.write_coff(toolchain.assemble("start:\tnop\nagain:\tb again\n"), tmp_path / "a.out")
    data = bytearray((tmp_path / "a.out").read_bytes())
    physical = 22 + 28 + 8  # behind the two headers and the name
    assert struct.unpack_from("<II", data, physical) == (0x300000, 0x300000)
    struct.pack_into("<I", data, physical, 0x310000)
    image = toolchain.read_coff_bytes(bytes(data))
    assert [(s.name, s.address) for s in image.sections] == [(".text", 0x310000)]
    assert image.symbols["again"] == 0x300001
