"""``python -m cmrc.sweeps.alone``: the process in which one run is alone (work.Alone); it talks on its standard
streams."""

from __future__ import annotations

import os
import sys

from cmrc.processes import die_with_parent


def first_to_go() -> None:
    """Where memory runs out, the kernel ends this process and not its worker."""
    try:
        with open("/proc/self/oom_score_adj", "w", encoding="ascii") as file:
            file.write("1000")
    except OSError:
        pass


def main() -> None:
    import cloudpickle

    answers = os.dup(1)
    os.dup2(2, 1)  # what a run prints is no part of the answer
    execute, key, toml, parent = cloudpickle.loads(sys.stdin.buffer.read())
    die_with_parent(parent)
    first_to_go()
    try:
        answer = execute(key, toml)
    except Exception as error:  # noqa: BLE001 (the worker raises it)
        answer = error
    with os.fdopen(answers, "wb") as out:
        out.write(cloudpickle.dumps(answer))


if __name__ == "__main__":
    main()
