"""What an editor offers as keywords is the configuration's schema."""

import importlib.util

from locations import ROOT


def test_the_stub_of_the_settings_is_the_schema() -> None:
    spec = importlib.util.spec_from_file_location("settings_stub", ROOT / "scripts" / "settings_stub.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.PLACE.read_text(encoding="utf-8") == module.stub(), "python scripts/settings_stub.py writes it"
