"""The page in Chromium: seen, turned, zoomed, asked; on a phone, in the dark, without WebGL."""

import importlib.util
import re
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from browser import NO_WEBGL, Tab, chromium, opened
from cmrc.page import Recording
from locations import ROOT
from page_runs import HOSTILE, KILLED_AT_S

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.unsanitized]


def misses(recording: Recording) -> list[tuple[float, str]]:
    jobs, last = recording.jobs, recording.last_runs()
    rows = [i for i in last.tolist() if jobs["missed"][i]]
    return sorted(
        (
            float(jobs["deadline_s"][i]),
            f"{recording.header['kinds'][jobs['kind'][i]]}:{jobs['robot'][i]}:{jobs['number'][i]}",
        )
        for i in rows
    )


def camera(tab: Tab) -> list[float]:
    return [float(value) for value in tab.page.evaluate("page.dock.eye")]


def test_it_opens_without_a_request_or_a_complaint(tab: Tab, run: tuple[Path, Recording]) -> None:
    assert tab.asked == [run[0].as_uri()]
    assert tab.problems == []
    facts = tab.page.locator("#facts").inner_text()
    assert facts.startswith(f"{len(misses(run[1]))} deadlines missed")
    assert tab.page.locator("#title").inner_text() == " ".join(
        HOSTILE.replace("\u2028", " ").replace("\u0007", " ").split()
    )
    assert tab.page.evaluate("document.querySelectorAll('header b').length") == 1  # nothing of the title is markup


def test_a_fetch_is_refused_by_the_policy(tab: Tab) -> None:
    before = len(tab.problems)
    assert tab.page.evaluate("fetch('https://example.org/').then(() => 'fetched', () => 'refused')") == "refused"
    new = tab.problems[before:]
    del tab.problems[before:]
    assert any("Content Security Policy" in problem for problem in new)


def test_the_dock_turns_and_keeps_its_ground(tab: Tab) -> None:
    x, y, width, height = tab.place("#dock")
    before = camera(tab)
    tab.page.mouse.move(x + width * 0.7, y + height * 0.4)
    tab.page.mouse.down()
    tab.page.mouse.move(x + width * 0.5, y + height * 0.5, steps=4)
    tab.page.mouse.up()
    tab.settle()
    assert camera(tab) != before
    # As far down as it goes: the eye stays above the ground, and ground and sky are both in the picture.
    for _ in range(3):
        tab.page.mouse.move(x + width * 0.5, y + height * 0.9)
        tab.page.mouse.down()
        tab.page.mouse.move(x + width * 0.5, y + 2, steps=4)
        tab.page.mouse.up()
    tab.settle()
    assert camera(tab)[2] >= 1.5
    colours = tab.colours((0.97, 0.97), (0.97, 0.02))
    assert sum(colours[0][:3]) > 0 and colours[0] != colours[1]
    tab.page.locator("#dock canvas").focus()
    lowest = camera(tab)
    for _ in range(6):
        tab.page.keyboard.press("ArrowUp")
    tab.page.keyboard.press("+")
    tab.settle()
    assert camera(tab)[2] > lowest[2]
    tab.page.click("#home")
    assert camera(tab) == pytest.approx(before)


def test_the_wheel_zooms_from_the_whole_run_to_one_claim(tab: Tab, run: tuple[Path, Recording]) -> None:
    jobs = run[1].jobs
    pid = run[1].header["kinds"].index("pid")
    row = next(i for i in range(200, jobs["kind"].size) if jobs["kind"][i] == pid and jobs["dsp"][i] == 0)
    middle = (jobs["claimed_s"][row] + jobs["ended_s"][row]) / 2
    took = jobs["ended_s"][row] - jobs["claimed_s"][row]
    for _ in range(40):
        if tab.state("to") - tab.state("from") < 3 * took:
            break
        tab.page.mouse.move(*tab.lane("DSP 0", middle))
        tab.page.mouse.wheel(0, -500)
        tab.settle(1)
    assert tab.state("from") < jobs["claimed_s"][row] < jobs["ended_s"][row] < tab.state("to")
    tab.page.mouse.move(*tab.lane("DSP 0", middle))
    said = tab.hint()
    assert (
        f"pid, job {jobs['number'][row]}" in said
        and "DSP 0 claimed it" in said
        and f"ran it for {took * 1e6:.2f}" in said.replace(" µs", "")
    )
    tab.page.keyboard.press("0")
    assert (tab.state("from"), tab.state("to")) == (0, tab.state("end"))


