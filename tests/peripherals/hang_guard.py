"""A run that could go on for ever, in a process that ends it."""

from __future__ import annotations

import os
import pickle
import resource
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")


def within(seconds: int, work: Callable[[], Result]) -> Result:
    """What `work` returns; an error if it needs more of the processor's time."""
    reads, writes = os.pipe()
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        try:
            answer: tuple[bool, object] = (True, work())
        except Exception as error:
            answer = (False, repr(error))
        with os.fdopen(writes, "wb") as out:
            pickle.dump(answer, out)
        os._exit(0)
    os.close(writes)
    with os.fdopen(reads, "rb") as answers:
        text = answers.read()
    _, status = os.waitpid(child, 0)
    assert os.WIFEXITED(status), f"more than {seconds} s"
    done, result = pickle.loads(text)
    assert done, result
    return result  # type: ignore[no-any-return]
