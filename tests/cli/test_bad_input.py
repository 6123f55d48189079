"""Bad input: one clear message on standard error, exit status 2, and no file where none was finished."""

from pathlib import Path

import pytest


def refused(result, *messages: str) -> None:
    assert result.returncode == 2, (result.stdout, result.stderr)
    assert result.stdout == ""
    assert result.stderr.startswith("emulator: ")
    for message in messages:
        assert message in result.stderr


def files_of(directory: Path) -> set[str]:
    return {path.name for path in directory.iterdir()}


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        (["--dsps", "0"], ["--dsps", "1", "16"]),
        (["--dsps", "10000"], ["--dsps", "16"]),
        (["--dsps", "-1"], ["--dsps"]),
        (["--dsps", "many"], ["--dsps"]),
        (["--dsps", "1", "--dsps", "2"], ["--dsps: given 2 times; once is expected"]),
        (["exec", "x.asm", "--entry", "a", "--entry", "b"], ["--entry: given 2 times; once is expected"]),
        (["--duration", "-5"], ["--duration"]),
        (["--duration", "soon"], ["--duration"]),
        (["--preset", "hevy"], ["hevy", "heavy"]),
        (["--idle-policy", "sleep"], ["doorbell", "pause", "spin"]),
        (["--eq7", "guessed"], ["restored", "as_printed"]),
        (["--seed", "x"], ["--seed"]),
        (["--config", "missing.toml"], ["missing.toml"]),
        (["--programs", "nowhere", "--duration", "0.03"], ["nowhere"]),
        (["--trace-window", "3", "--trace", "t"], ["--trace-window", "A:B"]),
        (["--trace-window", "5:2", "--trace", "t"], ["--trace-window", "5:2"]),
        (["--trace-window", "0:1"], ["--trace-window", "--trace"]),
        (["--trace-instructions", "9", "--trace", "t"], ["--trace-instructions", "9"]),
        (
            ["--trace-instructions", "1", "--trace", "t", "--set", "run.ideal=true"],
            ["--trace-instructions", "no DSP 1; 0 to 0"],
        ),
        (["--trace-labels", "--trace", "t"], ["--trace-labels", "--trace-instructions"]),
        (["exec", "x.asm", "--trace-labels"], ["--trace-labels", "--trace FILE"]),
        (["--set", "gamma"], ["--set", "KEY=VALUE"]),
        (["--set", "scheduling.gama_refreshes=1"], ["gamma_refreshes"]),
        (["--set", "scheduling.gamma_refreshes=often"], ["gamma_refreshes", "integer"]),
        (["--report", "no/such/place.json"], ["no/such/place.json"]),
        (["--report", "."], ["directory"]),
        (["--trace", "no/such/trace"], ["no/such/trace"]),
        (["--dspz", "4"], ["--dspz"]),
        (["dance"], ["dance"]),
        (["asm"], ["FILE"]),
        (["asm", "x.asm"], ["--output"]),
        (["exec"], ["PROGRAM"]),
        (["exec", "missing.out"], ["missing.out: no such file"]),
        (["exec", "."], ["directory"]),
        (["exec", "missing.asm"], ["missing.asm"]),
        (["disasm", "missing.out"], ["missing.out"]),
        (["trace-diff", "a", "b"], ["a: no such file"]),
    ],
)
def test_arguments(run, tmp_path: Path, arguments: list[str], messages: list[str]) -> None:
    refused(run(*arguments), *messages)
    assert files_of(tmp_path) == set()


@pytest.mark.parametrize(
    ("toml", "messages"),
    [
        ("[machine]\ndspss = 4\n", ["c.toml:2:", "dspss", "dsps"]),
        ('[machine]\ndsps = "four"\n', ["c.toml:2:", "dsps", "integer"]),
        ("dsps = 2\n", ["c.toml:1:1: dsps: no such key outside a table; machine.dsps is expected, below [machine]"]),
        ("[machine]\ndsps = 10000\n", ["c.toml:2:", "dsps", "16"]),
        ("[rates]\nrefresh_frequency_hz = 1500\n", ["c.toml", "refresh_frequency_hz"]),  # f_s >= 2 f_p
        ("[scheduling]\nq = 0x5000\n", ["q"]),  # 0 < q < p
        ("[scheduling]\np = 0x7F00\n", ["p"]),  # p + b < 7FFFh
        ("[scheduling]\na = 0x200\n", ["a"]),  # q + b + a (N_a,max - beta - 1) < 7FFFh
        ("[scheduling]\ngamma_refreshes = 8\n", ["gamma"]),  # gamma < N_p
        ("[scheduling]\nalpha_refreshes = 64\n", ["alpha"]),  # alpha < N_t
        ("[machine\ndsps = 4\n", ["c.toml:"]),
        ("[orchestra]\n", ["orchestra"]),
    ],
)
def test_configuration(run, tmp_path: Path, toml: str, messages: list[str]) -> None:
    (tmp_path / "c.toml").write_text(toml)
    refused(run("--config", "c.toml", "--report", "r.json", "--duration", "0.001"), *messages)
    assert files_of(tmp_path) == {"c.toml"}


