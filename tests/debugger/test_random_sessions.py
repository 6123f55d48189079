"""Random programs with calls, and random commands, against a model: what the trace of a run without a debugger says."""

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
from cmrc import c40
from cmrc.debug import Debugger

CYCLE_PS = 50_000
SEEDS = [*range(12), *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(12, 400))]


def generate(rng: random.Random) -> str:
    """Routines call only later ones. They return by RETS, through a register, or from LAJ through R11."""
    routines = [f"sub{n}" for n in range(rng.randint(1, 3))]
    count = iter(range(1000))

    def plain() -> list[str]:
        return [
            rng.choice(
                [
                    f"addi {rng.randint(1, 9)},r{rng.randint(0, 3)}",
                    f"sti r{rng.randint(0, 3)},@words+{rng.randint(0, 3)}",
                    f"cmpi {rng.randint(0, 9)},r{rng.randint(0, 3)}",
                    f"push r{rng.randint(0, 3)}\n        addi 1,r2\n        pop r{rng.randint(0, 3)}",
                    f"rpts {rng.randint(0, 2)}\n        addi 1,r{rng.randint(0, 3)}",
                ]
            )
        ]

    def piece(callable_: list[str], may_link: bool) -> list[str]:
        kind = rng.randrange(6)
        if kind == 0 and callable_:
            return [f"{rng.choice(['call', 'call', 'calllt', 'callge'])} {rng.choice(callable_)}"]
        if kind == 1 and may_link:
            return ["laj linked", "addi 1,r0", "addi 1,r1", "nop"]
        if kind == 2 and callable_:  # a call that may be jumped over
            place = f"over{next(count)}"
            return [f"bne {place}", f"call {rng.choice(callable_)}", f"{place}: nop"]
        if kind == 3:
            place = f"on{next(count)}"
            return [f"bged {place}", "addi 1,r3", "addi 2,r3", "nop", "addi 5,r0", f"{place}: nop"]
        return plain()

    lines = ["ldp words", "ldhi 2fh,sp", "or 0fc00h,sp", "ldi 2,ar3", "again: nop"]
    for _ in range(rng.randint(3, 6)):
        lines += piece(routines, may_link=True)
    lines += ["db ar3,again", "done: b done"]
    for n, name in enumerate(routines):
        lines.append(f"{name}: addi 1,r3")
        for _ in range(rng.randint(1, 3)):
            lines += piece(routines[n + 1 :], may_link=True)
        lines += rng.choice([["rets"], ["pop ar2", "bud ar2", "addi 1,r1", "nop", "nop"]])
    lines += ["linked: addi 1,r2", "bud r11", "nop", "addi 1,r1", "nop"]
    text = "\n".join(line if ": " in line else f"        {line}" for line in lines)
    return f"        .text\nstart:  nop\n{text}\n        .data\nwords:  .word 1,2,3,4\n"


@dataclass
class Condition:
    number: int
    meets: Callable[[int], bool]
    ignore: int
    hits: int = 0


@dataclass
class Run:
    """Point k is the instant before the k-th instruction; the last one is before the branch that ends the program."""

    pcs: list[int] = field(default_factory=list)
    cycles: list[int] = field(default_factory=list)
    stacks: list[int] = field(default_factory=list)
    writes: list[list[tuple[int, int]]] = field(default_factory=list)  # by the instruction before the point
    returns: dict[int, int] = field(default_factory=dict)  # of calls: by the point before them

    @classmethod
    def of(cls, source: str) -> "Run":
        image = c40.assemble(source)
        run, stack = cls(), 0
        written: list[tuple[int, int]] = []
        texts = c40.Processor(image).trace(20_000)
        for record, text in zip(c40.Processor(image)._core.trace(20_000), texts, strict=True):
            run.pcs.append(record["pc"])
            run.cycles.append(record["cycle"])
            run.stacks.append(stack)
            run.writes.append(written)
            if record["pc"] == image.symbols["done"]:
                return run
            stack = record["registers"].get("sp", stack)
            written = [(address, value) for how, address, value in record["memory"] if how == "w"]
            operation = text.split()[5]
            if operation.startswith(("call", "laj")):
                run.returns[len(run.pcs) - 1] = record["pc"] + (4 if operation.startswith("laj") else 1)
        raise AssertionError("the program has no end")

    @property
    def end(self) -> int:
        return len(self.pcs) - 1

    def over(self, point: int) -> int:
        """Where a step over calls ends."""
        if point not in self.returns:
            return min(point + 1, self.end)
        wanted = (self.returns[point], self.stacks[point])
        return next(k for k in range(point + 1, self.end + 1) if (self.pcs[k], self.stacks[k]) == wanted)

    def back_over(self, point: int) -> int:
        """The last call from which such a step comes here, else the instruction before."""
        calls = [k for k in self.returns if k < point and self.over(k) == point]
        return max(calls, default=max(point - 1, 0))


