"""docs/sweeps.md says what is."""

import re
from pathlib import Path

import pytest
from cmrc.sweeps import grid, metrics, store
from cmrc.sweeps.search import asked_of
from locations import ROOT

PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("text", BLOCKS, ids=range(len(BLOCKS)))
def test_every_grid_of_the_page_is_one(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(text)
    made = grid.read(tmp_path / "a.toml")
    if made.search:
        if "space" in made.search:
            pytest.importorskip("optuna")
        asked_of(made)
    else:
        if made.futures:
            assert len(list(made.points())) == 2 * 3 and made.fork_at_s == 0.5
            return
        assert len(list(made.points())) == 4 * 4 * 3
        assert text in (ROOT / "examples" / "misses.toml").read_text(encoding="utf-8")


def first_column(heading: str) -> list[str]:
    lines = iter(PAGE.splitlines())
    for line in lines:
        if line.startswith(heading):
            break
    next(lines)
    rows = []
    for line in lines:
        if not line.startswith("|"):
            break
        rows.append(line.split("|")[1])
    return re.findall(r"`([^`]+)`", " ".join(rows))


def test_the_tables_of_the_page_are_whole() -> None:
    assert sorted(first_column("| column | meaning |")) == sorted(name for name, _ in store.COLUMNS)
    assert sorted(first_column("| name | what it is |")) == sorted(metrics.NAMED)
    assert [name.strip("[]") for name in first_column("| table | what it holds |")] == list(grid.TABLES)
