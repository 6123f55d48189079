"""The C run-time's arithmetic, heap, console and start-up on the emulated chip, against Python over edges and random
values."""

from __future__ import annotations

import json
import math
import random
import subprocess
from fractions import Fraction
from pathlib import Path

import pytest
from c_library import CONVENTIONS, EMULATOR, Library, assemble, link, objects, single
from cmrc import c40
from cmrc.floats import extended_to_float, float_to_extended
from locations import ROOT
from words import signed

ALL = tuple(name for name in c40.REGISTERS if name not in ("SP", "ST", "DIE", "IIE", "IIF", "IVTP", "TVTP"))
DIVISION = tuple(name for name in ALL if name not in ("R0", "R1", "AR0", "AR1", "RC", "RS", "RE"))
FLOAT = tuple(name for name in ALL if name not in ("R0", "R1"))
EDGES = (0, 1, 2, 3, 5, 7, 10, 0xFFFF, 0x10000, 0x7FFFFFFE, 0x7FFFFFFF, 0x80000000, 0x80000001, 0xFFFFFFFE, 0xFFFFFFFF)
EDGES64 = (*EDGES, 1 << 32, (1 << 32) + 1, (1 << 63) - 1, 1 << 63, (1 << 63) + 1, (1 << 64) - 1, (1 << 64) - (1 << 32))


@pytest.fixture(scope="module", params=CONVENTIONS)
def library(request: pytest.FixtureRequest) -> Library:
    return Library(request.param)


@pytest.fixture(scope="module")
def any_library() -> Library:
    return Library("stack")


def pairs(edges: tuple[int, ...], bits: int, count: int) -> list[tuple[int, int]]:
    rng = random.Random(bits)

    def any_size() -> int:
        return rng.getrandbits(bits) >> rng.randrange(bits)

    out = [(a, b) for a in edges for b in edges]
    out += [(any_size(), any_size()) for _ in range(count)]
    return out + [(-a & (1 << bits) - 1, b) for a, b in out[-count:]]


def towards_zero(a: int, b: int) -> tuple[int, int]:
    quotient = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
    return quotient, a - quotient * b


