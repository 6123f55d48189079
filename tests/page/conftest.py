"""A page that is open in Chromium, for the tests that look at it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import SCREEN, SOFTWARE, Tab, chromium, driver, opened
from cmrc.page import Recording
from page_runs import BUSY, HOSTILE, KILLED, recorded


@pytest.fixture(scope="session")
def started() -> Iterator[Any]:
    with driver() as one:
        yield one


@pytest.fixture(scope="session")
def browser(started: Any) -> Iterator[Any]:
    with chromium(started, SOFTWARE) as opened:
        yield opened


@pytest.fixture(scope="session")
def run(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Recording]:
    path = tmp_path_factory.mktemp("page") / "busy.html"
    return path, recorded(BUSY, KILLED, path, HOSTILE)[1]


@pytest.fixture(scope="module")
def shared(browser: Any, run: tuple[Path, Recording]) -> Iterator[Tab]:
    with opened(browser, run[0]) as tab:
        yield tab


@pytest.fixture
def tab(shared: Tab) -> Tab:
    """The page of ``run`` as it was opened. A test leaves what this does not put back as it has found it."""
    shared.page.set_viewport_size(SCREEN)
    shared.page.evaluate(
        "page.state.choose(-1); page.state.play(false); page.state.setSpeed(1); page.state.whole(); page.state.seek(0)"
    )
    shared.page.mouse.move(2, 2)
    shared.settle()
    return shared


@pytest.fixture(scope="module")
def empty(browser: Any) -> Iterator[Tab]:
    tab = Tab(browser)
    yield tab
    tab.context.close()


@pytest.fixture
def other(empty: Tab) -> Tab:
    """A tab that loads pages, one after another."""
    empty.page.set_viewport_size(SCREEN)
    return empty
