"""The page of the demo in Chromium."""

from pathlib import Path
from typing import Any

import pytest
from cmrc import demo

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.unsanitized]


@pytest.mark.parametrize("width", [400, 1280])
def test_it_is_as_wide_as_the_window(browser: Any, tmp_path: Path, width: int) -> None:
    """A table with no room moves alone; in a usual window all of it is seen."""
    scene = demo.Scene("3. The same load", "A sentence.", ("3 DSPs", "avoidance missed", *demo.COST))
    scene.rows += [[name, "12.34 %", "12.34 %", "1000 Hz", "1000 Hz", "12.34 %", "1000 Hz", "10.16 mm", "12.34 %", "0.123 s"]
                   for name in ("together", "together, at most 2 long blocks at a time")]  # fmt: skip
    path = tmp_path / "demo.html"
    path.write_text(demo.PAGE.format(scenes=scene.page(), page="scene5.html"), encoding="utf-8")
    context = browser.new_context(viewport={"width": width, "height": 800})
    try:
        page = context.new_page()
        page.goto(path.as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        room = page.evaluate("(e => e.scrollWidth - e.clientWidth)(document.querySelector('.wide'))")
        assert (room > 0) == (width == 400)
        page.screenshot(path=tmp_path / "demo.png")
    finally:
        context.close()
