"""Boots the nucleus of the operating system Helios (1993) over a link, up to its first message to the host.

    PYTHONPATH=build/python .venv/bin/python examples/helios_nucleus.py nucleus.small

Two emulated C40s on the board `default`: DSP 1 has nothing but its boot ROM, and port 3 linked to port 0 of DSP 0. DSP
0 passes words between its port and a device, `Host`, which does what Helios's I/O server does at the start: it sends
the bootstrap, the ID-ROM, the nucleus and the configuration. Then it takes what the nucleus sends, and answers nothing.

The image is not in this tree: nucleus/C40/nucleus.small of axelmuhr/Helios-NG. The order of the words was read in
ioproc/server/tload.c, kernel/C40/c40boot.a and kernel/kstart.c there. The image holds its own bootstrap.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

from cmrc import c40
from cmrc.network import Network

STEP_US, MOST_US = 20_000, 1_000_000
HOST = 0xC0000000
# +1 of the device: is there a word to send? +0: that word; written, a word that came. Port 0 is at 00100040h.
RELAY = """
        .text
_start: ldhi    0xC000,ar0
        ldhi    0x0010,ar1
        or      0x0040,ar1
        ldi     0x100,r1        ; of the port's control register: the output FIFO is full
        ldi     0x1E00,r2       ; words in the input FIFO
send:   ldi     *+ar0(1),r0
        bz      take
        tstb    *ar1,r1
        bnz     take
        ldi     *ar0,r0
        sti     r0,*+ar1(2)
take:   tstb    *ar1,r2
        bz      send
        ldi     *+ar1(1),r0
        sti     r0,*ar0
        b       send
"""
BOOTSTRAP_AT = 0x2FFC00  # the second block of the chip's RAM
PSEUDO_ID_ROM = 8  # the bootstrap's first word: the ID-ROM comes over the link
RESET_CONTROL = 0x3E39FFF0  # of both interfaces, as after reset
NO_MEMORY = 0xFFFFFFFF
MESSAGE = 2  # the word before each message's header
ROOT = 1  # the flag of the first processor of a network
PARENT = 0x00030270  # of the link that boots: running, for messages, leads to the I/O server
UNUSED = 0x00060000


def words_of(data: bytes) -> list[int]:
    """Four characters a word, the first in bits 7 to 0."""
    return [int.from_bytes(data[at : at + 4], "little") for at in range(0, len(data), 4)]


def bootstrap(nucleus: list[int]) -> list[int]:
    """The fifth part of the image. Each of the words behind its size is the distance to a part, in bytes."""
    start, end = (number + nucleus[number] // 4 for number in (5, 6))
    return nucleus[start:end]


def id_rom() -> list[int]:
    """What the board `default` has: 100000h words at 80000000h and at 00300000h; timer 0 at 1 ms, for 40 MHz."""
    bases = [0x80000000, NO_MEMORY, 0x300000, NO_MEMORY]
    sizes = [0x100000, 0, 0x100000, 0]
    rest = [0x800, 0x55552222, 10_000, 0x80, 0x2C2, 0x1E4A4000, 0x1E4A4000, 0]
    words = [0x31000000, 0, *bases, *sizes, *rest]
    return [len(words) + 1, *words]


def configuration(nucleus: list[int]) -> list[int]:
    """Its size in bytes, and the vector: port table, boots, place, size, date, first task, memory, flags, names,
    links."""
    links = [number << 24 | (PARENT if number == 3 else UNUSED) for number in range(6)]
    to_names = 4 * (3 + len(links))
    words = [1024, 1, 0, 4 * len(nucleus), 0, 0, 0, ROOT, 0, to_names, to_names, len(links), *links]
    words += words_of(b"/00\0/IO\0")
    return [4 * len(words), *words]


@dataclass
class Message:
    destination: int
    reply_to: int
    function: int
    control: list[int]
    data: bytes


class Host:
    """The device at DSP 0."""

    words = 2

    def __init__(self, nucleus: list[int]) -> None:
        code = bootstrap(nucleus)
        self.to_send = [RESET_CONTROL, RESET_CONTROL, len(code), BOOTSTRAP_AT, *code, 0, 0, 0, 0x300000]
        self.to_send += [PSEUDO_ID_ROM, *id_rom(), *nucleus, *configuration(nucleus)]
        self.sent = 0
        self.came: list[int] = []

    def read(self, offset: int, cycle: int) -> int:
        if offset == 1:
            return int(self.sent < len(self.to_send))
        self.sent += 1
        return self.to_send[self.sent - 1]

    def write(self, offset: int, value: int, cycle: int) -> None:
        self.came.append(value)

    def messages(self) -> list[Message]:
        """Those that have come whole. The first word is the bootstrap's, which says that it runs."""
        out, at = [], 1
        while len(self.came) >= at + 5:
            if self.came[at] != MESSAGE:
                raise RuntimeError(f"no message: {self.came[at]:08X}h is word {at} that came")
            sizes, destination, reply_to, function = self.came[at + 1 : at + 5]
            controls, characters = sizes >> 16 & 0xFF, sizes & 0xFFFF
            data_at = at + 5 + controls
            at = data_at + (characters + 3) // 4
            if len(self.came) < at:
                break
            data = b"".join(word.to_bytes(4, "little") for word in self.came[data_at:at])[:characters]
            out.append(Message(destination, reply_to, function, self.came[data_at - controls : data_at], data))
        return out


def boot(image: bytes) -> tuple[Network, Host]:
    """The two DSPs when the first message has come."""
    host = Host(words_of(image))
    nothing = c40.assemble("        .text\n")
    network = Network([c40.assemble(RELAY), nothing], boots=[1], links=["0.0:1.3"], devices={0: {HOST: host}})
    for now_us in range(STEP_US, MOST_US, STEP_US):
        network.run(until_us=now_us)
        if host.messages():
            return network, host
        if network.chips[1].status in ("fault", "external_access"):
            break
    raise RuntimeError(f"no message after {host.sent} of {len(host.to_send)} words: {network.chips[1].message}")


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    network, host = boot(Path(arguments[0]).read_bytes())
    chip = network.chips[1]
    print(f"{host.sent} words to DSP 1, {chip.instructions} instructions in {chip.cycles} cycles")
    for message in host.messages():
        print(
            f"to port {message.destination}: function {message.function:08X}h, {message.data!r}, control {[f'{word:X}h' for word in message.control]}"
        )
    print(chip.message)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
