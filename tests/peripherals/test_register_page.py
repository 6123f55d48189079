"""docs/peripherals.md agrees with the register map."""

from cmrc._core import c40
from locations import ROOT

MARK = "<!-- registers -->\n"


def test_the_page_holds_the_generated_tables() -> None:
    text = (ROOT / "docs" / "peripherals.md").read_text()
    assert text.split(MARK)[1].strip() == c40.register_page().strip()


def test_fields_of_a_register_do_not_overlap() -> None:
    for register in c40.peripheral_registers():
        bits = [bit for low, width in register["fields"].values() for bit in range(low, low + width)]
        assert len(bits) == len(set(bits)) and all(0 <= bit < 32 for bit in bits), register["name"]