def test_a_click_goes_there_and_dragging_moves_the_view(tab: Tab) -> None:
    tab.page.mouse.click(*tab.lane("DSP 2", 0.1))
    assert tab.state("now") == pytest.approx(0.1, abs=0.002)
    assert tab.page.locator("#clock").inner_text().startswith("0.1")
    tab.page.evaluate("page.state.show(0.1, 0.2)")
    tab.settle()
    x, y = tab.lane("DSP 0", 0.15)
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x - 200, y, steps=3)
    tab.page.mouse.up()
    assert tab.state("from") > 0.11 and tab.state("to") - tab.state("from") == pytest.approx(0.1)


def test_a_lane_shows_what_its_dsp_waited_for(tab: Tab, run: tuple[Path, Recording]) -> None:
    hints = []
    for time in (0.03, 0.05, 0.1, 0.15, 0.2, 0.3):
        tab.page.mouse.move(*tab.lane("DSP 0", time))
        hints.append(tab.hint())
    assert any(re.search(r"waiting: [\d.]+ % for bus A", hint) for hint in hints), hints
    # Within one slice that waited for more than the foot's full height means, the causes share that height.
    waits = np.array([run[1].whole(f"lane.{name}") for name in ("bus_a", "bus_b", "list")])
    slot, what, took = (run[1].whole(f"lane.{name}") for name in ("slot", "what", "took"))
    pid = 4 + run[1].header["kinds"].index("pid")
    row = next(i for i in np.flatnonzero((slot == 2) & (what == pid)).tolist() if waits[1, i] > 0.05 * took[i])
    lane = run[1].lanes[2]
    own = int(np.count_nonzero(slot[:row] == 2))
    begin, end = float(lane.from_s[own]), float(lane.to_s[own])
    tab.page.evaluate("([a, b]) => page.state.show(a, b)", [begin + 0.2 * (end - begin), end - 0.2 * (end - begin)])
    tab.settle()
    x, y = tab.lane("DSP 2", (begin + end) / 2)
    foot = tab.page.evaluate(
        """([x, y]) => {
          const canvas = document.querySelector("#lanes canvas"), box = canvas.getBoundingClientRect();
          const data = canvas.getContext("2d").getImageData(Math.round(x - box.left), Math.round(y - box.top + 7.5), 1, 9).data;
          return Array.from({ length: 9 }, (_, i) => [...data.slice(4 * i, 4 * i + 3)].join());
        }""",
        [x, y],
    )
    shown = [foot.count(colour) for colour in ("0,114,178", "230,159,0", "204,121,167")]
    assert sum(shown) == 9 and shown == pytest.approx(9 * waits[:, row] / waits[:, row].sum(), abs=1.01), foot
    tab.page.mouse.move(x, y)
    assert f"of this it waited {waits[0, row] * 1e-3:.2f}" in tab.hint().replace(" µs", ""), tab.hint()


def test_a_killed_dsp_is_seen_to_die(tab: Tab) -> None:
    tab.page.mouse.move(*tab.lane("DSP 1", KILLED_AT_S + 0.1))
    assert "DSP 1 is dead" in tab.hint()
    tab.page.mouse.move(*tab.lane("DSP 2", KILLED_AT_S + 0.1))
    assert "dead" not in tab.hint()
    tab.page.mouse.move(*tab.lane("events", KILLED_AT_S))
    assert "0.2000 s: fail" in tab.hint()
    tab.page.keyboard.press("e")
    assert tab.state("now") == KILLED_AT_S


