"""How the thread calculates when a run begins changes nothing. A library that was compiled with -ffast-math takes
denormal numbers from the thread that loads it; another one may have left its rounding mode behind."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager

import cmrc
import pytest
from cmrc import c40, network

LIBM = ctypes.CDLL("libm.so.6")
MXCSR = 7  # in words of fenv_t of x86-64: after 28 bytes of the x87
TO_NEAREST, UPWARD, TOWARD_ZERO, NO_DENORMALS = 0, 0x4000, 0x6000, 0x8040
LOOP = c40.assemble("_start: b _start\n")


@contextmanager
def calculating(how: int) -> Iterator[None]:
    """SSE as this says; in the block no Python may calculate."""
    before, changed = (ctypes.c_uint32 * 8)(), (ctypes.c_uint32 * 8)()
    LIBM.fegetenv(before)
    LIBM.fegetenv(changed)
    changed[MXCSR] |= how
    LIBM.fesetenv(changed)
    try:
        yield
        after = (ctypes.c_uint32 * 8)()
        LIBM.fegetenv(after)
    finally:
        LIBM.fesetenv(before)
    assert after[MXCSR] & 0xE040 == how


def run() -> str:
    made = cmrc.Simulation(dsps=2, duration_s=0.3, settings={"report.reference": "none"})
    made.run_until(0.1)
    return made.run().hash


@pytest.mark.parametrize("how", [TO_NEAREST, UPWARD, TOWARD_ZERO, NO_DENORMALS])
def test_a_run_has_the_same_hash(how: int) -> None:
    expected = run()
    with calculating(how):
        found = run()
    assert found == expected


@pytest.mark.parametrize("how", [UPWARD, NO_DENORMALS])
def test_chips_leave_the_thread_as_it_was(how: int) -> None:
    with calculating(how):
        c40.Processor(LOOP).run(max_cycles=100)
        network.Network([LOOP, LOOP], links=["0.0:1.3"]).run(until_us=1)