def divided(a: int, b: int, bits: int) -> dict[str, int]:
    """What each kind of division gives for unsigned words, as words."""
    mask = (1 << bits) - 1
    if b == 0:
        sign = -1 if signed(a, bits) < 0 else 1
        magnitude = abs(signed(a, bits))
        return {"udiv": mask, "umod": a, "div": -sign & mask, "mod": sign * magnitude & mask}
    quotient, remainder = towards_zero(signed(a, bits), signed(b, bits))
    return {"udiv": a // b, "umod": a % b, "div": quotient & mask, "mod": remainder & mask}


def test_ti_division_gives_c_results_and_keeps_what_tis_own_keeps(any_library: Library) -> None:
    names = {"udiv": "DIV_U", "umod": "MOD_U", "div": "DIV_I", "mod": "MOD_I"}
    for a, b in pairs(EDGES, 32, 60):
        for kind, expected in divided(a, b, 32).items():
            assert any_library.operator(names[kind], a, b, DIVISION) & 0xFFFF_FFFF == expected, (
                names[kind],
                hex(a),
                hex(b),
            )
        assert any_library.operator("MPY_I", a, b, FLOAT) & 0xFFFF_FFFF == a * b & 0xFFFF_FFFF


def test_names_of_later_compilers_are_the_same_routines(any_library: Library) -> None:
    symbols = any_library.chip.address
    for name in ("DIV_I", "DIV_U", "MOD_I", "MOD_U", "DIV_F", "INV_F", "MPY_I"):
        assert symbols(name) == symbols(name + "30") == symbols(name + "40")


def test_gcc_division_of_words(library: Library) -> None:
    for a, b in pairs(EDGES, 32, 40):
        for kind, expected in divided(a, b, 32).items():
            assert library.call(f"___{kind}qi3", a, b) & 0xFFFF_FFFF == expected, (kind, hex(a), hex(b))
        assert library.call("___mulqi3", a, b) & 0xFFFF_FFFF == a * b & 0xFFFF_FFFF
        assert library.call("___umulhi3_high", a, b) & 0xFFFF_FFFF == a * b >> 32
        assert library.call("___smulhi3_high", a, b) & 0xFFFF_FFFF == signed(a) * signed(b) >> 32 & 0xFFFF_FFFF


def test_gcc_arithmetic_of_64_bits(any_library: Library) -> None:
    for a, b in pairs(EDGES64, 64, 60):
        for kind, expected in divided(a, b, 64).items():
            assert any_library.call_with_long_longs(f"___{kind}hi3", a, b) == expected, (kind, hex(a), hex(b))
        assert any_library.call_with_long_longs("___mulhi3", a, b) == a * b & (1 << 64) - 1


def test_ffs(library: Library) -> None:
    for word in (*EDGES, *(1 << n for n in range(32)), *(3 << n for n in range(31))):
        assert library.call("___ffs", word) & 0xFFFF_FFFF == (word & -word).bit_length(), hex(word)


def floats(count: int, most: int = 60) -> list[float]:
    rng = random.Random(most)
    out = [1.0, -1.0, 2.0, 3.0, -3.0, 0.1, 1 + 2.0**-23, 2 - 2.0**-23, -1 - 2.0**-23, 7.0, 1e-30, -1e30]
    return [
        single(value)
        for value in out
        + [rng.choice((-1, 1)) * math.ldexp(1 + rng.random(), rng.randrange(-most, most)) for _ in range(count)]
    ]


def relative(found: float, exact: Fraction) -> float:
    return float(abs(Fraction(found) / exact - 1))


def test_division_of_floats_rounds_to_24_bits(library: Library) -> None:
    values = floats(40)
    for a, b in [(a, b) for a in values for b in values[::7]]:
        exact = Fraction(a) / Fraction(b)
        if not 2.0**-120 < abs(exact) < 2.0**120:
            continue
        library.call("___divqf3", a, b)
        of_gcc = library.float()
        assert relative(of_gcc, exact) <= 2.0**-24 * (1 + 2.0**-5), (a, b)
        library.operator("DIV_F", float_to_extended(a), float_to_extended(b), FLOAT)
        assert library.float() == of_gcc


def test_reciprocal_has_32_bits(any_library: Library) -> None:
    for value in floats(300):
        any_library.operator("INV_F", float_to_extended(value), 0, FLOAT)
        assert relative(any_library.float(), 1 / Fraction(value)) <= 2.0**-29, value
    any_library.operator("INV_F", float_to_extended(1.5 * 2.0**127), 0, FLOAT)
    assert any_library.float() == 0


def long_doubles(count: int) -> list[float]:
    return [
        extended_to_float(float_to_extended(value * (1 + 2.0**-30 * (n % 7))))
        for n, value in enumerate(floats(count, 40))
    ]


def test_long_doubles(library: Library) -> None:
    values = long_doubles(30)
    for a, b in [
        (a, b) for a in values for b in values[::5] if abs(math.log2(abs(a / b))) < 120 > abs(math.log2(abs(a * b)))
    ]:
        library.call_with_long_doubles("___divhf3", a, b)
        assert relative(library.float(), Fraction(a) / Fraction(b)) <= 2.0**-28.5, (a, b)
        library.call_with_long_doubles("___mulhf3", a, b)
        assert relative(library.float(), Fraction(a) * Fraction(b)) <= 2.0**-30, (a, b)


def test_floats_to_64_bits_round_towards_zero(library: Library) -> None:
    values = [
        0.0,
        0.5,
        -0.5,
        0.999,
        1.5,
        -1.5,
        2.0**31,
        2.0**32,
        2.0**32 - 256,
        -(2.0**32),
        2.0**62,
        -(2.0**62),
        2.0**63 - 2**39,
        -(2.0**63),
        *floats(120, 62),
    ]
    for value in values:
        if abs(value) >= 2.0**63 and value > 0:
            continue
        for name in ("___fix_truncqfhi2", "___ufix_truncqfhi2"):
            library.call(name, float(value))
            assert library.both() == math.trunc(value) & (1 << 64) - 1, (name, value)
        wide = extended_to_float(float_to_extended(value * (1 + 2.0**-29)))
        library.call_with_long_doubles("___fix_trunchfhi2", wide)
        assert library.both() == math.trunc(wide) & (1 << 64) - 1, wide
    library.call("___ufix_truncqfhi2", 1.5 * 2.0**63)
    assert library.both() == 3 << 62
    library.call_with_long_doubles("___ufix_trunchfhi2", 2.0**64 - 2.0**32)
    assert library.both() == (1 << 64) - (1 << 32)


def test_64_bits_to_floats(any_library: Library) -> None:
    rng = random.Random(6)
    for word in (*EDGES64, *(rng.getrandbits(64) >> rng.randrange(64) for _ in range(200))):
        for sign, value in (("u", word), ("", signed(word, 64))):
            for kind, bound in (("qf", 2.0**-24 * (1 + 2.0**-6)), ("hf", 2.0**-30)):
                any_library.call_with_long_longs(f"___{sign}floathi{kind}2", word)
                found = any_library.float()
                assert found == 0 if value == 0 else relative(found, Fraction(value)) <= bound, (sign, kind, hex(word))


def test_heap_gives_blocks_that_do_not_overlap_and_takes_them_back(library: Library) -> None:
    chip = library.chip
    chip.memory[chip.address("heap_ready")] = 0
    begin, size = chip.address("__sys_memory"), chip.address("__SYSMEM_SIZE")
    rng = random.Random(3)
    blocks: dict[int, tuple[int, int]] = {}
    for step in range(400):
        if blocks and rng.random() < 0.45:
            block = rng.choice(list(blocks))
            words, mark = blocks.pop(block)
            assert chip.memory[block : block + words] == [mark] * words
            library.call("_free", block)
            continue
        words = rng.choice((0, 1, 2, 3, 30, 200, 900))
        block = library.call("_malloc", words) & 0xFFFF_FFFF
        if block == 0:
            continue
        words = max(words, 1)
        assert begin < block and block + words <= begin + size
        assert all(block + words <= other or other + used <= block for other, (used, _) in blocks.items())
        chip.memory[block : block + words] = [step] * words
        blocks[block] = (words, step)
    for block in list(blocks):
        library.call("_free", block)
    library.call("_free", 0)
    assert library.call("_malloc", size) & 0xFFFF_FFFF == 0  # a block's size takes a word, too
    assert library.call("_malloc", -1) & 0xFFFF_FFFF == 0
    assert library.call("_malloc", size - 1) & 0xFFFF_FFFF == begin + 1  # one block again


@pytest.mark.parametrize("words", [0, 1, 2, 77])
def test_memory_is_set_and_copied_to_the_word(library: Library, words: int) -> None:
    chip, source, target = library.chip, 0x340000, 0x350000
    chip.memory[source : source + 80] = [7 * n + 1 for n in range(80)]
    chip.memory[target : target + 80] = [0xABCD] * 80
    assert library.call("_memcpy", target, source, words) & 0xFFFF_FFFF == target
    assert chip.memory[target : target + 80] == [7 * n + 1 if n < words else 0xABCD for n in range(80)]
    assert library.call("_memset", target, -3, words) & 0xFFFF_FFFF == target
    assert chip.memory[target : target + 80] == [0xFFFFFFFD if n < words else 0xABCD for n in range(80)]


PROGRAM = """
        .ref _puts, _putchar, _malloc, _exit
        .global _main, _given, _cleared
        .sect ".cinit"
        .word 3,_given
        .word 11,22,33
        .word 1,_pointer
        .word _text
        .bss _given,3
        .bss _pointer,1
        .bss _cleared,2
        .const
_text:  .word "from C",0
        .text
_main:  ldp  @_given
        ldi  @_pointer,r0
        push r0
        lda  r0,ar2
        call _puts
        subi 1,sp
        ldi  33,r0              ; !
        push r0
        lda  r0,ar2
        call _putchar
        subi 1,sp
        ldi  @_given+1,r0
        addi @_given+2,r0
        addi @_cleared,r0
        rets
"""
BOARD = ROOT / "examples" / "console.toml"


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("model", ["rom", "ram"])
def test_start_up_sets_values_calls_main_and_leaves_its_status(convention: str, model: str, tmp_path: Path) -> None:
    source = tmp_path / "program.asm"
    source.write_text(PROGRAM.replace("        .const\n", '        .sect ".const"\n'))
    made = [*objects(convention), assemble(source, tmp_path)]
    output, placed = tmp_path / "program.out", tmp_path / "map.txt"
    assert link(made, output, "--c-model", model, "--map-output", placed) == ""
    image = c40.read_coff(output)
    assert ("for the loader" in placed.read_text()) == (model == "ram")
    assert image.symbols["cinit"] == (
        0xFFFFFFFF
        if model == "ram"
        else next(section.address for section in image.sections if section.name == ".cinit")
    )
    spoilt = f"{image.symbols['_cleared']:#x}=77"  # .bss: the ROM model's start-up clears it, the RAM model leaves it to the loader
    done = subprocess.run(
        [EMULATOR, "exec", output, "--board", BOARD, "--poke", spoilt, "--json"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr + done.stdout
    found = json.loads(done.stdout)
    expected = 22 + 33 + (77 if model == "ram" else 0)
    assert (found["stop"]["reason"], found["console"], found["registers"]["R0"] & 0xFFFF_FFFF) == (
        "halt",
        "from C\n!",
        expected,
    )
    chip = c40.Processor(image, board=BOARD)
    chip.memory[image.symbols["_cleared"]] = 77
    stop = chip.run(100_000, until="c_exit")
    assert stop.reason == "until" and chip.registers["R0"] & 0xFFFF_FFFF == expected


def test_written_and_read_again_a_ram_model_is_the_same_program(tmp_path: Path) -> None:
    source = tmp_path / "program.asm"
    source.write_text(PROGRAM.replace("        .const\n", '        .sect ".const"\n'))
    output, again = tmp_path / "program.out", tmp_path / "again.out"
    assert link([*objects("stack"), assemble(source, tmp_path)], output, "--c-model", "ram") == ""
    image = c40.read_coff(output)
    c40.write_coff(image, again)
    assert again.read_bytes() == output.read_bytes()
    records = [
        (section.address, list(section.words)) for section in image.sections if section.name.startswith(".cinit.")
    ]
    assert records == [(image.symbols["_given"], [11, 22, 33]), (image.symbols["_pointer"], [image.symbols["_text"]])]


def test_a_record_that_runs_out_of_the_table_is_refused(tmp_path: Path) -> None:
    source = tmp_path / "bad.asm"
    source.write_text('\t.global _main\n\t.sect ".cinit"\n\t.word 9,300000h,1\n\t.text\n_main:\trets\n')
    output = tmp_path / "bad.out"
    message = link([*objects("stack"), assemble(source, tmp_path)], output, "--c-model", "ram")
    assert "record 0 of .cinit asks for 9 words, but 2 are left" in message and not output.exists()


def test_initial_values_of_the_loader_may_not_lie_on_the_program(tmp_path: Path) -> None:
    source = tmp_path / "bad.asm"
    source.write_text('\t.global _main\n\t.sect ".cinit"\n\t.word 1,_main,1\n\t.text\n_main:\trets\n')
    output = tmp_path / "bad.out"
    message = link([*objects("stack"), assemble(source, tmp_path)], output, "--c-model", "ram")
    assert "the sections .text" in message and ".cinit.0" in message and "overlap" in message and not output.exists()


def test_a_memory_map_can_ask_for_the_model_stack_and_heap(tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(
        'c_model = "ram"\n[memory]\nlocal = { origin = 0x300000, length = 0x20000 }\n[sections]\n".stack" = { memory = "local", size = 0x500 }\n'
        '".sysmem" = { memory = "local", size = 0x3000 }\n[symbols]\n__console = 0xC0000000\n'
    )
    source = tmp_path / "program.asm"
    source.write_text(PROGRAM.replace("        .const\n", '        .sect ".const"\n'))
    own_place = [path for path in objects("stack") if path.stem != "console_at"]
    assert link([*own_place, assemble(source, tmp_path)], tmp_path / "x.out", "--map", tmp_path / "map.toml") == ""
    image = c40.read_coff(tmp_path / "x.out")
    symbols, sizes = image.symbols, {section.name: section.size for section in image.sections}
    assert (symbols["cinit"], sizes[".stack"], symbols["__SYSMEM_SIZE"], symbols["__console"]) == (
        0xFFFFFFFF,
        0x500,
        0x3000,
        0xC0000000,
    )
    (tmp_path / "map.toml").write_text('c_model = "rim"\n[memory]\nlocal = { origin = 0x300000, length = 0x20000 }\n')
    assert 'c_model: "rom" or "ram" is expected' in link(own_place, tmp_path / "y.out", "--map", tmp_path / "map.toml")


def test_every_file_of_the_run_time_is_in_the_page() -> None:
    page = (ROOT / "docs" / "from-c.md").read_text()
    files = sorted((ROOT / "c40_programs" / "lib" / "c").glob("*.asm"))
    assert files
    for file in files:
        assert file.name in page, file.name
