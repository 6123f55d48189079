"""SIGINT, SIGTERM and SIGHUP: the work ends at its next slice and writes what it has, a second signal ends the program
at once.

A signal is sent after the program has shown that it works: by data through a pipe that it writes or reads, by a line,
or by its child process. No test depends on the clock; timeouts only end a process that hangs.
"""

import array
import fcntl
import json
import os
import shutil
import signal
import subprocess
import sys
import termios
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from locations import BUILD

EMULATOR = BUILD / "bin" / "emulator"
PATIENCE = 120
SIGNALS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
LOOP = "        .text\n_start: ldi 0,r0\nround:  addi 1,r0\n        b round\n"
SEND = "        .text\n_start: ldp 100042h\n        ldi 0,r0\nround:  addi 1,r0\n        sti r0,@100042h\n        b round\n"
TAKE = "        .text\n_start: ldp 100071h\nround:  ldi @100071h,r0\n        b round\n"
LONG = ["--duration", "80000", "--set", "report.signal_decimation=80000"]


@dataclass
class Job:
    """A front end that runs without end, and the sign that it runs."""

    arguments: list[str]
    shown: Callable[["Running"], None]
    check: Callable[["Running"], None] = lambda running: None
    pipes: list[str] = field(default_factory=list)
    """FIFOs that it writes."""


