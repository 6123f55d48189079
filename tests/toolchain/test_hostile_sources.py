"""Damaged and hostile sources: an error with its place, quickly, and never a crash."""

import random
import subprocess
from pathlib import Path

import pytest
from cmrc._core import toolchain
from hypothesis import given, settings
from hypothesis import strategies as st
from locations import ROOT

EXAMPLES = ROOT / "c40_programs/examples"
SEEDS = [path.read_text() for path in sorted(EXAMPLES.glob("*.asm"))]
DIRECTIVES = """
        .asg    AR3,FP
        .eval   2*3,n
FP2     .set    AR4
m       .macro  a,most=3,c
        .var    i
        .eval   0,i
        .loop
        .break  i == most
        .eval   i+1,i
        ldi     *+FP(i),r0
x?:     b       x?
        .if     $symlen(a) > 2
        .mexit
        .elseif $symcmp(a,"q") = 0
        .word   :c(1):, :c(2,2):
        .else
        .string "a,b",0
        .endif
        .endloop
        .endm
        m       abc,2,"d,e"
        m       q,1,12345
$1:     mpyf3   *ar0++(1)%,*ar1++(ir0)b,r0 || addf3 r0,r2,r2
        dbnzd   ar3,$1
        .newblock
        .field  3,4
        .field  -1,5
        .ieee   1.5,-2e-3
        .ldouble 3.14159
        .usect  "x",3
buf     .usect  "stack",100,4
        .bss    y,4,1
        .sect   ".const"
t:      .word   t,hi16(t)&0FFh,lo16(t)<<2,page(buf),single(1.0)/2
        .byte   "text",10,0
        .align  16
        .space  3
        .bes    2
        .ref    elsewhere
        .def    t
        .version 40
"""


def outcome(source: str) -> str:
    try:
        toolchain.assemble(source, include_dirs=[EXAMPLES])
        result = "fine"
    except toolchain.AssemblyError as error:
        assert error.diagnostics and all(
            d["line"] >= 0 and d["column"] >= 1 and d["message"] for d in error.diagnostics
        )
        assert len(error.diagnostics) <= 1001
        result = "refused"
    try:
        toolchain.assemble_object(source, include_dirs=[EXAMPLES])
    except toolchain.AssemblyError:
        pass
    return result


def damaged(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(lines))
        line = lines[at]
        kind = rng.randrange(8)
        if kind == 0:
            lines[at] = line[: rng.randint(0, len(line))]
        elif kind == 1:
            lines.insert(at, rng.choice(lines))
        elif kind == 2:
            del lines[at]
            lines = lines or [""]
        elif kind == 3:
            place = rng.randint(0, len(line))
            lines[at] = (
                line[:place]
                + rng.choice("*+-()%,;:'\"\\$?@#&|=<>~!^.0x9hb_ \t\0\x80\xff") * rng.choice([1, 2, 40])
                + line[place:]
            )
        elif kind == 4:
            lines[at] = line.replace(
                rng.choice("0123456789"), rng.choice(["", "99999999999999999999", "-", "0FFFFFFFFh", "1e999"])
            )
        elif kind == 5:
            other = rng.choice(lines)
            lines[at] = line[: rng.randint(0, len(line))] + other[rng.randint(0, len(other)) :]
        elif kind == 6:
            words = line.split()
            rng.shuffle(words)
            lines[at] = "\t" + " ".join(words)
        else:
            lines[at] = line.upper() if rng.random() < 0.5 else line.lstrip()
    return "\n".join(lines)


def test_the_sources_that_are_damaged_below_are_sound() -> None:
    assert [outcome(source) for source in [*SEEDS, DIRECTIVES]] == ["fine"] * (len(SEEDS) + 1)


def test_damaged_sources_are_assembled_or_refused() -> None:
    rng = random.Random(1998)
    outcomes = [outcome(damaged(rng.choice([*SEEDS, DIRECTIVES, DIRECTIVES, DIRECTIVES]), rng)) for _ in range(600)]
    assert outcomes.count("fine") > 20 and outcomes.count("refused") > 200


@settings(max_examples=400, deadline=None)
@given(st.text(alphabet="*+-()%,;:'\"\\$?@|=<>~!.0xhbrai12 \t\nldifwos", max_size=120))
def test_any_text_is_assembled_or_refused(text: str) -> None:
    outcome(text)
    outcome("m .macro a\n " + text + '\n .endm\n m 1\n m "x,y"\n')


@settings(max_examples=300, deadline=None)
@given(st.lists(st.sampled_from(DIRECTIVES.split("\n")), max_size=30))
def test_any_order_of_directives_is_assembled_or_refused(lines: list[str]) -> None:
    outcome("\n".join(lines) + "\n")