def test_assembly_errors_have_their_places_and_leave_no_file(run, tmp_path: Path) -> None:
    (tmp_path / "bad.asm").write_text("start: ldi 5,r0\n       ldi r0\n       bogus r1,r2\n       b nowhere\n")
    for command in (["asm", "bad.asm", "-o", "bad.out", "--listing", "bad.lst"], ["exec", "bad.asm", "--trace", "t"]):
        result = run(*command)
        refused(result, "bad.asm:2:", "bad.asm:3:", "bad.asm:4:", "bogus r1,r2")
        assert files_of(tmp_path) == {"bad.asm"}


def test_asm_keeps_an_older_output_when_it_fails(run, tmp_path: Path) -> None:
    (tmp_path / "bad.asm").write_text(" bogus r1\n")
    (tmp_path / "old.out").write_text("precious")
    refused(run("asm", "bad.asm", "-o", "old.out"))
    assert (tmp_path / "old.out").read_text() == "precious"


@pytest.mark.parametrize(
    "content", [b"", b"hello, world\n" * 50, bytes(64), b"\xc2\x00" + bytes(10), bytes(range(256)) * 8]
)
def test_a_program_that_is_no_coff(run, tmp_path: Path, content: bytes) -> None:
    (tmp_path / "p.out").write_bytes(content)
    refused(run("exec", "p.out"), "p.out")
    refused(run("disasm", "p.out"), "p.out")


def test_a_coff_file_cut_short(run, tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text("start: ldi 5,r0\n b start\n")
    assert run("asm", "p.asm", "-o", "p.out").returncode == 0
    whole = (tmp_path / "p.out").read_bytes()
    for size in range(1, len(whole), 7):
        (tmp_path / "cut.out").write_bytes(whole[:size])
        result = run("exec", "cut.out", "--cycles", 10)
        assert result.returncode in (0, 2), size  # what is cut may be nothing but symbols
        assert result.returncode == 0 or "cut.out" in result.stderr


def test_hex_words_are_checked(run, tmp_path: Path) -> None:
    (tmp_path / "p.hex").write_text("08600005\nhello\n")
    refused(run("exec", "p.hex", "--load-at", "1000h", "--board", "flat"), "p.hex:2:", "hello")
    (tmp_path / "p.hex").write_text("123456789\n")
    refused(run("exec", "p.hex"), "p.hex:1:")
    (tmp_path / "p.hex").write_text("\n")
    refused(run("exec", "p.hex"), "contains no word")
    (tmp_path / "p.hex").write_bytes(b"12\0\n")
    refused(run("exec", "p.hex"), 'p.hex:1: "12\\x00" is not a word; up to 8 hexadecimal digits per line are expected')


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        (["--board", "kitchen"], ["kitchen", "default", "flat"]),
        (["--until", "nowhere"], ["--until", "nowhere"]),
        (["--entry", "nowhere"], ["--entry", "nowhere"]),
        (["--dump", "start"], ["--dump", "ADDRESS:COUNT"]),
        (["--dump", "start:0"], ["--dump: 0 words; 1 to 1000000 are possible"]),
        (["--dump", "start:1000001"], ["--dump: 1000001 words; 1 to 1000000 are possible"]),
        (["--dump", "0F0000000h:1000000"], ["F0000000h is no memory of this board"]),
        (["--dump", "start:x"], ["--dump"]),
        (["--dump", "0F0000000h:4"], ["F0000000"]),
        (["--dump", "1FFFFFFFFh:4"], ["--dump"]),
        (["--max-cycles", "0"], ["--max-cycles"]),
        (["--cycles", "0"], ["--cycles"]),
        (["--cycles", "-5"], ["--cycles"]),
        (["--cycles", "many"], ["--cycles"]),
        (["--cycles", "5", "--max-cycles", "5"], ["--cycles", "--max-cycles"]),
        (["--load-at", "1000h"], ["--load-at", ".hex"]),
        (["--trace", "no/such/trace"], ["no/such/trace"]),
    ],
)
def test_exec_arguments(run, tmp_path: Path, arguments: list[str], messages: list[str]) -> None:
    (tmp_path / "p.asm").write_text("start: ldi 5,r0\nend: b end\n")
    refused(run("exec", "p.asm", *arguments), *messages)
    assert files_of(tmp_path) == {"p.asm"}


def test_help_is_no_error(run) -> None:
    for arguments in (["--help"], ["exec", "--help"], ["asm", "--help"]):
        result = run(*arguments)
        assert (result.returncode, result.stderr) == (0, "")
        assert "Usage" in result.stdout
