"""``python -m cmrc.sweeps.alone``: a process for one run alone (work.Alone); it uses its standard streams for requests
and answers."""

from __future__ import annotations

import os
import sys

from cmrc.processes import die_with_parent


def first_to_go() -> None:
    """If memory runs out, the kernel ends this process and not its worker."""
    try:
        with open("/proc/self/oom_score_adj", "w", encoding="ascii") as file:
            file.write("1000")
    except OSError:
        pass


def main() -> None:
    import cloudpickle

    answers = os.dup(1)
    os.dup2(2, 1)  # a run's own output is not part of the answer
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
