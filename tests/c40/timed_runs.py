"""Programs of timed_programs.py on the emulator by single steps, what of it the timing model is told, and the first
instruction after which the two have counted differently."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cmrc import c40
from timed_instructions import ADDRESS_REGISTERS, Instruction, Kind, Operand, Registers
from timed_programs import CACHE_ENABLE, Program
from timing_model import NO_REGISTERS, CacheControl, Executed, Flow, Stages, TimingModel

MOST_STEPS = 1500
CACHE_FREEZE = 0x400
WORD = 0xFFFFFFFF
SLOTS = 3
FLOWS = {
    Kind.EMPTIES: Flow.EMPTIES,
    Kind.RPTS: Flow.EMPTIES,
    Kind.RETURN_CONDITIONALLY: Flow.EMPTIES,
    Kind.CALL_CONDITIONALLY: Flow.EMPTIES_AND_PUSHES,
    Kind.TRAP: Flow.EMPTIES_AND_PUSHES,
}


@dataclass(frozen=True)
class Step:
    """An instruction, or the entry of an interrupt."""

    pc: int
    registers: Registers
    """before it"""
    cycles: int
    """that the chip has counted after it"""
    causes: dict[str, int]


def loaded(program: Program, board: Path) -> c40.Processor:
    """`board`: where its file is written."""
    board.write_text(program.board())
    image = c40.assemble(program.text(), sections={"code": program.code_base}, entry="start")
    chip = c40.Processor(image, board=board)
    for address, word in program.words.items():
        chip.memory[address] = word
    for name, value in program.registers.items():
        chip.registers[name] = value
    return chip


def steps_of(program: Program, chip: c40.Processor) -> list[Step]:
    """By single steps to the program's end, with interrupts at instructions that its seed decides."""
    draw, steps = random.Random(program.seed), list[Step]()
    watched = sorted(name.upper() for name in ADDRESS_REGISTERS | {"st"})
    end = program.end
    while chip.pc != end and len(steps) < MOST_STEPS:
        registers = {name.lower(): chip.registers[name] for name in watched}
        pc = chip.pc
        if program.vector and len(steps) > 3 and draw.random() < 0.06:
            chip.raise_interrupt(draw.choice(["IIOF0", "IIOF0", "NMI"]))
        stop = chip.step()
        assert stop.reason == "limit", stop
        steps.append(Step(pc, registers, chip.cycles, dict(chip.causes)))
    return steps


