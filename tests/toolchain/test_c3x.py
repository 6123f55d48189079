"""Programs of the C3x: assembled, linked, disassembled; and the commands that refuse to run them (docs/assembler.md,
The C3x)."""

import json
import struct
import subprocess
from pathlib import Path

import cmrc
import corpus
import pytest
from cmrc._core import isa, toolchain
from cmrc_test import forms

C40_FLAG = 0x0010  # of a COFF file's header: its code is the C4x's

PROGRAM = """
        .text
start:  ldp     table
        ldi     @table,ar0
        ldi     ie,r0
        sti     r0,*ar0
        rptb    last
        addi    1,r0
last:   addi3   r0,*ar0,r1
        call    sub
        bnzd    start
        nop
        nop
        nop
        trap    5
        br      start
sub:    rets
        .data
table:  .word   table,1
"""


def words(source: str, **options: str) -> list[int]:
    return list(toolchain.assemble(source, cpu="c3x", **options).sections[0].words)


def refusal(source: str, cpu: str = "c3x", **options: str) -> str:
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble(source, cpu=cpu, **options)
    (one,) = caught.value.diagnostics
    return str(one["message"])


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("br 809800h", 0x60809800),
        ("brd 809800h", 0x61809800),
        ("call 809800h", 0x62809800),
        ("rptb 0FFFFFFh", 0x64FFFFFF),
        ("b 300000h", 0x6A00FFFF),  # Bcond is relative on both
        ("trap 0", 0x74000020),
        ("trapz 31", 0x7405003F),
        ("sigi", 0x16000000),
        ("idle2", 0x06000001),
        ("maxspeed", 0x10800000),
        ("lopower", 0x10800001),
        ("ldi ie,r0", 0x08000016),
        ("ldi 5,IF", 0x08770005),
        ("push iof", 0x0F380000),
        ("ldp 809800h", 0x50700080),
        ("ldp @809800h,dp", 0x50700080),
        ("ldp 809800h,ar2", 0x506A0080),  # as a source of the QCDSP machine has it
        ("ldiu 80h,dp", 0x50700080),
    ],
)
def test_what_the_c3x_has_otherwise(line: str, word: int) -> None:
    assert words(f" {line}\n") == [word]
    assert words(f" {isa.disassemble(word, 0x300000, cpu='c3x')}\n") == [word]


def test_ldp_takes_an_address_or_with_gnu_a_page() -> None:
    assert words(" ldp 80h\n", dialect="gnu") == [0x50700080]
    image = toolchain.assemble(" ldp 80h\n", cpu="c3x")
    assert image.sections[0].words[0] == 0x50700000 and "'ldiu 128,dp'" in image.warnings[0]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("ldpk 5", "'ldpk' is an instruction of the C40; the C3x has LDP"),
        ("lda 5,ar0", "the C3x has LDI"),
        ("ldhi 5,ar0", "'ldhi' is an instruction of the C40"),
        ("stik 1,@3", "'stik' is an instruction of the C40"),
        ("lajz r0", "'lajz' is an instruction of the C40; the C3x has no counterpart"),
        ("bzat 300000h", "'bzat' is an instruction of the C40"),
        ("retid", "the C3x has RETI"),
        ("frieee *ar0,r0 || stf r1,*ar1", "'frieee' is an instruction of the C40"),
        ("lb0 r0,r1", "'lb0' is an instruction of the C40"),
        ("mpyuhi3 r0,r1,r2", "is an instruction of the C40"),
        ("ldi r8,r0", "r8 is a register of the C40; the C3x has R0 to R7"),
        ("ldf f11,f0", "f11 is a register of the C40"),
        ("ldi iie,r0", "iie is a register of the C40; the C3x has IE"),
        ("push die", "die is a register of the C40; the C3x has IE"),
        ("sti iif,*ar0", "iif is a register of the C40; the C3x has IF and IOF"),
        ("ldi tvtp,r0", "tvtp is a register of the C40; the C3x has trap vectors"),
        ("addi3 5,r0,r1", "only the C40 has 'addi3' with these operands"),
        ("addi3 *+ar0(5),r0,r1", "only the C40 has 'addi3' with these operands"),
        ("rptb r0", "only the C40 has 'rptb' with these operands"),
        ("sti 5,@6", "only the C40 has 'sti' with these operands"),
        ("sigi *ar0,r0", "only the C40 has 'sigi' with these operands"),
        ("trap 32", "a trap number is 0 to 31"),
        ("br 1000000h", "an address of the C3x is 0 to 0FFFFFFh"),
        ("ldp 1000000h", "a page of the C3x is 0 to 255"),
        ("ldp 300000h,r0", "'ldp' loads DP or AR0 to AR7, not r0"),
        ("ldf ie,r0", "ie cannot hold a float; only R0 to R7 can"),
        ("ldi start,ar0\nstart: nop", "an address has 24 bits"),
    ],
)
def test_what_it_does_not_have_is_refused_by_name(line: str, message: str) -> None:
    assert message in refusal(f" {line}\n")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("ldi ie,r0", "ie is a register of the C3x; the C40 has IIE, and DIE for the DMA (--cpu c3x"),
        ("push IF", "IF is a register of the C3x; the C40 has IIF"),
        ("ldi 5,iof", "iof is a register of the C3x; the C40 has IIF"),
        ("lopower", "'lopower' is an instruction of the C3x; the C40 has IDLE2"),
        ("maxspeed", "'maxspeed' is an instruction of the C3x"),
        ("sigi", "only the C3x has 'sigi' with these operands"),
    ],
)
@pytest.mark.parametrize("dialect", ["ti", "gnu"])
def test_without_the_switch_a_name_of_the_c3x_is_refused_with_the_c40s_counterpart(
    line: str, message: str, dialect: str
) -> None:
    assert message in refusal(f" {line}\n", "c40", dialect=dialect)


