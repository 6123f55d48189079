"""Output files appear whole or not at all, never replace an input, and are never lost without a message."""

import json
import os
import resource
import shutil
import signal
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from bench_board import HEAD
from locations import BUILD, ROOT

EMULATOR = BUILD / "bin" / "emulator"
PROGRAM = "        .text\n_start: ldi 1,r0\n        idle\n"
SHORT = ["--duration", "0.021", "--set", "report.reference=none"]
RUN = [*SHORT, "--quiet"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "s.asm").write_text(PROGRAM)
    (tmp_path / "part.inc").write_text("two     .set 2\n")
    (tmp_path / "with.asm").write_text('        .include "part.inc"\n' + PROGRAM)
    (tmp_path / "c.toml").write_text("[machine]\ndsps = 2\n")
    (tmp_path / "net.toml").write_text('[[chip]]\nprogram = "s.asm"\n[[chip]]\nprogram = "s.asm"\n')
    subprocess.run([EMULATOR, "asm", "-c", "s.asm", "-o", "s.obj"], cwd=tmp_path, check=True)
    (tmp_path / "link").symlink_to("s.asm")
    os.link(tmp_path / "s.asm", tmp_path / "second_name.asm")
    return tmp_path


def emulator(folder: Path, *arguments: str, **more: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([EMULATOR, *arguments], check=False, cwd=folder, capture_output=True, text=True, **more)  # type: ignore[call-overload,no-any-return]


# ---- where an output goes


@pytest.mark.parametrize(
    "command",
    [
        ["asm", "s.asm", "-o"],
        ["link", "s.obj", "-o"],
        ["asm", "s.asm", "-o", "x.out", "--listing"],
        [*RUN, "--report"],
        ["exec", "s.asm", "--trace"],
    ],
)
@pytest.mark.parametrize("by_link", [False, True])
def test_a_pipe_is_written_into_and_stays_a_pipe(folder: Path, command: list[str], by_link: bool) -> None:
    os.mkfifo(folder / "pipe")
    (folder / "to_pipe").symlink_to("pipe")
    name = "to_pipe" if by_link else "pipe"
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append((folder / "pipe").read_bytes()))
    reader.start()
    assert emulator(folder, *command, name, timeout=60).returncode == 0
    reader.join()
    assert read[0] and stat.S_ISFIFO((folder / "pipe").stat().st_mode) and (folder / "to_pipe").is_symlink()


@pytest.mark.parametrize(
    "command", [["asm", "s.asm", "-o"], ["link", "s.obj", "-o"], ["exec", "s.asm", "--trace"], [*RUN, "--report"]]
)
def test_a_device_stays_a_device_and_a_full_one_is_reported(folder: Path, command: list[str]) -> None:
    (folder / "null").symlink_to("/dev/null")
    assert emulator(folder, *command, "null").returncode == 0
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode) and (folder / "null").is_symlink()
    full = emulator(folder, *command, "/dev/full")
    assert full.returncode == 1 and "/dev/full: writing failed: No space left on device" in full.stderr
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)


def test_a_reader_that_goes_away_costs_only_its_own_output(folder: Path) -> None:
    """The run, its report and its page are there; the error names the pipe."""
    os.mkfifo(folder / "pipe")

    def read_a_little() -> None:
        with (folder / "pipe").open("rb") as pipe:
            pipe.read(10)

    reader = threading.Thread(target=read_a_little)
    reader.start()
    ended = emulator(folder, *RUN, "--report", "r.json", "--page", "p.html", "--trace", "pipe", timeout=60)
    reader.join()
    assert (ended.returncode, ended.stderr) == (1, "emulator: pipe: writing failed: Broken pipe\n")
    assert json.loads((folder / "r.json").read_text())["stop_reason"] == "completed"
    assert "</html>" in (folder / "p.html").read_text()[-100:]


