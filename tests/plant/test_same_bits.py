"""The same bits on every x86-64: nothing that varies by CPU is linked; scenes agree without its newer instructions."""

import ctypes
import math
import os
import random
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from cmrc import _core
from locations import BUILD

EMULATOR = BUILD / "bin" / "emulator"
MODULE = Path(_core.__file__)
HERE = Path(__file__).parent

# IEEE 754 or C gives these one right result, so every variant returns it; fma's is one rounding of the exact sum.
EXACT = {
    "ceil", "copysign", "fabs", "fdim", "fegetenv", "fegetround", "fesetenv", "fesetround", "floor", "fma", "fmax",
    "fmin", "fmod", "frexp", "ilogb", "ldexp", "llrint", "llround", "logb", "lrint", "lround", "modf", "nearbyint",
    "nextafter", "remainder", "remquo", "rint", "round", "roundeven", "scalbln", "scalbn", "sqrt", "trunc",
}  # fmt: skip
# No run reaches it: toml++ calls it when it writes TOML, for the width of a line.
UNREACHED = {("libtomlplusplus.so.3", "log10")}
# Approximations, which differ between makers of CPUs; fused operations, whose rounding differs from that of the two.
VARYING = re.compile(
    r"^v?(rsqrt|rcp)[ps]s$|^vfn?m(add|sub)|^f(sin|cos|sincos|ptan|patan|2xm1|yl2x|yl2xp1)$|^(cpuid|xgetbv)$"
)
WITHOUT = "glibc.cpu.hwcaps=-AVX512F,-AVX2,-AVX,-FMA,-FMA4"


def run(*command: str | Path, **environment: str) -> str:
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def libraries(file: Path) -> dict[str, Path]:
    """Name and path of every library that `file` loads, directly or not."""
    return {name: Path(path) for name, path in re.findall(r"(\S+) => (\S+)", run("ldd", file))}


@cache
def symbols(file: Path, which: str) -> set[str]:
    return {line.split()[-1].split("@")[0] for line in run("nm", "-D", f"--{which}-only", file).splitlines()}


def base(name: str) -> str:
    """float, double and long double of one function."""
    return name[:-1] if name[-1] in "fl" and name[:-1] in EXACT else name


def varying_imports(name: str, file: Path, mathematics: set[str]) -> set[str]:
    return {
        symbol
        for symbol in symbols(file, "undefined") & mathematics
        if not symbol.startswith("_") and base(symbol) not in EXACT and (name, symbol) not in UNREACHED
    }


@pytest.mark.parametrize("file", [EMULATOR, MODULE], ids=["binary", "module"])
def test_nothing_is_imported_that_varies_by_cpu(file):
    loaded = libraries(file)
    mathematics = symbols(loaded["libm.so.6"], "defined")
    assert {"sin", "sincos", "pow", "expf", "atan2"} <= mathematics
    own = {file.name: file} | {name: path for name, path in loaded.items() if name not in ("libm.so.6", "libc.so.6")}
    assert {name: bad for name, path in own.items() if (bad := varying_imports(name, path, mathematics))} == {}
    assert not [name for name in loaded if "sundials" in name or "libode" in name]  # Debian's import pow and sincos


@pytest.mark.parametrize("file", [EMULATOR, MODULE], ids=["binary", "module"])
def test_of_sleef_only_what_does_not_choose_by_cpu(file):
    sleef = {name for name in symbols(file, "undefined") if name.startswith("Sleef_")}
    assert len(sleef) > 5
    assert [name for name in sleef if not re.fullmatch(r"Sleef_cinz_\w+(1_u\d+purec|2_u\d+sse2)", name)] == []


@pytest.mark.parametrize("file", [EMULATOR, MODULE, "libccd.so.2"], ids=["binary", "module", "libccd"])
def test_no_instruction_whose_result_the_maker_of_the_cpu_chooses(file):
    code = run("objdump", "-d", "--no-show-raw-insn", libraries(EMULATOR)[file] if isinstance(file, str) else file)
    found = set(re.findall(r"\t(\w+)", code))  # behind the address: the prefix or the mnemonic
    assert {"mulsd", "addsd"} <= found
    assert sorted(word for word in found if VARYING.search(word)) == []


def scene(*settings: str, **environment: str) -> str:
    text = run(EMULATOR, "--dsps", "2", "--duration", "0.3", *settings, **environment)
    return re.search(r"^hash (\w{64})", text, re.MULTILINE)[1]


def plant_scene(name: str, **environment: str) -> str:
    path = os.pathsep.join(str(folder) for folder in (BUILD / "python", HERE.parent, HERE))
    return run(sys.executable, HERE / "bits.py", name, PYTHONPATH=path, **environment)


@pytest.mark.parametrize("integrator", ["erk", "adams", "bdf"])
def test_a_run_has_the_same_hash_without_the_newer_instructions(integrator):
    setting = ("--set", f"dock.integrator={integrator}")
    assert scene(*setting) == scene(*setting, GLIBC_TUNABLES=WITHOUT)


@pytest.mark.parametrize("name", ["erk", "adams", "bdf", "landing", "leg", "bumps"])
def test_the_plant_has_the_same_bits_without_the_newer_instructions(name):
    assert plant_scene(name) == plant_scene(name, GLIBC_TUNABLES=WITHOUT)


def test_without_the_newer_instructions_this_machines_c_library_differs():
    """Otherwise the two tests above would compare a function with itself."""
    if "fma" not in Path("/proc/cpuinfo").read_text(encoding="ascii").split():
        pytest.skip("this CPU has no FMA")
    many = "import math; print(sum(hash(math.pow(1 + k * 1e-4, k * 1e-3)) for k in range(100000)))"
    assert run(sys.executable, "-c", many) != run(sys.executable, "-c", many, GLIBC_TUNABLES=WITHOUT)


def test_what_stands_in_for_the_c_library_means_the_same():
    """SLEEF promises one unit in the last place; the C library of this machine is within one, too."""
    module = ctypes.CDLL(str(MODULE))

    def stand_in(name, kind, arguments):
        function = getattr(module, f"cmrc_libm_{name}")
        function.restype, function.argtypes = kind, [kind] * arguments
        return function

    near = {"rel": 4 * sys.float_info.epsilon, "abs": 1e-300}
    draw = random.Random(3)
    power, angle = stand_in("pow", ctypes.c_double, 2), stand_in("atan2", ctypes.c_double, 2)
    inverse = {name: stand_in(name, ctypes.c_double, 1) for name in ("acos", "asin")}
    single = {name: stand_in(name, ctypes.c_float, 1) for name in ("acosf", "asinf")}
    sine, cosine = ctypes.c_double(), ctypes.c_double()
    both = module.cmrc_libm_sincos
    both.argtypes, both.restype = [ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p], None
    for _ in range(1000):
        x, y, z = math.exp(draw.uniform(-30, 30)), draw.uniform(-9, 9), draw.uniform(-1, 1)
        short = ctypes.c_float(z).value
        assert power(x, y) == pytest.approx(math.pow(x, y), **near)
        assert angle(y, z) == pytest.approx(math.atan2(y, z), **near)
        both(y, ctypes.byref(sine), ctypes.byref(cosine))
        assert (sine.value, cosine.value) == pytest.approx((math.sin(y), math.cos(y)), **near)
        for name, function in inverse.items():
            assert function(z) == pytest.approx(getattr(math, name)(z), **near)
            assert single[f"{name}f"](short) == pytest.approx(getattr(math, name)(short), rel=2**-21)
    assert power(0.0, 0.5) == 0.0 and power(7.0, 0.0) == 1.0 and angle(0.0, -1.0) == math.pi