def test_a_register_of_the_other_processor_is_no_other_objects_symbol() -> None:
    for cpu, name in (("c40", "ie"), ("c3x", "r9")):
        with pytest.raises(toolchain.AssemblyError, match=f"{name} is a register of the C"):
            toolchain.assemble_object(f" ldi {name},r0\n", dialect="gnu", cpu=cpu)
        toolchain.assemble_object(f" .global {name}\n .word {name}\n", dialect="gnu", cpu=cpu)


def test_version_and_predefined_symbols() -> None:
    source = ".if .C3X\n .word .TMS320xx,.TMS320C30,.TMS320C40,.c4x\n .else\n .word 0\n .endif\n"
    assert words(source) == [30, 1, 0, 0]
    assert toolchain.assemble(source).sections[0].words[0] == 0
    for cpu, version, warned in (("c3x", 31, False), ("c3x", 40, True), ("c40", 30, True), ("c40", 44, False)):
        warnings = toolchain.assemble(f" .version {version}\n nop\n", cpu=cpu).warnings
        assert bool(warnings) == warned, (cpu, version)
    assert "no processor has the number 54" in refusal(" .version 54\n")
    assert words(" ldi $isreg(iof),r0\n ldi $isreg(iif),r0\n") == [0x08600001, 0x08600000]


def test_every_encoding_comes_back_from_its_text() -> None:
    forms = corpus.every_form(cpu="c3x")
    lines = [isa.disassemble(word, at, cpu="c3x") for at, word in enumerate(forms)]
    image = toolchain.assemble("\n".join(f" {line}" for line in lines), sections={".text": 0}, cpu="c3x")
    assert list(image.sections[0].words) == forms and len(forms) > 60_000


def test_what_the_two_share_reads_the_same_and_the_rest_does_not() -> None:
    other = {"br", "brd", "call", "rptb", "trap?", "sigi", "maxspeed", "lopower"}
    c40 = {row["picture"]: row["mnemonic"] for row in isa.rows() if not row["c4x_only"]}
    c3x = {row["picture"]: row["mnemonic"] for row in isa.rows("c3x")}
    assert {name for picture, name in c3x.items() if c40.get(picture) != name} == {
        "trap?",
        "sigi",
        "maxspeed",
        "lopower",
        "idle2",
    }
    assert {name for picture, name in c40.items() if picture not in c3x} == {"trap?"}
    for word in corpus.every_form(cpu="c3x")[::37]:
        decoded = isa.decode(word, "c3x")
        registers = {0x16: "ie", 0x17: "if", 0x18: "iof"}
        if decoded["mnemonic"] in other or any(name in isa.disassemble(word, cpu="c3x") for name in registers.values()):
            continue
        assert isa.disassemble(word, 5, cpu="c3x") == isa.disassemble(word, 5)
    assert (
        isa.reserved_reason(0x1C000000 | 1 << 21, "c3x") and isa.reserved_reason(0x1C000000 | 1 << 21) is None
    )  # FRIEEE
    assert "register" in str(isa.reserved_reason(0x0800001C, "c3x"))  # LDI R8,R0
    with pytest.raises(ValueError, match='"c50" is unknown; "c40" or "c3x" is expected'):
        isa.decode(0, "c50")


