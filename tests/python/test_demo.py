"""The demo: its scenes say what their runs measured, and its page needs no other file."""

import re
from pathlib import Path

import pytest
from cmrc import __main__ as command
from cmrc import demo


def test_one_dsp_misses_the_servo_behind_identify_and_two_do_not() -> None:
    scene = demo.one_long_block()
    assert [row[0] for row in scene.rows] == ["1", "2"]
    assert int(scene.rows[0][1]) > 0 and scene.rows[1][1] == "0"
    assert f"{scene.rows[0][1]} blocks" in scene.conclusion and "leaves 0" in scene.conclusion
    lines = scene.text().splitlines()
    assert lines[0] == scene.title and len({len(line) for line in lines[2:5]}) == 1  # columns are below each other
    assert all(f"<td>{cell}</td>" in scene.page() for cell in scene.rows[0])


def test_a_block_whose_dsp_is_killed_is_run_again() -> None:
    scene = demo.killed()
    assert [row[0] for row in scene.rows] == ["the servo", "identify"]
    for row in scene.rows:
        assert 0 < float(row[1].removesuffix(" ms")) < 3 and row[2] == "1"
    assert scene.conclusion.startswith("No block is lost")


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
