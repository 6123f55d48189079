"""Random programs for the timing model: blocks with one way in and one way out, on boards with random wait states.

A seed gives the same program on every machine.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from timed_instructions import (
    PAGES,
    POINTERS,
    POOL,
    POOL_WORDS,
    Instruction,
    InstructionDrawer,
    Kind,
    Operand,
    in_pool,
    next_of_stack,
    nop,
    only,
    top_of_stack,
    without,
)
from timing_model import GLOBAL, LOCAL, Place, Region

PERIPHERAL_WORD = 0x1000A1
"""AR6's pointer: registers of a DMA channel that never starts"""
BLOCKS = 6
BLOCK_0, BLOCK_1 = 0x2FF800, 0x2FFC00
TABLES = [0x2FFA00, 0x2FFE00, 0x31E000, 0x8001E000, 0x40006000, 0xC0006000]
STACKS = [0x2FFA20, 0x2FFE20, 0x31C000, 0x8001C000]
DATA = [0x2FFA80, 0x2FFE80, 0x2FFA90, 0x2FFE98, 0x318000, 0x40004000, 0x80018000, 0xC0004000, 0x304000, 0x80004000]
FIRST_TRAP, NMI_VECTOR, IIOF0_VECTOR = 0x1E0, 1, 3
CACHE_ENABLE, INTERRUPTS_ENABLE, IIOF0_BY_LEVEL = 0x800, 0x2000, 9
CONDITIONS = ["eq", "ne", "gt", "lt", "le", "ge", "u", "hs", "lo"]


@dataclass(frozen=True)
class Setting:
    control: bool = True
    cache: bool = True
    interfaces: bool = True
    """random GMICR and LMICR"""
    pages: bool = True
    traps: bool = False
    interrupts: bool = False
    long_loops: bool = False
    """of some hundred words, more than the cache holds"""
    slow: bool = False
    """up to 15 wait states"""
    code: tuple[int, ...] = ()
    """where it may begin; empty: anywhere"""


SETTINGS = {
    "without control": Setting(control=False, cache=False),
    "loops, calls, cache": Setting(),
    "usual interfaces, no pages": Setting(interfaces=False, pages=False),
    "code on the chip": Setting(code=(BLOCK_0, BLOCK_1)),
    "traps, IIOF0, NMI": Setting(traps=True, interrupts=True),
    "long loops in external memory": Setting(long_loops=True, code=(0x300000, 0x80000000, 0x300013)),
    "slow boards": Setting(slow=True),
}


@dataclass(frozen=True)
class Program:
    seed: int
    code: list[Instruction]
    code_base: int
    regions: list[Region]
    interfaces: dict[Place, int]
    registers: dict[str, int]
    words: dict[int, int]
    """of memory, when the program begins"""
    vector: int
    """where the vectors of IIOF0 and NMI are; 0: there are no interrupts"""

    @property
    def end(self) -> int:
        return self.address("done")

    def address(self, label: str) -> int:
        return self.code_base + next(n for n, one in enumerate(self.code) if one.label == label)

    def at(self, address: int) -> Instruction:
        return self.code[address - self.code_base]

    def text(self) -> str:
        lines = [f"{one.label + ':' if one.label else '':8}{one.text}" for one in self.code]
        return "\n".join(['        .sect "code"', *lines, ""])

    def board(self) -> str:
        """Its file (docs/boards.md)."""
        lines = [f"gmicr = {self.interfaces[GLOBAL]}", f"lmicr = {self.interfaces[LOCAL]}"]
        for region in self.regions:
            lines += ["[[region]]", f'name = "at {region.base:X}h"', f'bus = "{region.bus}"']
            lines += [f"base = {region.base}", f"words = {region.words}", f"page_waits = {region.page_waits}"]
            lines += [f"read_waits = {region.read_waits}", f"write_waits = {region.write_waits}"]
        return "\n".join([*lines, ""])


def drawn(setting: Setting, seed: int) -> Program:
    return ProgramDrawer(setting, seed).program()


def labelled(instruction: Instruction, label: str) -> Instruction:
    return replace(instruction, label=label)


def begun(instructions: list[Instruction], label: str) -> list[Instruction]:
    """With this label at the first one."""
    return [labelled(instructions[0], label), *instructions[1:]]


def ended(instructions: list[Instruction], label: str) -> list[Instruction]:
    """With this label at the last one."""
    return [*instructions[:-1], labelled(instructions[-1], label)]


def branch(text: str) -> Instruction:
    return Instruction(text, Kind.EMPTIES)


