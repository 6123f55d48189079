"""The identity of a run: its key is the same on every machine, and differs if its result might differ."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from cmrc import _core
from cmrc.simulation import configured
from cmrc.sweeps.grid import Point


@cache
def build() -> str:
    """SHA-256 of the emulator's library without its version: builds that differ in anything else never share
    results."""
    return digest_without_version(Path(_core.__file__).read_bytes(), _core.cmrc.emulator_version)


def digest_without_version(library: bytes, version: str) -> str:
    """SHA-256 of a library with its version (emulator/report/version.cpp.in) replaced by zeros. Raises ValueError
    unless the version occurs exactly once."""
    text = version.encode().ljust(64, b"\0")
    if library.count(text) != 1:
        raise ValueError(f"the version {version} occurs {library.count(text)} times in the library; once is expected")
    return hashlib.sha256(library.replace(text, bytes(64))).hexdigest()


class Keys:
    """Makes keys. A file that several configurations name is read once."""

    def __init__(self) -> None:
        self._digests: dict[tuple[str, ...], str] = {(): ""}  # if no files are named, the build contains everything

    def of(self, config: _core.cmrc.Config, of_build: str | None = None) -> str:
        """SHA-256 over the canonical full configuration with its events (without turn order, strictness and paths,
        which change no result), the program and the files that it names, and the build (None: this one). Raises the
        error of a missing file."""
        inputs = tuple(_core.cmrc.inputs_of(config))
        if inputs not in self._digests:
            self._digests[inputs] = _core.cmrc.inputs_digest(config)
        parts = [_core.cmrc.run_key(config), self._digests[inputs], of_build or build()]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def key_of_refused(point: Point) -> str:
    """The key of a point without a valid configuration: over its settings."""
    asked: Mapping[str, Any] = {
        "settings": dict(point.settings),
        "preset": point.preset,
        "config": point.config,
        "events": list(point.events),
    }
    return hashlib.sha256(json.dumps([asked, build()], sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Run:
    """A point that can be run, or was refused."""

    key: str
    point: Point
    refused: str = ""
    group: str = ""
    """Runs of one group may share one ideal run; if runs fork, the group names their beginning first."""

    def toml(self) -> str:
        """Its whole configuration."""
        return _config(self.point).to_toml()


def run_of(point: Point, keys: Keys, fork_at_s: float | None = None) -> Run:
    """A point with its key. A point with an invalid configuration, or a missing file, is refused."""
    try:
        config = _config(point)
        group = _digest(_core.cmrc.reference_key(config))
        if fork_at_s is not None:
            group = _digest(_core.cmrc.beginning_of(config, fork_at_s).to_toml()) + group
        return Run(keys.of(config), point, group=group)
    except (ValueError, OSError, RuntimeError) as error:  # ConfigError, AssemblyError, a layout that is not there
        return Run(key_of_refused(point), point, str(error))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _config(point: Point) -> _core.cmrc.Config:
    return configured(point.config, point.preset, point.settings, point.events, {})
