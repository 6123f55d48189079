"""The user's locale changes nothing. Python gives it to the whole process: its letters at the start, its numbers if the
user's program asks for them. In Turkish the small letter of I is not i, and a half is 0,5."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from locations import BUILD, ROOT

WORK = """
import locale, sys
assert locale.setlocale(locale.LC_ALL, "") == sys.argv[1]
assert locale.localeconv()["decimal_point"] == sys.argv[2]
import cmrc, json
from cmrc import c40, plant

program = c40.assemble('''
_START: LDI     @COUNT,IR0
        LDF     1.5,R0
LOOP:   ADDI    1,IR1
        BRD     LOOP
        NOP
        NOP
        NOP
        .IF     1
        .DATA
COUNT:  .INT    0FFH, 1E1H, 017
        .FLOAT  3.25E-3, -7.5, 1.00000005960464477540, 0.1
        .LDOUBLE 1.1, 1.0000000002328306437
        .ENDIF
''')
print(program.listing())
processor = c40.Processor(program)
processor.run(max_cycles=100)
print({name: processor.registers[name] for name in ("IR0", "Ir1", "r0")}, processor.pc)
simulation = cmrc.Simulation(dsps=2, duration_s=0.3, settings={"REPORT.REFERENCE".lower(): "none"})
print(simulation.config.to_toml())
again = cmrc.Simulation.resume(simulation.snapshot())
print(again.run().hash, plant.default_dock().crane.a0, plant.gantry_dock().crane.a0)
"""


@pytest.fixture(scope="module")
def locales(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("locales")
    for charset, name in (("UTF-8", "tr_TR.UTF-8"), ("ISO-8859-9", "tr_TR")):
        subprocess.run(["localedef", "-i", "tr_TR", "-f", charset, folder / name], check=True, timeout=60)
    return folder


def answer(locales: Path, name: str, point: str) -> str:
    environment = {**os.environ, "LOCPATH": str(locales), "LC_ALL": name, "PYTHONPATH": str(BUILD / "python")}
    command = [sys.executable, "-c", WORK, name, point]
    done = subprocess.run(command, env=environment, capture_output=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout.decode("ascii", errors="replace")


@pytest.mark.parametrize("name", ["tr_TR.UTF-8", "tr_TR"])
def test_programs_parameters_and_runs_are_the_same_in_turkish(locales: Path, name: str) -> None:
    assert answer(locales, name, ",") == answer(locales, "C", ".")


def test_no_source_asks_the_locale() -> None:
    asks = re.compile(
        r"#include <(c?locale|cctype|ctype)|\b(std::)?(to(lower|upper)|is(alnum|alpha|blank|cntrl|digit|graph|lower|print|punct|space"
        r"|upper|xdigit)|sto(f|d|ld)|strto(f|d|ld)|atof|v?s?n?printf|v?s?scanf)\("
    )
    # The text of a message of ODE; at a terminal, what may be typed at the prompt of the debugger.
    excused = {"plant/numerics/ode_start.cpp", "emulator/debugger/terminal.cpp"}
    found = {
        f"{path.relative_to(ROOT)}:{number}": line.strip()
        for room in ("emulator", "plant", "bus_model", "python/bindings")
        for path in sorted((ROOT / room).rglob("*.?pp"))
        if str(path.relative_to(ROOT)) not in excused
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if asks.search(line)
    }
    assert not found, "the functions of isa/ascii.hpp, fmt and std::from_chars do not"
