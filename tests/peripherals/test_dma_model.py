"""Random programs that start up to six DMA channels, with timers, lists and changes on the way, against a model made
from the documents (dma_model.py)."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

import dma_model as dma
from cmrc import c40
from dma_model import Dma, Timer

CONSTANTS, DATA, DATA_WORDS, LISTS_FROM = 0x2FF800, 0x2FFC00, 0x400, 0x300
PERIPHERALS, DMA0, TIMER0 = 0x100000, 0xA0, 0x20
GO_PULSES, GO_CLOCK = 0x2C0, 0x3C0
FLAGS = 0xFF000000  # of IIF: timers and channels


@dataclass
class Program:
    """A program whose write number n falls into a cycle that is known: each instruction takes one."""

    draw: random.Random
    lines: list[str] = field(default_factory=list)
    constants: list[int] = field(default_factory=list)
    memory: dict[int, int] = field(default_factory=dict)
    writes: dict[int, tuple[int | None, int, int]] = field(default_factory=dict)
    """by cycle: channel (None: DIE), register, value"""
    timers: dict[int, Timer] = field(default_factory=dict)

    def constant(self, value: int) -> int:
        if value not in self.constants:
            self.constants.append(value)
        return self.constants.index(value)

    def store(self, offset: int, value: int) -> int:
        self.lines += [f"ldi *+ar1({self.constant(value)}),r0", f"sti r0,*+ar0({offset})"]
        return len(self.lines) - 1

    def channel(self, number: int, register: int, value: int) -> None:
        self.writes[self.store(DMA0 + 0x10 * number + register, value)] = number, register, value

    def die(self, value: int) -> None:
        self.lines.append(f"ldi *+ar1({self.constant(value)}),die")
        self.writes[len(self.lines) - 1] = None, 0, value

    def timer(self, number: int, period: int, control: int) -> None:
        self.store(TIMER0 + 0x10 * number + 8, period)
        self.timers[number] = Timer(self.store(TIMER0 + 0x10 * number, control), period, control == GO_CLOCK)

    def wait(self, cycles: int) -> None:
        self.lines += ["nop"] * cycles


def drawn_control(draw: random.Random, mode: int, start: int = dma.RUN) -> int:
    control = draw.choice([0, 1, 3]) | mode << 2 | start << 22
    control |= draw.choice([0, 0, 0x40, 0x80, 0xC0]) | draw.choice([0, 0, 0x1000, 0x2000, 0x3000])
    return control | draw.choice([0, dma.TCC]) | draw.choice([0, dma.FIXED_ORDER])


def drawn_list(program: Program, at: int, depth: int = 0) -> int:
    """The offset behind a list at `at`, and behind those that it leads to."""
    draw = program.draw
    mode = (
        draw.choice([dma.TO_THE_COUNT, dma.TO_THE_COUNT, dma.LISTS, dma.LISTS + 1]) if depth < 3 else dma.TO_THE_COUNT
    )
    control = drawn_control(draw, mode, draw.choice([dma.RUN, dma.RUN, dma.RUN, dma.HALT_AT_END]))
    counter = draw.choice([1, 2, 3, 5] if mode < dma.LISTS else [0, 1, 2, 3])
    words = [control, *drawn_block(draw, control, counter), DATA + (at + 7 if mode >= dma.LISTS else at)]
    program.memory |= {DATA + at + n: word for n, word in enumerate(words)}
    return drawn_list(program, at + 7, depth + 1) if mode >= dma.LISTS else at + 7


def drawn_place(draw: random.Random) -> int:
    return DATA + draw.randrange(0x80, 0x180)


def drawn_block(draw: random.Random, control: int, counter: int) -> list[int]:
    """Source, index, counter, destination, index. What moves on to the program's end stays in front of the lists."""
    indices = [0, 1, 1, 2, 4, 0x10] if control & dma.BIT_REVERSED else [0, 1, 1, 2, 4, dma.WORD]

    return [drawn_place(draw), draw.choice(indices), counter, drawn_place(draw), draw.choice(indices)]


def drawn_code(draw: random.Random, channel: int, access: int) -> int:
    """Of DIE: a timer or nothing."""
    if draw.random() < 0.3:
        return 0
    if channel < 2:
        return 3 << 4 * channel + 2 * access
    return draw.choice([6, 7]) << 8 + 6 * (channel - 2) + 3 * access