def returning(text: str) -> Instruction:
    return Instruction(text, Kind.EMPTIES, reads=[top_of_stack()])


def restored_ar6() -> Instruction:
    return Instruction(f"ldi {in_pool(POOL_WORDS).text},ar6", reads=[in_pool(POOL_WORDS)], results=only("ar6"))


@dataclass
class ProgramDrawer:
    setting: Setting
    seed: int
    _labels: int = 0
    _trap_routines: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._draw = random.Random(self.seed)
        self._one = InstructionDrawer(self._draw, self.setting.cache)
        self._trap_table = self._draw.choice(TABLES)
        traps = 1.2 * self.setting.traps
        self._blocks: dict[Callable[[], list[Instruction]], float] = {
            self._straight: 5,
            self._conditional_branch: 1.5,
            self._delayed_branch: 1.5,
            self._annulling_branch: 1,
            self._counted_loop: 1,
            self._delayed_counted_loop: 1,
            self._repeated_block: 1.5,
            self._delayed_repeated_block: 1.5,
            self._repeated_instruction: 1.2,
            self._call: 1,
            self._conditional_call: 0.7,
            self._linked_call: 0.8,
            self._branch_by_register: 0.6,
            self._trap: 2 * traps,
            self._linked_trap: 2 * traps,
        }

    def program(self) -> Program:
        draw, setting = self._draw, self.setting
        base = draw.choice(setting.code or (BLOCK_0, BLOCK_1, 0x300000, 0x300000, 0x80000000, 0x80000000))
        if not setting.code:
            base += draw.randrange(40)
        regions, interfaces = self._regions(), {LOCAL: self._interface(), GLOBAL: self._interface()}
        code = [
            labelled(branch("br start2"), "start"),
            nop("start2"),
            nop(),
            *self._body(),
            labelled(branch("br done"), "done"),
        ]
        if setting.interrupts:
            code += self._interrupt_routine()
        vector = draw.choice(TABLES) if setting.interrupts else 0
        registers, words = self._registers_and_memory()
        program = Program(self.seed, code, base, regions, interfaces, registers, words, vector)
        assert base not in range(BLOCK_0, BLOCK_1) or base + len(code) <= BLOCK_0 + 0xE0, "the code overlaps the pool"
        words |= {self._trap_table + FIRST_TRAP + n: program.address(at) for n, at in enumerate(self._trap_routines)}
        if setting.interrupts:
            words |= {vector + number: program.address("isr") for number in (NMI_VECTOR, IIOF0_VECTOR)}
            registers |= {"IVTP": vector, "IIF": IIOF0_BY_LEVEL, "ST": registers["ST"] | INTERRUPTS_ENABLE}
        return program

    # The board, and what the program begins with

    def _regions(self) -> list[Region]:
        draw, setting = self._draw, self.setting

        def waits() -> int:
            return draw.choice([0, 0, 3, 7, 15, 12] if setting.slow else [0, 0, 0, 1, 2, 3, draw.randint(0, 6)])

        def page_waits() -> int:
            if not setting.pages:
                return 0
            return draw.choice([0, 0, 4, 15] if setting.slow else [0, 0, 0, 1, 2, 4])

        places = [(0x300000, 0x8000, LOCAL), (0x310000, 0x10000, LOCAL), (0x40000000, 0x8000, LOCAL)]
        places += [(0x80000000, 0x8000, GLOBAL), (0x80010000, 0x10000, GLOBAL), (0xC0000000, 0x8000, GLOBAL)]
        return [Region(base, words, bus, waits(), waits(), page_waits()) for base, words, bus in places]

    def _interface(self) -> int:
        """GMICR or LMICR (c40-hardware.md 1.4); STRB1 begins at 40000000h and C0000000h."""
        if not self.setting.interfaces:
            return 0x1DEA4000
        draw = self._draw
        switch, sww = draw.randrange(2), [draw.choice([0, 0, 1, 2, 3]) for _ in range(2)]
        counters, pages = (
            [draw.randint(0, 3) for _ in range(2)],
            [draw.choice([7, 9, 3, 1, 15]), draw.choice([7, 9, 3, 29])],
        )
        value = 0x1D << 24 | switch << 29
        value |= sww[0] << 4 | sww[1] << 6 | counters[0] << 8 | counters[1] << 11
        return value | pages[0] << 14 | pages[1] << 19

    def _registers_and_memory(self) -> tuple[dict[str, int], dict[int, int]]:
        """The pools of pointers, each in a page, point into few places, so that conflicts are frequent."""
        draw = self._draw
        areas = draw.sample(DATA, draw.randint(1, 4))
        pool = [draw.choice(areas) + draw.randrange(4) for _ in range(POOL_WORDS)]
        words = {page << 16 | POOL + n: word for page in PAGES for n, word in enumerate([*pool, PERIPHERAL_WORD])}
        registers = {name.upper(): draw.choice(pool) for name in POINTERS}
        registers |= {"AR6": PERIPHERAL_WORD, "AR7": draw.choice(PAGES) << 16 | POOL}
        registers |= {"IR0": draw.randint(1, 3), "IR1": draw.randint(1, 3), "BK": draw.randint(6, 20)}
        registers |= {"DP": draw.choice(PAGES), "SP": draw.choice(STACKS), "TVTP": self._trap_table}
        registers["ST"] = CACHE_ENABLE if self.setting.cache and draw.random() < 0.6 else 0
        return registers, words

    # The program

    def _body(self) -> list[Instruction]:
        if not self.setting.long_loops:
            return [one for _ in range(BLOCKS) for one in self._block()]
        return [one for _ in range(self._draw.randint(1, 2)) for one in self._long_loop()]

    def _long_loop(self) -> list[Instruction]:
        draw, label = self._draw, self._label()
        body = [nop(label)]
        for _ in range(draw.randint(3, 9)):
            body += self._block()
            if draw.random() < 0.6:
                body += [nop()] * draw.randint(1, 40)
            if draw.random() < 0.5:
                body.append(self._one.cache_control())
            if draw.random() < 0.4:
                behind = self._label()
                body += [branch(f"br {behind}"), *[nop()] * draw.randint(0, 40), nop(behind)]
        back = draw.choice([branch(f"bgt {label}"), Instruction(f"bgtd {label}")])
        return [Instruction(f"ldi {draw.randint(1, 4)},r9"), *body, Instruction("subi 1,r9"), back, nop(), nop(), nop()]

    def _block(self) -> list[Instruction]:
        if not self.setting.control:
            return self._straight()
        return self._draw.choices(list(self._blocks), list(self._blocks.values()))[0]()

    def _label(self) -> str:
        self._labels += 1
        return f"l{self._labels}"

    def _slots(self) -> list[Instruction]:
        return self._one.some(3, 3)

    def _straight(self) -> list[Instruction]:
        return self._one.some(1, 8)

    def _condition(self) -> str:
        return self._draw.choice(CONDITIONS)

    def _conditional_branch(self) -> list[Instruction]:
        label = self._label()
        return [branch(f"b{self._condition()} {label}"), *ended(self._one.some(2, 5), label)]

    def _delayed_branch(self) -> list[Instruction]:
        label = self._label()
        return [Instruction(f"b{self._condition()}d {label}"), *self._slots(), *ended(self._one.some(2, 4), label)]

    def _annulling_branch(self) -> list[Instruction]:
        label = self._label()
        suffix, kind = self._draw.choice([("af", Kind.ANNULS_IF_FALSE), ("at", Kind.ANNULS_IF_TRUE)])
        slots = without(self._slots(), status=True)
        rest = ended(self._one.some(2, 4), label)
        return [Instruction(f"b{self._condition()}{suffix} {label}", kind), *slots, *rest]

    def _loop(self) -> tuple[str, list[Instruction]]:
        """A label, and the begin of a loop that AR6 counts."""
        label = self._label()
        count = Instruction(f"ldi {self._draw.randint(0, 4)},ar6", results=only("ar6"))
        return label, [count, *begun(without(self._one.some(1, 5), "ar6"), label)]

    def _counted_loop(self) -> list[Instruction]:
        label, loop = self._loop()
        text = f"db{self._draw.choice(['u', 'u', 'ne'])} ar6,{label}"
        back = Instruction(text, Kind.EMPTIES, address_only=only("ar6"), results=only("ar6"))
        return [*loop, back, restored_ar6()]

    def _delayed_counted_loop(self) -> list[Instruction]:
        label, loop = self._loop()
        back = Instruction(f"dbud ar6,{label}", address_only=only("ar6"), results=only("ar6"))
        return [*loop, back, *without(self._slots(), "ar6"), restored_ar6()]

    def _repeated(self, operation: str, kind: Kind, slots: list[Instruction]) -> list[Instruction]:
        label = self._label()
        block = ended(self._one.some(1, 7), label)
        count = Instruction(f"ldi {self._draw.randint(0, 5)},rc")
        return [count, Instruction(f"{operation} {label}", kind), *without([*slots, *block], status=True)]

    def _repeated_block(self) -> list[Instruction]:
        return self._repeated("rptb", Kind.EMPTIES, [])

    def _delayed_repeated_block(self) -> list[Instruction]:
        return self._repeated("rptbd", Kind.STRAIGHT, self._slots())

    def _repeated_instruction(self) -> list[Instruction]:
        repeat = Instruction(f"rpts {self._draw.randint(0, 6)}", Kind.RPTS)
        return [repeat, *without(self._one.some(1, 1), status=True)]

    def _routine(self, kept: str = "") -> tuple[str, list[Instruction], str, list[Instruction]]:
        """Label and instructions of a routine that leaves a register as it is, and of what follows behind it."""
        label, behind = self._label(), self._label()
        body = self._one.some(1, 4)
        return label, begun(without(body, kept) if kept else body, label), behind, [labelled(self._one.one(), behind)]

    def _called(self, caller: Callable[[str], Instruction]) -> list[Instruction]:
        label, body, behind, rest = self._routine("sp")
        if self._draw.random() < 0.3:
            condition = self._draw.choice(["eq", "ne", "gt"])
            body.append(Instruction(f"rets{condition}", Kind.RETURN_CONDITIONALLY, reads=[top_of_stack()]))
        body += [*without(self._one.some(0, 2), "sp"), returning("rets")]
        return [caller(label), branch(f"br {behind}"), *body, *rest]

    def _call(self) -> list[Instruction]:
        return self._called(lambda label: Instruction(f"call {label}", Kind.EMPTIES, writes=[next_of_stack()]))

    def _conditional_call(self) -> list[Instruction]:
        name = f"call{self._condition()}"
        kind = Kind.CALL_CONDITIONALLY
        return self._called(lambda label: Instruction(f"{name} {label}", kind, writes=[next_of_stack()]))

    def _linked_call(self) -> list[Instruction]:
        label, body, behind, rest = self._routine()
        back = [branch("bu r11")] if self._draw.random() < 0.5 else [Instruction("bud r11"), *self._slots()]
        return [Instruction(f"laj {label}"), *self._slots(), branch(f"br {behind}"), *body, *back, *rest]

    def _branch_by_register(self) -> list[Instruction]:
        """LAJ leaves the address behind its slots in R11."""
        here = self._label()
        passed = self._one.some(1, 2)
        address = Instruction(f"addi3 {3 + len(passed)},r11,ar6", results=only("ar6"))
        jump = Instruction("bu ar6", Kind.EMPTIES, operands=only("ar6"))
        rest = [*without(self._one.some(1, 1), "ar6"), restored_ar6()]
        return [Instruction(f"laj {here}"), nop(), nop(), nop(), nop(here), address, jump, *passed, *rest]

    def _returns_from_trap(self, *kept: str) -> list[Instruction]:
        returns = [[returning("reti")], [Instruction("retiud", reads=[top_of_stack()]), *without(self._slots(), *kept)]]
        return self._draw.choice(returns)

    def _vector(self, routine: str) -> tuple[int, Operand]:
        self._trap_routines.append(routine)
        number = FIRST_TRAP + len(self._trap_routines) - 1
        address = self._trap_table + number
        return number, Operand("", only(), lambda now: address)

    def _trap_condition(self) -> str:
        return self._draw.choice(["u", "u", self._condition()])

    def _trap(self) -> list[Instruction]:
        label, body, behind, rest = self._routine("sp")
        number, vector = self._vector(label)
        name = f"trap{self._trap_condition()} {number}"
        trap = Instruction(name, Kind.TRAP, reads=[vector], writes=[next_of_stack()])
        back = self._draw.choice([self._returns_from_trap("sp"), self._returns_from_trap("sp"), [returning("rets")]])
        return [trap, branch(f"br {behind}"), *body, *back, *rest]

    def _linked_trap(self) -> list[Instruction]:
        label, body, behind, rest = self._routine()
        number, vector = self._vector(label)
        trap = Instruction(f"lat{self._trap_condition()} {number}", Kind.LINK_AND_TRAP, reads=[vector])
        return [trap, *self._slots(), branch(f"br {behind}"), *body, branch("bu r11"), *rest]

    def _interrupt_routine(self) -> list[Instruction]:
        body = without(self._one.some(1, 4), "sp", "ar6", status=True)
        back = without(self._returns_from_trap("sp", "ar6"), status=True)
        return [*begun(body, "isr"), *back]