TALKS = """        .text
_start: ldhi 0010h,ar0
        or 0042h,ar0
        ldhi 0A000h,ar1
        ldi 65,r0
        sti r0,*ar0         ; port 0
        sti r0,*ar1         ; the console
        idle
"""
WITH_CONSOLE = (
    HEAD
    + """
[[device]]
name = "d"
kind = "console"
base = 0xA0000000
"""
)
TALKING = """[[chip]]
program = "talks.asm"
board = "b.toml"
[[chip]]
program = "s.asm"
[[link]]
ports = "0.0:1.3"
"""
OUTPUTS = {
    "--dsps 1": ["--report", "--page", "--profile", "--trace", "--perfetto"],
    "--dsps 2": ["--snapshot-at 0.01:", "--report", "--snapshot-at 0.02:"],
    "asm s.asm": ["-o", "--listing"],
    "link s.obj": ["-o", "--map-output"],
    "exec talks.asm --board b.toml": ["--trace", "--events", "--device-output d="],
    "exec --network talking.toml": ["--link-trace", "--events", "--perfetto"],
}


@pytest.mark.parametrize(("command", "lost"), [(name, n) for name, all in OUTPUTS.items() for n in range(len(all))])
def test_an_output_that_is_lost_costs_no_other_one(command: str, lost: int, folder: Path) -> None:
    for name, text in (("talks.asm", TALKS), ("b.toml", WITH_CONSOLE), ("talking.toml", TALKING)):
        (folder / name).write_text(text)
    (folder / f"out{lost}").symlink_to("/dev/full")
    options = " ".join(
        f"{option}{'' if option[-1] in ':=' else ' '}out{n}" for n, option in enumerate(OUTPUTS[command])
    )
    ended = emulator(folder, *command.split(), *(RUN if "--dsps" in command else []), *options.split(), timeout=60)
    assert ended.returncode == 1, ended.stderr
    assert ended.stderr.endswith(f"emulator: out{lost}: writing failed: No space left on device\n")
    assert sorted(path.name for path in folder.glob("out*")) == [f"out{n}" for n in range(len(OUTPUTS[command]))]


def test_a_snapshot_that_cannot_be_written_is_refused_before_the_run(folder: Path) -> None:
    ended = emulator(folder, "--duration", "80000", "--quiet", "--snapshot-at", "79999:no/s.bin", timeout=20)
    assert (ended.returncode, ended.stderr) == (2, "emulator: no/s.bin: cannot be written: No such file or directory\n")


@pytest.mark.parametrize("what", ["s.asm", "s.obj", "x.out"])
@pytest.mark.parametrize(
    "command",
    [["exec", "pipe"], ["disasm", "pipe"], ["image", "pipe", "--format", "intel-hex", "-o", "rom"]],
    ids=" ".join,
)
def test_a_program_in_a_pipe_is_read_once(folder: Path, command: list[str], what: str) -> None:
    """Whoever opens it first ends its writer when it closes, and a second opening has nobody to wait for. What kind of
    file it is, is seen from the pipe's name: a source is no COFF file."""
    assert emulator(folder, "asm", "s.asm", "-o", "x.out").returncode == 0
    os.mkfifo(folder / "pipe")
    openings: list[str] = []

    def write() -> None:
        with (folder / "pipe").open("wb") as pipe:
            openings.append(what)
            try:
                pipe.write((folder / what).read_bytes())
                pipe.flush()
            except BrokenPipeError:
                openings.append("broken")

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    ended = emulator(folder, *command, timeout=20)
    writer.join(20)
    assert openings == [what]
    if what == "s.asm":
        assert ended.returncode == 2 and "pipe: not a COFF file" in ended.stderr
    else:
        assert ended.returncode == emulator(folder, *[what if word == "pipe" else word for word in command]).returncode


def test_a_link_to_a_file_stays_a_link_and_the_files_mode_stays(folder: Path) -> None:
    (folder / "kept.out").write_text("old")
    (folder / "kept.out").chmod(0o640)
    (folder / "to_kept").symlink_to("kept.out")
    assert emulator(folder, "asm", "s.asm", "-o", "to_kept").returncode == 0
    assert (folder / "to_kept").is_symlink() and (folder / "kept.out").read_bytes()[:2] == b"\xc2\x00"
    assert stat.S_IMODE((folder / "kept.out").stat().st_mode) == 0o640
    (folder / "nowhere").symlink_to("new.out")
    assert emulator(folder, "asm", "s.asm", "-o", "nowhere").returncode == 0
    assert (folder / "nowhere").is_symlink() and (folder / "new.out").is_file()


