"""What the page shows besides lanes and misses: the dock's parts, plots, legend, colours."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Tab
from cmrc.page import Recording
from page_runs import recorded

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.unsanitized]

SHOOT = """name => {
  const picture = page.dock.picture(), copy = document.createElement("canvas");
  [copy.width, copy.height] = [picture.width, picture.height];
  const context = copy.getContext("2d");
  context.drawImage(picture, 0, 0);
  (window.shots ??= {})[name] = context.getImageData(0, 0, copy.width, copy.height).data;
}"""
COMPARE = """([one, other]) => {
  const [a, b] = [shots[one], shots[other]];
  let differ = 0;
  for (let i = 0; i < a.length; i += 4) differ += Math.abs(a[i] - b[i]) > 8 || Math.abs(a[i + 1] - b[i + 1]) > 8 || Math.abs(a[i + 2] - b[i + 2]) > 8;
  return a.length === b.length ? differ : a.length;
}"""


def shoot(tab: Tab, name: str) -> None:
    """Takes the dock's picture, and keeps it."""
    tab.page.evaluate(SHOOT, name)


def dots_that_differ(tab: Tab, one: str, other: str) -> int:
    return int(tab.page.evaluate(COMPARE, [one, other]))


def layer(tab: Tab, option: str, key: str) -> None:
    """The layer is drawn; its key hides it; its box shows it again."""
    shoot(tab, "shown")
    tab.page.keyboard.press(key)
    assert tab.page.locator(f"#{option}").is_checked() is False
    shoot(tab, "without")
    tab.page.check(f"#{option}")
    shoot(tab, "again")
    assert dots_that_differ(tab, "shown", "without") > 20 and dots_that_differ(tab, "shown", "again") == 0


@pytest.mark.parametrize(("option", "key"), [("rays", "r"), ("ghost", "g")])
def test_each_layer_of_the_dock_is_drawn_and_can_be_left_out(tab: Tab, option: str, key: str) -> None:
    tab.page.evaluate("page.state.seek(0.35)")
    layer(tab, option, key)


def test_the_planned_path_is_drawn_from_its_first_point_on(other: Tab, tmp_path: Path) -> None:
    path = tmp_path / "path.html"
    _, recording = recorded({"machine.dsps": 2, "duration_s": 6.0, "report.reference": "none"}, [], path)
    planned = recording.signals["planned_x_m"]
    first = int(np.flatnonzero(~np.isnan(planned))[0])
    assert 0 < first < 10 and planned[first] == pytest.approx(recording.signals["payload_x_m"][0], abs=0.01)
    assert np.isnan(recording.signals["agv0_planned_x_m"]).all()  # the vehicle does not move
    other.load(path)
    other.page.evaluate("page.state.seek(4); page.dock.turn(1.3, 0.2, 0.6)")  # at first it is looked along
    layer(other, "path", "l")


def test_the_ghost_and_the_load_stand_where_the_recording_has_them(tab: Tab, run: tuple[Path, Recording]) -> None:
    signals = run[1].signals
    tab.page.evaluate("page.state.seek(0.35)")
    shoot(tab, "now")
    load, ghost = tab.page.evaluate(
        "[page.dock.crane.load.position, page.dock.ghost.position].map(p => [p.x, p.y, p.z])"
    )
    row = int(np.searchsorted(signals["time_s"], 0.35 - 1e-9))
    for i, axis in enumerate("xyz"):
        assert load[i] == pytest.approx(signals[f"payload_{axis}_m"][row], abs=1e-3)
        assert ghost[i] == pytest.approx(load[i] + signals[f"ghost_{axis}_m"][row], abs=1e-3)


def test_the_load_leans_as_it_is_tilted(tab: Tab) -> None:
    tab.page.evaluate("page.state.seek(0.2)")
    shoot(tab, "level")
    tab.page.evaluate("window.up = page.recording.signals.get('payload_up_x'); window.kept = up.slice(); up.fill(0.17)")
    shoot(tab, "tilted")
    up = tab.page.evaluate(
        "(({x, y, z, w}) => [2 * (x * z + w * y), 2 * (y * z - w * x)])(page.dock.crane.load.quaternion)"
    )
    tab.page.evaluate("window.up.set(window.kept)")
    assert up[0] == pytest.approx(0.17, abs=1e-3) and dots_that_differ(tab, "level", "tilted") > 20


