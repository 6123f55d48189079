"""Static against dynamic timing on every program in the tree: cycles, causes, registers and memory at many points
(tests/lockstep.py).

Each case is what another module does with the program; that it gives the right results is tested there. Wider, as a
campaign: pytest --way exact tests/programs tests/kernels tests/c40.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import Any

import lockstep
import pytest
from locations import ROOT

sys.path[:0] = [str(ROOT / "tests" / room) for room in ("c40", "kernels", "programs")]
import test_chip
import test_examples as examples
import test_golden_kernels
import test_period_programs as period
import test_published as published
import test_slices
import test_two_ways
import test_validation as validation

EXAMPLES: dict[str, Callable[[], Any]] = {
    "crc32": lambda: examples.test_crc32(examples.Example("crc32"), bytes(range(64))),
    "divide": examples.test_division_and_square_root,
    "fft1024": examples.test_fft_against_numpy,
    "int64": examples.test_arithmetic_of_64_bits,
    "integer_division": examples.test_integer_division,
    "lms": examples.test_lms_learns_an_unknown_system,
    "matrix": lambda: examples.test_matrix_product(4, 8, 5),
    "quicksort": lambda: examples.test_quicksort("random"),
    "sha1": lambda: examples.test_sha1(examples.Example("sha1"), b"abc" * 40),
    "strings": lambda: examples.test_strings(b"abcd", b"abc", 3),
}
PERIOD: dict[str, Callable[[], Any]] = {
    "c_compiled": lambda: period.test_compiled_c(6, 4, False),
    "fft_stages": lambda: period.test_fft_of_any_size(6),
    "fir_interrupt": lambda: period.test_fir_in_an_interrupt_routine_beside_a_program_that_misses_no_bit(1),
    "tasks": lambda: period.run_tasks(lambda: 457),
    "vector_library": lambda: period.test_vector_library(17, False),
}
PUBLISHED: dict[str, Callable[[], Any]] = {
    "fir": lambda: published.test_fir(64),
    "biquads": lambda: published.test_biquads(4),
    "lms": published.test_lms,
    "matrix_vector": published.test_matrix_vector,
    "inverse": published.test_inverse_and_root,
    "square_root": published.test_inverse_and_root,
    "divide": published.test_integer_division_is_that_of_c,
    "fft_radix2": lambda: published.test_fft(2, 256),
    "fft_radix4": lambda: published.test_fft(4, 1024),
}
MEASURED: dict[str, Callable[[], Any]] = {
    "switch_reduced": lambda: validation.measured.switch_cycles("reduced"),
    "switch_c": lambda: validation.measured.switch_cycles("c"),
    "convolve_row": lambda: validation.measured.convolved_row(20),
}
KERNELS: dict[str, Callable[[], Any]] = {
    case[0]: lambda case=case: case[1]().run(case[0], case[2], case[3])  # type: ignore[misc]
    for case in test_golden_kernels.CASES
}
KERNELS |= {
    f"{name}_sliced": lambda name=name: test_slices.first_block(name)  # type: ignore[misc]
    for name in ("avoidance", "avoidance_dwa", "identify", "grab_path")
}
COMPILED: dict[str, Callable[[], Any]] = {
    name: lambda name=name: test_chip.test_compiled_program_gives_the_results_of_the_hosts_own_build(name)  # type: ignore[misc]
    for name in ("p_crc", "p_sort")
}
BENCH: dict[str, Callable[[], Any]] = {
    name: lambda name=name: test_two_ways.kernel(name).run(200_000) for name in ("fir", "branch", "controller")
}  # type: ignore[misc]
ALL = {
    f"{room} {name}": run
    for room, programs in {
        "example": EXAMPLES,
        "period": PERIOD,
        "published": PUBLISHED,
        "measured": MEASURED,
        "kernel": KERNELS,
        "compiled": COMPILED,
        "bench": BENCH,
    }.items()
    for name, run in programs.items()
}


@pytest.mark.parametrize("way", lockstep.WAYS)
@pytest.mark.parametrize("program", ALL)
def test_no_difference_at_any_point(program: str, way: str) -> None:
    points, cycles = lockstep.Processor.points, lockstep.Processor.cycles
    with lockstep.processors(way) as made:
        ALL[program]()
    assert made
    assert lockstep.Processor.points > points and lockstep.Processor.cycles > cycles + 10


def test_no_program_is_left_out() -> None:
    programs = ROOT / "c40_programs"
    assert set(EXAMPLES) == {path.stem for path in (programs / "examples").glob("*.asm")}
    assert set(PERIOD) == {path.stem for path in (ROOT / "tests" / "programs" / "period").glob("*.asm")}
    routines = re.findall(
        r"^; .*\n(?:;.*\n|                \.bss.*\n|\n)*^(\w+):",
        (programs / "published" / "routines.asm").read_text(),
        re.MULTILINE,
    )
    assert set(PUBLISHED) == set(routines)
    entries = re.findall(
        r"^; .*\n(?:;.*\n)*^(\w+):", (programs / "published" / "measured.asm").read_text(), re.MULTILINE
    )
    assert set(MEASURED) == set(entries) - {"process_a"}  # the processes that switch
    kernels = {
        label
        for path in (programs / "kernels").glob("*.asm")
        for label in re.findall(r"^kernel_(\w+):", path.read_text(), re.MULTILINE)
    }
    assert set(KERNELS) == kernels - ALIASES


ALIASES = {"pid_document", "pid_gantry_document", "trajectory_gantry_shaper"}
