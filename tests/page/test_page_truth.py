"""What the page draws and says is what the recording has: marks, words, scales, names; and links, keys and names of its
parts lead to what they promise."""

import re
from collections import Counter
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from browser import Tab
from cmrc.page import Recording
from page_runs import BUSY, recorded

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.unsanitized]

VERMILLION, SKY = (213, 94, 0), (86, 180, 233)
PIXELS = """([x, y, width, height]) => {
  const canvas = document.querySelector("#lanes canvas"), box = canvas.getBoundingClientRect();
  const data = canvas.getContext("2d").getImageData(Math.round(x - box.left), Math.round(y - box.top), width, height).data;
  return [...data];
}"""


def pixels(tab: Tab, row: str, time: float, before: int, width: int, high: int = 10) -> np.ndarray[Any, Any]:
    """Colours of a row around an instant: height x width x 3."""
    x, y = tab.lane(row, time)
    data = tab.page.evaluate(PIXELS, [x - before, y - high // 2, width, high])
    return np.array(data).reshape(high, width, 4)[:, :, :3]


def coloured(of: np.ndarray[Any, Any], colour: tuple[int, int, int]) -> set[int]:
    """Columns that have that colour somewhere."""
    return set(np.flatnonzero((np.abs(of - colour).sum(axis=2) < 12).any(axis=0)).tolist())


def last_runs(recording: Recording, kind: str) -> list[int]:
    k = recording.header["kinds"].index(kind)
    return [i for i in recording.last_runs().tolist() if recording.jobs["kind"][i] == k]


def view(tab: Tab, begin: float, end: float) -> None:
    tab.page.evaluate("([a, b]) => page.state.show(a, b)", [begin, end])
    tab.settle()


def test_a_missed_deadline_is_drawn_at_its_deadline_and_nowhere_else(tab: Tab, run: tuple[Path, Recording]) -> None:
    jobs = run[1].jobs
    for kind in ("pid", "torque_compensation", "trajectory_planning.crane", "inverse_kinematics.crane"):
        begin, end = 0.2245, 0.2275
        view(tab, begin, end)
        row = kind.replace("_", " ")
        (left, _), (right, _) = tab.lane(row, begin), tab.lane(row, end)
        width = round(right - left)
        due = [float(jobs["deadline_s"][i]) for i in last_runs(run[1], kind) if jobs["missed"][i]]
        expected = [(time - begin) / (end - begin) * width for time in due if begin <= time <= end]
        seen = coloured(pixels(tab, row, begin, 0, width), VERMILLION)
        assert all(min((abs(x - at) for at in expected), default=1e9) < 8 for x in seen), (kind, sorted(seen), expected)
        assert all(any(abs(x - at) < 8 for x in seen) for at in expected)
    assert any(jobs["missed"][i] and jobs["deadline_s"][i] < 0.2245 for i in last_runs(run[1], "pid"))


def test_the_end_of_a_job_is_seen_however_far_its_deadline_is(tab: Tab, run: tuple[Path, Recording]) -> None:
    jobs, kind = run[1].jobs, "trajectory_planning.agv"
    row = kind.replace("_", " ")
    met = [i for i in last_runs(run[1], kind) if jobs["outcome"][i] == 0 and not jobs["missed"][i]]
    far = [i for i in met if jobs["deadline_s"][i] - jobs["ended_s"][i] > 0.02][:4]
    assert len(far) == 4
    for i in far:
        end = float(jobs["ended_s"][i])
        view(tab, end - 2e-5, end + 2e-5)
        assert 4 in coloured(pixels(tab, row, end, 4, 9), SKY)
        tab.page.mouse.move(*tab.lane(row, end))
        assert f"job {jobs['number'][i]}" in tab.hint() and "in time" in tab.hint()


def test_met_is_said_of_deadlines_that_were_met_only(other: Tab, tmp_path: Path) -> None:
    settings = {**BUSY, "machine.dsps": 6, "scheduling.agv_phase": "staggered", "duration_s": 0.2}
    _, recording = recorded(settings, [], tmp_path / "end.html")
    jobs = recording.jobs
    outcomes = ["met" if name == "on_time" else name.replace("_", " ") for name in recording.header["outcomes"]]
    told: Counter[str] = Counter()
    other.load(tmp_path / "end.html")
    for kind in recording.header["kinds"]:
        rows = last_runs(recording, kind)
        at = {i: float(jobs["deadline_s"][i]) for i in rows}
        if not rows or any(np.isnan(time) for time in at.values()):
            continue
        for time, reach in ((0.1999, 0.00773), (0.1003, 0.0377)):
            near = [i for i in rows if abs(at[i] - time) <= 2 * reach]
            if len(near) < 3 or any(jobs["missed"][i] and abs(at[i] - time) <= 3 * reach for i in rows):
                continue
            name, said = other.page.evaluate(
                "([name, time, reach]) => page.lanes.rows.find(row => row.name === name).explain(time, reach)",
                [kind.replace("_", " "), time, reach],
            )
            counts = Counter(outcomes[jobs["outcome"][i]] for i in near)
            told += counts
            if set(counts) == {"met"}:
                assert said == f"{len(near)} deadlines under the pointer, all met"
                continue
            assert name == kind and "all met" not in said and said.startswith(f"{len(near)} jobs")
            assert all(f"{count} {what}" in said for what, count in counts.items()), (kind, said, counts)
    assert set(told) == {"met", "unfinished"}


def test_the_end_of_a_job_that_met_no_deadline_has_a_mark_of_its_own(tab: Tab, run: tuple[Path, Recording]) -> None:
    jobs = run[1].jobs
    without = [i for i in run[1].last_runs().tolist() if np.isnan(jobs["deadline_s"][i]) and jobs["outcome"][i] == 0]
    assert without
    i = without[0]
    row, end = run[1].header["kinds"][jobs["kind"][i]].replace("_", " "), float(jobs["ended_s"][i])
    view(tab, end - 1e-3, end + 1e-3)
    around = pixels(tab, row, end, 6, 13)
    assert not coloured(around, SKY) and not coloured(around, VERMILLION)
    assert tuple(around[5, 6]) == (255, 255, 255) and coloured(around, (27, 31, 36))  # hollow
    tab.page.keyboard.press("?")
    assert "no deadline, or was not finished" in tab.page.locator("#help").inner_text()
    tab.page.keyboard.press("?")


def test_the_band_of_met_deadlines_can_be_seen(tab: Tab) -> None:
    """At least 3 : 1 on its ground (WCAG 2.2, 1.4.11)."""

    def luminance(colour: Any) -> float:
        part = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in np.array(colour) / 255]
        return float(np.dot(part, [0.2126, 0.7152, 0.0722]))

    themes = set()
    for _ in range(2):
        tab.page.keyboard.press("d")
        tab.settle()
        themes.add(theme := tab.page.evaluate("document.documentElement.dataset.theme"))
        colours = pixels(tab, "torque compensation", 0.1, 0, 80, 3).reshape(-1, 3)
        text = tab.page.evaluate("page.theme.panel")
        ground = tuple(int(text[i : i + 2], 16) for i in (1, 3, 5))
        on, seen = luminance(ground), Counter(map(tuple, colours.tolist()))
        [(band, _)] = Counter({one: n for one, n in seen.items() if one not in (ground, VERMILLION)}).most_common(1)
        low, high = sorted((on, luminance(band)))
        assert (high + 0.05) / (low + 0.05) >= 3, (theme, band)
    assert themes == {"light", "dark"}


def test_at_the_end_of_the_run_the_view_zooms_into_the_end(tab: Tab) -> None:
    tab.page.keyboard.press("End")
    for _ in range(25):
        tab.page.keyboard.press("+")
        assert tab.state("to") == tab.state("end") == tab.state("now")
    assert tab.state("to") - tab.state("from") == pytest.approx(2e-6)
    for _ in range(25):
        tab.page.keyboard.press("-")
    assert (tab.state("from"), tab.state("to")) == (0, tab.state("end"))


@pytest.mark.parametrize("length", [0.1, 0.3, 0.7, 1.1, 19.9, 77.7, 180.0, 199.9])
def test_a_view_that_touches_an_end_is_that_end(tab: Tab, length: float) -> None:
    ends = tab.page.evaluate(
        """length => {
          const state = new page.state.constructor(0.0412, 0.0412 + length), seen = [];
          state.now = state.end;
          for (const by of [0.5, 0.5, 0.7, 0.31, 0.5, 3, 0.123, 0.5]) state.zoom(by, state.end), seen.push(state.to === state.end);
          state.whole();
          for (const by of [0.5, 0.5, 0.7, 0.31, 0.5, 3, 0.123, 0.5]) state.zoom(by, state.begin), seen.push(state.from === state.begin);
          state.pan(-1e9), seen.push(state.from === state.begin), state.pan(1e9), seen.push(state.to === state.end);
          return seen;
        }""",
        length,
    )
    assert len(ends) == 18 and all(ends), ends


def test_a_link_shows_the_same_in_a_page_that_is_open_already(
    tab: Tab, other: Tab, run: tuple[Path, Recording]
) -> None:
    jobs, pid = run[1].jobs, last_runs(run[1], "pid")
    name = next(f"pid:0:{jobs['number'][i]}" for i in pid if jobs["missed"][i])
    nothing: list[Any] = [None, False, ""]
    shows: dict[str, list[Any]] = {
        "#t=0.1&from=0.09&to=0.11": [0.1, 0.09, 0.11, *nothing],
        "#t=0.2": [0.2, 0, 0.4, *nothing],
        "": [0, 0, 0.4, *nothing],
        "#from=0.1&to=0.2": [0, 0.1, 0.2, *nothing],
    }
    stretch, *_ = shows
    miss, unknown = f"#miss={name}", "#miss=pid:0:999999"

    def shown(tab: Tab) -> list[Any]:
        seen = [tab.state("now"), tab.state("from"), tab.state("to"), tab.miss()]
        return [*seen, tab.page.locator("#miss").is_visible(), tab.page.locator("#note").inner_text()]

    other.load(run[0], stretch)
    assert shown(other) == shows[stretch]
    for link in (miss, unknown):
        other.load(run[0], link)
        shows[link] = shown(other)
    assert shows[miss][3:] == [name, True, ""] and "pid:0:999999" in shows[unknown][5]
    before = list(tab.problems)
    for link in [*shows, miss, unknown, stretch, "#t=0.2", stretch]:
        tab.page.evaluate("link => { location.hash = link; }", link)
        tab.settle()
        assert shown(tab) == shows[link], link
    # Back, to places whose address the page has rewritten in the meantime.
    tab.page.evaluate("page.state.choose(-1); page.state.whole(); page.state.seek(0.25)")
    tab.wait_until("location.hash === '#t=0.25'")
    tab.page.evaluate("location.hash = '#t=0.31'")
    tab.settle()
    tab.page.go_back()
    tab.settle()
    assert tab.state("now") == 0.25
    tab.page.keyboard.press("Escape")
    assert tab.page.locator("#note").is_hidden() and tab.problems == before


def test_e_goes_to_the_next_event_of_whatever_kind(tab: Tab) -> None:
    tab.page.evaluate(
        """for (const at of [0.05, 0.3]) page.moments.push({ at, what: "a dot", bad: false, scripted: false });
           page.moments.sort((a, b) => a.at - b.at)"""
    )
    times = sorted({round(time, 9) for time in tab.page.evaluate("page.moments.map(moment => moment.at)")})
    assert len(times) >= 3
    visited = []
    for _ in times:
        tab.page.keyboard.press("e")
        visited.append(round(tab.state("now"), 9))
    tab.page.evaluate(
        "page.moments.splice(0, page.moments.length, ...page.moments.filter(moment => moment.what !== 'a dot'))"
    )
    assert visited == times


def test_each_miss_is_reached_though_the_panel_is_closed_between(tab: Tab) -> None:
    names = tab.page.evaluate("Array.from(page.lanes.misses.run, run => page.miss.id(run))")
    times = tab.page.evaluate("[...page.lanes.misses.at]")
    assert len(set(times[:12])) < 12  # some are of one instant
    visited = []
    for _ in range(12):
        tab.page.keyboard.press("n")
        visited.append(tab.miss())
        tab.page.keyboard.press("Escape")
    assert visited == names[:12]
    tab.page.keyboard.press("p")
    assert tab.miss() == names[10]


def test_a_run_that_ended_early_says_so_and_of_what_time_its_numbers_are(other: Tab, tmp_path: Path) -> None:
    settings = {**BUSY, "machine.dsps": 1, "run.after_stop_s": 0.1, "duration_s": 1.5}
    _, recording = recorded(settings, [{"at_s": 0.05, "action": "fail", "dsp": 0}], tmp_path / "early.html")
    report = recording.report
    assert report["stop_reason"] == "no_dsp_left"
    other.load(tmp_path / "early.html")
    facts = other.page.locator("#facts").inner_text()
    assert facts.startswith(f"ended at {report['simulated_s']:.6g} s of 1.5 s: no DSP was left")
    begin, end = report["errors"]["window_s"]
    assert (f"from {begin:g} s to {end:g} s" in facts) == (end > recording.header["to_s"])


def test_a_page_from_a_snapshot_on_says_how_many_of_the_misses_it_has(other: Tab, tmp_path: Path) -> None:
    first = cmrc.Simulation(settings=BUSY)
    first.run_until(0.2)
    rest = cmrc.Simulation.resume(first.snapshot())
    rest.record()
    rest.run()
    rest.write_page(tmp_path / "rest.html")
    recording = Recording.read(tmp_path / "rest.html")
    whole = sum(task["misses"] for task in recording.report["tasks"].values())
    shown = sum(int(recording.jobs["missed"][i]) for i in recording.last_runs())
    assert 0 < shown < whole
    other.load(tmp_path / "rest.html")
    facts = other.page.locator("#facts").inner_text()
    assert facts.startswith(f"{whole} deadlines missed, {shown} of them on this page")
    assert "from 0.02 s to 0.4 s" in facts


def test_names_and_scales_can_be_read_on_a_narrow_screen(tab: Tab) -> None:
    for width in (320, 400, 1280):
        tab.resize(width, 850)
        names = tab.page.evaluate(
            """() => { const { lanes } = page, context = lanes.canvas.getContext("2d");
              context.font = "11.5px system-ui, sans-serif";
              return lanes.rows.map(row => lanes.nameOf(context, row, lanes.left - 12)); }"""
        )
        assert len(set(names)) == len(names)
        assert [bool(re.search(r"[AB] to \d+ %$", name)) for name in names[-2:]] == [True, True]
        whole = tab.page.evaluate("page.lanes.rows.map(row => row.name)")
        cut = next((i for i, name in enumerate(names) if "…" in name), None)
        assert (cut is None) == (width == 1280)
        if cut is not None:  # the whole name is there on demand
            x, y = tab.lane(whole[cut], 0.0)
            tab.page.mouse.move(x - 30, y)
            assert tab.hint() == whole[cut]
        labels = tab.page.evaluate("page.plots.plots.map(one => one.plot.axes[1]._splits)")
        assert len(labels) == 2 and all(len(of) >= 2 for of in labels), labels
        left, top, wide, high = tab.place("#clock")
        for button in ("#nearer", "#farther", "#whole", "#play"):
            x, y, w, h = tab.place(button)
            assert x >= left + wide or x + w <= left or y >= top + high or y + h <= top, (width, button)


@pytest.mark.parametrize("length", ["0.04", "0.25"])
def test_clock_and_head_have_the_digits_that_their_numbers_need(other: Tab, tmp_path: Path, length: str) -> None:
    _, recording = recorded({"machine.dsps": 4, "duration_s": float(length)}, [], tmp_path / "short.html")
    rms = recording.report["errors"]["load_m"]["rms"]
    assert 0 < rms < 1e-3
    other.load(tmp_path / "short.html")
    assert other.page.locator("#clock").inner_text().endswith(f" of {length} s")
    assert f"load {float(f'{rms * 1e6:.3g}'):g} µm RMS" in other.page.locator("#facts").inner_text()


def test_the_picture_names_its_plots(tab: Tab, tmp_path: Path) -> None:
    image = pytest.importorskip("matplotlib.image")
    with tab.page.expect_download() as download:
        tab.page.click("#picture")
    download.value.save_as(tmp_path / "picture.png")
    data = image.imread(tmp_path / "picture.png")[:, :, :3]
    heights = tab.page.evaluate("page.plots.plots.map(one => one.plot.ctx.canvas.height)")
    end = data.shape[0]
    for height in reversed(heights):
        beside = data[end - height : end, 5:90]
        assert (beside.sum(axis=2) < 1.5).sum() > 40, "no dark dots where the name of a plot is"
        end -= height


def test_a_click_beside_the_lanes_chooses_nothing(tab: Tab, run: tuple[Path, Recording]) -> None:
    view(tab, 0.24, 0.26)
    tab.page.evaluate("page.state.seek(0.25)")
    x, y = tab.lane("pid", 0.24)
    for away in range(5, 160, 5):
        tab.page.mouse.click(x - away, y)
        assert tab.miss() is None, away
    assert tab.state("now") == 0.25


@pytest.mark.parametrize("held", [{}, {"altKey": True}, {"ctrlKey": True, "altKey": True}, {"modifierAltGraph": True}])
def test_brackets_are_keys_on_every_keyboard(tab: Tab, held: dict[str, bool]) -> None:
    def press(key: str) -> float:
        tab.page.evaluate(
            "([key, held]) => document.body.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, ...held }))",
            [key, held],
        )
        return float(tab.state("speed"))

    assert [press("]"), press("["), press("[")] == [3, 1, 0.3]


def test_every_part_has_a_name_in_words(tab: Tab) -> None:
    names = tab.page.evaluate(
        "[...document.querySelectorAll('header button, #bar button, #home')].map(one => one.ariaLabel ?? one.textContent)"
    )
    assert len(names) >= 10 and all(re.search("[A-Za-z]{3}", name) for name in names), names
    assert tab.page.locator("#play").get_attribute("aria-label") == "Play"
    tab.page.evaluate("page.state.setSpeed(0.001); page.state.play(true)")
    assert tab.page.locator("#play").get_attribute("aria-label") == "Stop"
    tab.page.evaluate("page.state.play(false); page.state.seek(0.25)")
    assert tab.page.locator("#slider").get_attribute("aria-valuetext") == tab.page.locator("#clock").inner_text()
    said = tab.page.locator("#lanes canvas").get_attribute("aria-label")
    assert f"{tab.page.evaluate('page.lanes.misses.run.length')} missed deadlines" in said


def test_the_focus_goes_into_a_panel_and_back(tab: Tab) -> None:
    focused = "document.activeElement.id || document.activeElement.tagName"
    tab.page.locator("#slider").focus()
    for opens, panel in (("n", "miss"), ("?", "help")):
        tab.page.keyboard.press(opens)
        assert tab.page.evaluate(focused) == panel
        tab.page.keyboard.press("Tab")
        assert tab.page.evaluate(f"document.getElementById('{panel}').contains(document.activeElement)")
        tab.page.keyboard.press("Escape")
        assert tab.page.evaluate(focused) == "slider", panel
    tab.page.keyboard.press("n")
    tab.page.keyboard.press("Tab")
    tab.page.keyboard.press("n")
    assert tab.page.evaluate(focused) == "miss"  # what had the focus is gone
    tab.page.locator("#miss .close").click()
    assert tab.page.evaluate(focused) == "slider"


def test_without_javascript_the_page_says_what_is_missing(browser: Any, run: tuple[Path, Recording]) -> None:
    context = browser.new_context(java_script_enabled=False, viewport={"width": 1280, "height": 800})
    try:
        page = context.new_page()
        page.goto(run[0].as_uri())
        says = page.locator("noscript p")
        box = says.bounding_box()
        assert "needs JavaScript" in says.inner_text() and box and box["y"] < 500
        assert not page.locator("#wait").is_visible()
    finally:
        context.close()


def test_bars_of_a_chain_are_seen_in_forced_colours(tab: Tab) -> None:
    tab.page.emulate_media(forced_colors="active")
    tab.page.keyboard.press("n")
    colours = tab.page.evaluate(
        "[...document.querySelectorAll('#miss .part:not(.sum) .bar')].map(bar => getComputedStyle(bar).backgroundColor)"
    )
    tab.page.emulate_media(forced_colors="none")
    assert colours and set(colours) <= {"rgb(213, 94, 0)", "rgb(86, 180, 233)"}
