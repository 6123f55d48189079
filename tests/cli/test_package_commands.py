"""``python -m cmrc``: wrong command lines are one line with the command's name, what would be right, and status 2."""

from pathlib import Path

import pytest
from cmrc.__main__ import main


@pytest.mark.parametrize(("given", "says"), [
    (["sweep", "g.toml", "out"], "cmrc sweep: out was not expected (cmrc sweep --help lists options)"),
    (["sweep", "g.toml", "--workrs=2"], 'cmrc sweep: --workrs=2 was not expected; did you mean "--workers"? (cmrc sweep --help'),
    (["sweep"], "cmrc sweep: the following arguments are required: FILE.toml (cmrc sweep --help lists options)"),
    (["sweep", "g.toml", "--workers", "x"], "cmrc sweep: argument --workers: 'x' cannot be used; a whole number is expected (cmrc sweep --help"),
    (["swep"], "cmrc: argument command: invalid choice: 'swep' (choose from "),
    ([], "cmrc: a command is expected: page, events, demo, sweep, search, limits, compare, diff (cmrc --help lists options)"),
])  # fmt: skip
def test_a_wrong_argument(given: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(given)
    assert ended.value.code == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err.startswith(says) and said.err.count("\n") == 1


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (["diff", "a.json", "b.json"], "cmrc diff: a.json: No such file or directory\n"),
        (["demo", "--out", "file"], "cmrc demo: --out: file: is a file; the name of a folder is expected\n"),
    ],
)
def test_a_file_that_is_not_there_or_no_folder(
    given: list[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("kept")
    assert main(given) == 2
    assert capsys.readouterr() == ("", says)
    assert [path.name for path in tmp_path.iterdir()] == ["file"] and Path("file").read_text() == "kept"


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (["--dsps", "four"], 'machine.dsps: "four" is a string; an integer from 1 to 16 is expected'),
        (["--duration", "2s"], 'run.duration_s: "2s" is a string; a number from 1e-06 to 86400 is expected (s)'),
        (["--dsps", "1_0"], 'machine.dsps: "1_0" is a string; an integer from 1 to 16 is expected'),
        (["--set", "dsps= 2"], 'machine.dsps: " 2" is a string; an integer from 1 to 16 is expected'),
        (["--set", "dsps=+2"], 'machine.dsps: "+2" is a string; an integer from 1 to 16 is expected'),
        (["--set", "dsps=٣"], 'machine.dsps: "٣" is a string; an integer from 1 to 16 is expected'),
        (["--duration", "2_0.5"], 'run.duration_s: "2_0.5" is a string; a number from 1e-06 to 86400 is expected (s)'),
        (["--seed", "a"], 'run.seed: "a" is a string; an integer of at least 0 is expected'),
    ],
)
@pytest.mark.parametrize("name", ["limits", "compare"])
def test_a_wrong_value_of_a_setting_is_refused_as_the_emulator_does(
    name: str, given: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([name, *given]) == 2
    assert capsys.readouterr() == ("", f"cmrc {name}: {says}\n")


def test_a_grid_for_the_number_of_dsps_is_told_its_option(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["limits", "--dsps", "1:8"]) == 2
    says = "--dsps: '1:8' is a grid, and --dsps is the number of DSPs of every point; --dsps-grid 1:8 is expected"
    assert capsys.readouterr() == ("", f"cmrc limits: {says}\n")
