"""The workers of a sweep: on this machine, or on a Dask cluster at an address."""

from __future__ import annotations

import asyncio
import logging
import os
import select
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import Any

from cmrc.extras import needed
from cmrc.processes import environment
from cmrc.sweeps.store import SweepError

CONNECT_S = 30.0
GONE = "the cluster's scheduler is gone; the runs that it answered are kept, and the same command continues from there"
START_AGAIN_S = 0.2
ASK_S = 1.0
SETTINGS = {
    # Dask reports one death at once; runner.py decides what follows.
    "distributed.scheduler.allowed-failures": 0,
    "distributed.scheduler.worker-saturation": 1.0,
}
QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.work-stealing": False,
}
"""Dask's own monitoring costs a local sweep as much as its work, and its results are not used."""


class _Shared:
    """A context of the whole process that the sweeps of all threads share: the first one enters it, the last one
    leaves it."""

    def __init__(self, make: Callable[[], AbstractContextManager[Any]]) -> None:
        self._make = make
        self._lock = threading.Lock()
        self._users = 0

    def __enter__(self) -> None:
        with self._lock:
            if self._users == 0:
                self._context = self._make()
                self._context.__enter__()
            self._users += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._users -= 1
            if self._users == 0:
                self._context.__exit__(None, None, None)


@contextmanager
def _no_messages() -> Iterator[None]:
    """Dask's messages are not shown."""
    handlers = [handler for name in ("distributed", "bokeh") for handler in logging.getLogger(name).handlers]
    levels = [(one, one.level) for one in handlers if isinstance(one, logging.StreamHandler)]
    for handler, _ in levels:
        handler.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for handler, level in levels:
            handler.setLevel(level)


_silence = _Shared(_no_messages)
_settings = _Shared(lambda: needed("dask", "sweep", "cmrc.sweep").config.set({**SETTINGS, **QUIET}))


class Workers:
    """A client and its workers."""

    def __init__(self, client: Any, workers: _Processes | None) -> None:
        self.client = client
        self._processes = workers
        self._asked_at, self._threads = float("-inf"), 0

    def mend(self) -> None:
        """Restarts dead workers on this machine. Raises SweepError if the cluster is gone."""
        if self.client.status not in ("running", "connecting"):
            raise SweepError(GONE)
        if self._processes is not None:
            self._processes.mend()

    def threads(self) -> int:
        """How many runs are possible at a time; at most a second old. Raises SweepError where the cluster is gone."""
        now = time.monotonic()
        if now - self._asked_at > ASK_S:
            try:
                self._asked_at, self._threads = now, sum(map(int, self.client.nthreads().values()))
            except (OSError, RuntimeError) as error:  # Dask's CommClosedError is an OSError
                raise SweepError(GONE) from error
        return self._threads


class _Processes:
    """Workers of this machine, one process each. A dead worker is restarted, and so is the process that forks them."""

    def __init__(self, count: int, scratch: str) -> None:
        self.count, self.scratch = count, scratch
        self.address = ""
        self.number = 0
        self._start()  # it imports the workers' modules while this process does the same

    def join(self, address: str) -> None:
        """Connects the workers to the scheduler at that address."""
        self.address = address
        self._fork_all()

    def _start(self) -> None:
        command = [sys.executable, "-m", "cmrc.sweeps.local_worker", str(os.getpid())]
        self.forker = subprocess.Popen(
            command,
            env={**environment(), "DASK_TEMPORARY_DIRECTORY": self.scratch},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self.begun = time.monotonic()

    def _fork_all(self) -> None:
        for _ in range(self.count):
            self._fork()

    def _fork(self) -> None:
        self.number += 1
        stream = self.forker.stdin
        assert stream is not None
        try:
            stream.write(f"{self.address} local-{self.number}\n".encode())
            stream.flush()
        except BrokenPipeError:
            pass  # seen by the next mend

    def mend(self) -> None:
        if self.forker.poll() is not None:
            if time.monotonic() - self.begun > START_AGAIN_S:
                self._start()
                self._fork_all()
            return
        stream = self.forker.stdout
        assert stream is not None
        while select.select([stream], [], [], 0)[0]:
            received = os.read(stream.fileno(), 4096)
            if not received:
                break
            for _ in range(received.count(b"\n")):
                self._fork()

    def close(self) -> None:
        self.forker.kill()  # and the kernel ends its workers
        self.forker.wait()
        for stream in (self.forker.stdin, self.forker.stdout):
            if stream is not None:
                with suppress(BrokenPipeError):
                    stream.close()


@contextmanager
def workers(address: str | None, count: int | None, security: Mapping[str, Any] | None) -> Iterator[Workers]:
    """A local cluster of ``count`` workers (default: one per processor), or the cluster at ``address``.

    ``security`` has the fields of ``distributed.Security`` (tls_ca_file, tls_client_cert, ...). Raises SweepError if no
    cluster answers.
    """
    if address is None:
        with (
            tempfile.TemporaryDirectory(prefix="cmrc-sweep-", ignore_cleanup_errors=True) as scratch,
            _local(count or os.cpu_count() or 1, scratch) as found,
        ):
            yield found
        return
    distributed = needed("distributed", "sweep", "cmrc.sweep")
    with _settings:
        if count is not None:
            raise SweepError(
                "workers: a cluster with an address has workers of its own; one of address and workers is expected"
            )
        for name, path in (security or {}).items():
            if name.startswith("tls_") and isinstance(path, (str, os.PathLike)) and not os.path.isfile(path):
                raise SweepError(f"security.{name}: {path} is not a file; a certificate or a key is expected")
        try:
            safe = distributed.Security(**(security or {}))
            _greet(address, safe)
            client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False, security=safe)
        except (OSError, ValueError, TypeError) as error:
            raise SweepError(f"{address}: no cluster answers there: {error}") from None
        try:
            yield Workers(client, None)
        finally:
            client.close(timeout=5)


def _greet(address: str, security: Any) -> None:
    """A cluster identifies itself within CONNECT_S. Dask's client would wait forever for a server that accepts and does
    not answer. Raises OSError, ValueError, TypeError."""
    connect: Any = needed("distributed.comm", "sweep", "cmrc.sweep").connect

    async def greeted() -> None:
        try:
            comm = await asyncio.wait_for(
                connect(address, timeout=CONNECT_S, **security.get_connection_args("client")), CONNECT_S + 1
            )
        except asyncio.TimeoutError:
            raise OSError(f"the server at this address has not answered within {CONNECT_S:g} s") from None
        await comm.close()

    with ThreadPoolExecutor(1) as beside:  # a notebook has a loop of its own in this thread
        beside.submit(asyncio.run, greeted()).result()


@contextmanager
def _local(count: int, scratch: str) -> Iterator[Workers]:
    """``scratch``: the folder in which Dask makes its own."""
    processes = _Processes(count, scratch)
    try:
        distributed = needed("distributed", "sweep", "cmrc.sweep")
        with (
            _settings,
            _silence,
            distributed.LocalCluster(
                n_workers=0,
                processes=True,
                dashboard_address="127.0.0.1:0",
                silence_logs=False,
                host="127.0.0.1",
                scheduler_port=0,
                scheduler_kwargs={"local_directory": scratch},
            ) as cluster,
        ):
            client = distributed.Client(cluster, set_as_default=False)
            processes.join(cluster.scheduler_address)
            try:
                yield Workers(client, processes)
            finally:
                client.close(timeout=5)
                processes.close()
    finally:
        processes.close()
