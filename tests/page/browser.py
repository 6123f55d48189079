"""Debian's Chromium, driven by Playwright; tests that need it are skipped, with the reason, where either is missing."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

SOFTWARE = ["--no-sandbox", "--enable-unsafe-swiftshader"]
NO_WEBGL = ["--no-sandbox", "--disable-gpu", "--disable-3d-apis"]


@contextmanager
def driver() -> Iterator[Any]:
    """Of browsers; a process has one at a time. Skips the test where it or Chromium is missing."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="Playwright is missing (scripts/setup page installs it)"
    )
    found()
    with playwright.sync_playwright() as started:
        yield started


def found() -> str:
    path = next((one for name in ("chromium", "chromium-browser") if (one := shutil.which(name))), None)
    if path is None:
        pytest.skip("there is no Chromium here (scripts/setup page installs Debian's)")
    return path


@contextmanager
def chromium(started: Any, arguments: list[str]) -> Iterator[Any]:
    """A browser without a screen."""
    browser = started.chromium.launch(executable_path=found(), args=arguments)
    try:
        yield browser
    finally:
        browser.close()


SCREEN = {"width": 1280, "height": 800}
COLOURS = """places => {
  const picture = page.dock.picture(), copy = document.createElement("canvas");
  [copy.width, copy.height] = [picture.width, picture.height];
  const context = copy.getContext("2d");
  context.drawImage(picture, 0, 0);
  const at = ([x, y]) => context.getImageData(Math.floor(x * picture.width), Math.floor(y * picture.height), 1, 1);
  return places.map(place => [...at(place).data]);
}"""


class Tab:
    """A page that is open, and what it asked for or complained of."""

    def __init__(self, browser: Any, **options: Any) -> None:
        self.context = browser.new_context(**{"viewport": SCREEN, "accept_downloads": True, **options})
        self.page = self.context.new_page()
        self.problems: list[str] = []
        self.asked: list[str] = []
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", lambda message: self.problems.append(message.text) if message.type == "error" else None)
        self.page.on("request", lambda request: self.asked.append(request.url))

    def load(self, path: Path, place: str = "") -> None:
        """The page as one opens it, whatever was here before. A third cheaper than a new tab."""
        self.page.goto("about:blank")
        self.problems.clear()
        self.asked.clear()
        self.page.goto(path.as_uri() + place)
        self.page.wait_for_selector("html[data-ready]", timeout=60_000)
        self.settle()

    def resize(self, width: int, height: int) -> None:
        self.page.set_viewport_size({"width": width, "height": height})
        self.settle()

    def settle(self, frames: int = 3) -> None:
        """Until so many frames have been drawn."""
        self.page.evaluate(
            "n => new Promise(done => { const next = () => n-- > 0 ? requestAnimationFrame(next) : done(0); next(); })",
            frames,
        )

    def wait_until(self, expression: str, tries: int = 600) -> None:
        """The page's policy forbids what Playwright's own waiting evaluates."""
        for _ in range(tries):
            if self.page.evaluate(expression):
                return
            self.settle(2)
        raise AssertionError(f"{expression} did not become true")

    def state(self, name: str) -> Any:
        """A value of what is shown (page/src/ui/state.ts)."""
        return self.page.evaluate(f"page.state.{name}")

    def place(self, selector: str) -> tuple[float, float, float, float]:
        """Left, top, width, height."""
        box = self.page.locator(selector).bounding_box()
        assert box is not None
        return box["x"], box["y"], box["width"], box["height"]

    def lane(self, row: str, time: float) -> tuple[float, float]:
        """Where an instant of a row of the lanes is on the screen."""
        x, y = self.page.evaluate("([row, time]) => page.lanes.placeOf(row, time)", [row, time])
        return float(x), float(y)

    def miss(self) -> str | None:
        """The name of the job whose miss is shown."""
        name = self.page.evaluate("page.state.miss >= 0 ? page.miss.id(page.state.miss) : null")
        return None if name is None else str(name)

    def colours(self, *places: tuple[float, float]) -> list[list[int]]:
        """Of the dock's picture, at shares of its width and height."""
        found: list[list[int]] = self.page.evaluate(COLOURS, places)
        return found

    def hint(self) -> str:
        return str(self.page.locator("#hint").inner_text()) if self.page.locator("#hint").is_visible() else ""


@contextmanager
def opened(browser: Any, path: Path, place: str = "", **options: Any) -> Iterator[Tab]:
    """A tab that is closed in the end."""
    tab = Tab(browser, **options)
    try:
        tab.load(path, place)
        yield tab
    finally:
        tab.context.close()