def test_a_click_on_a_miss_shows_why(tab: Tab, run: tuple[Path, Recording]) -> None:
    chain = next(
        one for one in run[1].report["misses"] if one["kind"] == "pid" and one["outcome"] == "late" and one["behind"]
    )
    due = chain["deadline_ps"] * 1e-12
    tab.page.evaluate("t => page.state.show(t - 0.004, t + 0.004)", due)
    tab.settle()
    tab.page.mouse.click(*tab.lane("pid", due))
    panel = tab.page.locator("#miss")
    assert panel.is_visible() and f"job {chain['number']}" in panel.locator("h2").inner_text()
    text = panel.inner_text()
    assert "every DSP" in text and "In its way" in text and "late" in text
    amounts = panel.locator(".part .amount").all_inner_texts()
    assert len(amounts) >= 3 and amounts[-1].startswith("=")
    # A block in the way leads to its claim.
    panel.locator(".behind button").first.click()
    assert any(tab.state("now") == pytest.approx(one["claimed_ps"] * 1e-12, abs=1e-9) for one in chain["behind"])
    tab.page.keyboard.press("Escape")
    assert panel.is_hidden()


def test_keys_play_seek_and_go_from_miss_to_miss(tab: Tab, run: tuple[Path, Recording]) -> None:
    tab.page.keyboard.press("]")
    assert tab.state("speed") == 3 and tab.page.locator("#speed").input_value() == "3"
    for _ in range(5):
        tab.page.keyboard.press("[")
    assert tab.state("speed") == 0.01  # far from the run's end, however slow the machine is
    tab.page.keyboard.press("Space")
    tab.wait_until("page.state.now > 0.0005")
    tab.page.keyboard.press("Space")
    assert tab.state("playing") is False
    tab.page.keyboard.press("Home")
    tab.page.keyboard.press("n")
    first = misses(run[1])[0]
    assert tab.miss() == first[1]
    tab.page.keyboard.press("n")
    tab.page.keyboard.press("p")
    assert tab.miss() == first[1] and tab.state("now") == pytest.approx(first[0], abs=1e-6)


def test_a_link_leads_to_an_instant_and_a_miss(other: Tab, run: tuple[Path, Recording]) -> None:
    _, name = misses(run[1])[7]
    other.load(run[0], f"#t=0.123456&miss={name}")
    assert other.state("now") == pytest.approx(0.123456) and other.miss() == name
    assert other.page.locator("#miss").is_visible()
    other.page.evaluate("page.state.choose(-1); page.state.seek(0.25)")
    other.wait_until("location.hash.startsWith('#t=0.25')")
    assert "miss" not in other.page.evaluate("location.hash")
    other.load(run[0], "#t=nonsense&miss=nothing:9:9&from=5")
    assert other.state("now") == 0 and other.page.locator("#miss").is_hidden() and other.problems == []


def test_the_dock_says_what_is_under_the_pointer(tab: Tab) -> None:
    x, y, width, height = tab.place("#dock")
    said = set()
    for i in range(30):
        for k in range(12):
            lines = tab.page.evaluate(
                "([x, y]) => page.dock.explain(x, y)", [x + width * (0.2 + 0.02 * i), y + height * (0.2 + 0.06 * k)]
            )
            if lines:
                said.add(lines[0].split(" ")[0])
    assert {"ship", "container", "crane", "AGV"} <= said


def test_the_picture_is_a_png_of_dock_and_lanes(tab: Tab, tmp_path: Path) -> None:
    with tab.page.expect_download() as download:
        tab.page.click("#picture")
    path = tmp_path / "picture.png"
    download.value.save_as(path)
    data = path.read_bytes()
    width, height = int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and width >= 1000 and height > 500 and len(data) > 20_000
    assert re.fullmatch(r"cmrc-\d+\.\d{3}s\.png", download.value.suggested_filename)