def test_the_umask_is_kept_for_a_new_file(folder: Path) -> None:
    assert emulator(folder, "asm", "s.asm", "-o", "new.out", preexec_fn=lambda: os.umask(0o027)).returncode == 0
    assert stat.S_IMODE((folder / "new.out").stat().st_mode) == 0o640


def test_nothing_stands_beside_the_output_while_it_is_written_nor_after_a_kill(folder: Path) -> None:
    process = subprocess.Popen(
        [EMULATOR, "--duration", "100", "--quiet", "--set", "report.reference=none", "--trace", "t", "--report", "r"],
        cwd=folder,
    )
    before = sorted(path.name for path in folder.iterdir())
    try:
        process.wait(timeout=0.5)
    except subprocess.TimeoutExpired:
        process.kill()
    assert process.wait() == -9
    after = sorted(path.name for path in folder.iterdir())
    assert [name for name in after if name not in before and not name.endswith(".part")] == []
    if os.path.exists("/proc/self/fd"):
        assert after == before  # the file has no name until it is whole


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def small_files() -> None:
    """No file may have more than 100 bytes, as after `ulimit -f`."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))


COMMANDS = [["asm", "s.asm", "-o"], ["link", "s.obj", "-o"], ["exec", "s.asm", "--trace"], [*RUN, "--report"]]


@pytest.mark.parametrize("there", [False, True])
@pytest.mark.parametrize("command", COMMANDS)
def test_after_a_failed_write_nothing_is_left_and_the_old_file_stays(
    folder: Path, command: list[str], there: bool
) -> None:
    if there:
        (folder / "out").write_text("old")
    before = names(folder)
    done = emulator(folder, *command, "out", preexec_fn=small_files)
    assert done.returncode == 1 and "out: writing failed: File too large" in done.stderr
    assert names(folder) == before
    assert not there or (folder / "out").read_text() == "old"


def test_after_an_error_of_the_last_step_nothing_is_left(folder: Path) -> None:
    """While the program runs, a folder takes the output's name: the whole file cannot take its place."""
    (folder / "endless.asm").write_text("        .text\n_start: addi 1,r0\n        b _start\n")
    command = [EMULATOR, "exec", "endless.asm", "--max-cycles", "1000000000000", "--events", "t"]
    process = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)
    before = names(folder)
    # Half a second of its processor time: assembling takes a hundredth of that, so by then the endless program runs.
    while (
        int(Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11]) < os.sysconf("SC_CLK_TCK") // 2
    ):
        assert process.poll() is None
        time.sleep(0.01)
    (folder / "t").mkdir()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode != 0 and "t: writing failed: Is a directory" in said
    assert [name for name in names(folder) if name not in before] == ["t"] and names(folder / "t") == []


# ---- outputs over inputs, and over each other


@pytest.mark.parametrize(
    "command",
    [
        ["asm", "s.asm", "-o", "s.asm"],
        ["asm", "s.asm", "-o", "./s.asm"],
        ["asm", "s.asm", "-o", "link"],
        ["asm", "s.asm", "-o", "second_name.asm"],
        ["asm", "s.asm", "-o", "o.out", "--listing", "s.asm"],
        ["asm", "s.asm", "-o", "o.out", "--listing", "o.out"],
        ["asm", "with.asm", "-o", "part.inc"],
        ["link", "s.obj", "-o", "s.obj"],
        ["link", "s.obj", "-o", "o.out", "--map-output", "o.out"],
        ["exec", "s.asm", "--trace", "s.asm"],
        ["exec", "with.asm", "--events", "part.inc"],
        ["exec", "s.asm", "--trace", "x", "--events", "x"],
        ["exec", "s.asm", "--trace", "x", "--events", "./x"],
        ["exec", "--network", "net.toml", "--events", "net.toml"],
        ["exec", "--network", "net.toml", "--link-trace", "s.asm"],
        [*RUN, "--config", "c.toml", "--report", "c.toml"],
        [*RUN, "--trace", "x", "--report", "x"],
        [*RUN, "--trace", "x", "--profile", "x"],
        [*RUN, "--trace", "x", "--trace-instructions", "0", "--report", "x.dsp0"],
        ["limits", "--config", "c.toml", "--json", "c.toml"],
        ["compare", "--config", "c.toml", "--json", "c.toml"],
    ],
    ids=" ".join,
)
def test_an_output_that_is_an_input_or_another_output_is_refused(folder: Path, command: list[str]) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = emulator(folder, *command, timeout=60)
    assert (
        result.returncode == 2
        and "is the same file as" in result.stderr
        and "another name is expected" in result.stderr
    ), result.stderr
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