def test_objects_say_whose_they_are_and_link_to_what_one_assembly_gives() -> None:
    whole = toolchain.assemble(PROGRAM, cpu="c3x")
    for version in (0, 1, 2):
        o = toolchain.assemble_object(PROGRAM, cpu="c3x")
        data = forms.object_bytes(o, version)
        again = forms.read_object(data, "a.o")
        assert (struct.unpack_from("<H", data, 18)[0] & C40_FLAG, again.cpu) == (0, "c3x")
        assert [r.type for r in again.sections[0].relocations] == [
            "R_PARTMS8",
            "R_PARTLS16",
            "R_REL24",
            "R_REL24",
            "R_REL24",
        ]
        image, _ = toolchain.link([again])
        assert image.cpu == "c3x"
        assert [(s.name, s.address, list(s.words)) for s in image.sections] == [
            (s.name, s.address, list(s.words)) for s in whole.sections
        ]


def test_absolute_branches_between_objects() -> None:
    a = toolchain.assemble_object(
        " .global far,near\nstart: call far\n br far+2\nnear: br start\n", name="a.o", cpu="c3x"
    )
    b = toolchain.assemble_object(" .global far,near\n nop\nfar: br near\n rptb far+1\n nop\n", name="b.o", cpu="c3x")
    image, _ = toolchain.link(
        [a, b], map='[memory]\nm = { origin = 0x809800, length = 0x800 }\n[sections]\n".text" = "m"\n'
    )
    assert list(image.sections[0].words) == [
        0x62809804,
        0x60809806,
        0x60809800,
        0x0C800000,
        0x60809802,
        0x64809805,
        0x0C800000,
    ]


def test_objects_of_two_processors_are_not_linked() -> None:
    a = toolchain.assemble_object(" .global f\n call f\n", name="a.o", cpu="c3x")
    b = toolchain.assemble_object(" .global f\nf: rets\n", name="b.o")
    for objects, library in (([a, b], []), ([a], [b])):
        with pytest.raises(toolchain.LinkError, match=r"b.o: is for the C40, and a.o for the C3x"):
            toolchain.link(objects, library=library)


def test_the_address_space_ends_at_24_bits() -> None:
    sections = {".text": 0xFFFFFF}
    assert toolchain.assemble(" nop\n", sections=sections, cpu="c3x").sections[0].address == 0xFFFFFF
    with pytest.raises(toolchain.AssemblyError, match="passes the end of the address space of the C3x"):
        toolchain.assemble(" nop\n nop\n", sections=sections, cpu="c3x")
    o = toolchain.assemble_object(" nop\n nop\n", cpu="c3x")
    for place in ('".text" = { address = 0xFFFFFF }', '".text" = "m"'):
        with pytest.raises(toolchain.LinkError, match="passes the end of the address space of the C3x"):
            toolchain.link([o], map=f"[memory]\nm = {{ origin = 0xFFFFFF, length = 16 }}\n[sections]\n{place}\n")
    data = bytearray(forms.object_bytes(toolchain.assemble_object(" nop\n nop\n")))
    struct.pack_into("<I", data, 22 + 8, 0xFFFFFF)
    forms.read_object(bytes(data))
    struct.pack_into("<H", data, 18, struct.unpack_from("<H", data, 18)[0] & ~C40_FLAG)
    with pytest.raises(toolchain.CoffError, match="section '.text' passes the end of the address space of the C3x"):
        forms.read_object(bytes(data))


def test_checks_of_repeated_blocks_know_absolute_ends() -> None:
    image = toolchain.assemble(" rptb last\n nop\nlast: br last\n", cpu="c3x")
    assert len(image.warnings) == 1 and "the last instruction of a repeated block" in image.warnings[0]


# The programs


