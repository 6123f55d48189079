"""The executive from `_start` on: it claims in the order of the list, runs the kernel of the kind, writes FFh last, and
idles by its policy.

The shared memory is RAM, so a semaphore's word is written by hand: 0 free (as after a release), 1 taken.
"""

from __future__ import annotations

import functools
from typing import Any

import pytest
from cmrc import _core
from cmrc_test import run_setup
from harness import RETURN, WINDOW_A, Dsp, image
from locations import ROOT

KIND = {"error": 0, "torque": 5, "unknown": 77}


@functools.cache
def image_with_own_blocks() -> Any:
    """The program for a configuration where one task has its own DSP."""
    task = '[[tasks]]\nname = "own"\nprogram = "kernel_none"\nkind = 23\nimportance = 1\nperiod_ms = 1\ndsp = 0\n'
    return run_setup.dsp_image(_core.cmrc.config(toml=task, settings={"machine.programs": str(ROOT / "c40_programs")}))


class Board(Dsp):
    def __init__(self, slot: int = 3, policy: int = 0, pause: int = 50, program: Any = None) -> None:
        super().__init__()
        if program is not None:
            self.chip = _core.c40.Processor("flat", checks=True)
            self.symbols = program.symbols
        self.chip.load_image(program or image())
        s = self.symbols
        self.chip.poke(s["dsp_slot"], slot)
        self.chip.poke(s["idle_policy"], policy)
        self.chip.poke(s["pause_count"], pause)
        self.chip.pc = s["_start"]

    def shared(self, offset: int) -> int:
        return int(self.chip.peek(WINDOW_A + offset))

    def set_shared(self, offset: int, value: int) -> None:
        self.chip.poke(WINDOW_A + offset, value)

    def block(self, index: int, kind: int, j: int, link: int = 0) -> int:
        s = self.symbols
        at = s["BLOCK_POOL"] + index * s["BLOCK_WORDS"]
        words = {
            "TB_T": 9,
            "TB_FLAG": 0,
            "TB_J": j,
            "TB_LINK": link,
            "TB_KIND": kind,
            "TB_AREA": s["CR_BASE"],
            "TB_GENERATION": 4,
        }
        for name in ("TB_OWNER", "TB_RESULT", "TB_NOTIFY"):
            words[name] = 0x5A5A
        for name, value in words.items():
            self.set_shared(at + s[name], value)
        return at

    def field(self, block: int, name: str) -> int:
        return self.shared(block + self.symbols[name])

    def run_cycles(self, cycles: int) -> None:
        stop = self.chip.run(cycles, RETURN)
        assert stop["reason"] == "limit", stop


def test_blocks_are_claimed_in_list_order_until_one_is_not_to_be_run() -> None:
    b = Board()
    s = b.symbols
    third = b.block(2, KIND["torque"], 0)
    second = b.block(1, KIND["unknown"], 0xFFEF, link=third)
    first = b.block(0, KIND["error"], 0xFFFE, link=second)
    b.set_shared(s["LIST_WORK_POINTER"], first)
    b.run_cycles(20_000)
    assert b.chip.idle
    assert [b.field(first, n) for n in ("TB_FLAG", "TB_T", "TB_OWNER", "TB_RESULT", "TB_NOTIFY")] == [
        0xFF,
        0,
        4,
        0x20001,
        0,
    ]  # one error so far, of no origin: hold
    assert [b.field(second, n) for n in ("TB_FLAG", "TB_RESULT")] == [0xFF, 0xFFFFFFFF]
    assert [b.field(third, n) for n in ("TB_FLAG", "TB_T", "TB_OWNER")] == [0, 9, 0x5A5A]  # J = 0: left alone
    assert b.field(first, "TB_GENERATION") == 4
    assert b.shared(s["LIST_WORK_POINTER"]) == third
    assert b.shared(s["SEMAPHORE_LIST"]) == 0
    assert b.shared(s["DOORBELL_IDLE"]) == 3


def test_a_ring_wakes_an_idle_dsp() -> None:
    b = Board()
    s = b.symbols
    b.run_cycles(5_000)
    assert b.chip.idle
    for n in range(3):
        block = b.block(n, KIND["torque"], 0xFFF7)
        b.set_shared(s["LIST_WORK_POINTER"], block)
        b.run_cycles(1_000)
        assert b.field(block, "TB_FLAG") == 0  # it sleeps
        b.chip.raise_iiof(0)
        b.run_cycles(5_000)
        assert b.field(block, "TB_FLAG") == 0xFF
        assert b.shared(s["LIST_WORK_POINTER"]) == 0
        assert b.chip.idle


def test_the_flag_is_the_last_word_written_of_a_block() -> None:
    b = Board()
    s = b.symbols
    block = b.block(0, KIND["torque"], 0xFFF7)
    b.set_shared(s["LIST_WORK_POINTER"], block)
    writes = [
        address - WINDOW_A
        for record in b.chip.trace(20_000)
        for kind, address, _ in record.get("memory", ())
        if kind == "w" and block <= address - WINDOW_A < block + 16
    ]
    names = {block + s[n]: n for n in ("TB_T", "TB_FLAG", "TB_OWNER", "TB_RESULT", "TB_NOTIFY")}
    assert [names[w] for w in writes] == ["TB_T", "TB_FLAG", "TB_OWNER", "TB_RESULT", "TB_NOTIFY", "TB_FLAG"]


def test_a_taken_semaphore_is_waited_for() -> None:
    b = Board()
    s = b.symbols
    block = b.block(0, KIND["error"], 0xFFFE)
    b.set_shared(s["LIST_WORK_POINTER"], block)
    b.set_shared(s["SEMAPHORE_LIST"], 1)
    b.run_cycles(5_000)
    assert b.field(block, "TB_FLAG") == 0 and b.shared(s["LIST_WORK_POINTER"]) == block
    b.set_shared(s["SEMAPHORE_LIST"], 0)
    b.run_cycles(5_000)
    assert b.field(block, "TB_FLAG") == 0xFF


