"""A Simulation is used by one thread at a time; from inside a callback it may be read, and nothing else."""

import functools
import threading
from collections.abc import Callable
from typing import Any

import cmrc
import pytest

SHORT: dict[str, Any] = {"dsps": 2, "duration_s": 0.2, "settings": {"report.reference": "none"}}

READS: dict[str, Callable[[cmrc.Simulation], Any]] = {
    "result": lambda s: s.result().hash,
    "tasks": lambda s: s.tasks(),
    "reference": lambda s: s.reference(),
    "time_s": lambda s: s.time_s,
    "ended": lambda s: s.ended,
    "exit_status": lambda s: s._core.exit_status,
    "dsp": lambda s: s.dsp(0).pc,
    "registers": lambda s: s.dsp(1).registers["R0"],
    "memory": lambda s: s.dsp(0).memory[0x300000],
    "peek": lambda s: s._core.peek(0),
    "dock_events": lambda s: s._core.dock_events(),
}
CHANGES: dict[str, Callable[[cmrc.Simulation], Any]] = {
    "run": lambda s: s.run(),
    "run_until": lambda s: s.run_until(0.19),
    "at": lambda s: s.at(0.19, "fail", dsp=0),
    "profile": lambda s: s._core.profile(),
    "record": lambda s: s.record(),
    "register": lambda s: s.dsp(0).registers.__setitem__("R0", 1),
    "memory word": lambda s: s.dsp(0).memory.__setitem__(0x300000, 1),
}
ALL = {**READS, **CHANGES}


@functools.cache
def plain_hash() -> str:
    return cmrc.run(**SHORT).hash


@pytest.mark.parametrize("name", ALL)
def test_another_thread_is_refused_at_once_and_the_run_continues(name: str) -> None:
    """The run waits in its callback until the other thread has been answered."""
    simulation = cmrc.Simulation(**SHORT)
    dsp = simulation.dsp(0)  # held before: reading it is refused too
    refused: list[Exception] = []

    def other() -> None:
        for call in (ALL[name], lambda s: dsp.pc):
            try:
                call(simulation)
            except (RuntimeError, cmrc.ConfigError) as error:
                refused.append(error)

    def progress(simulated_s: float, duration_s: float) -> None:
        if not refused:
            thread = threading.Thread(target=other)
            thread.start()
            thread.join()

    result = simulation.run(progress)
    assert len(refused) == 2
    for error in refused:
        assert (
            type(error) is RuntimeError
            and "another thread is in Simulation.run" in str(error)
            and "wait for its end" in str(error)
        )
    assert result.stop_reason == "completed" and result.hash == plain_hash()


def test_a_run_without_callback_refuses_another_thread_too() -> None:
    simulation = cmrc.Simulation(**{**SHORT, "duration_s": 2.0})
    thread = threading.Thread(target=simulation.run)
    refused: list[str] = []
    thread.start()
    while thread.is_alive():
        try:
            simulation.result()
        except RuntimeError as error:
            refused.append(str(error))
    thread.join()
    assert refused and all("another thread is in Simulation." in text for text in refused)
    assert simulation.result().hash == cmrc.run(**{**SHORT, "duration_s": 2.0}).hash


def test_no_other_thread_comes_between_a_run_and_its_result() -> None:
    refused: list[str] = []

    class Asked(cmrc.Simulation):
        def other(self) -> None:
            with pytest.raises(RuntimeError) as found:
                super().result()
            refused.append(str(found.value))

        def result(self) -> cmrc.Result:
            thread = threading.Thread(target=self.other)
            thread.start()
            thread.join()
            return super().result()

    assert Asked(**SHORT).run().hash == plain_hash()
    assert len(refused) == 1 and "another thread is in Simulation.run" in refused[0]


@pytest.mark.parametrize("name", READS)
def test_a_callback_may_read(name: str) -> None:
    simulation = cmrc.Simulation(**SHORT)
    read: list[Any] = []
    result = simulation.run(lambda simulated_s, duration_s: read.append(READS[name](simulation)))
    assert len(read) == 10 and result.hash == plain_hash()


