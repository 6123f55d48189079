"""The configuration: one schema for parser and documentation, layers, and errors that say where and what would be
right."""

import re

import pytest
from cmrc import _core
from locations import ROOT

cmrc = _core.cmrc
KEYS = {key["name"]: key for key in cmrc.config_keys()}


def error(toml: str) -> str:
    with pytest.raises(cmrc.ConfigError) as caught:
        cmrc.config(toml=toml, name="dock.toml")
    return str(caught.value)


def test_defaults_are_the_base_rates_and_ruling_15() -> None:
    config = cmrc.config()
    values = config.to_dict()
    assert config.intervals() == {"N_p": 8, "N_t": 64, "N_a": 160, "N_a_slowed": 160}  # plant-and-bus.md 2.3
    assert values["run.duration_s"] == 180
    ruling = {"gamma_refreshes": 0, "alpha_refreshes": 24, "beta_refreshes": 12, "p": 0x4000, "q": 0x2000, "b": 0x100,
              "a": 0x40, "agv_interval_max_refreshes": 320, "buffer_points": 2}  # fmt: skip
    assert {name: values["scheduling." + name] for name in ruling} == ruling


def test_heavy_preset_is_the_heavy_column_of_2_3() -> None:
    config = cmrc.config(preset="heavy")
    assert config.intervals() == {"N_p": 8, "N_t": 128, "N_a": 320, "N_a_slowed": 320}
    assert config.to_dict()["dock.agvs"] == 4


def test_the_page_has_every_preset() -> None:
    page = (ROOT / "docs" / "configuration.md").read_text(encoding="utf-8")
    table = page.split("## Presets\n")[1].split("\n## ")[0]
    assert re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE) == list(cmrc.presets())


@pytest.mark.parametrize("preset", cmrc.presets())
def test_written_configuration_reads_back_as_itself(preset: str) -> None:
    config = cmrc.config(preset=preset)
    assert cmrc.config(toml=config.to_toml()).to_dict() == config.to_dict()


def test_a_string_with_quotes_and_line_feeds_survives_the_round_trip() -> None:
    config = cmrc.config(settings={"machine.programs": 'a "b"\\c\nd\te'})
    assert cmrc.config(toml=config.to_toml()).to_dict() == config.to_dict()


def test_layers_override_in_order() -> None:
    toml = 'preset = "heavy"\n[machine]\ndsps = 2\n[dock]\nagvs = 3\n'
    values = cmrc.config(toml=toml, settings={"machine.dsps": 8}).to_dict()
    assert (values["machine.dsps"], values["dock.agvs"], values["rates.servo_frequency_hz"]) == (8, 3, 2000)
    assert cmrc.config(toml=toml, preset="base").to_dict()["rates.servo_frequency_hz"] == 1000


def test_settings_may_be_nested_flat_or_unambiguous_leaves() -> None:
    for settings in ({"machine": {"dsps": 7}}, {"machine.dsps": 7}, {"dsps": 7}):
        assert cmrc.config(settings=settings).to_dict()["machine.dsps"] == 7


def test_an_integer_serves_as_a_number() -> None:
    assert cmrc.config(toml="[run]\nduration_s = 60\n").to_dict()["run.duration_s"] == 60.0


@pytest.mark.parametrize(
    ("toml", "place", "says"),
    [
        ("[machine]\ndsp = 4\n", "dock.toml:2:1: machine.dsp:", "machine.dsps"),
        ("[rates]\n  servo_freqency_hz = 1e3\n", "dock.toml:2:3: rates.servo_freqency_hz:", "rates.servo_frequency_hz"),
        ("[rate]\nservo_frequency_hz = 1e3\n", "dock.toml:2:1: rate.servo_frequency_hz:", "rates.servo_frequency_hz"),
        ("dsps = 4\n", "dock.toml:1:1: dsps:", "machine.dsps"),
        ('[machine]\ndsps = "4"\n', "dock.toml:2:8: machine.dsps:", "an integer from 1 to 16"),
        ("[machine]\ndsps = 4.5\n", "dock.toml:2:8: machine.dsps:", "an integer from 1 to 16"),
        ("[machine]\ndsps = 0\n", "dock.toml:2:8: machine.dsps:", "from 1 to 16"),
        ("[machine]\ndsps = 10000\n", "dock.toml:2:8: machine.dsps:", "from 1 to 16"),
        ('[machine]\nidle_policy = "sleep"\n', "dock.toml:2:15: machine.idle_policy:", '"doorbell", "pause" or "spin"'),
        ("[run]\nstrict = 1\n", "dock.toml:2:10: run.strict:", "true or false"),
        ("[run]\nduration_s = nan\n", "dock.toml:2:14: run.duration_s:", "a number from"),
        ("[run]\nduration_s = [1]\n", "dock.toml:2:14: run.duration_s:", "is expected"),
        ("[machine]\ndsps = \n", "dock.toml:2:", "TOML"),
        ("[dock]\nwind_gust_m_s = 1.5\n", "dock.toml:2:1: dock.wind_gust_m_s:", "a mean of 1 m/s or more"),
        ('preset = "bass"\n', "dock.toml:1:10: preset:", '"base", "heavy", "saturated" or "tight"'),
    ],
)
def test_bad_input_is_named_with_its_place_and_remedy(toml: str, place: str, says: str) -> None:
    message = error(toml)
    assert message.startswith(place)
    assert says in message