def test_a_phone_shows_it_all_within_its_width(browser: Any, run: tuple[Path, Recording]) -> None:
    with opened(
        browser, run[0], viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True, device_scale_factor=2
    ) as tab:
        assert tab.page.evaluate("document.documentElement.scrollWidth") == 390
        for selector in ("#dock canvas", "#lanes canvas", "#play", "#slider", "#keys"):
            left, top, width, height = tab.place(selector)
            assert left >= 0 and left + width <= 391 and top >= 0 and height > 20, selector
        tab.page.touchscreen.tap(*tab.lane("DSP 1", 0.3))
        assert tab.state("now") == pytest.approx(0.3, abs=0.01) and "DSP 1" in tab.hint()
        # Two fingers zoom the lanes.
        x, y = tab.lane("DSP 1", 0.2)
        session = tab.context.new_cdp_session(tab.page)

        def touch(kind: str, *places: float) -> None:
            points = [{"x": at, "y": y, "id": n} for n, at in enumerate(places)]
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        touch("touchStart", x - 20)
        touch("touchStart", x - 20, x + 20)
        for by in (30, 45, 60, 80):
            touch("touchMove", x - by, x + by)
        touch("touchEnd")
        tab.settle()
        width = tab.state("to") - tab.state("from")
        assert 0.05 < width < 0.2 and tab.state("from") < 0.2 < tab.state("to")
        assert tab.problems == []


def test_a_dark_theme_and_little_motion_are_given_where_they_are_asked_for(
    browser: Any, run: tuple[Path, Recording]
) -> None:
    with opened(browser, run[0], color_scheme="dark", reduced_motion="reduce") as tab:
        colours = [tab.page.evaluate("getComputedStyle(document.body).backgroundColor")]
        tab.page.keyboard.press("d")
        colours.append(tab.page.evaluate("getComputedStyle(document.body).backgroundColor"))
        brightness = [sum(int(part) for part in re.findall(r"\d+", colour)[:3]) for colour in colours]
        assert brightness[0] < 150 and brightness[1] > 600
        assert tab.state("still") is True
        assert tab.page.evaluate("getComputedStyle(document.getElementById('play')).transitionDuration") == "0s"
        tab.page.evaluate("page.state.setSpeed(0.1); page.state.play(true)")
        places = tab.page.evaluate(
            "[0.2, 0.2, 0.2, 0.2, 0.2].map(s => { page.state.advance(s); return page.state.now; })"
        )
        tab.page.evaluate("page.state.play(false)")
        assert len(set(places)) < 5  # it does not glide
        assert places[-1] > 0


def test_without_webgl_lanes_and_plots_still_work(started: Any, run: tuple[Path, Recording]) -> None:
    with chromium(started, NO_WEBGL) as plain, opened(plain, run[0]) as tab:
        assert "no WebGL" in tab.page.locator("#wait").inner_text()
        tab.page.mouse.click(*tab.lane("DSP 0", 0.2))
        assert tab.state("now") == pytest.approx(0.2, abs=0.002) and "DSP 0" in tab.hint()
        assert tab.page.locator(".u-wrap").count() == 2
        assert all("WebGL" in problem or "WEBGL" in problem or "context" in problem for problem in tab.problems)


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("settings", "most_bytes"),
    [
        ({"machine.dsps": 4}, 5_000_000),
        ({"machine.dsps": 4, "preset": "saturated", "dock.agvs": 8}, 15_000_000),
    ],
    ids=["four_dsps", "saturated"],
)
def test_a_long_run_is_a_small_page_that_is_drawn_in_time(
    browser: Any, tmp_path: Path, settings: dict[str, Any], most_bytes: int
) -> None:
    """180 s. At most 8 ms of script in a frame of 1920 x 1080, in processor time; 20 frames/s by software at 1280 x
    720, on two processors that do little else."""
    spec = importlib.util.spec_from_file_location("page_frames", ROOT / "scripts" / "documents" / "page_frames.py")
    assert spec and spec.loader
    frames = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(frames)
    path = tmp_path / "long.html"
    given = dict(settings)
    simulation = cmrc.Simulation(preset=given.pop("preset", None), settings={**given, "duration_s": 180.0})
    simulation.record()
    simulation.run()
    simulation.write_page(path)
    assert path.stat().st_size <= most_bytes
    for width, height in frames.SIZES:
        with opened(browser, path, viewport={"width": width, "height": height}) as tab:
            session = tab.context.new_cdp_session(tab.page)
            session.send("Performance.enable", {"timeDomain": "threadTicks"})
            for view, how in frames.views(tab).items():
                _, script_ms, rate = frames.played(tab, session, how)
                assert script_ms <= 8, (view, script_ms)
                assert height != 720 or rate >= 20, (view, rate)
