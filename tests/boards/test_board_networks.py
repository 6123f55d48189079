"""Devices of chips in a network, classes of Python's among them, dual-port memories, and the debugger."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from board_parts import END, HEAD, START, assembled, board, device, enabled, low, vector
from cmrc.c40 import Processor, SnapshotError
from cmrc.debug import Debugger
from cmrc.network import Network, NetworkError, SharedMemory
from command_line import emulator


class Alarm:
    """Interrupts a given number of cycles after each write, and counts the interrupts. Each part of its state is one
    number."""

    words = 2
    pin = "IIOF2"

    def __init__(self, state: bool = True) -> None:
        self.due: int | None = None
        self.rings = False
        self.count = 0
        if not state:
            self.save = None  # type: ignore[method-assign,assignment]

    def read(self, offset: int, cycle: int) -> int:
        self.rings = False
        return self.count

    def write(self, offset: int, value: int, cycle: int) -> None:
        if value == 13:
            raise RuntimeError("thirteen")
        self.due = cycle + value

    def next_event(self) -> int | None:
        return self.due

    def advance_to(self, cycle: int) -> None:
        if self.due is not None and self.due <= cycle:
            self.due, self.rings, self.count = None, True, self.count + 1

    def interrupts(self) -> bool:
        return self.rings

    def save(self) -> bytes:
        return json.dumps([self.due, self.rings, self.count]).encode()

    def load(self, state: bytes) -> None:
        self.due, self.rings, self.count = json.loads(state)


ALARM = (
    vector(5)
    + enabled(2)
    + "        ldi 100,r0\n        sti r0,*ar2\nwait:   idle\n        cmpi 3,r2\n        blt wait\n"
    + END
    + "isr:    ldi *ar2,r3\n        addi 1,r2\n        ldi 100,r0\n        sti r0,*ar2\n        reti\n"
)
PLACE = 0xA0000000


def test_classes_of_ones_own_interrupt_and_are_saved(tmp_path: Path) -> None:
    program, path = assembled(ALARM), board(tmp_path)
    alone = Processor(program, board=path, devices={PLACE: Alarm()})
    alone.run(150)
    other = alone.fork()
    for one in (alone, other):
        assert one.run(until="done").reason == "until" and (low(one, "R2"), low(one, "R3")) == (3, 3)
    assert alone.cycles == other.cycles > 300
    network = Network(
        [program, program], boards=str(path), until="done", devices={0: {PLACE: Alarm()}, 1: {PLACE: Alarm()}}
    )
    network.run(max_cycles=150)
    fork = network.fork()
    for each in (network, fork):
        assert each.run().reason == "ended"
        assert [(chip.cycles, low(chip, "R3")) for chip in each.chips] == [(alone.cycles, 3)] * 2


class Pulls:
    """Pulls its pin until it is written: it is asked after the first access."""

    words, pin, rings = 1, "IIOF0", True

    def read(self, offset: int, cycle: int) -> int:
        return 0

    def write(self, offset: int, value: int, cycle: int) -> None:
        self.rings = False

    def interrupts(self) -> bool:
        return self.rings


def test_a_pin_that_is_low_from_the_first_access_on_interrupts_once(tmp_path: Path) -> None:
    isr = "isr:    addi 1,r2\n        sti r2,*ar2\n        reti\n"
    program = assembled(vector(3) + enabled(0, 0xB) + "        ldi *ar2,r0\n        rpts 99\n        nop\n" + END + isr)
    alone = Processor(program, board=board(tmp_path), devices={PLACE: Pulls()})
    assert alone.run(until="done").reason == "until" and low(alone, "R2") == 1


def test_what_has_no_state_is_refused_by_name(tmp_path: Path) -> None:
    network = Network([assembled(ALARM)], boards=str(board(tmp_path)), devices={0: {PLACE: Alarm(state=False)}})
    for refused in (network.snapshot, network.fork, network.debug):
        with pytest.raises(SnapshotError, match="Alarm at A0000000h is Python's"):
            refused()


def test_what_a_device_raises_comes_out_of_a_network_and_can_be_fixed(tmp_path: Path) -> None:
    text = "        ldi 13,r0\n        sti r0,*ar2\n        ldi 1,r9\n"
    alarm = Alarm()
    network = Network([assembled(text + END)], boards=str(board(tmp_path)), until="done", devices={0: {PLACE: alarm}})
    for _ in range(2):
        with pytest.raises(RuntimeError, match="thirteen") as caught:
            network.run()
        assert "Alarm at A0000000h" in caught.value.__notes__[0] and "Dh" in caught.value.__notes__[0]
    alarm.write = lambda offset, value, cycle: None  # type: ignore[method-assign]
    assert network.run().reason == "ended" and low(network.chips[0], "R9") == 1


def test_a_device_may_not_run_what_runs_it(tmp_path: Path) -> None:
    alarm = Alarm()
    network = Network(
        [assembled("        sti r0,*ar2\n" + END)], boards=str(board(tmp_path)), devices={0: {PLACE: alarm}}
    )
    processor = Processor(assembled("        sti r0,*ar2\n" + END), board=board(tmp_path), devices={PLACE: alarm})
    for runner in (network, processor):
        for call in (runner.run, runner.snapshot, runner.debug):
            alarm.write = lambda offset, value, cycle, call=call: call()  # type: ignore[method-assign,misc]
            with pytest.raises(RuntimeError, match=r"\(\) from inside a device"):
                runner.run()


CALLS: dict[str, Callable[[Processor, Debugger], object]] = {
    "step": lambda processor, _: processor.step(),
    "trace": lambda processor, _: processor.trace(1),
    "reset": lambda processor, _: processor.reset(),
    "boot": lambda processor, _: processor.boot(),
    "load": lambda processor, _: processor.load(processor.program),
    "pc": lambda processor, _: setattr(processor, "pc", 0),
    "complete_read": lambda processor, _: processor.complete_read(0),
    "complete_write": lambda processor, _: processor.complete_write(),
    "debug().go": lambda _, debugger: debugger.go(),
    "debug().step": lambda _, debugger: debugger.step(),
    "debug().back": lambda _, debugger: debugger.back(),
    "debug().go_to_ps": lambda _, debugger: debugger.go_to_ps(0),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_device_may_not_move_the_processor_that_runs_it(name: str, tmp_path: Path) -> None:
    for run in (lambda processor, _: processor.run(), lambda _, debugger: debugger.go()):
        alarm = Alarm()
        processor = Processor(assembled("        sti r0,*ar2\n" + END), board=board(tmp_path), devices={PLACE: alarm})
        debugger = processor.debug()
        alarm.write = lambda offset, value, cycle, p=processor, d=debugger: CALLS[name](p, d)  # type: ignore[method-assign,misc]
        with pytest.raises(RuntimeError, match=re.escape(f"{name}() from inside a device")):
            run(processor, debugger)


@pytest.mark.parametrize(
    ("devices", "message"),
    [
        ({2: {PLACE: Alarm()}}, "number of a chip"),
        ({0: {0x300000: Alarm(), 0x300001: Alarm()}}, "overlap"),
        ({0: {PLACE: 5}}, r"no read\(\)"),
        ({0: {PLACE: Alarm()}}, "D is there"),
    ],
)
def test_wrong_devices_of_a_network_are_refused(tmp_path: Path, devices: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        Network([assembled(END)] * 2, boards=str(board(tmp_path, device("led"))), devices=devices)


def test_devices_may_stand_side_by_side(tmp_path: Path) -> None:
    both = {PLACE: Alarm(), PLACE + Alarm.words: Alarm()}
    text = "        ldi 9,r0\n        sti r0,*+ar2(2)\n        ldi 1,r9\n"
    processor = Processor(assembled(text + END), board=board(tmp_path), devices=both)
    assert processor.run(until="done").reason == "until"
    assert [device.due is None for device in both.values()] == [True, False]


def test_an_access_to_a_device_may_wait_a_million_cycles(tmp_path: Path) -> None:
    slow = Alarm()
    slow.waits = 1_000_000  # type: ignore[attr-defined]
    processor = Processor(assembled("        ldi *ar2,r3\n" + END), board=board(tmp_path), devices={PLACE: slow})
    assert processor.run(until="done").reason == "until" and processor.cycles > 1_000_000
    slow.waits = 1_000_001  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match="waits of the one at A0000000h: 1000001 is out of range"):
        Processor(devices={PLACE: slow})


def test_a_network_file_has_devices_per_chip(tmp_path: Path) -> None:
    board(tmp_path, device("fifo"), device("console", 0xA0000100, name="TTY"), device("led", 0xA0000300, name="lamp"))
    text = "        ldi *ar2,r3\n        addi 1,r3\n        sti r3,*ar2\n        ldhi 0a000h,ar3\n        or 100h,ar3\n        addi 30h,r0\n        sti r0,*ar3\n        or 200h,ar3\n        sti r3,*ar3\n"
    (tmp_path / "p.asm").write_text(
        START.replace("start:", "start:  ldi r0,r10\n        nop\n") + "        ldi r10,r0\n" + text + END
    )
    (tmp_path / "n.toml").write_text(
        '[[chip]]\nprogram = "p.asm"\nboard = "board.toml"\n[[chip]]\nname = "b"\nprogram = "p.asm"\nboard = "board.toml"\n'
    )
    for name, words in (("a", "7"), ("b", "9")):
        (tmp_path / name).write_text(words)
    run = (
        "exec",
        "--network",
        tmp_path / "n.toml",
        "--device-input",
        f"0.D={tmp_path / 'a'}",
        "--device-input",
        f"b.D={tmp_path / 'b'}",
        "--device-output",
        f"b.D={tmp_path / 'out'}",
    )
    done = emulator(*run)
    assert done.returncode == 0, done.stderr
    assert (
        "console of chip 0:\n0\n" in done.stdout
        and "console of chip b:\n1\n" in done.stdout
        and "led lamp of chip b: Ah at cycle" in done.stdout
    )
    assert (tmp_path / "out").read_text() == "0000000A\n"
    report = json.loads(emulator(*run, "--json").stdout)
    assert report["console"] == ["0", "1"] and report["hash"] in done.stdout and len(report["inputs"]) == 2
    (tmp_path / "b").write_text("A")
    assert json.loads(emulator(*run, "--json").stdout)["hash"] != report["hash"]
    wrong = emulator("exec", "--network", tmp_path / "n.toml", "--device-input", f"D={tmp_path / 'a'}")
    assert wrong.returncode == 2 and "several chips have a device D; 0.D, 0.TTY, b.D, b.TTY is expected" in wrong.stderr


def test_what_is_sent_between_runs_comes_when_the_next_begins(tmp_path: Path) -> None:
    """A chip that sleeps is woken, and time does not go back."""
    text = (
        vector(4)
        + "        ldi 1,r0\n        sti r0,*+ar2(4)\n"
        + enabled(1, 0xB)
        + "wait:   idle\n        b wait\nisr:    ldi *ar2,r3\n        addi 1,r2\n        reti\n"
        + END
    )
    network = Network([assembled(text)], boards=str(board(tmp_path, device("fifo", pin="IIOF1"))))
    for n, us in enumerate((10, 30, 70), 1):
        network.run(until_us=us)
        assert low(network.chips[0], "R2") == n - 1 and network.now_ps <= us * 1_000_000
        network.chips[0].send("D", [40 + n])
        network.run(until_us=us + 5)
        assert (low(network.chips[0], "R2"), low(network.chips[0], "R3")) == (n, 40 + n)
    assert network.nets[0].edges == 6


DPRAM = SharedMemory("dual", 16, {0: PLACE, 1: PLACE}, dual_port=True, pins={0: "IIOF1", 1: "IIOF2"})
LEFT = (
    vector(4)
    + enabled(1)
    + "        ldi 5,r0\n        sti r0,*+ar2(3)\n        sti r0,*+ar2(15)\nwait:   idle\n        ldi *+ar2(14),r3\n        ldi *+ar2(4),r4\n"
    + END
    + "isr:    addi 1,r2\n        reti\n"
)
RIGHT = (
    vector(5)
    + enabled(2)
    + "wait:   idle\n        ldi *+ar2(15),r3\n        ldi *+ar2(3),r4\n        addi r3,r4\n        sti r4,*+ar2(4)\n        sti r4,*+ar2(14)\n"
    + END
    + "isr:    addi 1,r2\n        reti\n"
)


def test_a_dual_port_memory_rings_the_other_side(tmp_path: Path) -> None:
    outcomes = []
    for order in (0, 3, 8):
        network = Network(
            [assembled(LEFT), assembled(RIGHT)],
            boards=str(board(tmp_path)),
            memories=[DPRAM],
            turn_order=order,
            clocks_mhz=[40, 33],
        )
        network.run(until_us=3)
        if order == 8:
            fork = network.fork()
            network = fork
        assert network.run().reason == "ended"
        outcomes.append(
            [(chip.cycles, low(chip, "R2"), low(chip, "R3"), low(chip, "R4")) for chip in network.chips]
            + [net.edges for net in network.nets]
        )
    assert outcomes[0] == outcomes[1] == outcomes[2]
    assert [each[1:] for each in outcomes[0][:2]] == [(1, 10, 10), (1, 5, 10)] and outcomes[0][2:] == [2, 2]


def busy(word: int, dual: bool) -> int:
    """Cycles of two chips that read a memory over and over; chip 1 reads another word, or the same."""
    text = "        ldi 49,rc\n        rptb last\nlast:   ldi *+ar2({}),r3\n" + END
    memory = SharedMemory("dual", 16, {0: PLACE, 1: PLACE}, waits=6, dual_port=dual)
    with_board = Path(__file__).parent / "window.toml"
    network = Network(
        [assembled(text.format(0)), assembled(text.format(word))], boards=str(with_board), memories=[memory]
    )
    network.run()
    return max(chip.cycles for chip in network.chips)


def test_a_dual_port_memory_is_busy_at_one_word_only() -> None:
    assert busy(1, True) < busy(0, True) == busy(0, False) == busy(1, False)


@pytest.mark.parametrize(
    ("memory", "message"),
    [
        (SharedMemory("m", 16, {0: PLACE}, dual_port=True), "two places"),
        (SharedMemory("m", 16, {0: PLACE, 1: PLACE}, pins={0: "IIOF1"}), "only a dual-port memory"),
        (SharedMemory("m", 1, {0: PLACE, 1: PLACE}, dual_port=True), "mailboxes"),
        (SharedMemory("m", 16, {0: PLACE, 1: PLACE}, dual_port=True, pins={0: "TCLK0"}), "IIOF0"),
        (SharedMemory("m", 16, {0: PLACE + 0x100, 1: PLACE}), "has device"),
    ],
)
def test_wrong_memories_are_refused(tmp_path: Path, memory: SharedMemory, message: str) -> None:
    with pytest.raises((NetworkError, ValueError), match=message):
        Network([assembled(END)] * 2, boards=str(board(tmp_path, device("led", 0xA0000100))), memories=[memory])


def test_a_pin_has_one_net(tmp_path: Path) -> None:
    with pytest.raises(NetworkError, match=r"pin 0.IIOF1 is already on net wire"):
        Network([assembled(END)], boards=str(board(tmp_path, device("timer", pin="IIOF1"))), nets=["wire: >0.IIOF1"])


HELLO = (
    "        ldhi hi16(text),ar3\n        or lo16(text),ar3\n"
    + "".join(f"        ldi *ar3++,r0\n        sti r0,*ar2\nat{n}:    nop\n" for n in range(3))
    + "        ldi *ar2,r7\n"
    + END
    + "text:   .word 41h, 42h, 43h\n"
)


def test_the_debugger_shows_the_console_and_goes_back_through_devices(tmp_path: Path) -> None:
    path = board(tmp_path, device("console", name="TTY"))
    (tmp_path / "p.asm").write_text(START + HELLO)
    (tmp_path / "typed").write_text("x")
    commands = "break at0\nbreak at1\nbreak at2\nbreak done\ncontinue\ncontinue\nback\nback\ncontinue\ncontinue\ncontinue\nprint r7\npage devices\n"
    done = emulator("debug", tmp_path / "p.asm", "--board", path, "--console-input", tmp_path / "typed", stdin=commands)
    assert done.returncode == 0, done.stderr
    shown = [line for line in done.stdout.splitlines() if line in ("A", "B", "C", "AB", "BC")]
    assert shown == ["A", "B", "B", "C"] or shown == ["A", "B", "A", "B", "C"], done.stdout
    assert "console TTY at A0000000h, has sent 3 words" in done.stdout
    for options, message in (
        (("--console-input", "-"), "the debugger reads standard input itself"),
        (("--console-record", "x"), "only exec writes this file"),
    ):
        refused = emulator("debug", tmp_path / "p.asm", "--board", path, *options)
        assert refused.returncode == 2 and message in refused.stderr
    debugger = Processor(assembled(HELLO), board=path).debug()
    assert debugger is not None


def test_a_region_of_a_networks_chip_holds_a_rom(tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text("start: ldi 42,r5\nend: b end\n")
    assert emulator("asm", tmp_path / "p.asm", "-o", tmp_path / "p.out", "--section", ".text=2FFC00h").returncode == 0
    assert (
        emulator("image", tmp_path / "p.out", "--format", "srec", "--width", 8, "-o", tmp_path / "boot").returncode == 0
    )
    rom = '\n[[region]]\nname = "EPROM"\nbase = 0x80000000\nwords = 0x1000\nbus = "global"\nfile = "boot"\n\n[pins]\nromen = true\niiof = "0111"\n'
    (tmp_path / "b.toml").write_text(HEAD + rom)
    (tmp_path / "n.toml").write_text('[[chip]]\nboard = "b.toml"\nboot = true\n')
    done = json.loads(emulator("exec", "--network", tmp_path / "n.toml", "--cycles", 20000, "--json").stdout)
    assert done["chips"][0]["registers"]["R5"] & 0xFFFFFFFF == 42


def test_a_chip_whose_pin_a_device_pulls_has_done_nothing_before_the_first_run(tmp_path: Path) -> None:
    """The level of the pin at the start is there before the first instruction, which a poke or a breakpoint may be
    for."""
    (tmp_path / "p.asm").write_text("        .text\nstart:  ldi 1,r5\ndone:   b done\n")
    path = board(tmp_path, device("fifo", pin="IIOF1"))
    network = Network([tmp_path / "p.asm"], boards=str(path), until="done")
    assert (network.chips[0].cycles, network.chips[0].pc) == (0, network.chips[0].address("start"))
    poked = emulator(
        "exec", tmp_path / "p.asm", tmp_path / "p.asm", "--board", path, "--poke", "0:start=08650009h", "--json"
    )  # ldi 9,r5
    assert [chip["registers"]["R5"] & 0xFFFF for chip in json.loads(poked.stdout)["chips"]] == [9, 1]
    printed = emulator(
        "debug", tmp_path / "p.asm", "--board", path, stdin="print pc\nprint r5\nstep\nprint r5\n"
    ).stdout
    assert printed.splitlines()[1].endswith("ldi 1,r5") and [
        line for line in printed.splitlines() if line.endswith("h)")
    ][1:] == ["0 (00000000h)", "1 (00000001h)"]
