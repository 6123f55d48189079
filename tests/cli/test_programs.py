"""emulator asm, disasm and exec: programs in, words and results out."""

import json
import re
from pathlib import Path

import pytest
from traces import without_operands

SQUARES = """
; the first eight squares into a table, by repeated addition
        .data
table   .space 8
        .text
start:  ldi   @table_at,ar0
        ldi   0,r0              ; square
        ldi   1,r1              ; next odd number
        ldi   7,rc
        rptb  loop
        sti   r0,*ar0++
        addi  r1,r0
loop:   addi  2,r1
        ldf   1.5,r2
        mpyf  r2,r2,r3
done:   b     done
table_at .word table
        .global start, done
"""


@pytest.fixture
def squares(tmp_path: Path) -> Path:
    source = tmp_path / "squares.asm"
    # The pointer is reached by DP: both lie in the page of .text.
    source.write_text(SQUARES.replace("start:  ldi", "start:  ldp   table_at\n        ldi", 1))
    return source


def test_exec_runs_source_to_its_end(run, squares) -> None:
    result = run("exec", squares, "--dump", "table:8")
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith("stop: halt: branch to itself at ")
    dump = [line for line in result.stdout.splitlines() if re.fullmatch(r"[0-9A-F]{8}:( [0-9A-F]{8})+", line)]
    assert [int(word, 16) for word in dump[0].split(": ")[1].split()] == [n * n for n in range(8)]
    assert "2.25" in result.stdout  # R3 as a float


def test_exec_json_accounts_every_cycle(run, squares) -> None:
    result = run("exec", squares, "--until", "done", "--json", "--dump", "table:3", "--dump", "table:1")
    report = json.loads(result.stdout)
    assert report["stop"]["reason"] == "until"
    assert sum(report["causes"].values()) == report["cycles"] > report["instructions"] >= 3 * 8
    assert report["registers"]["R0"] & 0xFFFFFFFF == 64
    assert report["floats"]["R3"] == 2.25
    assert [dump["words"] for dump in report["dumps"]] == [[0, 1, 4], [0]]


def test_coff_and_source_run_alike(run, squares, tmp_path: Path) -> None:
    made = run("asm", squares, "-o", "squares.out", "--listing", "squares.lst")
    assert (made.returncode, made.stdout, made.stderr) == (0, "", "")
    assert "mpyf" in (tmp_path / "squares.lst").read_text()
    assert run("exec", "squares.out", "--json").stdout == run("exec", squares, "--json").stdout


def test_disasm_assembles_to_the_same_words(run, squares, tmp_path: Path) -> None:
    run("asm", squares, "-o", "squares.out")
    text = run("disasm", "squares.out").stdout
    words = re.findall(r"^[0-9A-F]{8}  ([0-9A-F]{8})  (.*)$", text, re.MULTILINE)
    assert any(instruction.startswith("rptb") for _, instruction in words)
    assert "done:" in text.splitlines()
    code = text.split("; section .text")[1].split("; section")[0]
    lines = re.findall(r"^(?:(\w+):)$|^[0-9A-F]{8}  ([0-9A-F]{8})  (.*)$", code, re.MULTILINE)
    again = tmp_path / "again.asm"
    again.write_text("\n".join(f"{label}:" if label else f"        {instruction}" for label, _, instruction in lines))
    assert run("asm", again, "-o", "again.out").returncode == 0
    rebuilt = re.findall(r"^[0-9A-F]{8}  ([0-9A-F]{8})  ", run("disasm", "again.out").stdout, re.MULTILINE)
    assert rebuilt == [word for _, word, _ in lines if word]


@pytest.mark.parametrize("mark", ["", "\ufeff"])  # the byte order mark of UTF-8
def test_hex_is_loaded_and_started_at_the_given_address(run, tmp_path: Path, mark: str) -> None:
    # ldi 5,r0 ; addi 2,r0 ; b $ (words of c40-isa.md's tables: 08600005, 02600002, branch to itself 6A00FFFF)
    (tmp_path / "p.hex").write_text(f"{mark}08600005\n02600002\n6A00FFFF\n", encoding="utf-8")
    result = run("exec", "p.hex", "--load-at", "1000h", "--board", "flat", "--json")
    report = json.loads(result.stdout)
    assert report["registers"]["R0"] & 0xFFFFFFFF == 7
    assert (report["stop"]["reason"], report["stop"]["pc"]) == ("halt", 0x1002)


def test_hex_that_passes_the_end_of_memory_is_refused(run, tmp_path: Path) -> None:
    (tmp_path / "p.hex").write_text("0C800000\n" * 20)
    assert run("disasm", "p.hex", "--load-at", "0FFFFFFECh").stdout.endswith("19 more of the same, to FFFFFFFFh\n")
    for command in ("disasm", "exec"):
        refused = run(command, "p.hex", "--load-at", "0FFFFFFEDh")
        assert refused.returncode == 2
        assert "p.hex: 20 words at FFFFFFEDh pass the end of the address space" in refused.stderr
    refused = run("disasm", "p.hex", "--cpu", "c3x", "--load-at", "0FFFFFFh")
    assert "p.hex: 20 words at FFFFFFh pass the end of the address space" in refused.stderr


