"""Numbers that devices.inc and the plant both have: a program whose numbers differ is refused by name."""

import re
import shutil
from pathlib import Path

import pytest
from cmrc import _core
from cmrc._core import plant, toolchain
from cmrc_test import machine, run_setup
from locations import ROOT
from programs import INCLUDE, with_devices

TEXT = (INCLUDE / "devices.inc").read_text()
# What docs/plant.md says of the devices, and the bits of plant-and-bus.md; RANGE_MOST in mm.
SHARED = {
    "DRIVE_COUNT": 5,
    "ENCODER_BITS": 24,
    "SWAY_BITS": 12,
    "SPREADER_CORNERS": 0x0F,
    "SPREADER_LOCKED": 0x10,
    "SPREADER_OPEN": 0x20,
    "SCAN_COUNT": 128,
    "AGV_WAITING": 0x0F,
    "AGV_STANDING": 0x10,
    "AGV_LOADED": 0x20,
    "AGV_RAN_DRY": 0x40,
    "AGV_BUMPER": 0x80,
    "RANGE_RAYS": 180,
    "RANGE_MOST": 30000,
}
# Where things lie: the programs alone say so, and the machine puts them there.
LAYOUT = {
    *("WINDOW_B", "AGV_UNIT", "AGV_UNIT_WORDS", "AGV_RANGE", "AGV_RANGE_WORDS"),
    *(f"DRIVE_{bit}" for bit in ("READY", "FAULT", "LATE", "BRAKE")),
    *(f"TRIP_{bit}" for bit in ("OVERSPEED", "SATURATION", "HEAT", "WARNING")),
}


def text_with(**numbers: int) -> str:
    text = TEXT
    for name, number in numbers.items():
        text, found = re.subn(rf"^{name} +\.set +\w+", f"{name} .set {number}", text, flags=re.MULTILINE)
        assert found == 1
    return text


def program_with(**numbers: int) -> toolchain.Image:
    return with_devices(text_with(**numbers))


def test_each_number_of_the_file_is_an_offset_a_place_or_shared() -> None:
    others = {found[1] for line in TEXT.splitlines() if (found := re.match(r"(\w+) +\.set (?!.*(read|write):)", line))}
    assert others == LAYOUT | set(SHARED)
    symbols = program_with().symbols
    assert {name: symbols[name] for name in SHARED} == SHARED


@pytest.mark.parametrize("name", SHARED)
def test_a_program_with_another_number_is_refused_by_its_name(name: str) -> None:
    program = program_with(**{name: SHARED[name] + 1})
    said = f"the DSP program: {name} is {SHARED[name] + 1}, but the dock's devices have {SHARED[name]}; "
    with pytest.raises(ValueError, match=re.escape(said)):
        machine.Machine(program, dock=plant.Dock(plant.default_dock()))
    machine.Machine(program)  # bus B has no device that it could contradict


@pytest.mark.parametrize("name", sorted(LAYOUT))
def test_where_things_lie_a_program_may_say(name: str) -> None:
    symbols = program_with().symbols
    elsewhere = symbols[name] + (1 if name.startswith(("DRIVE_", "TRIP_")) else 0x1000 if "WORDS" in name else 0)
    machine.Machine(program_with(**{name: elsewhere}), dock=plant.Dock(plant.default_dock()))


def test_all_that_differ_are_named() -> None:
    program = program_with(SCAN_COUNT=0xFFFFFFFF, RANGE_RAYS=0xFFFFFFFF)
    said = "SCAN_COUNT is 4294967295, but the dock's devices have 128; RANGE_RAYS is 4294967295, but "
    with pytest.raises(ValueError, match=said):
        machine.Machine(program, dock=plant.Dock(plant.default_dock()))


def programs_with(folder: Path, **numbers: int) -> Path:
    shutil.copytree(ROOT / "c40_programs", folder / "c40_programs")
    (folder / "c40_programs" / "include" / "devices.inc").write_text(text_with(**numbers))
    return folder / "c40_programs"


def test_the_controllers_programs_are_refused_before_the_run(tmp_path: Path) -> None:
    folder = programs_with(tmp_path, RANGE_MOST=29000, AGV_LOADED=0x40)
    settings = {"machine.programs": str(folder)}
    said = "machine.programs: AGV_LOADED is 64, but the dock's devices have 32; RANGE_MOST is 29000, but"
    with pytest.raises(_core.cmrc.ConfigError, match=said):
        run_setup.dsp_image(_core.cmrc.config(settings=settings))
    with pytest.raises(_core.cmrc.ConfigError, match=said):
        _core.cmrc.Simulation(_core.cmrc.config(settings=settings))


@pytest.mark.parametrize(
    ("name", "number", "said"),
    [
        ("DRIVE_COUNT", 6, "five drives"),
        ("ENCODER_BITS", 20, "count 24 bits"),
        ("SWAY_BITS", 10, "in 12 bits"),
        ("DRIVE_LATE", 24, "octets"),
        ("TRIP_HEAT", 24, "octets"),
        ("AGV_WAITING", 0x1F, "lowest 4 bits"),
    ],
)
def test_what_a_kernel_is_built_on_is_refused_when_it_is_assembled(
    tmp_path: Path, name: str, number: int, said: str
) -> None:
    folder = programs_with(tmp_path, **{name: number})
    with pytest.raises(toolchain.AssemblyError, match=said):
        toolchain.assemble_file(folder / "dsp.asm", entry="_start")