def test_a_ship_that_moves_is_seen_to_move(other: Tab, tmp_path: Path) -> None:
    path = tmp_path / "ship.html"
    _, recording = recorded(
        {"machine.dsps": 1, "duration_s": 0.3, "dock.ship_motion": 5.0, "report.reference": "none"}, [], path
    )
    other.load(path)
    places = []
    for time in (0.0, 0.3):
        other.page.evaluate("t => page.state.seek(t)", time)
        shoot(other, str(time))
        places.append(other.page.evaluate("(({x, y, z}) => [x, y, z])(page.dock.ground.ship.position)"))
    moved = [recording.signals[f"ship_{axis}_m"] for axis in "xyz"]
    for i, column in enumerate(moved):
        assert places[1][i] - places[0][i] == pytest.approx(column[-1] - column[0], abs=1e-3)
    assert dots_that_differ(other, "0.0", "0.3") > 20
    # Without an ideal run there is neither its ghost nor an error, and the page says so.
    assert other.page.evaluate("page.dock.ghost.visible") is False and other.page.locator(".u-wrap").count() == 1
    assert "ideal run" not in other.page.locator("#facts").inner_text() and other.problems == []


def test_deadlines_that_were_met_are_shown_one_by_one(tab: Tab, run: tuple[Path, Recording]) -> None:
    jobs = run[1].jobs
    torque = run[1].header["kinds"].index("torque_compensation")
    row = next(i for i in run[1].last_runs().tolist() if jobs["kind"][i] == torque and jobs["outcome"][i] == 0)
    due = float(jobs["deadline_s"][row])
    tab.page.evaluate("t => page.state.show(t - 0.002, t + 0.002)", due)
    tab.settle()
    tab.page.mouse.move(*tab.lane("torque compensation", due))
    spare = (due - float(jobs["ended_s"][row])) * 1e3
    assert f"job {jobs['number'][row]}" in tab.hint() and "in time" in tab.hint()
    assert float(re.findall(r"in time, ([\d.]+)", tab.hint())[0]) == pytest.approx(
        spare if "ms to spare" in tab.hint() else spare * 1e3, rel=0.01
    )


def test_buses_report_their_masters(tab: Tab, run: tuple[Path, Recording]) -> None:
    names = tab.page.evaluate("page.lanes.rows.map(row => row.name).filter(name => name.startsWith('bus'))")
    assert [name.split(" to ")[0] for name in names] == ["bus A", "bus B"]
    slice_s = run[1].header["bus_slice_s"]
    for name in names:
        tab.page.mouse.move(*tab.lane(name, 0.1 + slice_s / 2))
        said = tab.hint()
        letter = name[4]
        masters = [column for column in run[1].names() if re.match(rf"bus\.{letter}\.(?!refused)", column)]
        held = {column: int(run[1].whole(column)[round(0.1 / slice_s)]) for column in masters}
        assert said.startswith(f"bus {letter}: in use {sum(held.values()) / 10:.1f} %"), said
        assert all(f"{share / 10:.1f} %" in said for share in held.values() if share)


def test_load_error_and_sway_are_shown_at_the_pointer(tab: Tab, run: tuple[Path, Recording]) -> None:
    signals = run[1].signals
    row = int(np.argmax(signals["load_error_m"]))
    time = float(signals["time_s"][row])
    for figure, value in ((0, 1e3 * signals["load_error_m"][row]), (1, np.degrees(signals["sway_alpha_rad"][row]))):
        x, _ = tab.lane("DSP 0", time)
        tab.page.evaluate("f => document.querySelectorAll('.plot')[f].scrollIntoView({block: 'center'})", figure)
        box = tab.page.locator(".plot").nth(figure).bounding_box()
        assert box is not None
        tab.page.mouse.move(x, box["y"] + box["height"] / 2)
        assert f": {value:.3f}" in tab.hint(), (figure, tab.hint())
    curve = tab.page.evaluate("page.plots.plots.map(one => one.plot.data[1].length)")
    assert curve == [signals["time_s"].size] * 2


def test_the_legend_names_what_is_drawn_and_every_key(tab: Tab) -> None:
    tab.page.keyboard.press("?")
    help_text = tab.page.locator("#help").inner_text()
    for name in (
        "PID",
        "obstacle avoidance",
        "dead: failed",
        "asleep",
        "bus A",
        "a deadline that was met",
        "play, stop",
    ):
        assert name in help_text, name
    swatches = tab.page.locator("#help .legend canvas").count()
    assert swatches == tab.page.locator("#help .legend span").count() > 15
    keys = tab.page.locator("#help kbd").all_inner_texts()
    assert {"space", "n", "p", "e", "h", "d", "s"} <= {word for key in keys for word in key.split()}
    tab.page.keyboard.press("?")
    assert tab.page.locator("#help").is_hidden()


def test_speeds_go_from_a_thousandth_to_a_hundred(tab: Tab) -> None:
    words = tab.page.locator("#speed option").all_inner_texts()
    assert words[0] == "1/1000" and words[-1] == "100" and "1" in words
    tab.page.select_option("#speed", "100")
    assert tab.state("speed") == 100
    tab.page.evaluate("page.state.seek(0); page.state.setSpeed(0.001); page.state.play(true)")
    tab.page.evaluate("page.state.advance(1.0)")
    assert 0.001 <= tab.state("now") < 0.05
    tab.page.evaluate("page.state.play(false)")


