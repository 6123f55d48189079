"""Child processes that do pieces of work. Processes, not threads: ODE has one random number generator per process. Not
multiprocessing: it would run a notebook's or a script's own lines again in every process."""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import select
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing_extensions import Self

PR_SET_PDEATHSIG = 1
LOOK_S = 0.1


def environment() -> dict[str, str]:
    """The environment of a Python that finds the same modules as this one."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}


def die_with_parent(parent: int) -> None:
    """The kernel ends this process when its parent ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def leave_signals_to_parent() -> None:
    """A terminal sends signals to both processes; the parent handles them and ends this process."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)


def ended(status: int) -> str:
    """How a process ended, in words."""
    if status < 0:
        try:
            return f"ended by {signal.Signals(-status).name}"
        except ValueError:
            return f"ended by signal {-status}"
    return f"ended with status {status}"


class Helpers:
    """``with Helpers("cmrc.limit_worker", 2) as helpers``: processes of ``python -m MODULE PARENT``. Each reads lines
    of JSON and answers each line with one. They end with the block, or with this process."""

    def __init__(self, module: str, count: int) -> None:
        self.module, self.count = module, count
        self.processes: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> Self:
        command = [sys.executable, "-m", self.module, str(os.getpid())]
        try:
            for _ in range(self.count):
                self.processes.append(
                    subprocess.Popen(command, env=environment(), stdin=subprocess.PIPE, stdout=subprocess.PIPE)
                )
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def _end(self) -> None:
        for process in self.processes:
            process.kill()
        for process in self.processes:
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    with contextlib.suppress(BrokenPipeError):
                        stream.close()

    def answers(self, requests: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """The number of a request and its answer, in the order in which they arrive. Raises RuntimeError if a process
        dies of its request."""
        waiting = deque(enumerate(requests))
        idle = list(self.processes)
        busy: dict[int, tuple[subprocess.Popen[bytes], int, bytes]] = {}  # by the descriptor of its answers
        while waiting or busy:
            while waiting and idle:
                number, request = waiting.popleft()
                process = idle.pop()
                assert process.stdin is not None and process.stdout is not None
                with contextlib.suppress(BrokenPipeError):  # its end is seen below
                    process.stdin.write(json.dumps(request).encode() + b"\n")
                    process.stdin.flush()
                busy[process.stdout.fileno()] = (process, number, b"")
            for stream in select.select(list(busy), [], [], LOOK_S)[0]:
                process, number, received = busy.pop(stream)
                new = os.read(stream, 1 << 16)
                if not new:
                    raise RuntimeError(f"the process of a run {ended(process.wait())}")
                received += new
                if received.endswith(b"\n"):
                    idle.append(process)
                    yield number, json.loads(received)
                else:
                    busy[stream] = (process, number, received)


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0))
