"""What a page costs: its size, and the script of its frames (docs/page.md, Size and speed).

`PYTHONPATH=build/python python scripts/documents/page_frames.py PAGE.html ...` plays each page in Chromium with
software WebGL, at 1920 x 1080 and 1280 x 720: the whole run, 10 s of it, 20 ms of it, and zooming between the two.
Script is measured within the page, from the begin to the end of a frame's work (performance.now), and again as the
processor time of the page's main thread per frame, which other work of the machine does not count in. Frames per second
are those that the browser has shown; they want a machine with two processors that does nothing else. Needs what
`scripts/setup page` installs."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "tests" / "page"))

from browser import SOFTWARE, Tab, chromium, driver, opened

SIZES = ((1920, 1080), (1280, 720))
SETTLE_MS, PLAY_MS = 5000, 5000
ZOOMING = """(() => {
  let factor = 0.95;
  window.zooming = setInterval(() => {
    const { from, to, now } = page.state;
    if (to - from < 0.01) factor = 1.05;
    if (to - from > 0.9 * (page.state.end - page.state.begin)) factor = 0.95;
    page.state.zoom(factor, now);
  }, 8);
})()"""
"""Lanes and plots are drawn in each frame."""


def views(tab: Tab) -> dict[str, str]:
    """What is shown, and how it is played."""
    middle = tab.page.evaluate("(page.state.begin + page.state.end) / 3")
    return {
        "whole run, speed 10": "page.state.whole(); page.state.setSpeed(10)",
        "10 s, speed 1": f"page.state.show({middle - 1}, {middle + 9}); page.state.setSpeed(1)",
        "20 ms, speed 1/1000": f"page.state.show({middle}, {middle + 0.02}); page.state.setSpeed(0.001)",
        "zooming without a stop": "page.state.whole(); " + ZOOMING,
    }


def played(tab: Tab, session: Any, how: str) -> tuple[list[float], float, float]:
    """Script of each frame and processor time of the main thread per frame in ms, and frames per second."""
    page = tab.page
    page.evaluate("clearInterval(window.zooming); page.state.seek((page.state.begin + page.state.end) / 3)")
    page.evaluate(f"{how}; page.state.play(true)")
    page.wait_for_timeout(SETTLE_MS)
    page.evaluate("page.frames.length = 0; window.since = performance.now()")
    before = busy(session)
    page.wait_for_timeout(PLAY_MS)
    frames, seconds = page.evaluate("[page.frames.slice(), (performance.now() - since) / 1000]")
    used = busy(session) - before
    page.evaluate("page.state.play(false)")
    return sorted(frames), 1000 * used / max(1, len(frames)), len(frames) / seconds


def busy(session: Any) -> float:
    """Seconds of script so far."""
    values = session.send("Performance.getMetrics")["metrics"]
    return float(next(one["value"] for one in values if one["name"] == "ScriptDuration"))


def main() -> None:
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    with driver() as started, chromium(started, SOFTWARE) as browser:
        for path in map(Path, sys.argv[1:]):
            print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB")
            for width, height in SIZES:
                with opened(browser, path.resolve(), viewport={"width": width, "height": height}) as tab:
                    session = tab.context.new_cdp_session(tab.page)
                    session.send("Performance.enable", {"timeDomain": "threadTicks"})
                    for name, how in views(tab).items():
                        frames, thread, rate = played(tab, session, how)
                        if not frames:
                            raise SystemExit(f"{path}: the run ended while it was played; at least 100 s are expected")
                        middle, most = frames[len(frames) // 2], frames[int(len(frames) * 0.95)]
                        print(
                            f"  {width} x {height}, {name}: script {middle:.1f} ms, 95 % of frames {most:.1f} ms, "
                            f"main thread {thread:.1f} ms a frame; {rate:.0f} frames/s at {tab.page.evaluate('page.dock.resolution'):.2f} "
                            "of the dots"
                        )
    print(f"load of the machine: {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
