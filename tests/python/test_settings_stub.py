"""What an editor offers as keywords is the configuration's schema."""

import importlib.util
import inspect
import pydoc
from collections import Counter

import cmrc
import pytest
from cmrc import _core, keywords
from locations import ROOT


def test_the_stub_of_the_settings_is_the_schema() -> None:
    spec = importlib.util.spec_from_file_location("settings_stub", ROOT / "scripts" / "documents" / "settings_stub.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.PLACE.read_text(encoding="utf-8") == module.stub(), (
        "python scripts/documents/settings_stub.py writes it"
    )
    plant = module.PLANT.read_text(encoding="utf-8")
    assert plant == module.plant_stub(plant), "python scripts/documents/settings_stub.py writes it"


def test_every_setting_is_a_keyword_that_a_notebook_completes() -> None:
    """IPython and jedi ask for the signature of the function that is there."""
    known = set(keywords.settings())
    of_tables = Counter(key["name"].rpartition(".")[2] for key in _core.cmrc.config_keys())
    several = {name for name, tables in of_tables.items() if tables > 1}
    assert len(known) > 200 and "efficiency" in several and known.isdisjoint(several)
    for function, own in (
        (cmrc.run, {"config", "preset", "keep_events"}),
        (cmrc.Simulation, {"profile"}),
        (cmrc.limits, {"cycles", "errors"}),
        (cmrc.compare, {"events"}),
    ):
        parameters = inspect.signature(function).parameters
        assert known | own <= set(parameters) and not any(one.kind is one.VAR_KEYWORD for one in parameters.values())
    assert inspect.signature(cmrc.run).parameters["idle_policy"].default == "doorbell"


def test_help_is_one_screen() -> None:
    for function in (cmrc.run, cmrc.Simulation, cmrc.limits, cmrc.compare):
        text = pydoc.plain(pydoc.render_doc(function))
        head = next(line for line in text.splitlines() if "(" in line and "keywords" in line)
        assert len(head) < 800 and "**keywords" in head and "idle_policy" not in head, function


def test_a_completer_sees_them() -> None:
    jedi = pytest.importorskip("jedi", reason="jedi is missing, which completes in notebooks")
    for text, expected in (("cmrc.run(idle_", "idle_policy="), ("cmrc.Simulation(servo_fr", "servo_frequency_hz=")):
        found = jedi.Interpreter(text, [{"cmrc": cmrc}]).complete()
        assert expected in [one.name for one in found]