def test_a_projector_shows_it_all_at_once(tab: Tab) -> None:
    tab.resize(1920, 1080)
    bottoms = [top + height for _, top, _, height in map(tab.place, ("#dock", "#bar", "#time"))]
    assert bottoms == sorted(bottoms) and bottoms[-1] <= 1081
    assert tab.place("#dock")[3] >= 300
    assert tab.page.evaluate("document.documentElement.scrollWidth") == 1920
    assert tab.page.evaluate("(e => e.scrollHeight - e.clientHeight)(document.getElementById('time'))") <= 1


def test_a_name_without_end_from_right_to_left_leaves_the_page_whole(other: Tab, tmp_path: Path) -> None:
    path = tmp_path / "long.html"
    title = "\u202eמנוף \u2066عربة " + "אבג" * 400 + '<img src=x onerror="alert(1)">' + "x" * 4000
    recorded({"machine.dsps": 1, "duration_s": 0.05, "report.reference": "none"}, [], path, title)
    other.load(path)
    assert other.asked == [path.as_uri()]
    for wide, high in ((1280, 800), (390, 844)):
        other.resize(wide, high)
        assert other.problems == [] and other.page.evaluate("document.documentElement.scrollWidth") == wide
        for selector in ("#keys", "#picture", "#play", "#facts"):
            left, _, width, height = other.place(selector)
            assert left >= 0 and left + width <= wide + 1 and height > 10, selector
        assert "4 deadlines missed" in other.page.locator("#facts").inner_text()
        assert other.place("#facts")[2] > 150 and other.place("#next")[3] < 40
        for shown in (other.page.locator("#title").inner_text(), other.page.title()):
            assert "\u202e" not in shown and "\u2066" not in shown and "מנוף" in shown and "<img" in shown


def test_the_picture_becomes_coarser_where_frames_are_slow(tab: Tab) -> None:
    scales = tab.page.evaluate(
        """() => {
          const pace = new page.dock.pace.constructor(), scales = [];
          let now = 1000;
          for (let n = 0; n < 200; ++n) pace.frame(now += 120);
          scales.push(pace.scale);
          for (let n = 0; n < 2000; ++n) pace.frame(now += 10);
          scales.push(pace.scale);
          return scales;
        }"""
    )
    assert scales == [pytest.approx(0.35), 1]


def test_webgl_that_is_taken_away_comes_back(other: Tab, run: tuple[Path, Recording]) -> None:
    other.load(run[0])
    shoot(other, "before")
    other.page.evaluate(
        "window.lost = page.dock.renderer.getContext().getExtension('WEBGL_lose_context'); lost.loseContext()"
    )
    other.wait_until("!document.getElementById('wait').hidden")
    other.page.mouse.click(*other.lane("DSP 0", 0.2))
    assert other.state("now") == pytest.approx(0.2, abs=0.002)
    other.page.evaluate("page.state.seek(0); lost.restoreContext()")
    other.wait_until("document.getElementById('wait').hidden")
    other.settle(5)
    shoot(other, "after")
    assert dots_that_differ(other, "before", "after") < 200


# Machado, Oliveira and Fernandes (2009), severity 1: what linear RGB looks like without L, M or S cones.
BLIND = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
}


def lab(hexes: list[str], sees: list[list[float]] | None) -> np.ndarray[Any, Any]:
    """CIE L*a*b* (D65) of colours."""
    rgb = np.array([[int(one[i : i + 2], 16) / 255 for i in (1, 3, 5)] for one in hexes])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    if sees is not None:
        linear = np.clip(linear @ np.array(sees).T, 0, 1)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = linear @ to_xyz.T / [0.9505, 1.0, 1.089]
    root = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16 / 116)
    return np.stack([116 * root[:, 1] - 16, 500 * (root[:, 0] - root[:, 1]), 200 * (root[:, 1] - root[:, 2])], axis=1)


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("blind", [None, *BLIND])
def test_colours_of_the_lanes_can_be_distinguished(tab: Tab, theme: str, blind: str | None) -> None:
    if tab.page.evaluate("document.documentElement.dataset.theme") != theme:
        tab.page.keyboard.press("d")
    colours = tab.page.evaluate("page.theme.groups")
    tab.page.evaluate(
        "page.dress && document.documentElement.dataset.theme !== 'light' && document.getElementById('theme').click()"
    )
    seen = lab(colours, None if blind is None else BLIND[blind])
    apart = np.sqrt(((seen[:, None, :] - seen[None, :, :]) ** 2).sum(axis=2))
    pairs = {(i, k): apart[i, k] for i in range(len(colours)) for k in range(i)}
    # Groups 0 and 2, no board and asleep, are both "nothing runs", and pale.
    worst = min((distance, pair) for pair, distance in pairs.items() if pair != (2, 0))
    assert worst[0] >= 13, worst
