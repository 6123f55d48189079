"""The executive from `_start` on: claims in list order, runs by kind, writes FFh last, idles by policy.

The shared memory is RAM, so a semaphore's word is written by hand: 0 free (as after a release), 1 taken.
"""

from __future__ import annotations

import pytest
from harness import RETURN, WINDOW_A, Dsp, image

KIND = {"error": 0, "torque": 5, "unknown": 77}


class Board(Dsp):
    def __init__(self, slot: int = 3, policy: int = 0, pause: int = 50) -> None:
        super().__init__()
        self.chip.load_image(image())
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
        words = {"TB_T": 9, "TB_FLAG": 0, "TB_J": j, "TB_LINK": link, "TB_KIND": kind, "TB_AREA": s["CR_BASE"], "TB_GENERATION": 4}
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
    assert [b.field(first, n) for n in ("TB_FLAG", "TB_T", "TB_OWNER", "TB_RESULT", "TB_NOTIFY")] == [0xFF, 0, 4, 0x20001, 0]  # one error so far, of no origin: hold
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


def test_pause_looks_at_the_list_as_often_as_it_is_told() -> None:
    looks = {}
    for pause in (100, 1000):
        b = Board(policy=1, pause=pause)
        b.run_cycles(2_000)
        records = b.chip.trace(20_000)
        looks[pause] = sum(1 for r in records for k, a, _ in r.get("memory", ()) if k == "r" and a == WINDOW_A)
    assert looks[100] == pytest.approx(20_000 / (100 + 60), rel=0.25)
    assert looks[1000] == pytest.approx(20_000 / (1000 + 60), rel=0.1)
