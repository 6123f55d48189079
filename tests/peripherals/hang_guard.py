"""A run that might not end, in a process that ends it."""

from __future__ import annotations

import os
import pickle
import resource
import traceback
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")


def within(seconds: int, work: Callable[[], Result]) -> Result:
    """What `work` returns; an error if it fails, or needs more of the processor's time."""
    reads, writes = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
            with os.fdopen(writes, "wb") as out:
                pickle.dump(work(), out)
            os._exit(0)
        finally:
            traceback.print_exc()
            os._exit(1)
    os.close(writes)
    with os.fdopen(reads, "rb") as answers:
        text = answers.read()
    _, status = os.waitpid(child, 0)
    assert status == 0, f"more than {seconds} s" if os.WIFSIGNALED(status) else "failed"
    return pickle.loads(text)  # type: ignore[no-any-return]
