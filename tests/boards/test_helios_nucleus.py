"""The host of examples/helios_nucleus.py, with a nucleus of our own that has the same form; and with Helios's, where it
was fetched."""

from __future__ import annotations

import importlib.util
import struct
import sys
from types import ModuleType

import pytest
from cmrc import c40
from locations import ROOT

# As Helios's own: the word "I run", then what the host sends. It passes the ID-ROM over, puts the image to 00300000h,
# takes the configuration's size and first word, and sends a message of one control word and six characters.
BOOTSTRAP = """
        .text
_start: stik    1,*+ar3(2)
        ldi     *+ar3(1),r0     ; how the ID-ROM comes
        cmpi    8,r0
wrong:  bne     wrong
        ldi     *+ar3(1),rc     ; its words, this one included
        subi    2,rc
        rptb    rom
rom:    ldi     *+ar3(1),r0
        ldhi    0x30,ar0
        ldi     *+ar3(1),r0     ; bytes of the image, this word included
        sti     r0,*ar0++
        lsh     -2,r0,rc
        subi    2,rc
        rptb    copy
        ldi     *+ar3(1),r0
copy:   sti     r0,*ar0++
        ldi     *+ar3(1),r4     ; bytes of the configuration
        lsh     -2,r4,rc
        ldi     *+ar3(1),r5     ; its first word
        subi    2,rc
        rptb    rest
rest:   ldi     *+ar3(1),r0
        ldi     2,r0            ; a message
        sti     r0,*+ar3(2)
        ldhi    0x4001,r0       ; one control word,
        or      6,r0            ; six characters
        sti     r0,*+ar3(2)
        ldi     1,r0            ; to port 1
        sti     r0,*+ar3(2)
        ldhi    0x8003,r0       ; answers to this port
        sti     r0,*+ar3(2)
        sti     r5,*+ar3(2)     ; as the function: the configuration's first word
        sti     r4,*+ar3(2)     ; as the control word: its size
        ldhi    0x6578,r0
        or      0x6168,r0       ; "haxe"
        sti     r0,*+ar3(2)
        ldi     0x6c6c,r0       ; "ll"
        sti     r0,*+ar3(2)
wait:   b       wait
"""


@pytest.fixture(scope="module")
def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("helios_nucleus", ROOT / "examples" / "helios_nucleus.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def nucleus(source: str) -> bytes:
    """Its size, distances to seven parts and a 0; the fifth part is the bootstrap, all others are one word."""
    (code,) = [
        list(section.words)
        for section in c40.assemble(source, sections={".text": 0x2FFC00}).sections
        if section.name == ".text"
    ]
    parts = [[0x60F160F1]] * 4 + [code] + [[0x60F060F0]] * 2
    at, distances = 9, []
    for number, part in enumerate(parts, start=1):
        distances.append(4 * (at - number))
        at += len(part)
    words = [4 * at, *distances, 0, *(word for part in parts for word in part)]
    return struct.pack(f"<{len(words)}I", *words)


def test_the_host_boots_a_nucleus_over_a_link_and_takes_its_first_message(example: ModuleType) -> None:
    image = nucleus(BOOTSTRAP)
    network, host = example.boot(image)
    (message,) = host.messages()
    size = len(example.configuration(example.words_of(image))) - 1
    assert (message.destination, message.reply_to) == (1, 0x80030000)
    assert message.function == 1024 and message.control == [4 * size] and message.data == b"haxell"
    assert host.sent == len(host.to_send) and host.came[0] == 1
    assert b"".join(struct.pack("<I", network.chips[1].memory[0x300000 + n]) for n in range(len(image) // 4)) == image


def test_a_nucleus_that_stops_is_reported_with_the_cause(example: ModuleType) -> None:
    broken = BOOTSTRAP.replace("ldi     2,r0            ; a message", "ldhi    0x0040,ar1\n        ldi     *ar1,r0")
    with pytest.raises(RuntimeError, match="read of 00400000h"):
        example.boot(nucleus(broken))
    other = BOOTSTRAP.replace("ldi     2,r0            ; a message", "ldi     3,r0")
    with pytest.raises(RuntimeError, match="no message: 00000003h is word 1"):
        example.boot(nucleus(other))


IMAGE = ROOT / "build-foreign" / "helios" / "nucleus" / "C40" / "nucleus.small"


@pytest.mark.skipif(not IMAGE.exists(), reason="scripts/foreign helios has not been run here")
def test_the_helios_nucleus_asks_its_host_for_helios(example: ModuleType) -> None:
    network, host = example.boot(IMAGE.read_bytes())
    message = host.messages()[0]
    assert (message.destination, message.function, message.data) == (1, 0x60002010, b"/helios\0")
    assert "the processor sleeps" in network.chips[1].message


@pytest.mark.skipif(not IMAGE.exists(), reason="scripts/foreign helios has not been run here")
def test_the_other_two_images_of_the_repository_have_a_text_between_their_modules(example: ModuleType) -> None:
    with pytest.raises(RuntimeError, match="read of 0849B310h"):
        example.boot(IMAGE.with_name("nucleus").read_bytes())