def run(emulator: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([emulator, *arguments], capture_output=True, text=True, check=False)


@pytest.fixture
def built(emulator: Path, tmp_path: Path) -> Path:
    (tmp_path / "p.asm").write_text(PROGRAM)
    assert run(emulator, "asm", tmp_path / "p.asm", "--cpu", "c3x", "-c", "-o", tmp_path / "p.o").returncode == 0
    done = run(emulator, "link", tmp_path / "p.o", "-o", tmp_path / "p.out")
    assert done.returncode == 0, done.stderr
    return tmp_path


def test_disassembly_gives_a_source_that_assembles_to_the_same(emulator: Path, built: Path) -> None:
    plain = run(emulator, "disasm", built / "p.out").stdout
    assert plain.startswith("; cpu c3x\n") and "call sub" in plain and "ldi ie,r0" in plain
    assert "; cpu c3x" in run(emulator, "disasm", built / "p.o").stdout
    source = run(emulator, "disasm", built / "p.out", "--source").stdout
    head = source.splitlines()[0].split()
    assert head[head.index("--cpu") + 1] == "c3x"
    (built / "again.asm").write_text(source)
    options = [word for word in head[head.index("OUT") + 1 :]]
    done = run(
        emulator, "asm", built / "again.asm", *options, "-o", built / "again.out", "--listing", built / "again.lst"
    )
    assert done.returncode == 0, done.stderr
    assert (built / "again.lst").read_text().startswith("cpu c3x\n")
    once, again = toolchain.read_coff(built / "p.out"), toolchain.read_coff(built / "again.out")
    assert [(s.name, list(s.words)) for s in again.sections] == [(s.name, list(s.words)) for s in once.sections]


def test_words_of_a_hex_file_are_read_as_the_switch_says(emulator: Path, tmp_path: Path) -> None:
    (tmp_path / "w.hex").write_text("62809800\n08000016\n")
    assert "call 0x809800" in run(emulator, "disasm", tmp_path / "w.hex", "--cpu", "c3x").stdout
    assert "ldi die,r0" in run(emulator, "disasm", tmp_path / "w.hex").stdout


def test_whatever_runs_programs_refuses_it_by_name(emulator: Path, built: Path) -> None:
    (built / "net.toml").write_text('[[chip]]\nprogram = "p.out"\n')
    board = built / "board.toml"
    board.write_text('[[region]]\nname = "r"\nbase = 0x300000\nwords = 0x1000\nbus = "local"\n')
    (built / "script").write_text("registers\n")
    for arguments in (
        ["exec", built / "p.out"],
        ["exec", built / "p.o"],
        ["exec", built / "p.out", "--board", board],
        ["exec", built / "p.out", "--boot", "0"],
        ["exec", built / "p.out", "--topology", "ring:2"],
        ["exec", "--network", built / "net.toml"],
        ["debug", built / "p.out"],
        ["image", built / "p.out", "--format", "binary", "-o", built / "image"],
    ):
        done = run(emulator, *arguments)
        assert done.returncode == 2, arguments
        assert "a program of the TMS320C3x" in done.stderr and ".o" in done.stderr and done.stdout == "", arguments
    assert not (built / "image").exists()


def test_the_debug_adapter_refuses_it(emulator: Path, built: Path) -> None:
    def message(sequence: int, command: str, **arguments: object) -> bytes:
        body = json.dumps({"seq": sequence, "type": "request", "command": command, "arguments": arguments}).encode()
        return b"Content-Length: %d\r\n\r\n" % len(body) + body

    requests = (
        message(1, "initialize", adapterID="x")
        + message(2, "launch", program=str(built / "p.out"))
        + message(3, "disconnect")
    )
    done = subprocess.run([emulator, "dap"], input=requests, capture_output=True, timeout=60, check=False)
    assert b"a program of the TMS320C3x" in done.stdout


def test_a_coff_file_says_its_processor_itself(emulator: Path, built: Path) -> None:
    done = run(emulator, "disasm", built / "p.out", "--cpu", "c40")
    assert done.returncode == 2 and "--cpu" in done.stderr and "names its processor itself" in done.stderr
    done = run(emulator, "asm", built / "p.asm", "--cpu", "c50", "-o", built / "x.out")
    assert done.returncode == 2 and "--cpu" in done.stderr and not (built / "x.out").exists()


def test_python_assembles_writes_and_disassembles_but_does_not_run_it(tmp_path: Path) -> None:
    program = cmrc.c40.assemble(PROGRAM, cpu="c3x")
    assert program.cpu == "c3x" and cmrc.c40.assemble(" nop\n").cpu == "c40"
    cmrc.c40.write_coff(program, tmp_path / "p.out")
    again = cmrc.c40.read_coff(tmp_path / "p.out")
    assert again.cpu == "c3x"
    assert cmrc.c40.disassemble(again.sections[0].words, 0x300000, cpu="c3x")[2] == "ldi ie,r0"
    for act in (
        lambda: cmrc.c40.Processor(again),
        lambda: cmrc.c40.Processor().load(again),
        lambda: cmrc.network.Network([again, again], links=["0.0:1.3"]),
    ):
        with pytest.raises(ValueError, match="a program of the TMS320C3x"):
            act()
    with pytest.raises(ValueError, match='cpu: "c44" is unknown'):
        cmrc.c40.assemble(" nop\n", cpu="c44")
