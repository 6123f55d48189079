"""Devices, and a DMA channel at them, do the same however a run is cut: in pieces, by steps, with each instruction
timed by itself, through snapshots, watched for a word or an address, and in a network."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from board_parts import END, START, assembled, board, device, enabled, low, vector
from cmrc.c40 import Processor
from cmrc.network import Network
from command_line import emulator

CYCLES = 4000
COPY, ECHO = 0x306000, 0x304000
TIMER, FIFO, CONSOLE = 0x20, 0, 0x10

LOOPS = {
    "idle": "main:   idle\n        nop\n        addi 1,r7\n        b main\n",
    "spin": "main:   addi 1,r7\n        nop\n        mpyi r7,r6\n        b main\n",
    "slots": "main:   addi 1,r7\n        bd main\n        nop\n        addi 1,r6\n        nop\n",
    "polls": "main:   ldi *+ar2(22h),r6\n        ldi *+ar2(20h),r7\n        sti r7,*ar4\n        b main\n",
}

HANDLERS = """
isrf:   push r0
        push st
        ldi *+ar2(1),r0
        tstb 1,r0
        bz isrfe
        ldi *ar2,r0
        sti r0,*ar4++
        sti r0,*ar2
isrfe:  pop st
        pop r0
        reti
isrt:   push r0
        push st
        ldi 3,r0
        sti r0,*+ar2(23h)
        addi 1,r4
        pop st
        pop r0
        reti
