"""The demo: its scenes say what their runs measured, and its page needs no other file."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cmrc
import cmrc.page
import pytest
from cmrc import __main__ as command
from cmrc import demo


def test_one_dsp_misses_the_servo_behind_identify_and_two_do_not() -> None:
    scene = demo.one_long_block()
    assert [row[0] for row in scene.rows] == ["1", "2"]
    assert int(scene.rows[0][1]) > 0 and scene.rows[1][1] == "0"
    assert f"{scene.rows[0][1]} blocks" in scene.conclusion and "leaves 0" in scene.conclusion
    lines = scene.text().splitlines()
    table = [line for line in lines if line.startswith("  ")]
    assert lines[0] == scene.title and len(table) == len(scene.header)
    assert len({len(line) for line in table}) == 1  # columns are below each other
    assert max(map(len, lines)) < 80
    assert all(f"<td>{cell}</td>" in scene.page() for cell in scene.rows[0])


def test_a_block_whose_dsp_is_killed_is_run_again() -> None:
    scene = demo.killed()
    assert [row[0] for row in scene.rows] == ["the servo", "identify"]
    for row in scene.rows:
        assert 0 < float(row[1].removesuffix(" ms")) < 3 and row[2] == "1"
    assert scene.conclusion.startswith("No block is lost")


@pytest.mark.golden
def test_a_dsp_that_is_plugged_in_in_a_tenth_of_a_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Callable[[str, str], None]
) -> None:
    """The last scene in small: the new DSP begins to work, and the page is that of its run."""

    def short(settings: dict[str, Any], events: Any = (), reference: Any = None) -> cmrc.Simulation:
        soon = [{**event, "at_s": event["at_s"] / 60} for event in events]
        return cmrc.Simulation(settings={**settings, "duration_s": 0.1}, events=soon, reference=reference)

    monkeypatch.setattr(demo, "Simulation", short)
    golden("demo-plugged.text", demo.plugged_in(tmp_path / "a.html").text())
    recording = cmrc.page.Recording.read(tmp_path / "a.html")
    assert recording.header["title"] == "Scene 5: a DSP is plugged in" and recording.report["dsps"][1]["claims"] > 0


def test_names_of_runs_take_as_many_lines_as_they_need() -> None:
    scene = demo.Scene("t", "long " * 40, ("3 DSPs", "missed", *demo.COST))
    scene.rows += [[name, "12.34 %", *["1000.00 mm"] * 8] for name in ("a", "b", "c")]
    scene.rows.append(["together, at most 2 long blocks at a time", "0 %", *["0 m"] * 8])
    lines = scene.text().splitlines()
    table = [line for line in lines if line.startswith("  ")]
    assert max(map(len, lines)) < 80 and len({len(line) for line in table}) == 1
    assert [line[-12:].strip() for line in table[:4]] == ["together, at", "most 2 long", "blocks at a", "time"]
    assert table[3].split()[:5] == ["3", "DSPs", "a", "b", "c"] and table[4].split()[0] == "missed"


def test_lengths_are_those_of_the_report_on_the_terminal() -> None:
    """0.78 um is not 0.00 mm."""
    found = [demo._length(metres) for metres in (0, 7.76e-7, 2.713e-3, 0.5, 10.161159)]
    assert found == ["0 m", "0.776 um", "2.71 mm", "500 mm", "10.16 m"]


def test_a_share_that_is_not_0_is_not_shown_as_0() -> None:
    found = [demo._percent(share) for share in (None, 0.0, 4.9e-5, 5.1e-5, 0.1234)]
    assert found == ["-", "0 %", "< 0.01 %", "0.01 %", "12.34 %"]


@pytest.mark.campaign
def test_the_whole_demo_writes_a_page_that_works_offline(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["demo", "--out", str(tmp_path / "demo")]) == 0
    printed = capsys.readouterr().out
    assert [line for line in printed.splitlines() if re.match(r"\d\. ", line)] == re.findall(
        r"<h2>(.*?)</h2>", (tmp_path / "demo/demo.html").read_text()
    )
    assert printed.rstrip().endswith(f"Open {tmp_path / 'demo' / 'demo.html'}")
    assert (
        "http" not in (tmp_path / "demo/demo.html").read_text()
        and (tmp_path / "demo/scene5.html").stat().st_size > 10_000
    )


def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert command.main(["demo", "--out", str(tmp_path / "file" / "demo")]) == 2
    assert "file" in capsys.readouterr().err