BOARD = """[[region]]
name = "code"
kind = "ram"
base = 0x300000
words = 256
bus = "local"
[[region]]
name = "rom"
kind = "ram"
base = 0x400000
words = 16
bus = "local"
file = "rom.bin"
width = 32
"""


@pytest.mark.parametrize(
    ("command", "output"),
    [
        (["exec", "s.asm", "--board", "b.toml", "--trace"], "rom.bin"),
        *((["exec", "--network", "n.toml", "--events"], name) for name in ("p.out", "b.toml", "rom.bin")),
        ([*RUN, "--programs", "programs", "--report"], "programs/dsp.asm"),
        ([*RUN, "--programs", "programs", "--report"], "programs/include/areas.inc"),
        ([*RUN, "--programs", "programs", "--trace"], "programs/not_there_yet"),
        (["compare", *SHORT, "--programs", "programs", "--json"], "programs/dsp.asm"),
        *(([*RUN, "--programs", "programs", "--report"], name) for name in ("outside.inc", "outside.asm")),
        *((["compare", *SHORT, "--programs", "programs", "--json"], name) for name in ("outside.inc", "outside.asm")),
    ],
)
def test_a_file_that_another_one_names_is_an_input(folder: Path, command: list[str], output: str) -> None:
    (folder / "b.toml").write_text(BOARD)
    (folder / "rom.bin").write_bytes(bytes(64))
    (folder / "n.toml").write_text('[[chip]]\nprogram = "p.out"\nboard = "b.toml"\n[[chip]]\nprogram = "s.asm"\n')
    emulator(folder, "asm", "s.asm", "-o", "p.out")
    shutil.copytree(ROOT / "c40_programs", folder / "programs")
    (folder / "outside.inc").write_text("")
    dsp = folder / "programs" / "dsp.asm"
    dsp.rename(folder / "outside.asm")
    dsp.symlink_to("../outside.asm")
    dsp.write_text('        .include "../outside.inc"\n' + dsp.read_text())
    before = (folder / output).read_bytes() if (folder / output).exists() else None
    result = emulator(folder, *command, output, timeout=60)
    assert result.returncode == 2 and "another name is expected" in result.stderr, result.stderr
    assert ((folder / output).read_bytes() if (folder / output).exists() else None) == before


@pytest.mark.parametrize("option", ["--console-input -", "--console-input live", "--device-input d=-"])
def test_standard_input_may_be_a_file_that_is_no_output(folder: Path, option: str) -> None:
    for name, text in (("talks.asm", TALKS), ("b.toml", WITH_CONSOLE), ("typed", "hello")):
        (folder / name).write_text(text)
    command = ["exec", "talks.asm", "--board", "b.toml", *option.split(), "--trace"]
    for output, status in (("typed", 2), ("new", 0)):
        with (folder / "typed").open() as typed:
            ended = emulator(folder, *command, output, stdin=typed, timeout=60)
        assert ended.returncode == status, ended.stderr
        assert (folder / "typed").read_text() == "hello"
    assert (folder / "new").exists()


@pytest.mark.parametrize("first", ["one", "target"])
def test_two_links_to_a_file_that_is_not_there_are_one_output(folder: Path, first: str) -> None:
    (folder / "one").symlink_to("target")
    (folder / "two").symlink_to("target")
    result = emulator(folder, *RUN, "--report", first, "--trace", "two", timeout=60)
    assert result.returncode == 2 and "is the same file as" in result.stderr, result.stderr
    assert not (folder / "target").exists()
    assert emulator(folder, *RUN, "--report", "one", timeout=60).returncode == 0
    assert (folder / "target").exists() and (folder / "one").is_symlink()


