"""``python -m cmrc.sweeps.local_worker ADDRESS NAME PARENT``: one Dask worker with one thread, for a sweep on this machine."""

from __future__ import annotations

import asyncio
import signal
import sys

from cmrc.sweeps.alone import die_with_parent


async def work(address: str, name: str) -> None:
    from distributed import Worker

    async with Worker(address, nthreads=1, name=name, memory_limit=0, death_timeout=60) as worker:
        await worker.finished()


def main() -> None:
    address, name, parent = sys.argv[1:]
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the sweep, which ends its workers
    die_with_parent(int(parent))
    asyncio.run(work(address, name))


if __name__ == "__main__":
    main()