class Running:
    """The program, and what came through its pipes."""

    def __init__(self, folder: Path, job: Job, **more: object) -> None:
        self.folder, self.job = folder, job
        self.came = {name: b"" for name in job.pipes}
        self.readers = []
        for name in job.pipes:
            os.mkfifo(folder / name)
        self.out, self.err = (folder / "stdout").open("wb"), (folder / "stderr").open("wb")
        self.before = {path.name for path in folder.iterdir()}
        self.process = subprocess.Popen(
            [EMULATOR, *job.arguments], cwd=folder, stdout=self.out, stderr=self.err, **more
        )  # type: ignore[call-overload]
        for name in job.pipes:
            thread = threading.Thread(target=self._read, args=(name,), daemon=True)
            thread.start()
            self.readers.append(thread)
        job.shown(self)

    def _read(self, name: str) -> None:
        with (self.folder / name).open("rb", buffering=0) as pipe:
            while part := pipe.read(1 << 16):
                self.came[name] += part

    def until(self, ready: Callable[[], bool]) -> None:
        """Polls until the condition holds; fails if the program ends before."""
        while not ready():
            assert self.process.poll() is None, self.stderr()
            threading.Event().wait(0.005)

    def came_through(self, name: str) -> None:
        self.until(lambda: len(self.came[name]) > 0)

    def children(self) -> list[int]:
        listed = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        try:
            return [int(number) for number in listed.read_text().split()]
        except OSError:  # it has ended
            return []

    def has_child(self) -> None:
        self.until(lambda: bool(self.children()))

    def computes(self) -> None:
        """A fifth of a second of processor time is more than it takes to begin the run."""
        self.has_child()

        def used() -> int:
            fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
            return int(fields[11]) + int(fields[12])

        self.until(lambda: used() > os.sysconf("SC_CLK_TCK") // 5)

    def has_said(self, words: str) -> None:
        self.until(lambda: words in self.stderr())

    def stderr(self) -> str:
        return (self.folder / "stderr").read_text()

    def stdout(self) -> str:
        return (self.folder / "stdout").read_text()

    def json(self, name: str) -> dict:  # type: ignore[type-arg]
        return json.loads((self.folder / name).read_text())  # type: ignore[no-any-return]

    def signal(self, number: signal.Signals) -> int:
        self.process.send_signal(number)
        return self.end()

    def end(self) -> int:
        status = self.process.wait(PATIENCE)
        for thread in self.readers:
            thread.join(PATIENCE)
        return status

    def new_files(self) -> set[str]:
        return {path.name for path in self.folder.iterdir()} - self.before


def feed(running: Running) -> None:
    """The program has read a megabyte of vectors, and the test sends more without end."""
    line = b"id=v op=0C800000 -> PC=00001001\n" * 1000
    sent = 0
    enough = threading.Event()

    def write() -> None:
        nonlocal sent
        with (running.folder / "vectors").open("wb", buffering=0) as pipe:
            try:
                while True:
                    sent += pipe.write(line)
                    if sent > 1 << 20:
                        enough.set()
            except BrokenPipeError:
                pass

    threading.Thread(target=write, daemon=True).start()
    assert enough.wait(PATIENCE), running.stderr()


def taken(name: str) -> Callable[[Running], None]:
    """The program has opened an input that never ends."""

    def shown(running: Running) -> None:
        running.held = (running.folder / name).open("wb", buffering=0)  # type: ignore[attr-defined]

    return shown


def run_check(running: Running) -> None:
    report = running.json("r.json")
    assert report["stop_reason"] == "interrupted" and 0 < report["simulated_s"] < 80000
    for task in report["tasks"].values():
        assert task["released"] == sum(
            task[outcome] for outcome in ("on_time", "late", "unfinished", "never_started", "lost", "dropped")
        )
    assert report["errors"] is not None and report["errors"]["window_s"][1] <= report["simulated_s"]
    assert "The run ended early: interrupted" in running.stdout()
    assert running.stderr() == ""


def trace_check(running: Running) -> None:
    lines = running.came["t"].decode().splitlines()
    assert lines[0] == "# cmrc event trace 1" and running.came["t"].endswith(b"\n")
    report = running.json("r.json")
    assert report["stop_reason"] == "interrupted" and float(lines[-1].split()[0]) == pytest.approx(
        report["simulated_s"], abs=2.5e-4
    )  # the drives latch each 125 us


def exec_check(running: Running) -> None:
    found = json.loads(running.stdout())
    assert found["stop"]["reason"] == "interrupted"
    assert len(running.came["t"].splitlines()) - 1 == found["instructions"] > 0
    assert sum(found["causes"].values()) == found["cycles"]


def network_check(running: Running) -> None:
    found = json.loads(running.stdout())
    assert found["stop"]["reason"] == "interrupted" and len(found["chips"]) == 2
    assert len(running.came["t.chip0"].splitlines()) - 1 == found["chips"][0]["instructions"] > 0


def limits_check(running: Running) -> None:
    found = running.json("l.json")
    assert found["stop_reason"] == "interrupted"
    points = found["scans"]["dsps"]["points"]
    assert any(point["ran"] for point in points) and not all(point["ran"] for point in points)
    for point in points:
        assert point["ran"] == (point["stop_reason"] is not None)
    assert "not run: interrupted" in running.stdout()


def compare_check(running: Running) -> None:
    found = running.json("c.json")
    assert found["stop_reason"] == "interrupted" and 0 < found["duration_s"] < 80000
    assert found["metrics"]["load error RMS"]["ideal"] is not None
    assert "; interrupted" in running.stdout()


def vectors_check(running: Running) -> None:
    found = json.loads(running.stdout())
    assert found["stop_reason"] == "interrupted" and found["passed"] > 1000 and found["failed"] == 0


def nothing_new(running: Running) -> None:
    assert running.new_files() == set() and running.stderr() == ""


JOBS = {
    "run": Job([*LONG, "--report", "r.json"], Running.computes, run_check),
    "run with a trace": Job(
        [*LONG, "--set", "report.reference=none", "--report", "r.json", "--trace", "t", "--quiet"],
        lambda r: r.came_through("t"),
        trace_check,
        ["t"],
    ),
    "exec": Job(
        ["exec", "loop.asm", "--json", "--cycles", str(10**13), "--trace", "t"],
        lambda r: r.came_through("t"),
        exec_check,
        ["t"],
    ),
    "network": Job(
        ["exec", "send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--cycles", str(10**13), "--trace", "t"],
        lambda r: r.came_through("t.chip0"),
        network_check,
        ["t.chip0", "t.chip1"],
    ),
    "limits": Job(
        [
            "limits",
            "--duration",
            "1000",
            "--set",
            "machine.boot=preloaded",
            "--set",
            "host.start_ms=0",
            "--dsps-grid",
            "1:4",
            "--json",
            "l.json",
        ],
        lambda r: r.has_said("1 of 4"),
        limits_check,
    ),
    "compare": Job(["compare", *LONG, "--json", "c.json"], Running.computes, compare_check),
    "vectors": Job(["vectors", "vectors", "--json"], feed, vectors_check),
    # What has nothing to show half-way ends at the first signal, and leaves no file.
    "asm": Job(["asm", "endless.asm", "-o", "o.out", "--listing", "o.lst"], taken("endless.asm"), nothing_new),
    "link": Job(["link", "endless.obj", "-o", "o.out"], taken("endless.obj"), nothing_new),
    "disasm": Job(["disasm", "endless.out"], taken("endless.out"), nothing_new),
    "trace-diff": Job(["trace-diff", "endless.trace", "endless.trace"], taken("endless.trace"), nothing_new),
    "configuration": Job([*LONG, "--config", "endless.toml", "--report", "r.json"], taken("endless.toml"), nothing_new),
}


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    for name, text in (("loop", LOOP), ("send", SEND), ("take", TAKE)):
        (tmp_path / f"{name}.asm").write_text(text)
    for name in ("vectors", "endless.asm", "endless.obj", "endless.out", "endless.trace", "endless.toml"):
        os.mkfifo(tmp_path / name)
    yield tmp_path


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
@pytest.mark.parametrize("job", JOBS.values(), ids=list(JOBS))
def test_a_signal_ends_the_work_and_what_it_has_is_written(folder: Path, job: Job, number: signal.Signals) -> None:
    running = Running(folder, job)
    children = running.children()
    assert running.signal(number) == SIGNALS[number], running.stderr()
    job.check(running)
    assert not [name for name in running.new_files() if name.endswith(".part")]
    for child in children:
        assert not Path(f"/proc/{child}").exists()


def test_ctrl_c_at_a_terminal_comes_to_the_children_too(folder: Path) -> None:
    running = Running(folder, JOBS["limits"], start_new_session=True)
    os.killpg(running.process.pid, signal.SIGINT)
    assert running.end() == 130, running.stderr()
    limits_check(running)


@pytest.mark.parametrize("answers", [True, False])
def test_a_signal_while_the_ideal_run_is_waited_for(folder: Path, answers: bool) -> None:
    """The run itself ends early, since no DSP is left; its ideal run would take hours more. One that does not answer is
    left out."""
    (folder / "dead.toml").write_text(
        "".join(f'[[events]]\nat_s = 0.05\naction = "fail"\ndsp = {slot}\n' for slot in range(2))
    )
    arguments = [*LONG, "--dsps", "2", "--config", "dead.toml", "--set", "run.after_stop_s=0.1", "--report", "r.json"]
    running = Running(folder, Job(arguments, Running.has_child))
    stat = Path(f"/proc/{running.process.pid}/stat")
    running.until(lambda: stat.read_text().rsplit(")", 1)[1].split()[0] == "S")
    [child] = running.children()
    if not answers:
        os.kill(child, signal.SIGSTOP)
    assert running.signal(signal.SIGTERM) == 143
    report = running.json("r.json")
    assert report["stop_reason"] == "interrupted" and (report["errors"] is not None) == answers
    assert answers or "did not stop" in report["reference_problem"]
    assert not Path(f"/proc/{child}").exists()


def pending(process: "subprocess.Popen[bytes]") -> bool:
    status = Path(f"/proc/{process.pid}/status").read_text()
    return any(int(line.split()[1], 16) != 0 for line in status.splitlines() if line.startswith(("SigPnd", "ShdPnd")))


SHIM = """
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <sys/syscall.h>
#include <unistd.h>
static int opened(const char* path, int flags, mode_t mode) {
  if ((flags & O_TMPFILE) == O_TMPFILE) { errno = EOPNOTSUPP; return -1; }
  return syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}
#define OPEN(name) int name(const char* path, int flags, ...) { va_list a; va_start(a, flags); mode_t m = va_arg(a, mode_t); va_end(a); return opened(path, flags, m); }
OPEN(open)
OPEN(open64)
"""


@pytest.fixture(scope="module")
def without_nameless_files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of a program whose file system has no files without a name, as NFS has none."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler for a file system without nameless files")
    folder = tmp_path_factory.mktemp("shim")
    (folder / "shim.c").write_text(SHIM)
    subprocess.run([compiler, "-shared", "-fPIC", "-o", folder / "shim.so", folder / "shim.c"], check=True)
    return {**os.environ, "LD_PRELOAD": str(folder / "shim.so")}


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
@pytest.mark.unsanitized
def test_a_second_signal_ends_at_once_and_leaves_no_file(
    folder: Path, without_nameless_files: dict[str, str], number: signal.Signals
) -> None:
    """The program waits in a write to a pipe without a reader, so the first signal cannot end it."""
    os.mkfifo(folder / "t")
    with os.fdopen(os.open(folder / "t", os.O_RDWR), "rb", buffering=0) as pipe:
        job = Job(
            [*LONG, "--set", "report.reference=none", "--report", "r.json", "--trace", "t", "--quiet"], lambda r: None
        )
        running = Running(folder, job, env=without_nameless_files)
        full = fcntl.fcntl(pipe, fcntl.F_GETPIPE_SZ)  # type: ignore[attr-defined]
        waiting = array.array("i", [0])

        def stands() -> bool:
            fcntl.ioctl(pipe, termios.FIONREAD, waiting)
            return waiting[0] == full

        running.until(stands)
        assert [name for name in running.new_files() if name.endswith(".part")]
        running.process.send_signal(number)
        running.until(lambda: not pending(running.process))
        assert running.process.poll() is None
        assert running.signal(number) == SIGNALS[number]
        assert running.new_files() == set()


