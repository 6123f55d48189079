"""The Hydra's monitor (1991) boots the board's second DSP over a communication port, and tests it.

    PYTHONPATH=build/python .venv/bin/python examples/hydra_link.py monitor.hex others.hex

Two emulated C40s: DSP 1 has the EPROM, its serial line and the register that resets DSP 2; DSP 2 has nothing but its
boot ROM, and port 3 linked to port 0 of DSP 1. The command `t` of the monitor tests memories, resets DSP 2, sends it
the second program of the EPROM, waits for the number that DSP 2 sends back, and lets it test its ports and memories.

The two files are not in this tree: kernel/C40/arielbits/monitor/source/boot/monitor of axelmuhr/Helios-NG. The EPROM
has others.hex at 0030D000h: the monitor reads it there.
"""

import sys
import tempfile
from pathlib import Path

from cmrc import c40
from cmrc.network import Network
from hydra_monitor import PROMPT, Stub, Vac

OTHERS = 0xD000  # of the EPROM
STEP_US = 50_000
MOST_US = 10_000_000


class Line(Vac):
    """The VAC068's serial line with the interrupt that the VIC068A makes of it: a pulse on NMI for each character."""

    pin = "NMI"

    def __init__(self) -> None:
        super().__init__()
        self.due: int | None = None
        self.waits_for_program = False
        self.cycle = 0

    def read(self, offset: int, cycle: int) -> int:
        self.cycle = cycle
        if offset >> 6 == self.RECEIVED:
            self.waits_for_program = False
        return super().read(offset, cycle)

    def write(self, offset: int, value: int, cycle: int) -> None:
        self.cycle = cycle
        super().write(offset, value, cycle)

    def type(self, character: str) -> None:
        self.held[self.RECEIVED] = ord(character) << 16
        self.due = self.cycle

    def next_event(self) -> int | None:
        return self.due

    def advance_to(self, cycle: int) -> None:
        if self.due is not None and self.due <= cycle:
            self.due, self.waits_for_program = None, True

    def interrupts(self) -> bool:
        return self.waits_for_program


class Control(Stub):
    """The board's control register: bit 28 is RESET of DSP 2, bit 18 its NMI; both are active low."""

    REGISTER, RESET, NMI = 8, 1 << 28, 1 << 18

    def __init__(self) -> None:
        super().__init__(0x4000)
        self.network: Network | None = None

    def write(self, offset: int, value: int, cycle: int) -> None:
        changed = self.held.get(offset, 0) ^ value
        super().write(offset, value, cycle)
        if offset != self.REGISTER or self.network is None:
            return
        now_us = cycle / 20  # at 40 MHz
        if changed & self.NMI:
            self.network.drive("nmi", bool(value & self.NMI), now_us)
        if changed & self.RESET:
            (self.network.reset if value & self.RESET else self.network.hold)(1, now_us)


def boards(folder: Path, monitor: Path, others: Path) -> list[str]:
    """The Hydra's board file with the EPROM and the pins of each DSP."""
    images = [bytes(word & 0xFF for word in c40.read_rom(path, width=8)) for path in (monitor, others)]
    (folder / "eprom.bin").write_bytes(images[0].ljust(OTHERS, b"\xff") + images[1])
    text = (Path(__file__).parent / "hydra.toml").read_text()
    with_rom = text.replace("words = 0x80000\n", 'words = 0x80000\nfile = "eprom.bin"\nwidth = 8\n', 1)
    for name, board, levels in (("dsp1", with_rom, "1101"), ("dsp2", text, "1111")):
        (folder / f"{name}.toml").write_text(f'{board}\n[pins]\nromen = true\niiof = "{levels}"\n')
    return [str(folder / "dsp1.toml"), str(folder / "dsp2.toml")]


class TwoDsps:
    def __init__(self, monitor: Path, others: Path) -> None:
        self.line, self.control = Line(), Control()
        stubs = {
            0xBF700000: Stub(0xFC000),
            0xBF7FC000: self.control,
            0xBFC00000: Stub(0x3F0000),
            0xBFFF0039: Stub(0x4000 - 0x39),
            0xBFFF8000: Stub(0x8000),
        }
        nothing = c40.assemble("        .text\n")
        with tempfile.TemporaryDirectory() as folder:
            self.network = Network(
                [nothing, nothing],
                boards=boards(Path(folder), monitor, others),
                boots=[0, 1],
                links=["0.0:1.3"],
                nets=["nmi: >1.NMI"],
                devices={0: {**stubs, 0xBFFF4000: self.line}},
            )
        self.control.network = self.network
        self.network.drive("nmi", True, 0)
        self.now_us = 0

    def _go_on(self) -> None:
        self.now_us += STEP_US
        self.network.run(until_us=self.now_us)

    def until_prompt(self) -> str:
        while not self.line.sent.endswith(PROMPT):
            failed = [chip.message for chip in self.network.chips if chip.status in ("fault", "external_access")]
            if failed or self.now_us > MOST_US:
                raise RuntimeError(f"no prompt: {self.line.sent[-200:]!r} {failed}")
            self._go_on()
        sent, self.line.sent = self.line.sent, ""
        return sent

    def type(self, text: str) -> None:
        for character in text:
            self.line.type(character)
            self._go_on()


def main(arguments: list[str]) -> int:
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    dsps = TwoDsps(Path(arguments[0]), Path(arguments[1]))
    print(dsps.until_prompt().replace("\a", ""), end="")
    dsps.type("t\n")
    print(dsps.until_prompt().replace("\a", ""))
    link = dsps.network.links[0]
    print(f"{link.forth.sent} words to DSP 2, {link.back.sent} back")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
