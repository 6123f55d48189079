"""The C++ reference against the specification: every operation, cases as the reference draws them.

    PYTHONPATH=tests python -m spec.campaign --cases 1000000 [--seed S] [--jobs J] [OPERATION...]

A case's registers are those of tests/reference/reference.hpp: R0 = d, R1 = a, R2 = b.
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from . import floats, integers
from .addressing import bit_reversed, circular
from .flags import Flags, applied, holds
from .formats import canonical

WORD = 0xFFFFFFFF
RECORD = struct.Struct("<QQQIIQI")
Case = tuple[int, int, int, int, int]  # d, a, b, ST, selector
Outcome = tuple[int, int]  # R0 (or the address), ST

CONDITION_CODES = [code for code in range(21) if code != 11]


def float_binary(operation: Callable[[int, int], floats.Result]) -> Callable[..., Outcome]:
    def run(d: int, a: int, b: int, st: int, selector: int) -> Outcome:
        result, flags = operation(a, b)
        return result, applied(st, flags)

    return run


def float_unary(operation: Callable[[int], floats.Result]) -> Callable[..., Outcome]:
    def run(d: int, a: int, b: int, st: int, selector: int) -> Outcome:
        result, flags = operation(a)
        return result, applied(st, flags)

    return run


def integer(operation: Callable[..., integers.Result], *sources: str) -> Callable[..., Outcome]:
    """Sources by name, as words; ST last unless the selector takes its place."""

    def run(d: int, a: int, b: int, st: int, selector: int) -> Outcome:
        given = {"d": d & WORD, "a": a & WORD, "b": b & WORD, "st": st, "selector": selector}
        word, flags = operation(*(given[source] for source in sources))
        return d & ~WORD | word, applied(st, flags)

    return run


def compare(operation: Callable[..., Outcome]) -> Callable[..., Outcome]:
    return lambda d, a, b, st, selector: (d, operation(d, a, b, st, selector)[1])


def fix(d: int, a: int, b: int, st: int, selector: int) -> Outcome:
    word, flags = floats.fix(a)
    return d & ~WORD | word, applied(st, flags)


def conditional(load: Callable[[int, int], int]) -> Callable[..., Outcome]:
    return lambda d, a, b, st, selector: (load(d, a) if holds(CONDITION_CODES[selector], st) else d, st)


def moved(update: Callable[[int, int, int], int]) -> Callable[..., Outcome]:
    return lambda d, a, b, st, selector: (update(a & WORD, b & WORD, d & WORD), st)


def float_of_word(operation: Callable[[int], tuple[int, Flags]]) -> Callable[..., Outcome]:
    return float_unary(lambda a: operation(a & WORD))


OPERATIONS: dict[str, Callable[..., Outcome]] = {
    "addf": float_binary(floats.addf),
    "subf": float_binary(floats.subf),
    "cmpf": compare(float_binary(floats.subf)),
    "mpyf": float_binary(floats.mpyf),
    "subrf": lambda d, a, b, st, selector: float_binary(floats.subf)(d, a, d, st, selector),
    "negf": float_unary(floats.negf),
    "absf": float_unary(floats.absf),
    "rnd": float_unary(floats.rnd),
    "fix": fix,
    "norm": float_unary(floats.norm),
    "ldf": float_unary(floats.ldf),
    "lde": lambda d, a, b, st, selector: (floats.lde(a, d), st),
    "ldm": lambda d, a, b, st, selector: (d & ~WORD | a & WORD, st),
    "toieee": float_unary(floats.toieee),
    "rcpf": float_unary(floats.rcpf),
    "rsqrf": float_unary(floats.rsqrf),
    "ldfcond": conditional(lambda d, a: canonical(a)),
    "float": float_of_word(floats.float_),
    "frieee": float_of_word(floats.frieee),
    "addi": integer(integers.addi, "a", "b", "st"),
    "addc": integer(integers.addc, "a", "b", "st"),
    "subi": integer(integers.subi, "a", "b", "st"),
    "subb": integer(integers.subb, "a", "b", "st"),
    "subri": integer(integers.subi, "a", "d", "st"),
    "subrb": integer(integers.subb, "a", "d", "st"),
    "negi": integer(integers.negi, "a", "st"),
    "negb": integer(integers.negb, "a", "st"),
    "absi": integer(integers.absi, "a", "st"),
    "cmpi": compare(integer(integers.cmpi, "a", "b", "st")),
    "mpyi": integer(integers.mpyi, "a", "b", "st"),
    "mpyshi": integer(integers.mpyshi, "a", "b", "st"),
    "mpyuhi": integer(integers.mpyuhi, "a", "b", "st"),
    "and": integer(integers.and_, "a", "b", "st"),
    "andn": integer(integers.andn, "a", "b", "st"),
    "or": integer(integers.or_, "a", "b", "st"),
    "xor": integer(integers.xor, "a", "b", "st"),
    "not": integer(integers.not_, "a", "st"),
    "tstb": compare(integer(integers.and_, "a", "b", "st")),
    "lsh": integer(integers.lsh, "a", "b", "st"),
    "ash": integer(integers.ash, "a", "b", "st"),
    "rol": integer(integers.rol, "d", "st"),
    "rolc": integer(integers.rolc, "d", "st"),
    "ror": integer(integers.ror, "d", "st"),
    "rorc": integer(integers.rorc, "d", "st"),
    "subc": lambda d, a, b, st, selector: (d & ~WORD | integers.subc(d & WORD, a & WORD), st),
    "lb": integer(integers.lb, "a", "d", "selector"),
    "lbu": integer(integers.lbu, "a", "d", "selector"),
    "lh": integer(integers.lh, "a", "d", "selector"),
    "lhu": integer(integers.lhu, "a", "d", "selector"),
    "lwl": integer(integers.lwl, "a", "d", "selector"),
    "lwr": integer(integers.lwr, "a", "d", "selector"),
    "mb": integer(integers.mb, "a", "d", "selector"),
    "mh": integer(integers.mh, "a", "d", "selector"),
    "ldicond": conditional(lambda d, a: d & ~WORD | a & WORD),
    "circular_up": moved(circular),
    "circular_down": moved(lambda a, step, size: circular(a, -step, size)),
    "bit_reversed": moved(lambda a, step, size: bit_reversed(a, step)),
}


@dataclass(frozen=True)
class Comparison:
    operation: str
    cases: int
    differing: int
    first: str
    seconds: float


def records(program: Path, operation: str, cases: int, seed: int) -> Iterator[tuple[int, ...]]:
    command = [program, "--emit", operation, "--cases", str(cases), "--seed", str(seed)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        while chunk := process.stdout.read(RECORD.size * 4096):
            yield from RECORD.iter_unpack(chunk)
        if process.wait():
            raise RuntimeError(f"{program} ended with status {process.returncode}")


def check(program: Path, operation: str, cases: int, seed: int) -> Comparison:
    begin = time.perf_counter()
    run = OPERATIONS[operation]
    count = differing = 0
    first = ""
    for d, a, b, st, selector, result, after in records(program, operation, cases, seed):
        count += 1
        expected = run(d, a, b, st, selector)
        if expected != (result, after):
            differing += 1
            first = first or (
                f"d={d:010X} a={a:010X} b={b:010X} ST={st:04X} selector={selector}: "
                f"reference {result:010X} {after:04X}, specification {expected[0]:010X} {expected[1]:04X}"
            )
    return Comparison(operation, count, differing, first, time.perf_counter() - begin)


def default_program() -> Path:
    return Path(__file__).resolve().parents[2] / "build" / "bin" / "arithmetic_campaign"


def main() -> int:
    parser = argparse.ArgumentParser(description="Compares the C++ reference with the specification.")
    parser.add_argument("operations", nargs="*", metavar="OPERATION")
    parser.add_argument("--cases", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--program", type=Path, default=default_program(), help="arithmetic_campaign, as built")
    arguments = parser.parse_args()
    names = arguments.operations or list(OPERATIONS)
    failed = 0
    with ProcessPoolExecutor(arguments.jobs) as pool:
        futures = [pool.submit(check, arguments.program, name, arguments.cases, arguments.seed) for name in names]
        for future in futures:
            result = future.result()
            failed += result.differing
            print(
                f"{result.operation:<14}{result.cases:>12} cases, {result.differing} differ ({result.seconds:.1f} s) {result.first}",
                flush=True,
            )
    print(f"{len(names)} operations: {failed} differ")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