@pytest.mark.unsanitized
def test_a_first_signal_outside_the_work_leaves_no_file(folder: Path, without_nameless_files: dict[str, str]) -> None:
    """One output is open. The other is a pipe: the program waits until a reader opens it."""
    os.mkfifo(folder / "t")
    running = Running(
        folder, Job([*LONG, "--report", "r.json", "--trace", "t"], lambda r: None), env=without_nameless_files
    )
    running.until(lambda: any(name.endswith(".part") for name in running.new_files()))
    assert running.signal(signal.SIGTERM) == 143
    assert running.new_files() == set()


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_signal_that_is_ignored_at_the_start_stays_ignored(folder: Path, number: signal.Signals) -> None:
    other = next(each for each in SIGNALS if each != number)
    running = Running(folder, JOBS["exec"], preexec_fn=lambda: signal.signal(number, signal.SIG_IGN))
    running.process.send_signal(number)
    running.until(lambda: not pending(running.process))
    so_far = len(running.came["t"])
    running.until(lambda: len(running.came["t"]) > so_far + (1 << 20))  # it continues
    assert running.signal(other) == SIGNALS[other]
    exec_check(running)


TWO_AT_ONCE = """
import signal
from cmrc.signals import raised
both = [signal.SIGINT, signal.SIGTERM]
for number in both:
    signal.signal(number, signal.SIG_DFL)  # in a job in the background SIGINT is ignored
with raised():
    signal.pthread_sigmask(signal.SIG_BLOCK, both)
    for number in both:
        signal.raise_signal(number)
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, both)
    except KeyboardInterrupt:
        pass  # as the code of a library may do
    while True:
        pass
"""


def test_two_signals_that_come_together_end_a_command_of_the_package_at_once() -> None:
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python")}
    ended = subprocess.run(
        [sys.executable, "-c", TWO_AT_ONCE], env=environment, capture_output=True, text=True, check=False, timeout=60
    )
    assert (ended.returncode, ended.stderr) == (-signal.SIGTERM, "")