"""


class Drawn:
    """A program with interrupts of a FIFO and a timer, and a DMA channel that copies what one of the devices holds."""

    def __init__(self, seed: int, folder: Path) -> None:
        rng = random.Random(seed)
        pins = rng.sample(range(4), 2)
        waits = [rng.choice([0, 1, 4]) for _ in range(3)]
        self.board = board(
            folder,
            device("fifo", 0xA0000000 + FIFO, "F", pin=f"IIOF{pins[0]}", waits=waits[0], depth=rng.choice([1, 2, 16]),
                   input_cycles=rng.choice([0, 7, 60]), output_cycles=rng.choice([0, 3, 50])),
            device("console", 0xA0000000 + CONSOLE, "C", waits=waits[1]),
            device("timer", 0xA0000000 + TIMER, "T", pin=f"IIOF{pins[1]}", waits=waits[2],
                   count_cycles=rng.choice([1, 3, 10])),
        )  # fmt: skip
        source = rng.choice([TIMER, TIMER, TIMER, FIFO, FIFO + 1])
        control = rng.choice([0xC00004, 0xC00005, 0xC00007])
        nibbles = rng.choice([9, 0xB]) << 4 * pins[0] | 9 << 4 * pins[1]
        self.program = assembled(
            vector(3 + pins[0], "isrf")
            + vector(3 + pins[1], "isrt")
            + f"        ldhi 30h,ar4\n        or 4000h,ar4\n        ldi 5,r0\n        sti r0,*+ar2(4)\n"
            f"        ldi {rng.choice([20, 37, 100])},r0\n        sti r0,*+ar2(21h)\n"
            f"        ldi {rng.choice([3, 7, 1])},r0\n        sti r0,*+ar2(22h)\n"
            f"        ldhi 0,r0\n        or {nibbles},r0\n        ldi r0,iif\n        ldhi 10h,ar5\n"
            f"        ldhi 0a000h,r0\n        or 0{source:x}h,r0\n        sti r0,*+ar5(0a1h)\n"
            "        ldi 0,r0\n        sti r0,*+ar5(0a2h)\n        ldi 40,r0\n        sti r0,*+ar5(0a3h)\n"
            "        ldhi 30h,r0\n        or 6000h,r0\n        sti r0,*+ar5(0a4h)\n"
            "        ldi 1,r0\n        sti r0,*+ar5(0a5h)\n"
            f"        ldhi 0{control >> 16:x}h,r0\n        or {control & 0xFFFF},r0\n        sti r0,*+ar5(0a0h)\n"
            "        or 2000h,st\n" + rng.choice(list(LOOPS.values())) + HANDLERS
        )
        words = [rng.getrandbits(32) for _ in range(rng.randint(4, 25))]
        self.script = ""
        while words:
            part = words[: rng.randint(1, 6)]
            del words[: len(part)]
            self.script += f"{rng.choice(['at', 'wait'])} {rng.choice([0, 3, rng.randint(0, 2000), 300])} "
            self.script += " ".join(map(str, part)) + "\n"

    def made(self) -> Processor:
        made = Processor(self.program, board=self.board)
        made.send_script("F", self.script)
        return made


def pieces(chip: Processor, rng: random.Random) -> None:
    while chip.cycles < CYCLES:
        chip.run(min(rng.choice([1, 1, 2, 7, 30, 400]), CYCLES - chip.cycles))


def steps(chip: Processor, rng: random.Random) -> None:
    while chip.cycles < CYCLES:
        chip.run(1) if chip.idle else chip.step()


def snapshots(chip: Processor, rng: random.Random) -> None:
    while chip.cycles < CYCLES:
        chip.run(min(rng.choice([2, 30, 200]), CYCLES - chip.cycles))
        before = chip.snapshot()
        chip.run(rng.randint(1, 100))
        chip.restore(before)


def exact(chip: Processor, rng: random.Random) -> None:
    chip._core.set_exact(True)
    chip.run(CYCLES)


def watched(chip: Processor, rng: random.Random) -> None:
    while chip.run(CYCLES - chip.cycles, until="main").reason == "until" and chip.cycles < CYCLES:
        pass


def looked_at(chip: Processor, rng: random.Random) -> None:
    while chip.cycles < CYCLES:
        chip.run(min(50, CYCLES - chip.cycles))
        chip.sent("F"), chip.console, chip.registers, chip.snapshot(), chip.peripherals


WAYS: list[Callable[[Processor, random.Random], None]] = [pieces, steps, snapshots, exact, watched, looked_at]


def seen(chip: Any) -> dict[str, Any]:
    """What the program and the other side have seen."""
    copied, echoed = ([chip.memory[base + n] for n in range(45)] for base in (COPY, ECHO))
    return {"copied": copied, "echoed": echoed, "sent": chip.sent("F"), "R4": low(chip, "R4"), "R5": low(chip, "R5")}


@pytest.mark.parametrize("seed", [*range(12), 113, 144, 200, 245, 602, 758])
def test_a_dma_channel_at_devices(seed: int, tmp_path: Path) -> None:
    drawn = Drawn(seed, tmp_path)
    whole = drawn.made()
    whole.run(CYCLES)
    assert whole.cycles >= CYCLES and whole.peripheral("DMA0.counter") < 40
    for way in WAYS:
        other = drawn.made()
        way(other, random.Random(seed))
        assert seen(other) == seen(whole), way
        if other.pc != drawn.program.symbols["main"]:  # where a run for an address may have ended
            assert other.snapshot().to_bytes() == whole.snapshot().to_bytes(), way
    ends = []
    for cuts in (False, True):
        rng = random.Random(seed)
        network = Network([drawn.program, drawn.program], boards=str(drawn.board), turn_order=rng.randint(0, 5))
        network.chips[1].send_script("F", drawn.script)
        end, now = CYCLES / 20, 0.0
        while now < end:
            now = min(end, now + rng.uniform(0.05, 20)) if cuts else end
            network.run(until_us=now)
        alone, chip = whole, network.chips[1]
        if chip.status == "running":  # its last instruction has begun at the end
            alone = drawn.made()
            alone.run(chip.cycles)
        assert seen(chip) == seen(alone), cuts
        ends.append(network.snapshot().to_bytes())
    assert ends[0] == ends[1]


@pytest.mark.parametrize("cuts", [[10.0], [24.0], [2.0, 3.0, 20.0], [n / 4 for n in range(1, 100)]])
def test_a_network_ends_when_its_devices_rest(cuts: list[float], tmp_path: Path) -> None:
    """The word that is on its way to the host could have interrupted the chip."""
    text = (
        vector(4)
        + "        ldi 1,r0\n        sti r0,*+ar2(4)\n"
        + enabled(1)
        + "        sti r0,*ar2\nwait:   idle\n        b wait\nisr:    reti\n"
    )
    there = str(board(tmp_path, device("fifo", pin="IIOF1", output_cycles=500)))
    whole, cut = (Network([assembled(text)], boards=there) for _ in range(2))
    for us in cuts:
        assert cut.run(until_us=us).reason == "limit" and cut.now_ps == round(us * 1_000_000)
    for network in (whole, cut):
        assert network.run().reason == "ended" and network.chips[0].sent("D") == [1]
    assert whole.now_ps == cut.now_ps > 500 * 50_000
    assert whole.chips[0].cycles == cut.chips[0].cycles


PLAIN = "        ldi 3,ar3\nw:      nop\n        nop\n        db ar3,w\n"
FIVE = "        ldi 5,r0\n        sti r0,*ar2\n        rpts 200\n        nop\n"
COUNTS = "        ldi 50,r0\n        sti r0,*+ar2(21h)\n        ldi 3,r0\n        sti r0,*+ar2(22h)\n"


@pytest.mark.parametrize("body", [PLAIN, FIVE, COUNTS + FIVE, COUNTS + PLAIN])
@pytest.mark.parametrize("watch", [("--until", "2FFFFFh==7"), ("--trace", "trace"), ("--check",), ("--profile",)])
def test_exec_has_the_same_hash_where_nothing_is_met(body: str, watch: tuple[str, ...], tmp_path: Path) -> None:
    there = board(tmp_path, device("fifo", pin="IIOF1", output_cycles=70), device("timer", 0xA0000020, "T"))
    (tmp_path / "p.asm").write_text(START + body + END)
    run = ("exec", "p.asm", "--board", there, "--json")
    alone, other = (json.loads(emulator(*run, *options, folder=tmp_path).stdout) for options in ((), watch))
    assert alone["cycles"] == other["cycles"] and alone["hash"] == other["hash"]


def test_a_stop_at_an_address_that_the_chip_has_left_is_no_state(tmp_path: Path) -> None:
    program = assembled(PLAIN + "x:      nop\n        nop\n" + END)
    one, two = (Processor(program, board=board(tmp_path, device("fifo"))) for _ in range(2))
    assert one.run(until="x").reason == "until"
    one.run(100)
    two.run(one.cycles)
    assert one.cycles == two.cycles and one.snapshot().to_bytes() == two.snapshot().to_bytes()


# ---- what devices have sent by the end ----


@pytest.mark.parametrize("kind", ["fifo", "mailbox"])
@pytest.mark.parametrize("keys", [{}, {"pin": "IIOF1"}, {"output_cycles": 100}, {"output_cycles": 5000}])
@pytest.mark.parametrize("slices", [[1000], [10] * 100])
def test_a_run_ends_with_all_that_the_host_has_taken(
    kind: str, keys: dict[str, Any], slices: list[int], tmp_path: Path
) -> None:
    there = board(tmp_path, device(kind, **keys))
    expected = [] if keys.get("output_cycles") == 5000 else [5]
    chip = Processor(assembled(FIVE + END), board=there)
    for cycles in slices:
        chip.run(cycles)
    assert chip.sent("D") == expected
    network = Network([assembled(FIVE + END)], boards=str(there))
    for n in range(len(slices)):
        network.run(until_us=sum(slices[: n + 1]) / 20)
    assert network.chips[0].sent("D") == expected


@pytest.mark.parametrize("chips", [1, 2])
def test_exec_writes_what_the_host_has_taken(chips: int, tmp_path: Path) -> None:
    there = board(tmp_path, device("fifo", output_cycles=3))
    (tmp_path / "p.asm").write_text(START + FIVE + END)
    name = "D" if chips == 1 else "1.D"
    done = emulator("exec", *["p.asm"] * chips, "--board", there, "--device-output", f"{name}=out", "--json",
                    folder=tmp_path)  # fmt: skip
    assert done.returncode == 0 and (tmp_path / "out").read_text() == "00000005\n"
    assert [sent["words"] for sent in json.loads(done.stdout)["sent"]] == [[5]] * chips


# ---- what is sent in the middle of a run ----


class Alone:
    def __init__(self, program: Any, there: Path) -> None:
        self.chip: Any = Processor(program, board=there)

    def run_to(self, cycle: int) -> None:
        self.chip.run(max(0, cycle - self.chip.cycles))


class InNetwork:
    def __init__(self, program: Any, there: Path) -> None:
        self.network = Network([program], boards=str(there))
        self.chip: Any = self.network.chips[0]

    def run_to(self, cycle: int) -> None:
        self.network.run(until_us=cycle / 20)


# The cycles in which words come: the program reads how many wait.
POLLS = "loop:   ldi *+ar2(2),r0\n        nop\n        nop\n        b loop\n"
SENT: list[tuple[dict[str, Any], str, list[int]]] = [
    ({"input_cycles": 1000}, "1 2 3", [9000, 10_000, 11_000]),
    ({}, "1 2 3", [9000, 9000, 9000]),
    ({}, "at 0 7\nwait 3000 8", [9000, 12_000]),
    ({}, "wait 500 7", [9500]),
    ({}, "at 9700 7\nat 2 8", [9700, 9700]),
    ({"input_cycles": 100}, "at 9700 7 8\nwait 5 9", [9700, 9800, 9900]),
    ({"depth": 2}, "1 2 3", [9000, 9000]),
]


@pytest.mark.parametrize("front", [Alone, InNetwork])
@pytest.mark.parametrize("early", [False, True])
@pytest.mark.parametrize(("keys", "script", "come"), SENT)
def test_words_that_are_sent_in_mid_run_come_from_then_on(
    front: Any, early: bool, keys: dict[str, Any], script: str, come: list[int], tmp_path: Path
) -> None:
    """`early`: the host has sent others before, which have come."""
    run = front(assembled(POLLS), board(tmp_path, device("fifo", **({"depth": 20} | keys))))
    others = 1 if early and "depth" not in keys else 0
    if others:
        run.chip.send("D", [99])
    run.run_to(9000)
    if script[0].isdigit():
        run.chip.send("D", [int(word) for word in script.split()])
    else:
        run.chip.send_script("D", script)
    for cycle in sorted({*come, *(at + 40 for at in come), *(at - 1 for at in come if at > 9000)}):
        run.run_to(cycle)
        waiting = low(run.chip, "R0") - others
        assert waiting in (sum(at <= cycle for at in come), sum(at <= cycle - 30 for at in come)), cycle


# ---- a pin with two drivers ----


@pytest.mark.parametrize("kind", ["fifo", "console", "timer", "vic068a"])
def test_a_program_that_drives_the_pin_of_a_device_is_at_fault(kind: str, tmp_path: Path) -> None:
    there = board(tmp_path, device(kind, pin="IIOF1"))
    text = START + "        ldi 20h,iif\n        ldi 60h,iif\n" + END
    message = "pin IIOF1 becomes an output, and a net or device drives it"
    alone = Processor(assembled("        ldi 20h,iif\n        ldi 60h,iif\n" + END), board=there)
    stop = alone.run()
    assert (stop.reason, stop.message) == ("fault", message)
    network = Network([assembled("        ldi 20h,iif\n        ldi 60h,iif\n" + END)], boards=str(there))
    network.run()
    assert network.chips[0].status == "fault" and message in network.chips[0].message
    assert network.chips[0].pc == alone.pc and network.chips[0].cycles == alone.cycles
    (tmp_path / "p.asm").write_text(text)
    for chips in (1, 2):
        done = emulator("exec", *["p.asm"] * chips, "--board", there, folder=tmp_path)
        assert done.returncode == 1 and message in done.stdout


def test_a_pin_that_no_device_pulls_may_be_an_output(tmp_path: Path) -> None:
    there = board(tmp_path, device("fifo", pin="IIOF2"))
    chip = Processor(assembled("        ldi 60h,iif\n" + enabled(2) + END), board=there)
    assert chip.run(until="done").reason == "until"
