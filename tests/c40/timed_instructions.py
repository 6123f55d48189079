"""Random instructions without control, and what the timing model has to know of each: its accesses and registers.

Sections are those of c40-hardware.md."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto

Registers = Mapping[str, int]
"""by lower-case name"""
POINTERS = [f"ar{n}" for n in range(6)]
"""They point into data. AR6 points to peripheral registers and counts loops; AR7 points to the pool of pointers."""
ADDRESS_REGISTERS = frozenset([*POINTERS, "ar6", "ar7", "ir0", "ir1", "bk", "sp", "dp"])
PAGES = [0x2F, 0x31, 0x8001]
"""of DP; each has a pool of pointers and some words for data"""
POOL, POOL_WORDS, SCRATCH, SCRATCH_WORDS = 0xF8E0, 12, 0xF900, 8
"""in a page; the word behind the pool is AR6's pointer"""
CLEAR_CACHE = ("or 1800h,st", "or 1000h,st")
CACHE_CONTROLS = [*CLEAR_CACHE, "or 0800h,st", "andn 0800h,st", "or 0400h,st", "andn 0400h,st"]


class Kind(Enum):
    STRAIGHT = auto()
    """also delayed branches"""
    EMPTIES = auto()
    """a branch, a call or a return that is not delayed, or RPTB"""
    RPTS = auto()
    ANNULS_IF_FALSE = auto()
    ANNULS_IF_TRUE = auto()
    CALL_CONDITIONALLY = auto()
    RETURN_CONDITIONALLY = auto()
    TRAP = auto()
    LINK_AND_TRAP = auto()


@dataclass(frozen=True)
class Operand:
    text: str
    registers: frozenset[str]
    address: Callable[[Registers], int]
    steps: bool = False
    """It changes its ARn."""


@dataclass(frozen=True)
class Instruction:
    text: str
    kind: Kind = Kind.STRAIGHT
    reads: list[Operand] = field(default_factory=list)
    """of two, the one in bits 15 to 8 of the word first"""
    writes: list[Operand] = field(default_factory=list)
    address_only: frozenset[str] = frozenset()
    """registers of an address that is not accessed: of NOP's, and DBcond's counter, which is one for 7.3"""
    operands: frozenset[str] = frozenset()
    """the address registers that it reads as operands"""
    results: frozenset[str] = frozenset()
    """those that it writes in E"""
    early_results: frozenset[str] = frozenset()
    """those that it writes in R: LDA"""
    writes_status: bool = False
    label: str = ""

    def addressing(self) -> frozenset[str]:
        return self.address_only.union(*(one.registers for one in self.reads + self.writes))

    def touches(self, register: str) -> bool:
        return register in self.addressing() | self.operands | self.results | self.early_results

    @property
    def clears_cache(self) -> bool:
        return self.text in CLEAR_CACHE


def only(*names: str) -> frozenset[str]:
    """Those of the registers that can make addresses."""
    return ADDRESS_REGISTERS.intersection(names)


def nop(label: str = "") -> Instruction:
    return Instruction("nop", label=label)


def without(instructions: list[Instruction], *registers: str, status: bool = False) -> list[Instruction]:
    """NOP for each that touches one of the registers; `status`: for each that writes ST."""
    return [
        nop(one.label) if any(map(one.touches, registers)) or (status and one.writes_status) else one
        for one in instructions
    ]


def top_of_stack() -> Operand:
    return Operand("", only("sp"), lambda now: now["sp"])


def next_of_stack() -> Operand:
    return Operand("", only("sp"), lambda now: now["sp"] + 1)


def in_pool(n: int) -> Operand:
    return Operand(f"*+ar7({n})" if n else "*ar7", only("ar7"), lambda now: now["ar7"] + n)


def direct(offset: int) -> Operand:
    return Operand(f"@0{offset:x}h", only("dp"), lambda now: (now["dp"] & 0xFFFF) << 16 | offset)


def displaced(pointer: str, displacement: int) -> Operand:
    sign = "-" if displacement < 0 else "+"
    text = f"*{sign}{pointer}({abs(displacement)})"
    return Operand(text, only(pointer), lambda now: now[pointer] + displacement)