def nested(depth: int) -> str:
    """Macros that call one another, `depth` deep."""
    return (
        "".join(f"m{n} .macro\n\tm{n + 1}\n\t.endm\n" for n in range(1, depth))
        + f"m{depth} .macro\n\tnop\n\t.endm\n\tm1\n"
    )


@pytest.mark.parametrize(
    ("most", "more", "message"),
    [
        (
            "\tnop ;" + "x" * (65536 - 6) + "\n",
            "\tnop ;" + "x" * (65536 - 5) + "\n",
            "a line of 65537 characters; 65536 are the most",
        ),
        (nested(100), nested(101), "nested deeper than 100"),
    ],
)
def test_a_limit_is_allowed_and_one_more_is_not(most: str, more: str, message: str) -> None:
    assert len(toolchain.assemble(most).sections[0].words) == 1
    with pytest.raises(toolchain.AssemblyError, match=message):
        toolchain.assemble(more)


@pytest.mark.parametrize(
    ("source", "line", "message"),
    [
        ("\t.word 1/0\n", 1, "division by zero"),
        ("\t.word 5%(3-3)\n", 1, "division by zero"),
        ("\t.if 1/0\n\t.endif\n", 1, "division by zero"),
        ("\t.float 1.0/0.0\n", 1, "division by zero"),
        ("\t.word -9223372036854775808/-1\n", 1, "not a number"),
        ("\t.word 1<<64\n", 1, "a shift count"),
        ("\t.space -1\n", 1, "cannot be -1"),
        ("\t.space 1<<40\n", 1, "cannot be"),
        ("\t.align 0\n", 1, "power of 2"),
        ("s\t.struct\n\t.align 3\nz\t.endstruct\n", 2, "power of 2"),
        ("\t.eval undefined+1,n\n", 1, "undefined symbol"),
        ("\t.loop\n\t.endloop\n", 1, None),
        ("\t.rept 1000000\n\tnop\n\tnop\n\t.endr\n", 2, "more than 1000000 lines"),
        ("m .macro\n\tm\n\t.endm\n\tm\n", 2, "nested deeper than 100"),
        ("m .macro\n\tm\n\tm\n\t.endm\n\tm\n", 2, "nested deeper than 100"),
        ("\t.asg \"a a\",a\n\t.word a\n", 2, None),
        ("\t.asg \"b b b b b b b b b b b b b b b b\",a\n\t.asg \"a a a a a a a a a a a a a a a a\",b\n\t.word a\n", 3, "longer than 65536"),
        ("\tb far\n\t.space 8000h\nfar:\n", 1, "the target is 32768 words away"),
        ("\tdb ar0,far\n\t.space 8000h\nfar:\n", 1, "words away"),
        ("\tbr far\nfar .set 40000000h\n", 1, "words away"),
        ("\tldi *+ar0(256),r0\n", 1, "0 to 255"),
        ("a .set b\nb .set c\nc .set a\n\t.word a\n", 1, "in terms of itself"),
        ("\t.field 1,33\n", 1, "1 to 32 bits"),
        ("\t.string \"" + "x" * 70000 + "\"\n", 1, "are the most"),
        ("\t.word " + "-" * 600 + "1\n", 1, "500 operators"),
    ],
)  # fmt: skip
def test_what_a_slip_can_ask_for(source: str, line: int, message: str | None) -> None:
    if message is None:
        outcome(source)
    else:
        with pytest.raises(toolchain.AssemblyError) as caught:
            toolchain.assemble(source)
        first = caught.value.diagnostics[0]
        assert first["line"] == line and message in first["message"], first


def test_a_thousand_errors_are_reported_and_then_an_end_is_made() -> None:
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble("\tbogus\n" * 5000)
    assert len(caught.value.diagnostics) == 1001


CHAIN = "".join(f"x{i + 1} .set x{i}+x{i}\n" for i in range(60))
TAGS = "s0 .struct\nx .word\nz0 .endstruct\n" + "".join(
    f"s{i + 1} .struct\na .tag s{i}\nb .tag s{i}\nz{i + 1} .endstruct\n" for i in range(40)
)


