"""Boots the monitor of the Hydra board (1991) from its EPROM, waits for its prompt, and types commands.

    PYTHONPATH=build/python .venv/bin/python examples/hydra_monitor.py monitor.hex '?'

The EPROM is not in this tree: kernel/C40/arielbits/monitor/source/boot/monitor/monitor.hex of axelmuhr/Helios-NG. Of
the board, only the serial line of the VAC068 is modelled; the VIC068, the configuration EEPROM and what acknowledges
interrupts hold what is written. So the monitor finds no valid configuration, and rings its bell at the start.
"""

import sys
from pathlib import Path

from cmrc.c40 import Processor

EPROM = 0x300000
PROMPT = "Hydra_Mon => "
STEP = 1_000_000  # cycles between two looks at what has been sent
MOST = 200 * STEP


class Stub:
    """Registers that hold what was written last."""

    def __init__(self, words: int) -> None:
        self.words = words
        self.held: dict[int, int] = {}

    def read(self, offset: int, cycle: int) -> int:
        return self.held.get(offset, 0)

    def write(self, offset: int, value: int, cycle: int) -> None:
        self.held[offset] = value


class Vac(Stub):
    """The VAC068's serial line: its registers are 40h words apart, their bits in the upper half of a word."""

    SEND, RECEIVED, STATUS = 0x1E, 0x20, 0x25
    READY = 0x180 << 16  # to send; and a character is there when the interrupt says so

    def __init__(self) -> None:
        super().__init__(0x4000)
        self.sent = ""

    def read(self, offset: int, cycle: int) -> int:
        return self.READY if offset >> 6 == self.STATUS else super().read(offset >> 6, cycle)

    def write(self, offset: int, value: int, cycle: int) -> None:
        if offset >> 6 == self.SEND:
            self.sent += chr(value >> 24 & 0x7F)
        super().write(offset >> 6, value, cycle)


class Hydra:
    """The board, its monitor, and somebody at its terminal."""

    def __init__(self, eprom: Path) -> None:
        self.vac = Vac()
        stubs = {
            0xBF700000: Stub(0x100000),
            0xBFC00000: Stub(0x3F0000),
            0xBFFF0039: Stub(0x4000 - 0x39),
            0xBFFF8000: Stub(0x8000),
        }
        board = Path(__file__).parent / "hydra.toml"
        self.chip = Processor(board=board, boots_from=EPROM, devices={**stubs, 0xBFFF4000: self.vac})
        self.chip.load_rom(eprom, EPROM)
        self.chip.boot()

    def until_prompt(self) -> str:
        """What is sent up to and with the next prompt."""
        while not self.vac.sent.endswith(PROMPT):
            stop = self.chip.run(STEP)
            if stop.reason != "limit" or self.chip.cycles > MOST:
                raise RuntimeError(f"no prompt: {stop}")
        sent, self.vac.sent = self.vac.sent, ""
        return sent

    def type(self, text: str) -> None:
        for character in text:
            self.vac.held[Vac.RECEIVED] = ord(character) << 16
            self.chip.raise_interrupt("NMI")  # by the VIC
            self.chip.run(STEP)


def main(arguments: list[str]) -> int:
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    hydra = Hydra(Path(arguments[0]))
    print(hydra.until_prompt().replace("\a", ""), end="")
    for command in arguments[1:]:
        hydra.type(command + "\n")
        print(hydra.until_prompt(), end="")
    print(f"\n{hydra.chip.cycles} cycles")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
