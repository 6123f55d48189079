"""Configurations that could fill the task-block list are refused; a list that is full all the same is a named error."""

import shutil
from pathlib import Path

import cmrc
import pytest
from cmrc import _core
from cmrc_test import run_setup
from locations import ROOT

TASK = '[[tasks]]\nname = "t{0}"\nprogram = "kernel_avoidance"\nkind = {1}\nimportance = 62463\nperiod_ms = {2}\n'
ROW = '[[subprocesses]]\nnumber = {0}\nname = "s{0}"\nagv = "user.t{1}"\nrelease = "interval"\n'


def config(rows: int, periodic: int, agvs: int = 8) -> _core.cmrc.Config:
    tasks = "".join(TASK.format(n, 30 + n, 10 if n < periodic else 0) for n in range(max(rows, periodic)))
    toml = tasks + "".join(ROW.format(6 + n, n) for n in range(rows))
    return _core.cmrc.config(toml=toml, settings={"dock.agvs": agvs, "report.reference": "none"})


def test_the_most_blocks_are_counted_when_the_configuration_is_read() -> None:
    """Eight vehicles: 4 blocks of the crane, 3 of each vehicle, 2 processes of no robot, an error; 33 are left."""
    config(rows=4, periodic=1)
    for rows, periodic, number in ((5, 0, 10), (4, 2, 9)):
        with pytest.raises(cmrc.ConfigError, match=f"subprocesses.agv: with sub-process {number} and dock.agvs = 8"):
            config(rows, periodic)
    config(rows=5, periodic=5, agvs=6)


def test_the_list_of_the_programs_has_the_length_that_is_counted_with() -> None:
    assert run_setup.dsp_image(config(0, 0)).symbols["BLOCK_COUNT"] == 64


def test_a_full_list_is_an_error_with_instant_and_kind(tmp_path: Path) -> None:
    """Programs of one's own, with a list for two blocks: the first refresh loads three."""
    programs = tmp_path / "programs"
    shutil.copytree(ROOT / "c40_programs", programs)
    source = programs / "include" / "task_block.inc"
    source.write_text(source.read_text().replace("BLOCK_COUNT         .set 64", "BLOCK_COUNT         .set 2"))
    settings = {"machine.programs": str(programs), "duration_s": 0.03, "report.reference": "none"}
    simulation = _core.cmrc.Simulation(_core.cmrc.config(settings=settings))
    with pytest.raises(_core.cmrc.ListFull) as raised:
        simulation.run()
    assert isinstance(raised.value, cmrc.Error)
    assert "at 0.02000" in str(raised.value) and "refresh 160: no place for a block of kind identify" in str(
        raised.value
    )