@pytest.mark.parametrize("policy", [1, 2])
def test_pause_and_spin_find_a_block_without_a_ring(policy: int) -> None:
    b = Board(policy=policy, pause=50)
    s = b.symbols
    b.run_cycles(5_000)
    assert not b.chip.idle
    block = b.block(0, KIND["torque"], 0xFFF7)
    b.set_shared(s["LIST_WORK_POINTER"], block)
    b.run_cycles(5_000)
    assert b.field(block, "TB_FLAG") == 0xFF
    assert b.shared(s["DOORBELL_IDLE"]) == 0


def test_pause_looks_at_the_list_as_often_as_given() -> None:
    looks = {}
    for pause in (100, 1000):
        b = Board(policy=1, pause=pause)
        b.run_cycles(2_000)
        records = b.chip.trace(20_000)
        looks[pause] = sum(1 for r in records for k, a, _ in r.get("memory", ()) if k == "r" and a == WINDOW_A)
    assert looks[100] == pytest.approx(20_000 / (100 + 60), rel=0.25)
    assert looks[1000] == pytest.approx(20_000 / (1000 + 60), rel=0.1)


# ---- blocks for one DSP alone (claim_own.asm)

ANYBODY, OTHER, OWN = 0, 3, 4  # TB_OWNER of waiting blocks, as DSP 3 sees them


class OwnBoard(Board):
    """DSP 3, and a list of blocks with these owners and flags, all with J > 0 but the last `not_due`."""

    def __init__(self, blocks: list[tuple[int, int]], not_due: int = 0, policy: int = 0) -> None:
        super().__init__(program=image_with_own_blocks(), policy=policy)
        s = self.symbols
        at = [s["BLOCK_POOL"] + n * s["BLOCK_WORDS"] for n in range(len(blocks))]
        self.at = at
        for n, (owner, flag) in enumerate(blocks):
            j = 0xF000 - n if n < len(blocks) - not_due else 0
            self.block(n, KIND["unknown"], j, link=at[n + 1] if n + 1 < len(at) else 0)
            self.set_shared(at[n] + s["TB_OWNER"], owner)
            self.set_shared(at[n] + s["TB_FLAG"], flag)
        self.set_shared(s["LIST_WORK_POINTER"], at[0] if at else 0)

    def run_to_sleep(self) -> list[int]:
        """Numbers of the blocks that it has run, all in the order of the writes of 0Fh."""
        s = self.symbols
        order = [
            (address - WINDOW_A - s["BLOCK_POOL"]) // s["BLOCK_WORDS"]
            for record in self.chip.trace(100_000)
            for kind, address, value in record.get("memory", ())
            if kind == "w" and value == 0xF and address - WINDOW_A in {at + s["TB_FLAG"] for at in self.at}
        ]
        assert self.chip.idle and self.shared(s["SEMAPHORE_LIST"]) == 0
        for n in order:
            assert [self.field(self.at[n], name) for name in ("TB_FLAG", "TB_T", "TB_OWNER")] == [0xFF, 0, 4]
        return order

    def pointer(self) -> int | None:
        """Number of the block at the work pointer."""
        at = self.shared(self.symbols["LIST_WORK_POINTER"])
        return self.at.index(at) if at else None


WAITING, TAKEN, DONE = 0, 0xF, 0xFF


@pytest.mark.parametrize(
    ("blocks", "not_due", "runs", "pointer"),
    [
        ([], 0, [], None),
        ([(ANYBODY, WAITING), (OWN, WAITING), (ANYBODY, WAITING)], 0, [0, 1, 2], None),
        ([(OTHER, WAITING)], 0, [], 0),
        ([(OTHER, WAITING), (OWN, WAITING), (OTHER, WAITING), (ANYBODY, WAITING)], 0, [1, 3], 0),
        ([(OTHER, TAKEN), (OTHER, DONE), (OWN, DONE), (ANYBODY, WAITING), (OTHER, WAITING)], 0, [3], 0),
        ([(ANYBODY, WAITING), (OTHER, WAITING), (OWN, WAITING)], 0, [0, 2], 1),
        ([(OWN, WAITING), (OTHER, TAKEN), (OWN, WAITING)], 0, [0, 2], 1),
        ([(OTHER, WAITING), (OWN, WAITING), (OWN, WAITING)], 1, [1], 0),
        ([(OWN, WAITING), (ANYBODY, WAITING)], 2, [], 0),
        ([(OTHER if n % 3 else OWN, WAITING) for n in range(64)], 0, list(range(0, 64, 3)), 1),
    ],
)
def test_a_dsp_passes_what_is_anothers_or_taken_and_takes_what_is_left(
    blocks: list[tuple[int, int]], not_due: int, runs: list[int], pointer: int | None
) -> None:
    b = OwnBoard(blocks, not_due)
    assert b.run_to_sleep() == runs
    assert b.pointer() == pointer
    for n, (owner, flag) in enumerate(blocks):
        if n not in runs:
            assert [b.field(b.at[n], name) for name in ("TB_FLAG", "TB_T", "TB_OWNER")] == [flag, 9, owner]
    assert b.chip.diagnostics() == []


def test_a_dsp_that_polls_finds_its_own_block() -> None:
    b = OwnBoard([(OTHER, WAITING), (OWN, WAITING)], policy=1)
    b.run_cycles(10_000)
    assert [b.field(at, "TB_FLAG") for at in b.at] == [WAITING, DONE] and b.pointer() == 0
