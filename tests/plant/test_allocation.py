"""No allocation in the stepping of crane and AGVs: every call of malloc is counted by a library loaded before all
others."""

import os
import shutil
import subprocess
import sys

import pytest
from locations import BUILD

COUNTER = """
#include <stddef.h>
extern void* __libc_malloc(size_t); extern void* __libc_calloc(size_t, size_t); extern void* __libc_realloc(void*, size_t);
static long count;
long allocations(void) { return __atomic_load_n(&count, __ATOMIC_RELAXED); }
void* malloc(size_t n) { __atomic_fetch_add(&count, 1, __ATOMIC_RELAXED); return __libc_malloc(n); }
void* calloc(size_t n, size_t m) { __atomic_fetch_add(&count, 1, __ATOMIC_RELAXED); return __libc_calloc(n, m); }
void* realloc(void* p, size_t n) { __atomic_fetch_add(&count, 1, __ATOMIC_RELAXED); return __libc_realloc(p, n); }
"""

PROGRAM = """
import ctypes, sys
from cmrc._core import plant
allocations = ctypes.CDLL(sys.argv[1]).allocations
allocations.restype = ctypes.c_long
assert allocations() > 1000  # it counts
from cmrc.plant import Crane
cranes = [Crane(load_mass=1e4, **more) for more in ({}, {"integrator": "adams"}, {"integrator": "bdf"}, {"bookkeeping": True}, {"wind": {"mean": 5.0}}, {"gear_losses": True})]
dock = plant.Dock(plant.default_dock(2))
dock.enable_drives(31, 0)

def of_cranes(steps):
    before = allocations()
    for crane in cranes:
        crane.run([100.0, 1500.0, 1300.0, -1000.0, 2.0], 1e-3, steps)
    return allocations() - before

def of_dock(seconds):
    end = dock.time + seconds * 10**12
    for agv in (0, 1):
        dock.agv_push(agv, 1000, 50000, -50000, dock.time)
    before = allocations()
    dock.advance_to(end)
    return allocations() - before

linkage = plant.Linkage(plant.LinkageParameters())
linkage.place(1.0)

def of_linkage(steps):
    before = allocations()
    for _ in range(steps):
        linkage.advance(4e6, 0.01)
    return allocations() - before

of_cranes(10), of_dock(1), of_linkage(3)
print(of_cranes(10), of_cranes(1000), of_dock(1), of_dock(3), of_linkage(100))
"""


@pytest.mark.unsanitized  # the sanitizer has a malloc of its own
def test_stepping_does_not_allocate(tmp_path):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler here")
    source, library = tmp_path / "counter.c", tmp_path / "counter.so"
    source.write_text(COUNTER, encoding="utf-8")
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", str(source), "-o", str(library)], check=True)
    environment = {**os.environ, "LD_PRELOAD": str(library), "PYTHONPATH": str(BUILD / "python")}
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(library)], env=environment, capture_output=True, text=True, check=True
    )
    few, many, short, long, linkage = (int(word) for word in run.stdout.split())
    assert many == few <= 50  # those of the call from Python
    assert long - short <= 20  # the dock's events are kept
    assert linkage <= 20  # of 100 calls