@pytest.mark.parametrize(
    ("source", "word"),
    [
        (f"\t.word {'1|' * 499}1\n", 1),
        (f"\t.word {'0<<' * 60}1\n", 0),
        (f"\t.word single({'1.0+' * 400}1.0)\n", 0x08488000),
        (f"\t.word {'-' * 499}1\n", 0xFFFFFFFF),
        (f"\t.word {'~' * 498}1\n", 1),
        (f"\t.word {'hi16(' * 99}x{')' * 99}\nx .set 1\n", 0),
        ("\t.word x60>>60\n" + CHAIN + "x0 .set 1\n", 1),
    ],
    ids=["or", "shift", "float", "minus", "not", "hi16", "forward symbols"],
)
def test_what_is_written_once_is_evaluated_once(source: str, word: int) -> None:
    """Twice for each operator or symbol would be 2 to the power of 60 or more: no end."""
    assert toolchain.assemble(source).sections[0].words[0] == word


def test_a_symbol_that_later_symbols_give_a_value_has_it() -> None:
    source = "a .set c+1\n .word a\nb .set a+1\nc .set d\n .word b\nd .set 5\ne .set a+b\n .word e\n"
    assert list(toolchain.assemble(source).sections[0].words) == [6, 7, 13]
    assert list(toolchain.assemble("a .set hi16(b)\nc .set a\n .word c,a\nb .word 0\n").sections[0].words[:2]) == [
        0x30,
        0x30,
    ]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("".join(f"x{i} .set nix\n" for i in range(20000)), "undefined symbol 'nix' (in 'x0', defined at <text>:1)"),
        ("".join(f"x{i} .set y{i}\n" for i in range(20000)), "undefined symbol 'y0'; did you mean 'x0'? (in"),
        ("".join(f"x{i} .set x{i + 1}\n" for i in range(20000)), "'x200' is defined through more than 200"),
        ("s .struct\n" + "".join(f"m{i} .word\n" for i in range(3000)) + "z .endstruct\nname .tag s\n", "undefined symbol 'name'"),
        (" .loop 300\n .loop 300\n foo r0\n .endloop\n .endloop\n", "there is no instruction, directive or macro 'foo'"),
        (" .foo\n" * 2000, "there is no directive '.foo'"),
    ],
)  # fmt: skip
def test_errors_of_one_kind_cost_little_however_many_there_are(source: str, message: str) -> None:
    """The number of names compared in search of a suggestion has a limit, and an error is found once."""
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble(source)
    assert message in caught.value.diagnostics[0]["message"]
    assert len(caught.value.diagnostics) == 1001
    gives_up = "(there may be more errors; the assembler gives up after 1000)"
    assert [gives_up in each["message"] for each in caught.value.diagnostics] == [False] * 1000 + [True]


def test_suggestions_end_when_many_names_have_been_compared() -> None:
    """20,000 names and 1000 undefined symbols: the first hundred get a suggestion."""
    names = "".join(f"place{i:05} .set {i}\n" for i in range(20000))
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble(names + "".join(f" .word plaze{i:05}\n" for i in range(1000)))
    suggested = ["did you mean" in error["message"] for error in caught.value.diagnostics]
    assert suggested == [True] * 100 + [False] * 900


def test_structures_of_structures_have_a_limit() -> None:
    """Each has the members of the one before twice: 2 to the power of 40 names."""
    with pytest.raises(
        toolchain.AssemblyError, match="too many members: the names that structures make have more than"
    ):
        toolchain.assemble(TAGS)


def test_nothing_is_written_when_something_is_wrong(tmp_path: Path, emulator: Path) -> None:
    (tmp_path / "bad.asm").write_text("\tldi 70000,r0\n\t.word 1/0\n\tcall nowhere\n")
    (tmp_path / "cut.o").write_bytes((Path(__file__).parent / "linking/a.gnu.o").read_bytes()[:500])
    (tmp_path / "huge.out").write_bytes(b"\xc2\x00\xff\xff" + b"\xff" * 60)
    for arguments in (
        ("asm", "bad.asm", "-o", "x.out", "--listing", "x.lst"), ("asm", "bad.asm", "-c", "-o", "x.o"), ("link", "cut.o", "-o", "x.out", "--map-output", "x.map"),
        ("link", "huge.out", "-o", "x.out"), ("disasm", "huge.out"), ("disasm", "cut.o"), ("exec", "huge.out"), ("exec", "bad.asm"),
    ):  # fmt: skip
        done = subprocess.run(
            [emulator, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=20
        )
        assert done.returncode == 2 and done.stderr.startswith("emulator: ") and done.stdout == "", arguments
    done = subprocess.run(
        [emulator, "asm", "bad.asm", "-o", "x.out"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert [line.split(": ", 1)[0] for line in done.stderr.removeprefix("emulator: ").splitlines() if "error:" in line] == [
        "bad.asm:1:6", "bad.asm:2:9", "bad.asm:3:7",
    ]  # fmt: skip
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.asm", "cut.o", "huge.out"]
