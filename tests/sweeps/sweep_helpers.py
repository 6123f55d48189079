"""Stand-ins for a run, for what real runs do too rarely: they go to the workers by value."""

import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

import cloudpickle
from cmrc.sweeps import store

cloudpickle.register_pickle_by_value(sys.modules[__name__])


def report_with(**more: Any) -> dict[str, Any]:
    """A report with no more than a reader of results needs."""
    return {
        "schema_version": 4, "emulator_version": "0", "stop_reason": "completed", "simulated_s": 1.0, "hash": "",
        "containers_delivered": 0, "configuration": {}, "tasks": {}, "buses": {}, "misses": [], "dsps": [],
        "cycles": [], "rates": None, "errors": None, **more,
    }  # fmt: skip


def answer(key: str, **more: Any) -> dict[str, Any]:
    return {
        "key": key,
        "status": store.DONE,
        "message": "",
        "hash": key,
        "report": store.packed({"schema_version": 4, "number": 1}),
        "elapsed_s": 0.0,
        "host": "here",
        **more,
    }


class Takes:
    """A run that takes so long, and leaves a mark for each time that it was begun."""

    def __init__(self, seconds: float, marks: Path) -> None:
        self.seconds, self.marks = seconds, marks

    def __call__(self, key: str, toml: str) -> dict[str, Any]:
        (self.marks / f"{key}-{os.getpid()}-{time.monotonic_ns()}").touch()
        time.sleep(self.seconds)
        return answer(key)


class Refuses(Takes):
    """One of them is refused where it runs."""

    def __init__(self, line: str, marks: Path) -> None:
        super().__init__(0.0, marks)
        self.line = line

    def __call__(self, key: str, toml: str) -> dict[str, Any]:
        if self.line in toml.splitlines():
            return answer(key, status=store.REFUSED, message="not here", hash=None, report=None)
        return super().__call__(key, toml)


class Deadly(Takes):
    """One of them ends its process, each time."""

    def __init__(self, line: str, marks: Path, how: int = signal.SIGSEGV) -> None:
        super().__init__(0.05, marks)
        self.line, self.how = line, how

    def __call__(self, key: str, toml: str) -> dict[str, Any]:
        if self.line in toml.splitlines():
            (self.marks / f"{key}-{os.getpid()}-deadly").touch()
            os.kill(os.getpid(), self.how)
        return super().__call__(key, toml)