def drawn(seed: int) -> Program:
    draw = random.Random(seed)
    program = Program(draw, memory={DATA + n: draw.getrandbits(32) for n in range(DATA_WORDS)})
    for timer in (0, 1):
        program.timer(timer, draw.choice([1, 2, 3, 4, 7]), draw.choice([GO_PULSES, GO_CLOCK]))
    codes = sum(drawn_code(draw, n, access) for n in range(dma.CHANNELS) for access in (dma.READ, dma.WRITE))
    if early := draw.random() < 0.5:
        program.die(codes)
    channels = draw.sample(range(dma.CHANNELS), draw.randint(1, 4))
    controls, lists = {}, LISTS_FROM
    for n in channels:
        mode = draw.choice([dma.TO_THE_COUNT, dma.TO_THE_COUNT, dma.LISTS, dma.LISTS + 1])
        controls[n] = drawn_control(draw, mode)
        block = drawn_block(draw, controls[n], draw.choice([1, 2, 3, 4, 7] if mode < dma.LISTS else [0, 0, 1, 2, 3]))
        for register, value in zip(range(dma.SOURCE, dma.DESTINATION_INDEX + 1), block, strict=True):
            program.channel(n, register, value)
        if mode >= dma.LISTS:
            program.channel(n, dma.LINK, DATA + lists)
            lists = drawn_list(program, lists)
    for n in channels:
        program.channel(n, dma.CONTROL, controls[n])
        program.wait(draw.choice([0, 0, 1, 2, 5]))
    if not early:
        program.die(codes)
    for _ in range(draw.choice([0, 0, 3, 8])):
        n, what = draw.choice(channels), draw.random()
        program.wait(draw.randint(0, 9))
        if what < 0.7:
            program.channel(n, dma.CONTROL, controls[n] & ~(3 << 22) | draw.choice([0, 1, 2, 3, 3]) << 22)
        elif what < 0.85:
            program.channel(n, dma.COUNTER, draw.choice([1, 2, 3]))
        else:
            program.channel(n, draw.choice([dma.SOURCE, dma.DESTINATION]), drawn_place(draw))
    program.wait(draw.randint(20, 60))
    return program


def test_random_channels_against_a_model_from_the_documents() -> None:
    for seed in range(400):
        program = drawn(seed)
        text = "\n        ".join(["        .text\nstart:", *program.lines]) + "\ndone:   b done\n"
        chip = c40.Processor(c40.assemble(text), board="flat")
        chip.registers["AR0"], chip.registers["AR1"] = PERIPHERALS, CONSTANTS
        for n, value in enumerate(program.constants):
            chip.memory[CONSTANTS + n] = value
        for address, value in program.memory.items():
            chip.memory[address] = value
        model = Dma(dict(program.memory))
        model.timers = program.timers
        last = len(program.lines) - 1
        for cycle in range(last):
            channel, register, value = program.writes.get(cycle, (None, None, 0))
            model.cycle(cycle, register, value, channel)
        chip.run(last - chip.cycles)
        assert chip.cycles == last
        if differences(chip, model):  # then the chip has done what the DMA begins in its last cycle
            model.begin(last - 1)
        assert differences(chip, model) == [], f"seed {seed}"


def differences(chip: c40.Processor, model: Dma) -> list[str]:
    now = chip.peripherals
    found = []
    for channel in model.channels:
        expected = [channel.registers[dma.CONTROL] | channel.status() << 26, *channel.registers[1:]]
        for name, value in zip(dma.REGISTERS, expected, strict=True):
            if now[f"DMA{channel.number}.{name}"] != value:
                found.append(f"DMA{channel.number}.{name}: {now[f'DMA{channel.number}.{name}']:x}, model {value:x}")
    if (chip.registers["IIF"] ^ model.iif) & FLAGS:
        found.append(f"IIF: {chip.registers['IIF']:x}, model {model.iif:x}")
    words = chip.memory[DATA : DATA + DATA_WORDS]
    found += [f"{DATA + n:x}" for n, word in enumerate(words) if word != model.memory[DATA + n]]
    return found
