"""What a linked program is called inside: names of several objects, names that only the linker needs, and the entry."""

import subprocess
from pathlib import Path

import pytest
from cmrc._core import toolchain
from cmrc_test import forms
from linked import contents, link

Program = tuple[int, str]


def run(emulator: Path, *arguments: str, at: Path) -> tuple[int, str, str]:
    done = subprocess.run([emulator, *arguments], cwd=at, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def built(emulator: Path, at: Path, *sources: str) -> None:
    """p.out and p.map of a.asm, b.asm, ..."""
    names = []
    for number, source in enumerate(sources):
        name = chr(97 + number)
        (at / f"{name}.asm").write_text(source)
        assert run(emulator, "asm", "-c", f"{name}.asm", "-o", f"{name}.o", at=at) == (0, "", "")
        names.append(f"{name}.o")
    assert run(emulator, "link", *names, "-o", "p.out", "--map-output", "p.map", at=at) == (0, "", "")


# Names

SHARED = (
    "\t.ref f\nN\t.set 5\nstart:\tldhi 31h,sp\nloop:\tcall f\n\tb $\n",
    "\t.global f\nN\t.set 5\nf:\tnop\nloop:\tnop\n\trets\n",
    "M\t.set 1\nloop:\tnop\nN\t.set 6\n",
)


def test_local_names_that_objects_share_are_all_kept(tmp_path: Path, emulator: Path) -> None:
    built(emulator, tmp_path, *SHARED)
    rows = (tmp_path / "p.map").read_text().split("address    symbol\n")[1].splitlines()
    assert [row for row in rows if row.endswith("loop")] == ["00300001h  loop", "00300004h  loop", "00300006h  loop"]
    assert [row for row in rows if row.endswith("  N")] == ["00000005h  N", "00000006h  N"]
    listed = run(emulator, "disasm", "p.out", at=tmp_path)[1]
    assert listed.splitlines().count("loop:") == 3
    file = forms.read_object((tmp_path / "p.out").read_bytes())
    assert sorted((s.value, s.is_global) for s in file.symbols if s.name == "loop") == [
        (0x300001, True), (0x300004, False), (0x300006, False),
    ]  # fmt: skip


def test_a_shared_name_is_the_first_objects(tmp_path: Path, emulator: Path) -> None:
    built(emulator, tmp_path, *SHARED)
    assert toolchain.read_coff(tmp_path / "p.out").symbols["loop"] == 0x300001
    built(emulator, tmp_path, "\t.ref loop\nstart:\tb loop\n", "loop:\tnop\n\tb loop\n", "\t.def loop\nloop:\tb $\n")
    image = toolchain.read_coff(tmp_path / "p.out")
    assert image.symbols["loop"] == 0x300003  # the global one
    assert run(emulator, "exec", "p.out", "--until", "loop", at=tmp_path)[1].count("00300003") > 0


def test_a_program_with_shared_names_is_a_source_again(tmp_path: Path, emulator: Path) -> None:
    built(emulator, tmp_path, *SHARED)
    source = run(emulator, "disasm", "p.out", "--source", at=tmp_path)[1]
    assert contents(toolchain.assemble(source)) == contents(toolchain.read_coff(tmp_path / "p.out"))


def test_a_float_is_in_the_linked_program_as_in_the_one_made_at_once() -> None:
    source = "F\t.set 1.5\nstart:\tldf F,r0\n\t.float F\n"
    at_once = toolchain.assemble(source)
    assert link(source).symbols == at_once.symbols
    assert at_once.symbols["F"] == toolchain.assemble("x:\t.float 1.5\n").sections[0].words[0]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("\t.global F\nF\t.set 1.5\n\tnop\n", "'F' is a float; other objects can see addresses and integers"),
        ("\t.global H\ns:\tnop\nH\t.set hi16(s)\n", "'H' is half of an address that the linker assigns"),
        ("\t.global H\n\t.ref s\nH\t.set lo16(s)\n\tnop\n", "'H' is half of an address that the linker assigns"),
        ("\t.global H\n\t.ref s\nH\t.set s+1\n\tnop\n", "'H' is defined through a symbol of another object"),
    ],
)
def test_what_other_objects_cannot_see_is_an_error(source: str, message: str) -> None:
    with pytest.raises(toolchain.AssemblyError, match=message):
        toolchain.assemble_object(source)


def test_a_constant_for_other_objects_has_32_bits() -> None:
    for number in (5000000000, -2147483649):
        with pytest.raises(toolchain.AssemblyError, match=rf"'K' is {number}: other objects can see 32 bits of it"):
            toolchain.assemble_object(f"\t.global K\nK\t.set {number}\n\tnop\n")
    for number in (0xFFFFFFFF, -2147483648):
        made = toolchain.assemble_object(f"\t.global K\nK\t.set {number}\n\tnop\n")
        assert [s.value for s in made.symbols if s.name == "K"] == [number % 2**32]