def test_what_a_callback_reads_is_of_that_instant() -> None:
    simulation = cmrc.Simulation(**SHORT)
    seen: list[tuple[float, float, str]] = []

    def progress(simulated_s: float, duration_s: float) -> None:
        result = simulation.result()
        seen.append((simulated_s, result.report["simulated_s"], result.stop_reason))

    simulation.run(progress)
    assert [of for of, _, _ in seen] == [of for _, of, _ in seen]
    assert [why for _, _, why in seen] == ["under_way"] * 9 + ["completed"]


@pytest.mark.parametrize("name", CHANGES)
def test_a_callback_may_not_change(name: str) -> None:
    simulation = cmrc.Simulation(**SHORT)
    refused: list[str] = []

    def progress(simulated_s: float, duration_s: float) -> None:
        with pytest.raises(
            RuntimeError, match="not from inside a callback of run; there only what reads is allowed"
        ) as found:
            CHANGES[name](simulation)
        refused.append(str(found.value))

    assert simulation.run(progress).hash == plain_hash()
    assert len(refused) == 10


def test_after_an_exception_in_a_callback_the_run_can_continue() -> None:
    simulation = cmrc.Simulation(**SHORT)

    def progress(simulated_s: float, duration_s: float) -> None:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        simulation.run(progress)
    assert simulation.result().stop_reason == "interrupted"
    assert simulation.run().hash == plain_hash()


def test_four_simulations_in_threads_are_what_they_are_alone() -> None:
    hashes: list[str] = []
    threads = [threading.Thread(target=lambda: hashes.append(cmrc.run(**SHORT).hash)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert hashes == [plain_hash()] * 4


@pytest.mark.parametrize(
    "call",
    [
        pytest.param(lambda s, d: d.go(0.19), id="go"),
        pytest.param(lambda s, d: d.back(), id="back"),
        pytest.param(lambda s, d: d.stop, id="stop"),
        pytest.param(lambda s, d: d.registers(chip=0), id="registers"),
        pytest.param(lambda s, d: d.on("claim"), id="on"),
        pytest.param(lambda s, d: s.result(), id="result"),
        pytest.param(lambda s, d: s.snapshot(), id="snapshot"),
        pytest.param(lambda s, d: s.run_until(0.19), id="run_until"),
    ],
)
def test_a_debugger_and_its_run_have_one_user(call: Callable[[cmrc.Simulation, Any], Any]) -> None:
    """The debugger waits in its output until the other thread has been answered."""
    simulation = cmrc.Simulation(**SHORT)
    debugger = simulation.debug()
    debugger.on("claim", log="claimed")
    refused: list[str] = []

    def other() -> None:
        with pytest.raises(RuntimeError) as found:
            call(simulation, debugger)
        refused.append(str(found.value))

    def heard(text: str) -> None:
        if not refused:
            thread = threading.Thread(target=other)
            thread.start()
            thread.join()

    debugger.on_output(heard)
    assert debugger.go(0.03).reason == "moved"
    assert len(refused) == 1 and "another thread is in" in refused[0] and "wait for its end" in refused[0]


def test_a_run_under_way_refuses_its_debugger() -> None:
    simulation = cmrc.Simulation(**SHORT)
    debugger = simulation.debug()
    with pytest.raises(RuntimeError, match="Simulation.debug: not from inside a callback of run"):
        simulation.run(lambda simulated_s, duration_s: debugger.go(0.19))


def test_a_crane_has_one_user() -> None:
    crane = cmrc.plant.Crane()
    steps = threading.Thread(target=crane.run, args=((100.0, 0, 0, 0, 0), 0.001, 3000))
    refused: list[str] = []
    steps.start()
    while steps.is_alive():
        for call in (lambda: crane.state, lambda: crane.step((0.0,) * 5, 0.0)):
            try:
                call()
            except RuntimeError as error:
                refused.append(str(error))
    steps.join()
    assert any("Crane.step: another thread is in Crane.run" in text for text in refused)
    alone = cmrc.plant.Crane()
    alone.run((100.0, 0, 0, 0, 0), 0.001, 3000)
    assert crane.state.q.tolist() == alone.state.q.tolist()