class Follower:
    """Tells the model what was executed. Where the program went shows which conditions were true."""

    def __init__(self, program: Program, steps: list[Step]) -> None:
        self._program, self._steps = program, steps
        self._annulled = 0  # slots that are still to come
        self._repeats = False  # the instruction behind RPTS

    def executed(self) -> Iterator[Executed]:
        for n, step in enumerate(self._steps):
            entered = step.causes["interrupt"] - (self._steps[n - 1].causes["interrupt"] if n else 0)
            yield self._interrupt(n) if entered else self._instruction(n, self._program.at(step.pc))

    def _pc(self, n: int) -> int | None:
        return self._steps[n].pc if n < len(self._steps) else None

    def _interrupt(self, n: int) -> Executed:
        step, self._repeats = self._steps[n], False
        stack = step.registers["sp"] + 1
        cache = CacheControl(clear=False, enabled=bool(step.registers["st"] & CACHE_ENABLE), frozen=True)
        return Executed(step.pc, Flow.INTERRUPT, reads=(self._program.vector,), writes=(stack,), cache=cache)

    def _instruction(self, n: int, instruction: Instruction) -> Executed:
        step = self._steps[n]
        fetched = self._is_fetched(n)
        if self._annulled:
            self._annulled -= 1
            return self._in_annulled_slot(step, instruction, SLOTS - self._annulled)
        self._annulled = SLOTS * self._annuls(n, instruction.kind)
        accesses = self._makes_accesses(n, instruction.kind)
        return Executed(
            step.pc,
            FLOWS.get(instruction.kind, Flow.STRAIGHT),
            fetched,
            instruction.addressing(),
            instruction.operands,
            instruction.results,
            instruction.early_results,
            addresses(instruction.reads, step) if accesses or instruction.kind is Kind.CALL_CONDITIONALLY else (),
            addresses(instruction.writes, step) if accesses else (),
            self._cache_control(n, instruction),
        )

    @staticmethod
    def _in_annulled_slot(step: Step, instruction: Instruction, slot: int) -> Executed:
        """It takes its cycle. The LDA of the first one is executed, but waits for no register (docs/fidelity.md)."""
        early = instruction.early_results if slot == 1 else NO_REGISTERS
        reads = addresses(instruction.reads, step) if early else ()
        return Executed(step.pc, early_results=early, reads=reads)

    def _is_fetched(self, n: int) -> bool:
        """The instruction behind RPTS is fetched once."""
        before = self._steps[n - 1].pc if n else None
        if self._repeats and before == self._pc(n):
            return False
        self._repeats = before is not None and self._program.at(before).kind is Kind.RPTS
        return True

    def _annuls(self, n: int, kind: Kind) -> bool:
        if kind not in (Kind.ANNULS_IF_FALSE, Kind.ANNULS_IF_TRUE):
            return False
        taken = self._pc(n + 1 + SLOTS) not in (None, self._steps[n].pc + 1 + SLOTS)
        return taken == (kind is Kind.ANNULS_IF_TRUE)

    def _makes_accesses(self, n: int, kind: Kind) -> bool:
        """False: its condition was false."""
        pc = self._steps[n].pc
        if kind in (Kind.CALL_CONDITIONALLY, Kind.RETURN_CONDITIONALLY, Kind.TRAP):
            return self._pc(n + 1) != pc + 1
        return kind is not Kind.LINK_AND_TRAP or self._pc(n + 1 + SLOTS) != pc + 1 + SLOTS

    def _cache_control(self, n: int, instruction: Instruction) -> CacheControl | None:
        if n + 1 == len(self._steps):
            return None
        before, after = (self._steps[m].registers["st"] for m in (n, n + 1))
        if not instruction.clears_cache and not (before ^ after) & (CACHE_ENABLE | CACHE_FREEZE):
            return None
        return CacheControl(instruction.clears_cache, bool(after & CACHE_ENABLE), bool(after & CACHE_FREEZE))


def addresses(operands: list[Operand], step: Step) -> tuple[int, ...]:
    return tuple(one.address(step.registers) & WORD for one in operands)


def drawn_stages(chip: c40.Processor, cycles: int) -> list[Stages]:
    """Those of a traced run (docs/trace.md); the entry of an interrupt has none."""
    return [Stages(*record["stages"]) for record in chip._core.trace(cycles) if "stages" in record]


def first_difference(program: Program, steps: list[Step], stages: list[Stages]) -> str | None:
    """The program around the first instruction after which chip and model have counted differently, or whose stages
    differ; without `stages` of the chip only counts are compared."""
    model = TimingModel(program.regions, program.interfaces, bool(steps[0].registers["st"] & CACHE_ENABLE))
    for n, (step, executed) in enumerate(zip(steps, Follower(program, steps).executed(), strict=True)):
        same = model.execute(executed) == step.cycles
        if not same or (stages and stages[n] != model.stages[n]):
            return described(program, steps, model.stages, stages, n)
    return None


def described(
    program: Program, steps: list[Step], model: list[Stages], chip: list[Stages], last: int, before: int = 10
) -> str:
    lines = ["", "what the chip counted, F, D, R, E of the model (the chip counts E + 1, after a branch E + 4), causes"]
    for n in range(max(0, last - before), last + 1):
        step, earlier = steps[n], steps[n - 1].causes if n else {}
        causes = {name: count - earlier.get(name, 0) for name, count in step.causes.items()}
        spent = ", ".join(f"{name} {count}" for name, count in causes.items() if count)
        text = f"{step.pc:08X}  {program.at(step.pc).text:42}"
        lines.append(f"{text} {step.cycles:5}  {' '.join(f'{cycle:5}' for cycle in model[n])}   {spent}")
    if chip:
        lines.append(f"the last one's stages by the chip: {' '.join(map(str, chip[last]))}")
    registers = steps[last].registers
    lines.append(" ".join(f"{name} {value & WORD:X}" for name, value in registers.items()))
    lines += [str(region) for region in program.regions]
    lines.append(" ".join(f"{bus} {value:08X}" for bus, value in program.interfaces.items()))
    return "\n".join(lines)