def test_loads_that_pass_the_end_of_memory_are_refused(run, tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text("start: b start\n")
    (tmp_path / "two").write_bytes(bytes(range(8)))
    flat = ["exec", "p.asm", "--board", "flat"]
    assert "FFFFFFFE: 03020100 07060504" in run(*flat, "--load", "two@0FFFFFFFEh", "--dump", "0FFFFFFFEh:2").stdout
    for options in (
        ["--load", "two@0FFFFFFFFh"],
        ["--rom", "two@0FFFFFFFFh", "--rom-width", "32", "--boot", "300000h"],
    ):
        refused = run(*flat, *options)
        assert (
            refused.returncode == 2
            and "2 words at FFFFFFFFh do not lie in memory: the words pass the end" in refused.stderr
        )


def test_limit_of_cycles(run, tmp_path: Path) -> None:
    (tmp_path / "loop.asm").write_text("start: nop\n       b start\nnever: nop\n")
    for option, status, message in (
        ("--max-cycles", 1, "--max-cycles 1000 reached"),
        ("--cycles", 0, "the 1000 cycles of --cycles"),
    ):
        for program in (["loop.asm"], ["loop.asm", "loop.asm", "--link", "0.0:1.3"]):  # one chip, and a network
            plain = run("exec", *program, option, 1000, "--json")
            report = json.loads(plain.stdout)
            assert (plain.returncode, report["stop"]["reason"]) == (status, "limit")
            assert (message if len(program) == 1 else option) in report["stop"]["message"]
            for chip in report.get("chips", [report]):
                assert 1000 <= chip["cycles"] < 1010
            assert run("exec", *program, option, 1000, "--until", "never").returncode == status
    # A program that ends before has ended, whatever the limit.
    (tmp_path / "end.asm").write_text("start: nop\nhalt: b halt\n")
    assert "stop: halt" in run("exec", "end.asm", "--cycles", 1000).stdout
    (tmp_path / "bad.asm").write_text("start: .word 0FFFFFFFFh\n")
    assert run("exec", "bad.asm", "--cycles", 1000).returncode == 1


def test_idle_without_an_interrupt_to_come_ends_the_run(run, tmp_path: Path) -> None:
    (tmp_path / "idle.asm").write_text("start: ldi 3,r0\n       idle\n       ldi 4,r0\n")
    report = json.loads(run("exec", "idle.asm", "--json").stdout)
    assert report["stop"]["reason"] == "idle"
    assert report["registers"]["R0"] & 0xFFFFFFFF == 3


@pytest.mark.parametrize(
    ("source", "what"),
    [
        ("start: ldhi 0C000h,ar0\n ldi *ar0,r0\n", "C0000000h"),  # window to bus A: no target there
        ("start: .word 0FFFFFFFFh\n", "300000"),  # a reserved word: the PC is named
        ("start: ldhi 0F000h,ar0\n ldi *ar0,r0\n", "F0000000"),  # a reserved address
    ],
)
def test_what_a_chip_cannot_do_is_a_typed_stop(run, tmp_path: Path, source: str, what: str) -> None:
    (tmp_path / "p.asm").write_text(source)
    result = run("exec", "p.asm")
    assert result.returncode == 1
    first = result.stdout.splitlines()[0]
    assert re.match("stop: (fault|external_access): ", first)
    assert what.upper() in first.upper()


def test_trace_shows_every_instruction_and_changes_nothing(run, squares, tmp_path: Path) -> None:
    plain = run("exec", squares, "--json").stdout
    assert run("exec", squares, "--json", "--trace", "t.trace").stdout == plain
    lines = (tmp_path / "t.trace").read_text().splitlines()
    assert lines[0] == "# cmrc instruction trace 1"
    assert len(lines) - 1 == json.loads(plain)["instructions"]
    # Cycles of the lines add up: each line starts where the one before ended.
    cycle = 0
    for line in lines[1:]:
        at, rest = line.split(" ", 1)
        assert int(at) == cycle
        spent = re.findall(r" (?:branch|register_conflict|memory_conflict|wait_state)=(\d+)", rest)
        cycle += 1 + sum(map(int, spent))
    assert cycle == json.loads(plain)["cycles"]


def test_a_labelled_trace_does_not_show_where_the_program_lies(run, squares, tmp_path: Path) -> None:
    traces = []
    for place in ("300000h", "301234h"):
        assert run("asm", squares, "-o", "p.out", "--section", f".text={place}").returncode == 0
        result = run("exec", "p.out", "--board", "flat", "--trace", "t", "--trace-labels")
        assert result.returncode == 0, result.stderr
        traces.append((tmp_path / "t").read_text())
    # A COFF file has no source: the operands are disassembled, and a direct address shows its place.
    assert [without_operands(line) for line in traces[0].splitlines()] == [
        without_operands(line) for line in traces[1].splitlines()
    ]
    assert traces[0].startswith("# cmrc labelled instruction trace 1\n0 [dsp 0] start -  ")
    # The plain trace's cycles and causes, in the same order.
    assert run("exec", "p.out", "--board", "flat", "--trace", "plain").returncode == 0
    plain = (tmp_path / "plain").read_text().splitlines()[1:]
    labelled = traces[0].splitlines()[1:]
    causes = re.compile(r"^(\d+) | (branch|register_conflict|memory_conflict|wait_state)=(\d+)")
    assert [causes.findall(line) for line in labelled] == [causes.findall(line) for line in plain]
    assert run("trace-diff", "t", "t").returncode == 0
    assert "traces of two kinds" in run("trace-diff", "t", "plain").stderr