class Session:
    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        source = generate(self.rng)
        self.run = Run.of(source)
        self.chip = c40.Processor(c40.assemble(source))
        self.debugger: Debugger = self.chip.debug()
        self.words = self.debugger.places("words")[0]
        self.conditions: list[Condition] = []
        self.at = 0

    def add(self) -> None:
        run, ignore = self.run, self.rng.choice([0, 0, 0, 1, 3])
        if self.rng.random() < 0.6:
            pc = self.rng.choice(run.pcs)
            number = self.debugger.break_at(pc, ignore=ignore)
            self.conditions.append(Condition(number, lambda k: run.pcs[k] == pc, ignore))
        else:
            word = self.words + self.rng.randrange(4)
            number = self.debugger.watch(word, on="write", ignore=ignore)
            self.conditions.append(Condition(number, lambda k: word in dict(run.writes[k]), ignore))

    def forward(self, goal: int) -> tuple[int, list[int]]:
        for k in range(self.at + 1, goal + 1):
            met = []
            for condition in self.conditions:
                if condition.meets(k):
                    condition.hits += 1
                    if condition.hits > condition.ignore:
                        met.append(condition.number)
            if met:
                return k, met
        return goal, []

    def backward(self) -> tuple[int, list[int]]:
        for k in range(self.at - 1, -1, -1):
            if met := [condition.number for condition in self.conditions if condition.meets(k)]:
                return k, met
        return 0, []

    def command(self) -> None:
        run, debugger = self.run, self.debugger
        name = self.rng.choice(["go", "step", "over", "over", "back", "step_back", "over_back", "over_back", "go_to"])
        if self.at == run.end and name in ("step", "over"):
            return
        hits: list[int] = []
        moves: dict[str, Callable[[], Any]] = {
            "go": debugger.go,
            "step": debugger.step,
            "over": lambda: debugger.step("over"),
            "back": debugger.back,
            "step_back": debugger.step_back,
            "over_back": lambda: debugger.step_back("over"),
        }
        before = self.at
        if name == "go":
            self.at, hits = self.forward(run.end)
        elif name in ("step", "over"):
            self.at, hits = self.forward(self.at + 1 if name == "step" else run.over(self.at))
        elif name == "back":
            self.at, hits = self.backward()
        elif name == "go_to":
            self.at = self.rng.randrange(run.end)
            moves[name] = lambda: debugger.go_to_ps(run.cycles[self.at] * CYCLE_PS)
        else:
            self.at = max(self.at - 1, 0) if name == "step_back" else run.back_over(self.at)
        stop = moves[name]()
        shown = (stop.time_ps // CYCLE_PS, self.chip.pc, sorted(hit.number for hit in stop.hits))
        assert shown == (run.cycles[self.at], run.pcs[self.at], sorted(hits)), (name, before, self.at, stop)
        assert debugger.value("instructions") == self.at
        assert debugger.hits() == {condition.number: condition.hits for condition in self.conditions}


@pytest.mark.parametrize("seed", SEEDS)
def test_commands_do_what_the_trace_says(seed: int) -> None:
    session = Session(seed)
    for _ in range(40):
        if session.rng.random() < 0.2 and len(session.conditions) < 4:
            session.add()
        session.command()
