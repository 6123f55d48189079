"""docs/peripherals.md agrees with the register map, and the map with the fields that the models use."""

import re

import cmrc_test
import pytest
from cmrc._core import c40
from locations import ROOT

MARK = "<!-- registers -->\n"


def test_the_page_holds_the_generated_tables() -> None:
    text = (ROOT / "docs" / "peripherals.md").read_text()
    assert text.split(MARK)[1].strip() == c40.register_page().strip()


def test_fields_of_a_register_do_not_overlap() -> None:
    for register in cmrc_test.peripheral_registers():
        bits = [bit for low, width in register["fields"].values() for bit in range(low, low + width)]
        assert len(bits) == len(set(bits)) and all(0 <= bit < 32 for bit in bits), register["name"]


@pytest.mark.parametrize(
    ("header", "register"),
    [
        ("dma_registers", "DMA0.control"),
        ("timer", "TIMER0.control"),
        ("comm_port", "PORT0.control"),
        ("memory_interface", "GMICR"),
    ],
)
def test_every_field_of_a_model_is_in_the_map(header: str, register: str) -> None:
    text = (ROOT / "emulator" / "c40" / "peripherals" / f"{header}.hpp").read_text(encoding="utf-8")
    declared = {
        name: (int(low), int(width))
        for name, low, width in re.findall(r'constexpr Field \w+\{"([^"]+)", (\d+), (\d+)', text)
    }
    [fields] = [entry["fields"] for entry in cmrc_test.peripheral_registers() if entry["name"] == register]
    assert declared and declared == fields


def test_every_register_of_the_dma_is_in_the_map() -> None:
    text = (ROOT / "emulator" / "c40" / "peripherals" / "dma_registers.hpp").read_text(encoding="utf-8")
    [body] = re.findall(r"enum class DmaRegister[^{]*\{([^}]*)\}", text)
    names = [entry["name"] for entry in cmrc_test.peripheral_registers() if entry["name"].startswith("DMA0.")]
    assert names == [f"DMA0.{name}" for name in re.findall(r"\w+", body)]
