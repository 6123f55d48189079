"""Which agent is on which bus: the presets of plant-and-bus.md 3.4, other topologies as data, and topologies that are
refused."""

from __future__ import annotations

from typing import Any

import cmrc as package
import pytest
from cmrc._core import cmrc

SHORT = {"dsps": 2, "duration_s": 0.15}
PRESETS = ["dual", "host_on_both", "sensors_with_host", "single"]
ACROSS = {
    "drives behind a bridge": {"boards": "A", "bridges": "A-B"},
    "DSPs behind a bridge": {"boards": "B", "bridges": "A-B"},
    "DSPs in the middle": {
        "buses": "A B C",
        "boards": "B",
        "drives": "C",
        "sensors": "C",
        "comm_port": "B",
        "bridges": "A-B, B-C",
    },
    "a bus with two bridges": {"buses": "A B C", "boards": "B", "drives": "C", "bridges": "A-B, A-C"},
    "two bridges in a row": {"buses": "A B C", "boards": "C", "drives": "C", "bridges": "A-B, B-C"},
}


def run(topology: str = "dual", layout: dict[str, str] | None = None, **more: Any) -> package.Result:
    settings = {f"topology.{key}": value for key, value in (layout or {}).items()}
    return package.run(settings={"bus.topology": topology, "report.reference": "none", **settings}, **{**SHORT, **more})


def words(result: package.Result, bus: str) -> dict[str, int]:
    targets = result.report["buses"][bus]["targets"]
    return {name: counts["words_read"] + counts["words_written"] for name, counts in targets.items()}


def servo_is_sound(result: package.Result) -> None:
    assert result.report["audit"]["violations"] == [] and result.report["failures"] == []
    tasks = result.report["tasks"]
    assert tasks["pid"]["released"] == tasks["torque_compensation"]["released"] == 130  # 20 ms to 149 ms
    assert tasks["pid"]["on_time"] >= 130


@pytest.mark.parametrize("topology", PRESETS)
def test_every_preset_carries_the_servo(topology: str) -> None:
    result = run(topology)
    servo_is_sound(result)
    assert list(result.report["buses"]) == (["A"] if topology == "single" else ["A", "B"])
    on_a = words(result, "A")
    assert ("drives" in on_a) == (topology == "single")
    assert ("sensors" in on_a) == (topology in ("single", "sensors_with_host"))
    if topology == "host_on_both":
        assert "host" in result.report["buses"]["B"]["masters"]
    moved = sum(words(result, bus)["drives"] for bus in result.report["buses"] if "drives" in words(result, bus))
    assert moved >= 130 * (5 + 5)  # PID reads five encoders and writes five torques


@pytest.mark.parametrize("name", ACROSS)
def test_layouts_of_ones_own_reach_over_bridges(name: str) -> None:
    layout = ACROSS[name]
    result = run(layout=layout)
    servo_is_sound(result)
    masters = {m for bus in result.report["buses"].values() for m in bus["masters"]}
    for pair in layout["bridges"].split(", "):
        assert {f"bridge {pair} reads", f"bridge {pair} writes"} <= masters
    assert run(layout=layout, turn_order=77).hash == result.hash


def test_crossing_a_bridge_takes_longer() -> None:
    def mean(result: package.Result) -> float:
        return result.report["tasks"]["pid"]["execution_ps"]["mean"] / 1e6

    near, drives, dsps = (
        mean(run()),
        mean(run(layout=ACROSS["drives behind a bridge"])),
        mean(run(layout=ACROSS["DSPs behind a bridge"])),
    )
    # 5 encoders, the spreader and two sway words are read one by one: at least 6 clocks (forward both ways) each.
    assert drives > near + 8 * 6 * 0.03
    assert dsps > near + 1


def test_boards_come_and_go_over_a_bridge() -> None:
    events = [
        {"at_s": 0.031, "action": "unplug", "dsp": 0},
        {"at_s": 0.06, "action": "plug", "dsp": 0},
        {"at_s": 0.09, "action": "hang", "dsp": 1},
    ]
    result = run(layout=ACROSS["DSPs behind a bridge"], events=events, dsps=3)
    assert result.report["audit"]["violations"] == []
    assert result.report["tasks"]["pid"]["on_time"] > 120
    assert len(result.report["dsps"][0]["boots"]) == 2 and result.report["dsps"][0]["boots"][1]["boot_s"] is not None


@pytest.mark.parametrize("at_s", [0.02000985, 0.02001022, 0.02003094, 0.02003131, 0.02003168])
@pytest.mark.parametrize("action", ["reset", "unplug"])
def test_a_new_program_reads_no_words_that_the_bridge_has_read_for_the_old_one(action: str, at_s: float) -> None:
    """DSP 0 ends in a claim, when the bridge has words of the list for it. Within 2^15 clocks of the bus its next
    program reads the same words."""
    events: list[dict[str, Any]] = [{"at_s": at_s, "action": action, "dsp": 0}]
    if action == "unplug":
        events.append({"at_s": at_s + 0.0003, "action": "plug", "dsp": 0})
    result = run(layout=ACROSS["DSPs behind a bridge"], events=events, duration_s=0.0235, boot="preloaded")
    assert result.report["audit"]["violations"] == []
    assert result.report["tasks"]["identify"]["released"] == 1