class InstructionDrawer:
    def __init__(self, draw: random.Random, controls_cache: bool) -> None:
        self.draw = draw
        self._kinds: dict[Callable[[], Instruction], float] = {
            self._arithmetic: 4,
            nop: 2,
            self._load: 5,
            self._store: 5,
            self._two_loads: 3,
            self._two_stores: 3,
            self._read_and_store: 3,
            self._multiply_and_add: 2,
            self._three_operands: 4,
            self._pointer_from_memory: 3,
            self._pointer_from_registers: 2,
            self._read_of_address_register: 2,
            self._index: 2,
            self._data_page: 1,
            self._stack: 1.5,
            self._peripherals: 0.8,
            self.cache_control: 0.4 * controls_cache,
            self._nop_with_address: 1,
            self._conditional_load: 1,
            self._store_of_constant: 0.5,
        }

    def one(self) -> Instruction:
        return self.draw.choices(list(self._kinds), list(self._kinds.values()))[0]()

    def some(self, fewest: int, most: int) -> list[Instruction]:
        return [self.one() for _ in range(self.draw.randint(fewest, most))]

    def cache_control(self) -> Instruction:
        return Instruction(self.draw.choice(CACHE_CONTROLS), writes_status=True)

    # Operands

    def _register(self) -> str:
        return f"r{self.draw.randrange(8)}"

    def _pointer(self, *other_than: str) -> str:
        return self.draw.choice([name for name in POINTERS if name not in other_than])

    def _indirect(self, furthest: int = 5, other_than: frozenset[str] = frozenset(), steps: bool = True) -> Operand:
        pointer = self._pointer(*other_than)
        forms = {"plain": 2, "before": 1, "stepping before": 1, "stepping behind": 1, "index": 1, "reversed": 1}
        if not steps:
            forms = {"plain": 1, "before": 1}
        form = self.draw.choices(list(forms), list(forms.values()))[0]
        sign, distance = self.draw.choice([1, -1]), self.draw.randint(1, furthest)
        if form == "plain":
            return Operand(f"*{pointer}", only(pointer), lambda now: now[pointer])
        if form == "before":
            return displaced(pointer, sign * distance)
        if form == "reversed":
            return Operand(f"*{pointer}++(ir0)b", only(pointer, "ir0"), lambda now: now[pointer], True)
        if form == "index":
            return self._indexed(pointer, sign)
        twice = "++" if sign > 0 else "--"
        if form == "stepping before":
            text = f"*{twice}{pointer}({distance})"
            return Operand(text, only(pointer), lambda now: now[pointer] + sign * distance, True)
        text = f"*{pointer}{twice}({distance})"
        if self.draw.random() < 0.3:
            return Operand(text + "%", only(pointer, "bk"), lambda now: now[pointer], True)
        return Operand(text, only(pointer), lambda now: now[pointer], True)

    def _indexed(self, pointer: str, sign: int) -> Operand:
        index = self.draw.choice(["ir0", "ir1"])
        once, twice = ("+", "++") if sign > 0 else ("-", "--")
        form = self.draw.choice(["before", "stepping before", "stepping behind", "circular"])
        registers = only(pointer, index)
        if form == "before":
            return Operand(f"*{once}{pointer}({index})", registers, lambda now: now[pointer] + sign * now[index])
        if form == "stepping before":
            text = f"*{twice}{pointer}({index})"
            return Operand(text, registers, lambda now: now[pointer] + sign * now[index], True)
        if form == "stepping behind":
            return Operand(f"*{pointer}{twice}({index})", registers, lambda now: now[pointer], True)
        return Operand(f"*{pointer}{twice}({index})%", registers | only("bk"), lambda now: now[pointer], True)

    def _memory(self) -> Operand:
        if self.draw.random() < 0.25:
            return direct(SCRATCH + self.draw.randrange(SCRATCH_WORDS))
        return self._indirect()

    def _of_pool(self) -> Operand:
        n = self.draw.randrange(POOL_WORDS)
        return direct(POOL + n) if self.draw.random() < 0.5 else in_pool(n)

    def _two(self) -> tuple[Operand, Operand]:
        """Of a word with two operands: rarely by one ARn, and then neither steps it."""
        first = self._indirect(furthest=1)
        if first.steps or self.draw.random() < 0.8:
            return first, self._indirect(furthest=1, other_than=first.registers)
        return first, self._indirect(furthest=1, steps=False)

    # Instructions

    def _arithmetic(self) -> Instruction:
        a, b, c = self._register(), self._register(), self._register()
        forms = [f"addi {a},{b}", f"subi 3,{a}", f"addf {a},{b}", f"mpyi3 {a},{b},{c}", f"cmpi {a},{b}", f"lsh 1,{a}"]
        return Instruction(self.draw.choice(forms))

    def _nop_with_address(self) -> Instruction:
        """It computes the address, and does not read."""
        operand = self._indirect()
        return Instruction(f"nop {operand.text}", address_only=operand.registers)

    def _load(self) -> Instruction:
        operation = self.draw.choice(
            ["ldi", "addi", "subi", "cmpi", "ldf", "addf", "mpyf", "lb1", "tstb", "ldii"],
        )
        source = self._memory()
        return Instruction(f"{operation} {source.text},{self._register()}", reads=[source])

    def _conditional_load(self) -> Instruction:
        """It reads, and keeps its register waiting, whether its condition is true or not."""
        if self.draw.random() < 0.65:
            source = self._memory()
            operation = self.draw.choice(["ldieq", "ldine", "ldigt", "ldflt", "ldfu"])
            return Instruction(f"{operation} {source.text},{self._register()}", reads=[source])
        operation, pointer = self.draw.choice(["ldieq", "ldine", "ldigt"]), self._pointer()
        source, other = self._of_pool(), self._pointer()
        return self.draw.choice(
            [
                Instruction(f"{operation} {source.text},{pointer}", reads=[source], results=only(pointer)),
                Instruction(f"{operation} {other},{pointer}", operands=only(other), results=only(pointer)),
                Instruction(f"{operation} {self.draw.randint(1, 3)},ir0", results=only("ir0")),
            ]
        )

    def _store(self) -> Instruction:
        target = self._memory()
        if self.draw.random() < 0.8:
            text = f"{self.draw.choice(['sti', 'stf', 'stii'])} {self._register()},{target.text}"
            return Instruction(text, writes=[target])
        source = self.draw.choice([*POINTERS, "ar6", "ar7", "ir0", "bk", "dp", "sp"])
        return Instruction(f"sti {source},{target.text}", writes=[target], operands=only(source))

    def _store_of_constant(self) -> Instruction:
        target = self._memory()
        return Instruction(f"stik {self.draw.randint(-9, 9)},{target.text}", writes=[target])

    def _two_loads(self) -> Instruction:
        a, b = self._two()
        x, y = self.draw.sample(range(8), 2)
        load = self.draw.choice(["ldi", "ldf"])
        return Instruction(f"{load} {a.text},r{x} || {load} {b.text},r{y}", reads=[b, a])

    def _two_stores(self) -> Instruction:
        a, b = self._two()
        store = self.draw.choice(["sti", "stf"])
        text = f"{store} {self._register()},{a.text} || {store} {self._register()},{b.text}"
        return Instruction(text, writes=[b, a])

    def _read_and_store(self) -> Instruction:
        a, b = self._two()
        x, y, z = self._register(), self._register(), self._register()
        operation, store = self.draw.choice(
            [
                (f"ldi {a.text},{x}", "sti"),
                (f"ldf {a.text},{x}", "stf"),
                (f"addi3 {a.text},{z},{x}", "sti"),
                (f"mpyf3 {a.text},{z},{x}", "stf"),
                (f"float {a.text},{x}", "stf"),
            ]
        )
        return Instruction(f"{operation} || {store} {y},{b.text}", reads=[a], writes=[b])

    def _multiply_and_add(self) -> Instruction:
        a, b = self._two()
        x, y = self._register(), self._register()
        text = self.draw.choice(
            [
                f"mpyf3 {a.text},{b.text},r0 || addf3 {x},{y},r2",
                f"mpyf3 {x},{y},r1 || addf3 {a.text},{b.text},r3",
                f"mpyi3 {b.text},{x},r0 || subi3 {y},{a.text},r2",
            ]
        )
        return Instruction(text, reads=[b, a])

    def _three_operands(self) -> Instruction:
        operation, target = self.draw.choice(["addi3", "subi3", "and3", "xor3"]), self._register()
        form = self.draw.randrange(5)
        if form == 0:
            a, b = self._two()
            return Instruction(f"{operation} {a.text},{b.text},{target}", reads=[b, a])
        if form == 1:
            a, b = (displaced(self._pointer(), self.draw.randint(2, 31)) for _ in range(2))
            return Instruction(f"{operation} {a.text},{b.text},{target}", reads=[b, a])
        if form == 2:
            a = displaced(self._pointer(), self.draw.randint(2, 31))
            return Instruction(f"{operation} {self.draw.randint(-9, 9)},{a.text},{target}", reads=[a])
        a, b_register = self._indirect(furthest=1), self.draw.choice([self._register(), self._pointer()])
        text = f"{operation} {a.text},{b_register},{target}"
        return Instruction(text, reads=[a], operands=only(b_register))

    def _pointer_from_memory(self) -> Instruction:
        pointer, source = self._pointer(), self._of_pool()
        if self.draw.random() < 0.5:
            return Instruction(f"ldi {source.text},{pointer}", reads=[source], results=only(pointer))
        return Instruction(f"lda {source.text},{pointer}", reads=[source], early_results=only(pointer))

    def _pointer_from_registers(self) -> Instruction:
        pointer = self._pointer()
        other = self._pointer(pointer)
        step = f"{self.draw.choice(['addi', 'subi'])} {self.draw.randint(1, 3)},{pointer}"
        return self.draw.choice(
            [
                Instruction(step, operands=only(pointer), results=only(pointer)),
                Instruction(f"ldi {other},{pointer}", operands=only(other), results=only(pointer)),
                Instruction(f"lda {other},{pointer}", operands=only(other), early_results=only(pointer)),
                Instruction(f"addi3 1,{other},{pointer}", operands=only(other), results=only(pointer)),
            ]
        )

    def _read_of_address_register(self) -> Instruction:
        read = self.draw.choice([*POINTERS, "ar6", "ar7", "ir0", "ir1", "bk", "dp", "sp"])
        operation = self.draw.choice(["ldi", "cmpi", "addi", "cmpi3"])
        return Instruction(f"{operation} {read},{self._register()}", operands=only(read))

    def _index(self) -> Instruction:
        index = self.draw.choice(["ir0", "ir1", "bk"])
        value = self.draw.randint(6, 20) if index == "bk" else self.draw.randint(1, 3)
        forms = [
            Instruction(f"ldi {value},{index}", results=only(index)),
            Instruction(f"lda {value},{index}", early_results=only(index)),
        ]
        if index != "bk":
            forms.append(Instruction(f"and 3,{index}", operands=only(index), results=only(index)))
        return self.draw.choice(forms)

    def _data_page(self) -> Instruction:
        page = self.draw.choice(PAGES[:2])
        return self.draw.choice(
            [
                Instruction(f"ldpk 0{self.draw.choice(PAGES):x}h"),  # in D: nothing waits for it (7.3)
                Instruction(f"ldi 0{page:x}h,dp", results=only("dp")),
                Instruction(f"lda 0{page:x}h,dp", early_results=only("dp")),
            ]
        )

    def _stack(self) -> Instruction:
        pushed = self.draw.choice([self._register(), self._register(), self._pointer()])
        step = f"{self.draw.choice(['addi', 'subi'])} 1,sp"
        push = Instruction(f"push {pushed}", writes=[next_of_stack()], operands=only(pushed))
        pop = Instruction(f"pop {self._register()}", reads=[top_of_stack()])
        return self.draw.choice(
            [push, push, pop, pop, Instruction(step, operands=only("sp"), results=only("sp"))],
        )

    def _peripherals(self) -> Instruction:
        first = Operand("*ar6", only("ar6"), lambda now: now["ar6"])
        second = displaced("ar6", 1)
        r = self._register()
        return self.draw.choice(
            [
                Instruction(f"sti {r},*ar6", writes=[first]),
                Instruction(f"ldi *ar6,{r}", reads=[first]),
                Instruction("ldi *ar6,r1 || ldi *+ar6(1),r2", reads=[second, first]),
                Instruction("sti r1,*ar6 || sti r2,*+ar6(1)", writes=[second, first]),
                Instruction("ldi *ar6,r1 || sti r2,*+ar6(1)", reads=[first], writes=[second]),
            ]
        )