def test_devices_may_be_named_twice(folder: Path) -> None:
    assert emulator(folder, *RUN, "--trace", "/dev/null", "--report", "/dev/null").returncode == 0
    assert emulator(folder, "exec", "s.asm", "--trace", "/dev/null", "--events", "/dev/null").returncode == 0


def test_the_configuration_of_a_page_is_not_replaced_by_it(folder: Path) -> None:
    before = (folder / "c.toml").read_text()
    command = [sys.executable, "-m", "cmrc", "page", "c.toml", "--out", "c.toml"]
    result = subprocess.run(
        command,
        check=False,
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
    )
    assert (
        result.returncode == 2
        and "is the same file as RUN" in result.stderr
        and (folder / "c.toml").read_text() == before
    )


# ---- standard output


PRINTING = [
    ["exec", "s.asm"],
    ["exec", "s.asm", "--json"],
    ["exec", "--network", "net.toml"],
    ["disasm", "s.obj"],
    ["config"],
    ["--help"],
    ["classify", "--range", "0:10"],
    SHORT,
]


@pytest.mark.parametrize("command", PRINTING, ids=" ".join)
def test_a_full_or_closed_standard_output_is_reported(folder: Path, command: list[str]) -> None:
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [EMULATOR, *command], check=False, cwd=folder, stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert result.returncode == 1 and "No space left on device" in result.stderr
    closed = subprocess.run(
        [EMULATOR, *command], check=False, cwd=folder, stderr=subprocess.PIPE, text=True, preexec_fn=lambda: os.close(1)
    )
    assert closed.returncode == 1 and "Bad file descriptor" in closed.stderr
    from_pipe, into_pipe = os.pipe()
    os.close(from_pipe)
    left = subprocess.run(
        [EMULATOR, *command], check=False, cwd=folder, stdout=into_pipe, stderr=subprocess.PIPE, text=True
    )
    os.close(into_pipe)
    assert left.returncode == 1 and left.stderr.endswith("standard output: writing failed: Broken pipe\n")


def test_an_output_file_never_gets_what_is_printed(folder: Path) -> None:
    """With standard output closed, the first file that is opened would have its number."""
    subprocess.run(
        [EMULATOR, "exec", "s.asm", "--trace", "t"],
        check=False,
        cwd=folder,
        stderr=subprocess.DEVNULL,
        preexec_fn=lambda: os.close(1),
    )
    assert "stop:" not in (folder / "t").read_text()


@pytest.mark.parametrize("output", ["out", "/dev/stdout", "to_out"])
@pytest.mark.parametrize("mode", ["w", "a"])
def test_a_file_with_what_is_printed_gets_an_output_too(folder: Path, output: str, mode: str) -> None:
    """As a terminal or a pipe would. Replaced, it would lose one of them."""
    (folder / "to_out").symlink_to("out")
    (folder / "out").write_text("before\n")
    with (folder / "out").open(mode) as out:
        ended = subprocess.run([EMULATOR, *SHORT, "--report", output], check=False, cwd=folder, stdout=out, timeout=60)
    text = (folder / "out").read_text()
    assert ended.returncode == 0
    assert text.startswith("before\n") == (mode == "a")
    assert '"schema_version"' in text and "\nhash " in text and not list(folder.glob("*.part"))


# ---- long names


@pytest.mark.parametrize("letter", ["x", "ü"])
def test_a_name_may_have_as_many_bytes_as_the_file_system_allows(folder: Path, letter: str) -> None:
    bytes_max = os.pathconf(folder, "PC_NAME_MAX")
    name = letter * (bytes_max // len(letter.encode()))
    done = emulator(folder, *RUN, "--report", name)
    assert done.returncode == 0, done.stderr
    assert (folder / name).read_text().startswith("{") and not list(folder.glob("*.part"))
    before = sorted(folder.iterdir())
    done = emulator(folder, *RUN, "--report", name + letter)
    assert done.returncode == 2 and "File name too long" in done.stderr and sorted(folder.iterdir()) == before
