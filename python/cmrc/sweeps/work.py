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
from cmrc.simulation import ConfigError
from cmrc.sweeps import store
from cmrc.sweeps.identity import Keys, build

Answer = dict[str, Any]
Execute = Callable[[str, str], Answer]


def execute(key: str, toml: str) -> Answer:
    """Runs a configuration and tells what the part needs of it. What the run raises is an answer, too.

    Raises RuntimeError on a machine whose build or files are not those of the sweep: its results would not be the same.
    """
    return _answer(key, toml, None)


class Forked:
    """The same for runs that are alike until ``at_s``: what a worker has run until then serves the next one, too. The
    results are those of whole runs."""

    def __init__(self, at_s: float) -> None:
        self.at_s = at_s

    def __call__(self, key: str, toml: str) -> Answer:
        return _answer(key, toml, self.at_s)


def _answer(key: str, toml: str, fork_at_s: float | None) -> Answer:
    began = time.monotonic()
    config = _core.cmrc.config(toml=toml, name="run")
    _check(key, config)
    answer: Answer = {"key": key, "status": store.DONE, "message": "", "hash": None, "report": None}
    try:
        text = _report(config, fork_at_s)
        answer |= {"report": store.packed(text), "hash": json.loads(text)["hash"]}
    except ConfigError as error:  # what only the making of the run shows: a label that no program has
        answer |= {"status": store.REFUSED, "message": str(error)}
    except (ValueError, RuntimeError, OSError, MemoryError) as error:
        answer |= {"status": store.FAILED, "message": f"{type(error).__name__}: {error}"}
    return answer | {"elapsed_s": time.monotonic() - began, "host": socket.gethostname()}


_same_build: set[str] = set()
"""Builds that a key has shown to be the sweep's: one, this worker's, or none."""


def _check(key: str, config: _core.cmrc.Config) -> None:
    """The key says that this worker would make the same run. Where no files are named, one key of a build says it of
    all."""
    if not _core.cmrc.inputs_of(config) and build() in _same_build:
        return
    try:
        found = Keys().of(config)
    except (ValueError, OSError, RuntimeError) as error:
        raise RuntimeError(f"{socket.gethostname()}: the run's files cannot be read here: {error}") from None
    if found != key:
        raise RuntimeError(
            f"{socket.gethostname()}: this worker has another build of cmrc ({build()[:12]}), or other "
            "files behind the configuration's paths, than the process that started the sweep"
        )
    _same_build.add(build())


_references: dict[str, _core.cmrc.Reference] = {}
"""The last ideal runs of this worker: runs that may share one come one after the other."""


_beginnings: dict[tuple[str, str], _core.cmrc.Simulation] = {}
"""The last beginning of this worker, by its key and configuration: runs that share one come one after the other."""


def _report(config: _core.cmrc.Config, fork_at_s: float | None) -> str:
    group = _core.cmrc.reference_key(config)
    simulation = _made(config, _references.get(group), fork_at_s)
    simulation.run()
    text = simulation.report_json()
    its = simulation.reference()
    if its is not None and simulation.ended:
        _references.clear()
        _references[group] = its
    return text


def _made(
    config: _core.cmrc.Config, reference: _core.cmrc.Reference | None, fork_at_s: float | None
) -> _core.cmrc.Simulation:
    if fork_at_s is not None:
        beginning = _core.cmrc.beginning_of(config, fork_at_s)
        key = (Keys().of(beginning), beginning.to_toml())
        if key not in _beginnings:
            _beginnings.clear()
            made = _core.cmrc.Simulation(beginning)
            made.run_until(fork_at_s)
            _beginnings[key] = made
        if not _beginnings[key].ended:  # a run that has ended before has no future
            return _beginnings[key].fork_into(config, reference)
    return _core.cmrc.Simulation(config) if reference is None else _core.cmrc.Simulation(config, reference)


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