@pytest.mark.parametrize("arbiter", ["fixed", "two_level", "host_fair"])
def test_arbiters_timers_and_cards_are_keys(arbiter: str) -> None:
    settings = {
        "bus.arbiter": arbiter,
        "bus.first_level_dsps": 1,
        "bus.parking": "host",
        "bus.multi_transaction_clocks": 32,
        "bus.max_burst_words": 4,
        "bus.think_on_retry_clocks": 3,
        "bus.delayed_reads": True,
        "bus.device_post_words": 4,
        "bus.shared_memory_card": "s5933",
    }
    result = package.run(settings=settings, **SHORT)
    servo_is_sound(result)
    assert any(m["retries"] for m in result.report["buses"]["B"]["masters"].values())


@pytest.mark.parametrize("topology", ["dual", "host_on_both", "single"])
def test_a_bus_without_the_host_is_parked_on_nobody(topology: str) -> None:
    """`bus.parking = "host"`: no DSP takes the host's place on bus B. One DSP alone never has to wait for another."""
    settings = {
        "bus.topology": topology,
        "bus.parking": "host",
        "report.reference": "none",
        "machine.boot": "preloaded",
    }
    buses = package.run(settings=settings, dsps=1, duration_s=0.05).report["buses"]
    assert {bus["masters"]["DSP 0"]["wait_clocks"]["best"] for bus in buses.values()} == {2}
    assert buses["A"]["masters"]["host"]["wait_clocks"]["best"] == 0


def test_delayed_reads_of_the_device_card_are_retried() -> None:
    retries = [
        sum(
            master["retries"]
            for master in package.run(settings={"bus.delayed_reads": delayed}, **SHORT)
            .report["buses"]["B"]["masters"]
            .values()
        )
        for delayed in (False, True)
    ]
    assert retries[0] == 0 and retries[1] > 100


@pytest.mark.parametrize(
    "toml, message",
    [
        ('[topology]\ndrives = "C"\n', r"topology\.drives: there is no bus C; the buses are A, B"),
        ('[topology]\nbuses = "A C"\n', r'topology\.buses: "A C" is not a list of buses; '),
        ('[topology]\nboards = "A A"\n', r"topology\.boards: bus A is named twice; "),
        ('[topology]\nsensors = "A B"\n', r"topology\.sensors: it is on 2 buses; a target is on one bus"),
        (
            '[topology]\nboards = "A"\n',
            r"topology\.boards: the DSPs cannot reach the drives on bus B; .*topology\.bridges",
        ),
        ('[topology]\nhost = "B"\n', r"topology\.host: the host cannot reach shared memory on bus A; "),
        ('[topology]\nbridges = "A-B, B-A"\n', r"topology\.bridges: with B-A the bridges form a loop; "),
        (
            '[topology]\nbuses = "A B C"\nbridges = "A-B, B-C, C-A"\n',
            r"topology\.bridges: with C-A the bridges form a loop; ",
        ),
        ('[topology]\nbridges = "A-A"\n', r"topology\.bridges: A-A connects a bus to itself; "),
        ('[topology]\nbridges = "AB"\n', r'topology\.bridges: "AB" is not a bridge; two buses are expected'),
        ("[topology]\nsensors_at = 0x800\n", r"topology\.sensors_at: the windows at 800h .* and 0h .* overlap; "),
        (
            '[bus]\ntopology = "single"\n[topology]\ndrives_at = 0x8000\n',
            r"topology\.drives_at: 8000h overlaps shared memory",
        ),
        ("[bus]\nlatency_timer_clocks = 16\n", r"bus\.latency_timer_clocks: a line of 8 words does not fit"),
        (
            '[bus]\ntopology = "single"\n[[events]]\nat_s = 1\naction = "stall_bus"\nbus = "B"\nlasts_ms = 1\n',
            r"events\.bus: there is no bus B; ",
        ),
    ],
)
def test_contradictions_are_named_by_their_key(toml: str, message: str) -> None:
    with pytest.raises(cmrc.ConfigError, match=r"^dock\.toml:\d+:\d+: " + message):
        cmrc.config(toml=toml, name="dock.toml")


def test_a_stalled_bus_of_ones_own() -> None:
    stall = {"at_s": 0.02, "action": "stall_bus", "bus": "C", "lasts_ms": 5}
    result = run(layout=ACROSS["two bridges in a row"], events=[stall])
    assert result.report["tasks"]["pid"]["misses"] >= 4
