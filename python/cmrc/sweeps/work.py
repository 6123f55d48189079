"""One run, as a worker does it: in its own process or, where a run is suspected, in one that only this run has."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

from cmrc import _core
from cmrc.processes import ended, environment
from cmrc.sweeps import store
from cmrc.sweeps.identity import build, key_of

Answer = dict[str, Any]
Execute = Callable[[str, str], Answer]


def execute(key: str, toml: str) -> Answer:
    """Runs a configuration and tells what the part needs of it. What the run raises is an answer, too.

    Raises RuntimeError on a machine whose build or files are not those of the sweep: its results would not be the same.
    """
    began = time.monotonic()
    config = _core.cmrc.config(toml=toml, name="run")
    _check(key, config)
    answer: Answer = {"key": key, "status": store.DONE, "message": "", "hash": None, "report": None}
    try:
        text = _report(config)
        answer |= {"report": store.packed(text), "hash": json.loads(text)["hash"]}
    except (ValueError, RuntimeError, OSError, MemoryError) as error:
        answer |= {"status": store.FAILED, "message": f"{type(error).__name__}: {error}"}
    return answer | {"elapsed_s": time.monotonic() - began, "host": socket.gethostname()}


_same_build: set[str] = set()
"""Builds that a key has shown to be the sweep's: one, this worker's, or none."""


def _check(key: str, config: _core.cmrc.Config) -> None:
    """The key says that this worker would make the same run. Where no files are named, one key of a build says it of all."""
    settings = config.to_dict()
    files = (settings["machine.programs"], settings["dock.layout"], settings["machine.board"]) != ("", "", "default")
    if not files and build() in _same_build:
        return
    try:
        found = key_of(config)
    except (ValueError, OSError, RuntimeError) as error:
        raise RuntimeError(f"{socket.gethostname()}: the run's files cannot be read here: {error}") from None
    if found != key:
        raise RuntimeError(
            f"{socket.gethostname()}: this worker has another build of cmrc ({build()[:12]}), or other "
            "files behind the configuration's paths, than who started the sweep"
        )
    _same_build.add(build())


_references: dict[str, _core.cmrc.Reference] = {}
"""The last ideal runs of this worker: runs that may share one come one after the other."""


def _report(config: _core.cmrc.Config) -> str:
    group = _core.cmrc.reference_key(config)
    shared = _references.get(group)
    simulation = _core.cmrc.Simulation(config) if shared is None else _core.cmrc.Simulation(config, shared)
    simulation.run()
    text = simulation.report_json()
    its = simulation.reference()
    if its is not None and simulation.ended:
        _references.clear()
        _references[group] = its
    return text


class Alone:
    """The same in a process of its own, so that what kills it kills nothing else and is known for its doing.

    Raises RunDied where that process ends without an answer.
    """

    def __init__(self, execute: Execute) -> None:
        self.execute = execute

    def __call__(self, key: str, toml: str) -> Answer:
        import cloudpickle

        command = [sys.executable, "-m", "cmrc.sweeps.alone"]
        asked = cloudpickle.dumps((self.execute, key, toml, os.getpid()))
        done = subprocess.run(command, input=asked, stdout=subprocess.PIPE, env=environment(), check=False)
        if done.returncode != 0:
            raise RunDied(ended(done.returncode))
        answer: Answer = cloudpickle.loads(done.stdout)
        if isinstance(answer, Exception):
            raise answer
        return answer


class RunDied(Exception):
    """The process in which a run was alone has died of it."""