def test_all_errors_of_a_file_are_reported_in_the_order_of_their_lines() -> None:
    """Keys of known and unknown tables, events, tasks, rows of processes: each part has its own error."""
    message = error(
        """preset = "bass"
[run]
seed = "one"
[rate]
servo_frequency_hz = 1e3
[machine]
dsps = 0
slot = 4
[[events]]
time_s = 1
[[events]]
time_s = [1]
[[tasks]]
nam = "t"
[[processes]]
number = 0
[[processes]]
number = 1
nmae = "x"
[wnd]
"""
    )
    assert [line.split(": ")[:2] for line in message.split("\n")] == [
        ["dock.toml:1:10", "preset"],
        ["dock.toml:3:8", "run.seed"],
        ["dock.toml:5:1", "rate.servo_frequency_hz"],
        ["dock.toml:7:8", "machine.dsps"],
        ["dock.toml:8:1", "machine.slot"],
        ["dock.toml:10:10", "events.time_s"],
        ["dock.toml:12:10", "events.time_s"],
        ["dock.toml:14:7", "tasks.nam"],
        ["dock.toml:16:10", "processes.number"],
        ["dock.toml:19:8", "processes.nmae"],
        ["dock.toml:20:2", "wnd"],
    ]


def test_a_file_with_very_many_errors_is_not_read_to_its_end() -> None:
    lines = error("[machine]\n" + "".join(f"wrong_{n} = 1\n" for n in range(1000))).split("\n")
    assert len(lines) == 21
    assert lines[-1] == "there may be more errors; the file was not read further"


@pytest.mark.parametrize(
    ("toml", "key"),
    [
        ("[scheduling]\nq = 0x4000\n", "scheduling.q"),  # q < p
        ("[scheduling]\np = 0x7f00\nb = 0xff\n", "scheduling.p"),  # p + b < 7FFFh
        ("[scheduling]\na = 0x60\n", "scheduling.a"),  # q + b + a (N^_a,max - beta - 1) < 7FFFh
        ("[scheduling]\na = 0x40\np = 0x2010\n", "scheduling.a"),  # t* >= 1
        ("[scheduling]\ngamma_refreshes = 8\n", "scheduling.gamma_refreshes"),  # gamma < N_p
        ("[scheduling]\nalpha_refreshes = 64\n", "scheduling.alpha_refreshes"),  # alpha < min(N_t, N^_a)
        ("[scheduling]\nbeta_refreshes = 64\n", "scheduling.beta_refreshes"),
        ("[scheduling]\nagv_interval_refreshes = 159\n", "scheduling.agv_interval_refreshes"),  # N_a <= N^_a
        ("[scheduling]\nagv_interval_refreshes = 321\n", "scheduling.agv_interval_refreshes"),  # N^_a <= N^_a,max
        ("[rates]\nservo_frequency_hz = 4001\n", "rates.servo_frequency_hz"),  # f_s >= 2 f_p
        ("[rates]\ncrane_point_frequency_hz = 1001\n", "rates.crane_point_frequency_hz"),  # f_t <= f_p
        ("[rates]\nagv_point_frequency_hz = 20\n", "rates.agv_point_frequency_hz"),  # N_a <= N^_a,max
    ],
)
def test_every_invariant_of_4_5_is_checked(toml: str, key: str) -> None:
    message = error(toml)
    assert re.match(rf"dock\.toml:\d+:\d+: {re.escape(key)}: .+; .+", message), message


@pytest.mark.parametrize("toml", [
    "[scheduling]\nq = 0x3fff\na = 1\n",
    "[scheduling]\ngamma_refreshes = 7\n",
    "[scheduling]\nalpha_refreshes = 63\n",
    "[scheduling]\nagv_interval_refreshes = 320\n",
    "[scheduling]\na = 79\n",  # 2100h + 79 * 307 = 32701 < 32767, and 80 gives 33008
    "[rates]\nservo_frequency_hz = 4000\n",
])  # fmt: skip
def test_the_last_good_value_is_accepted(toml: str) -> None:
    cmrc.config(toml=toml)


def test_a_flag_or_argument_has_no_file_in_its_message() -> None:
    with pytest.raises(ValueError, match=r"^machine\.dsps: 0 is out of range; "):
        cmrc.config(settings={"dsps": 0})


def test_a_missing_file_is_named() -> None:
    with pytest.raises(cmrc.ConfigError, match=r"^no/such\.toml: cannot be read"):
        cmrc.config(file="no/such.toml")


def test_documentation_lists_exactly_the_schema() -> None:
    page = (ROOT / "docs" / "configuration.md").read_text()
    rows = {}
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 5 and (key := re.fullmatch(r"`([a-z_0-9.]+)(?:\{([a-z,]+)\}([a-z_0-9.]+))?`", cells[0])):
            before, tables, after = key.groups()
            names = [f"{before}{table}{after}" for table in tables.split(",")] if tables else [before]
            defaults = cells[1].split(", ") if "," in cells[1] and tables else cells[1:2] * len(names)
            for name, default in zip(names, defaults, strict=True):
                rows[name] = [cells[0], default, *cells[2:]]
    assert set(rows) == set(KEYS)
    for name, (_, default, unit, meaning, source) in rows.items():
        key = KEYS[name]
        assert meaning.startswith("*live:*") == key["live"], name
        assert (unit, source) == (key["unit"], key["source"]), name
        if key["type"] in ("integer", "number"):
            assert float(int(default, 0) if default.startswith("0x") else default) == pytest.approx(
                key["default"], rel=1e-6
            ), name
        else:
            assert default == (str(key["default"]).lower() if key["type"] == "boolean" else f'"{key["default"]}"'), name
