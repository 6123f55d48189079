"""What a network's file refuses, its arguments in Python refuse too."""

import re
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network, NetworkError, SharedMemory

ENDLESS = c40.assemble("   .text\nx: nop\n   b x\n")
WINDOW = 0xC0000000


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"links": [("0.0:1.3", {"word_cycle": 9})]},
            "link 0.0:1.3: no such key word_cycle; known are word_cycles, token_cycles, enter_cycles, exit_cycles",
        ),
        ({"boots": [2]}, "boots[0]: 2 is out of range; the number of a chip, 0 to 1, is expected"),
        ({"boots": [0, -1]}, "boots[1]: -1 is out of range; the number of a chip, 0 to 1, is expected"),
        (
            {"memories": [SharedMemory("m", 8, {0: WINDOW, 1: WINDOW}, dual_port=True, pins={5: "IIOF0"})]},
            "memories[0].pins: the memory has no place at chip 5; it has places at 0, 1",
        ),
        (
            {"memories": [SharedMemory("m", 8, {0: WINDOW, 1: WINDOW}, dual_port=True, pins={1: "INT9"})]},
            "memories[0].pins: IIOF0, IIOF1, IIOF2, IIOF3, NMI is expected, not 'INT9'",
        ),
    ],
)
def test_what_names_nothing_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        Network([ENDLESS, ENDLESS], **given)


def test_settings_of_a_link_are_taken() -> None:
    network = Network([ENDLESS, ENDLESS], links=[("0.0:1.3", {"word_cycles": 9, "exit_cycles": 2})])
    assert len(network.links) == 1
    with pytest.raises(NetworkError, match="known are"):
        Network([ENDLESS, ENDLESS], links=["0.1:1.4", ("0.0:1.3", {"words": 9})])


def test_cycles_that_have_passed_are_refused() -> None:
    network = Network([ENDLESS, ENDLESS])
    assert network.run(max_cycles=100).time_ps == network.now_ps == 5_000_000
    with pytest.raises(ValueError, match="max_cycles: 10 cycles of chip 0 have passed, the network is at 5.0 us"):
        network.run(max_cycles=10)
    assert network.now_ps == 5_000_000
    assert network.run(max_cycles=100).reason == network.run(max_cycles=101).reason == "limit"