def test_relocations_leave_no_names_behind(tmp_path: Path, emulator: Path) -> None:
    source = (
        "start:\tldhi 31h,sp\nf:\tcall helper+1\n\tbr 300100h\n\tldi 5,r0\n\tb $\n\t.sect \"lib\"\nhelper:\tnop\n"
        "\tldi 7,r1\n\trets\n\t.sect \"zz\"\n\tbne helper-1\n"
    )  # fmt: skip
    built(emulator, tmp_path, source)
    at_once = toolchain.assemble(source, name="a.asm")
    image = toolchain.read_coff(tmp_path / "p.out")
    assert image.symbols == at_once.symbols
    assert contents(image) == contents(at_once)
    shown = (tmp_path / "p.map").read_text() + run(emulator, "disasm", "p.out", at=tmp_path)[1]
    assert "lib+" not in shown and "=300100h" not in shown


# The entry


@pytest.mark.parametrize(
    "source",
    [
        "\tldi 1,r0\n\tb $\nstart\t.set 10\n", "start\t.set 10\n\tldi 1,r0\n\tb $\n", "start\t.set 1.5\n\tldi 1,r0\n\tb $\n",
        "\tldi 1,r0\n\tb $\n\t.bss start,5\n", "_start\t.set 10\nstart\t.set 20\n\tnop\n",
        "H\t.set hi16(x)\n\tnop\nx:\tnop\nstart\t.set H\n", 'start\t.usect "heap",3\n\tnop\n',
    ],
)  # fmt: skip
def test_only_an_address_in_a_loaded_section_is_an_entry_by_its_name(source: str) -> None:
    assert toolchain.assemble(source).entry == 0x300000
    assert link(source).entry == 0x300000
    assert link(source.replace("start", "START")).entry == 0x300000


def test_the_next_name_is_looked_for() -> None:
    source = "_start\t.set 10\n\tnop\nstart:\tnop\n"
    assert toolchain.assemble(source).entry == link(source).entry == 0x300001
    other = '\tnop\n\t.sect "code"\nc_int00:\tnop\n\t.bss _start,1\n'
    assert toolchain.assemble(other).entry == link(other).entry == 0x300001
    alias = "\tnop\nhere:\tnop\nstart\t.set here\n"
    assert toolchain.assemble(alias).entry == link(alias).entry == 0x300001


def test_a_constant_is_an_entry_where_somebody_asks_for_it() -> None:
    source = "start\t.set 300001h\n\tnop\n\tnop\n"
    assert toolchain.assemble(source, entry="start").entry == 0x300001
    where = "[memory]\nm = { origin = 0x300000, length = 0x100 }\n[symbols]\nstart = 0x300001\n"
    assert link("\tnop\n\tnop\n", map=where).entry == 0x300000
    assert link("\tnop\n\tnop\n", map='entry = "start"\n' + where).entry == 0x300001


def test_the_linker_finds_a_local_entry(tmp_path: Path, emulator: Path) -> None:
    built(emulator, tmp_path, "start:\tnop\nz:\tb $\n", "z:\tnop\n")
    for entry, address in (("z", 0x300001), ("start", 0x300000)):
        assert run(emulator, "link", "a.o", "b.o", "-o", "q.out", "--entry", entry, at=tmp_path) == (0, "", "")
        assert toolchain.read_coff(tmp_path / "q.out").entry == address
    status, _, message = run(emulator, "link", "a.o", "b.o", "-o", "q.out", "--entry", "none", at=tmp_path)
    assert (status, message) == (2, "emulator: the entry symbol 'none' is not defined\n")
    built(emulator, tmp_path, "start:\tnop\nz:\tb $\n", "\t.def z\n\tnop\nz:\tnop\n")
    assert run(emulator, "link", "a.o", "b.o", "-o", "q.out", "--entry", "z", at=tmp_path) == (0, "", "")
    assert toolchain.read_coff(tmp_path / "q.out").entry == 0x300003  # a global symbol comes first


@pytest.mark.parametrize(
    ("option", "value", "instead"),
    [("--entry", "z", "emulator link --entry"), ("--section", ".text=0x1000", "emulator link --map")],
)
def test_an_object_takes_no_addresses_and_no_entry(
    tmp_path: Path, emulator: Path, option: str, value: str, instead: str
) -> None:
    (tmp_path / "a.asm").write_text("start:\tnop\nz:\tb $\n")
    status, _, message = run(emulator, "asm", "-c", "a.asm", "-o", "a.o", option, value, at=tmp_path)
    assert status == 2 and message.startswith(f"emulator: {option}: ") and instead in message
    assert not (tmp_path / "a.o").exists()


def test_an_address_of_no_section_gives_a_warning(tmp_path: Path, emulator: Path) -> None:
    (tmp_path / "a.asm").write_text("start:\tnop\n")
    status, _, message = run(emulator, "asm", "a.asm", "-o", "a.out", "--section", ".nosuch=0x1000", at=tmp_path)
    assert (
        status == 0
        and message == "warning: an address is given for the section '.nosuch', and the program has no such section\n"
    )
    assert run(emulator, "asm", "a.asm", "-o", "a.out", "--section", ".data=0x1000", at=tmp_path) == (0, "", "")
