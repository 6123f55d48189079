"""A device of Python that raises in each of its members: the exception comes out with its place, nothing is half done,
and after a repair the device continues."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from board_parts import END, assembled, board, enabled, low, vector
from cmrc.c40 import Processor
from cmrc.network import Network

PLACE = 0xA0000000
# One write, one read, an interrupt that the device makes by itself 50 cycles after the write.
PROGRAM = (
    vector(5)
    + enabled(2)
    + "        ldi 5,r0\n        sti r0,*ar2\n        ldi *+ar2(1),r3\n        idle\n        addi 1,r9\n"
    + END
    + "isr:    addi 1,r2\n        reti\n"
)


class Fragile:
    """Counts accesses, rings once. The member that `raising` names raises."""

    words = 2
    pin = "IIOF2"

    def __init__(self, raising: str = "") -> None:
        self.raising = raising
        self.log: list[str] = []
        self.due: int | None = None
        self.rings = False

    def _may(self, member: str) -> None:
        if member == self.raising:
            raise RuntimeError(f"{member} is broken")

    def read(self, offset: int, cycle: int) -> int:
        self._may("read")
        self.log.append("read")
        return 7

    def write(self, offset: int, value: int, cycle: int) -> None:
        self._may("write")
        self.log.append("write")
        self.due = cycle + 50

    def next_event(self) -> int | None:
        self._may("next_event")
        return self.due

    def advance_to(self, cycle: int) -> None:
        self._may("advance_to")
        if self.due is not None and self.due <= cycle:
            self.due, self.rings = None, True

    def interrupts(self) -> bool:
        if self.log:
            self._may("interrupts")
        return self.rings

    def save(self) -> bytes:
        self._may("save")
        return repr((self.log, self.due, self.rings)).encode()

    def load(self, state: bytes) -> None:
        self._may("load")
        self.log, self.due, self.rings = eval(state.decode())

    def __deepcopy__(self, memo: Any) -> Fragile:
        self._may("copy")
        other = Fragile(self.raising)
        other.log, other.due, other.rings = copy.copy(self.log), self.due, self.rings
        return other


def one_chip(device: Fragile, path: Path) -> tuple[Any, Callable[[], Any], Any]:
    chip = Processor(assembled(PROGRAM), board=path, devices={PLACE: device})
    return chip, lambda: chip.run(10_000, until="done"), chip


def one_of_two(device: Fragile, path: Path) -> tuple[Any, Callable[[], Any], Any]:
    network = Network(
        [assembled(PROGRAM), assembled(END)], boards=str(path), until="done", devices={0: {PLACE: device}}
    )
    return network, network.run, network.chips[0]


MAKERS = {"processor": one_chip, "network": one_of_two}


@pytest.mark.parametrize("maker", MAKERS)
@pytest.mark.parametrize("member", ["read", "write", "next_event", "advance_to", "interrupts"])
def test_what_a_member_raises_comes_out_of_a_run_and_a_repaired_device_continues(
    tmp_path: Path, maker: str, member: str
) -> None:
    whole = MAKERS[maker](Fragile(), board(tmp_path))
    whole[1]()
    device = Fragile()
    _runner, run, chip = MAKERS[maker](device, board(tmp_path))
    device.raising = member
    for _ in range(2):
        with pytest.raises(RuntimeError, match=f"{member} is broken") as caught:
            run()
        assert "Fragile at A0000000h" in "".join(caught.value.__notes__)
    device.raising = ""
    run()
    assert (low(chip, "R3"), low(chip, "R2"), low(chip, "R9")) == (7, 1, 1)
    if member in ("read", "write"):
        assert device.log == ["write", "read"] and chip.cycles == whole[2].cycles


@pytest.mark.parametrize("maker", MAKERS)
@pytest.mark.parametrize("call", ["snapshot", "fork"])
def test_what_save_raises_comes_out_of_snapshots_and_forks_and_the_run_continues(
    tmp_path: Path, maker: str, call: str
) -> None:
    device = Fragile()
    runner, run, chip = MAKERS[maker](device, board(tmp_path))
    device.raising = "save"
    with pytest.raises(RuntimeError, match="save is broken"):
        getattr(runner, call)()
    device.raising = ""
    assert getattr(runner, call)() is not None
    run()
    assert (low(chip, "R3"), low(chip, "R2")) == (7, 1)


@pytest.mark.parametrize("maker", MAKERS)
def test_what_a_copy_raises_comes_out_of_what_makes_it_and_the_run_continues(tmp_path: Path, maker: str) -> None:
    """A network copies its devices when it is made, a processor when it is forked."""
    broken = Fragile("copy")
    if maker == "network":
        with pytest.raises(RuntimeError, match="copy is broken"):
            MAKERS[maker](broken, board(tmp_path))
        return
    runner, run, chip = MAKERS[maker](broken, board(tmp_path))
    with pytest.raises(RuntimeError, match="copy is broken"):
        runner.fork()
    run()
    assert (low(chip, "R3"), low(chip, "R2")) == (7, 1)


@pytest.mark.parametrize("maker", MAKERS)
def test_what_load_raises_comes_out_of_a_fork_and_the_run_continues(tmp_path: Path, maker: str) -> None:
    runner, run, chip = MAKERS[maker](Fragile("load"), board(tmp_path))
    with pytest.raises(RuntimeError, match="load is broken"):
        runner.fork()
    run()
    assert (low(chip, "R3"), low(chip, "R2")) == (7, 1)


@pytest.mark.parametrize("maker", MAKERS)
def test_a_load_that_raises_leaves_what_was_there(tmp_path: Path, maker: str) -> None:
    device = Fragile()
    runner, run, chip = MAKERS[maker](device, board(tmp_path))
    begin, at_begin = runner.snapshot(), (chip.cycles, low(chip, "R3"), [])
    run()
    there = (chip.cycles, low(chip, "R3"), list(device.log))
    device.raising = "load"
    with pytest.raises(RuntimeError, match="load is broken"):
        runner.restore(begin)
    assert (chip.cycles, low(chip, "R3"), device.log) == there
    device.raising = ""
    runner.restore(begin)
    assert (chip.cycles, low(chip, "R3"), device.log) == at_begin
    run()
    assert (chip.cycles, low(chip, "R3"), device.log) == there


@pytest.mark.parametrize("wrong", ["x", None, 1.5, 2**32, -(2**31) - 1])
def test_a_read_that_gives_no_word_is_reported(tmp_path: Path, wrong: Any) -> None:
    for maker in MAKERS.values():
        device = Fragile()
        device.read = lambda offset, cycle: wrong  # type: ignore[method-assign]
        _, run, _ = maker(device, board(tmp_path))
        with pytest.raises((TypeError, ValueError)) as caught:
            run()
        assert "Fragile at A0000000h" in "".join([str(caught.value), *getattr(caught.value, "__notes__", [])])
