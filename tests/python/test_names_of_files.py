"""Names of files with any byte. Python has a byte that is no UTF-8 as a lone surrogate; a zero byte is in no name."""

import os
from collections.abc import Callable
from pathlib import Path

import cmrc
import pytest
from cmrc import c40, network, page, plant
from cmrc.sweeps import Sweep

ODD = os.fsdecode(b"gr\xfc\xdfe")  # Latin-1
LOOP = "_start: b _start\n"
QUICK = {"duration_s": 0.03, "settings": {"report.reference": "none"}}

OPENED: dict[str, Callable[[str], object]] = {
    "source": c40.assemble_file,
    "object": c40.read_coff,
    "program": c40.Processor,
    "board": lambda path: c40.Processor(c40.assemble(LOOP), board=path),
    "EPROM": lambda path: c40.read_rom(path, width=8),
    "configuration": lambda path: cmrc.Simulation(config=path),
    "network": network.Network.from_file,
    "layout": lambda path: plant.load_layout(plant.default_dock(), path),
    "snapshot": cmrc.Simulation.resume,
    "result": cmrc.Result.load,
    "page": page.Recording.read,
}


@pytest.mark.parametrize("kind", OPENED)
def test_a_missing_file_is_named(kind: str) -> None:
    with pytest.raises((ValueError, OSError)) as caught:
        OPENED[kind](f"{ODD}.none")
    assert any(name in str(caught.value) for name in (r"gr\xfc\xdfe.none", repr(f"{ODD}.none")))


@pytest.mark.parametrize("kind", OPENED)
def test_a_name_with_a_zero_byte_is_refused(kind: str) -> None:
    with pytest.raises(ValueError, match="zero|null byte"):
        OPENED[kind]("a\0b")


@pytest.mark.parametrize("kind", OPENED)
def test_a_surrogate_that_stands_for_no_byte_is_in_no_name(kind: str) -> None:
    with pytest.raises(ValueError, match="surrogate") as caught:
        OPENED[kind]("a\ud800")
    assert "incompatible function arguments" not in str(caught.value)


def test_files_with_such_names_are_written_and_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(f"{ODD}.asm").write_text(LOOP)
    program = c40.assemble_file(f"{ODD}.asm")
    c40.write_coff(program, f"{ODD}.out")
    Path(f"{ODD}.toml").write_text("[machine]\ndsps = 3\n")
    made = cmrc.Simulation(config=f"{ODD}.toml", **QUICK)
    cmrc.write_snapshot(f"{ODD}.snap", made.snapshot())
    result = cmrc.Simulation.resume(f"{ODD}.snap").run()
    result.save(f"{ODD}.result")
    assert c40.read_coff(f"{ODD}.out").entry == program.entry
    assert cmrc.Result.load(f"{ODD}.result").report == result.report and len(result.report["dsps"]) == 3
    assert {os.fsdecode(name) for name in os.listdir(os.fsencode(tmp_path))} == {
        f"{ODD}.{kind}" for kind in ("asm", "out", "toml", "snap", "result")
    }


def test_text_that_is_no_unicode_is_an_ordinary_mistake() -> None:
    for odd in ("\ud800", "\udcff"):
        with pytest.raises(cmrc.ConfigError, match="no such key"):
            cmrc.Simulation(settings={odd: 1})
        with pytest.raises(cmrc.ConfigError, match="bus.topology"):
            cmrc.Simulation(settings={"bus.topology": odd})
        with pytest.raises(c40.AssemblyError):
            c40.assemble(odd)


def test_a_setting_that_no_report_and_no_snapshot_can_hold_is_refused() -> None:
    with pytest.raises(cmrc.ConfigError, match=r'dock.layout: "gr\\xfc\\xdfe.toml" is not UTF-8; a text in UTF-8'):
        cmrc.Simulation(settings={"dock.layout": f"{ODD}.toml"})


def test_a_sweep_lies_in_a_folder_with_such_a_name(tmp_path: Path) -> None:
    grid = {"axes": {"machine.dsps": [1, 2]}, "fixed": {"run.duration_s": 0.03, "report.reference": "none"}}
    cmrc.sweep(grid, tmp_path / ODD)
    assert len(Sweep(tmp_path / ODD)) == 2
