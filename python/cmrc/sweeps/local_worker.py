"""``python -m cmrc.sweeps.local_worker PARENT``: forks Dask workers with one thread each, for a sweep on this machine.

A line ``ADDRESS NAME`` on its standard input starts a worker; a line ``NAME died`` on its standard output reports one
that has ended. This process has imported all modules of a worker, so that a worker starts in a fraction of the time of
a new Python.
"""

from __future__ import annotations

import asyncio
import os
import select
import signal
import sys

from cmrc.processes import die_with_parent


async def work(address: str, name: str) -> None:
    from distributed import Worker

    async with Worker(
        address,
        nthreads=1,
        name=name,
        memory_limit=0,
        death_timeout=60,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    ) as worker:
        await worker.finished()


def forked(address: str, name: str) -> int:
    """The process of a new worker."""
    parent = os.getpid()
    child = os.fork()
    if child:
        return child
    try:
        die_with_parent(parent)
        silent = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(silent, stream)
        asyncio.run(work(address, name))
    finally:
        os._exit(0)


def ended(children: dict[int, str]) -> list[str]:
    """Names of the workers that have ended since the last call."""
    names = []
    while children:
        pid, _ = os.waitpid(-1, os.WNOHANG)
        if pid == 0:
            break
        names.append(children.pop(pid))
    return names


def main() -> None:
    [parent] = sys.argv[1:]
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the sweep handles Ctrl-C and ends its workers
    die_with_parent(int(parent))
    import dask
    import distributed  # noqa: F401 (for the workers to be)

    import cmrc.sweeps.work  # noqa: F401
    from cmrc.sweeps.cluster import QUIET

    dask.config.set(QUIET)

    children: dict[int, str] = {}
    received = b""
    while True:
        if select.select([0], [], [], 0.05)[0]:
            new = os.read(0, 4096)
            if not new:
                return
            *lines, received = (received + new).split(b"\n")
            for line in lines:
                address, name = line.decode().split()
                children[forked(address, name)] = name
        for name in ended(children):
            os.write(1, f"{name} died\n".encode())


if __name__ == "__main__":
    main()
