"""The debugger over networks and the dock: one instant for all chips, what it shows, and that looking changes
nothing."""

import re
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import c40
from cmrc.debug import DebugError, Stop
from cmrc.network import Network, SharedMemory
from locations import AT_ONCE


def dock(duration_s: float = 0.2, dsps: int = 4, **settings: Any) -> cmrc.Simulation:
    return cmrc.Simulation(
        settings={"run.duration_s": duration_s, "machine.dsps": dsps, "report.reference": "none", **settings}
    )


def test_words_of_a_shared_memory_are_watched_whoever_touches_them() -> None:
    program = c40.assemble(
        """
        .text
start:  ldhi 0C000h,ar0
        ldi 3,ar1
loop:   sti ar1,*ar0
        ldi *ar0,r3
        subi 1,ar1
        cmpi 0,ar1
        bnz loop
end:    bu end
        """
    )
    memory = SharedMemory("table", 16, {0: 0xC0000000, 1: 0xC0000000})
    network = Network([program, program], memories=[memory])
    debugger = network.debug()
    debugger.watch(0xC0000000, on="access", chip=0)
    hits = []
    for stop in debugger.run():
        for hit in stop.hits:
            hits.append((hit.chip, "wrote" in hit.text))
            if "wrote" in hit.text:
                assert debugger.word(0xC0000000, chip=1) == hit.value
    assert sorted(hits) == [(chip, wrote) for chip in (0, 1) for wrote in (False, True) for _ in range(3)]
    writer = debugger.last_write(0xC0000000, chip=1)
    assert writer is not None and writer.value == 1


def test_a_condition_may_ask_for_a_word_that_other_chips_write() -> None:
    """Chip 0 counts in a shared word. Chip 1 goes round a loop, and stops there as soon as the word is 5; afterwards
    any word can be asked for."""
    counts = c40.assemble(
        "        .text\nstart:  ldhi 0C000h,ar0\n        ldi 0,r0\nloop:   addi 1,r0\n        sti r0,*ar0\n        b loop\n"
    )
    waits = c40.assemble("        .text\nstart:  ldi 0,r1\nround:  addi 1,r1\n        b round\n")
    network = Network([counts, waits], memories=[SharedMemory("table", 16, {0: 0xC0000000, 1: 0xC0000000})])
    debugger = network.debug()
    debugger.break_at("round", chip=1, condition="[0C0000000h] == 5")
    stop = next(debugger.run())
    assert [hit.chip for hit in stop.hits] == [1] and debugger.word(0xC0000000, chip=1) == 5
    assert debugger.value("[0C0000000h] + 1", chip=1) == 6


@pytest.mark.parametrize("asks", [0, 1])
def test_a_condition_may_ask_for_a_register_of_another_chip(asks: int) -> None:
    """Both count alike, and a round is shorter than ten cycles: the other's count is that of the same instant."""
    counts = c40.assemble("        .text\nstart:  ldi 0,r0\nround:  addi 1,r0\n        b round\n")
    debugger = Network([counts, counts]).debug()
    debugger.break_at("round", chip=asks, condition=f"chip{1 - asks}.r0 >= 30")
    stop = next(debugger.run())
    assert [hit.chip for hit in stop.hits] == [asks]
    assert [debugger.value(f"chip{chip}.r0") for chip in (0, 1)] == [30, 30]


@pytest.mark.parametrize(("dsps", "settings"), [(4, {}), (16, {"preset": "saturated"}), (2, {})])
def test_at_a_stop_the_dock_is_as_without_a_debugger(dsps: int, settings: dict[str, str]) -> None:
    preset = settings.get("preset")

    def make() -> cmrc.Simulation:
        return cmrc.Simulation(
            preset=preset,
            settings={
                "run.duration_s": 0.1,
                "machine.dsps": dsps,
                "report.reference": "none",
                "machine.boot": "preloaded",
                "host.start_ms": 0,
            },
        )

    run = make()
    debugger = run.debug()
    debugger.break_at("kernel_pid", ignore=3)
    debugger.on("claim", task="pid")
    debugger.watch("LIST_WORK_POINTER", on="change", ignore=30)
    debugger.watch("EXEC_BLOCK", chip=dsps - 1)
    reasons = set()
    for _ in range(12):
        stop = debugger.go(0.09)
        if not stop.hits:
            break
        reasons.add(stop.reason)
        alone = make()
        alone.run_until(stop.time_s)
        assert run._core.difference(alone._core) is None, stop
    assert {"watchpoint", "event"} <= reasons
    debugger.step_back()
    debugger.go_to(0.02)
    debugger.close()
    run.run()
    undisturbed = make()
    undisturbed.run()
    assert run.result().hash == undisturbed.result().hash


def test_an_instant_is_found_again_and_a_change_by_hand_begins_a_branch() -> None:
    run = dock()
    debugger = run.debug()
    printed: list[str] = []
    debugger.on_output(printed.append)
    first = debugger.go_to(0.05)
    here = debugger._core.state()
    debugger.go_to(0.11)
    debugger.go_to(0.05)
    assert debugger._core.state() == here and debugger.time_s == first.time_s
    scratch = debugger.places("SCRATCH")[0]
    debugger.set_word(scratch + 5, 1234, chip=3)
    assert "new branch" in printed[0] and debugger.word(scratch + 5, chip=3) == 1234
    changed = debugger._core.state()
    assert changed != here
    debugger.go_to(0.04)
    assert debugger.word(scratch + 5, chip=3) != 1234
    debugger.go_to(0.05)
    assert debugger._core.state() == changed


def test_a_miss_has_the_name_of_its_task(tmp_path: Path) -> None:
    """Late and dropped jobs, those of a user's task, too; numbers KIND_* of c40_programs/include/task_block.inc."""
    config = tmp_path / "own.toml"
    config.write_text(
        '[[tasks]]\nname = "own"\nprogram = "kernel_none"\nkind = 23\nimportance = 1\n'
        "period_ms = 1\ndeadline_ms = 0.125\n"
    )
    settings = {"run.duration_s": 0.1, "machine.dsps": 1, "report.reference": "none", **AT_ONCE}
    numbers = {"torque_compensation": "kind=5 ", "pid": "kind=6 ", "own": "kind=12 "}
    for task, number in numbers.items():
        debugger = cmrc.Simulation(config=config, settings=settings).debug()
        debugger.on("miss", task=task)
        stop = debugger.go(0.01)
        assert stop.hits and all(number in hit.text and hit.text.endswith(f" task={task}") for hit in stop.hits)
    debugger = cmrc.Simulation(config=config, settings=settings).debug()
    debugger.on("miss", task="obstacle_avoidance")
    assert not debugger.go(0.01).hits


def test_functions_are_called_at_stops_and_may_let_the_machine_continue() -> None:
    debugger = dock(**{"machine.boot": "preloaded", "host.start_ms": 0}).debug()
    number = debugger.on("claim", task="pid")
    seen: list[tuple[float, str]] = []

    def look(stop: Stop) -> bool:
        seen.append((stop.time_s, debugger.page("dsps")))
        return len(seen) < 5

    debugger.call(number, look)
    stop = debugger.go()
    assert len(seen) == 5 and stop.time_s == seen[-1][0]
    with pytest.raises(DebugError, match="no stop condition 99"):
        debugger.call(99, look)


def test_steps_by_claim_and_by_refresh_go_both_ways() -> None:
    debugger = dock(**{"machine.boot": "preloaded", "host.start_ms": 0}).debug()
    debugger.go_to(0.02)
    claims = [debugger.step("claim", chip=chip).time_ps for chip in (0, 0, 1)]
    assert claims == sorted(set(claims))
    assert debugger.step_back("claim", chip=0).time_ps in claims[:2]
    refresh = debugger.step("refresh")
    assert "refresh" in refresh.text
    following = debugger.step("refresh")
    assert 100_000_000 < following.time_ps - refresh.time_ps < 150_000_000
    assert debugger.step_back("refresh").time_ps == refresh.time_ps


def test_values_of_the_plant_stop_at_the_first_look_at_which_they_hold() -> None:
    debugger = dock(1.0).debug()
    moved = debugger.when("plant.sway_alpha_rad * plant.sway_alpha_rad > 1e-12")
    stop = debugger.go()
    assert stop.reason == "watchpoint"
    assert debugger.value("plant.sway_alpha_rad * plant.sway_alpha_rad > 1e-12")
    debugger.go_to_ps(stop.time_ps - 125_000_000)
    assert not debugger.value("plant.sway_alpha_rad * plant.sway_alpha_rad > 1e-12")
    debugger.remove(moved)
    debugger.when(f"1 / !(time_s > {stop.time_ps / 1e12 + 0.001}) > 1")
    with pytest.raises(ValueError, match=r'stop condition \d, "when 1 / .* > 1": a division by zero'):
        debugger.go()


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (lambda d: d.break_at("nowhere"), "is not a place"),
        (lambda d: d.break_at("pid.asm:99999"), "there is no instruction"),
        (lambda d: d.break_at("pid.asm:x"), "FILE:LINE is expected"),
        (lambda d: d.break_at(0x00500000), "no memory there"),
        (lambda d: d.break_at("kernel_pid", condition="r0 +"), "column 5"),
        (lambda d: d.break_at("kernel_pid", condition="r99 > 1"), "r99 is not a register"),
        (lambda d: d.break_at("kernel_pid", condition="(" * 500), "nested too deep"),
        (lambda d: d.break_at("kernel_pid", chip=9), "there is no chip 9"),
        (lambda d: d.on("nothing"), "is not an event"),
        (lambda d: d.on("\0"), r"^\\x00 is not an event"),
        (lambda d: d.break_at("\0"), r'^"\\x00" is not a place'),
        (lambda d: d.watch_register("IVTP"), "not a register that can be watched"),
        (lambda d: d.when("plant.nothing > 1"), "plant.nothing is not a register"),
        (lambda d: d.remove(7), "there is no stop condition 7"),
        (lambda d: d.step("out", chip=7), "there is no chip 7"),
        (lambda d: d.value("1 / 0"), "division by zero"),
        (lambda d: d.value("[0xD0000000]"), "nothing can be read"),
        (lambda d: d.set_word(0xD0000000, 1), "cannot be written|reserved"),
        (lambda d: d.set_register("R99", 1), "R99 is not a register"),
        (lambda d: d.set_register("AR0", 1.5), "holds integers"),
        (lambda d: d.set_register("R0", 1e300), "beyond what a register holds"),
        (lambda d: d.set_register("R0", 1 << 32), "does not fit into R0: 32 bits do"),
        (lambda d: d.set_register("AR0", 1 << 32), "does not fit into AR0"),
        (lambda d: d.set_register("pc", 1 << 32), "does not fit into pc"),
        (lambda d: d.set_register("R0", 1 << 63), "9223372036854775808 is not a number; .* of 64 bits at the most"),
        (lambda d: d.set_register("R0", "0x1p3"), "0x1p3 is not a number"),
        (lambda d: d.set_register("ST", -(1 << 31) - 1), "does not fit into ST"),
        (lambda d: d.page("nothing"), "is expected"),
    ],
)
def test_commands_that_make_no_sense_are_refused_and_change_nothing(command: Any, message: str) -> None:
    debugger = dock().debug()
    before = debugger._core.state()
    with pytest.raises(DebugError, match=message):
        command(debugger)
    assert debugger._core.state() == before and not debugger.hits()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7), ("(1 + 2) * 3", 9), ("10 - 4 - 3", 3), ("1 << 4 | 1", 17), ("7 & 3 ^ 1", 2), ("-5 / 2", -2), ("-5 % 3", -2), ("!0 && 1 || 0", 1), ("~0 == 0xFFFFFFFF", 1),
        ("0FFFFFFFFh == -1", 1), ("300000h", 0x300000), ("1.5 * 2", 3.0), ("2e-1 < 0.25", 1), ("3 > 2 == 1", 1), ("u(-1)", 0xFFFFFFFF), ("f(0x00400000)", 1.5), ("1 << 70", 0),
        ("kernel_pid == [kernel_pid] - [kernel_pid] + kernel_pid", 1), ("chip1.sp == dsp1.SP", 1), ("cause.execute == cycle - cycle", 1),
    ],
)  # fmt: skip
def test_expressions(text: str, value: float) -> None:
    assert dock().debug().value(text) == value


def test_an_expression_reads_an_extended_register_as_a_float_by_its_other_name() -> None:
    debugger = dock().debug()
    debugger.set_register("R3", -2.25)
    assert debugger.value("f3") == -2.25 and debugger.value("F3 * 2 < -4.25") == 1
    assert debugger.value("u(r3)") == 0xF0000000  # the mantissa: -2 + 0.875, without its exponent


@pytest.mark.parametrize(
    ("value", "bits"), [(-1.0, 0xFF_8000_0000), (-0.5, 0xFE_8000_0000), (-4.0, 0x01_8000_0000), (1.0, 0)]
)
def test_a_power_of_two_is_set_as_the_chip_has_it(value: float, bits: int) -> None:
    chip = c40.Processor(c40.assemble("        .text\nstart:  b start\n"))
    debugger = chip.debug()
    debugger.set_register("R3", value)
    assert debugger.value("f3") == value and chip.registers["R3"] & 0xFF_FFFF_FFFF == bits


def test_an_integer_that_is_set_leaves_the_exponent() -> None:
    debugger = dock().debug()
    debugger.set_register("R3", -2.25)
    debugger.set_register("R3", 0x40000000)
    assert debugger.value("f3") == 3.0  # 1.5 times 2 to the power that stood there


def test_words_up_to_the_end_of_memory_are_watched() -> None:
    program = c40.assemble("        .text\nstart:  ldi -1,ar0\n        sti ar0,*ar0\nend:    bu end\n")
    debugger = Network([program], memories=[SharedMemory("top", 16, {0: 0xFFFFFFF0})]).debug()
    debugger.watch(0xFFFFFFF0, 16)
    assert "wrote" in next(debugger.run()).hits[0].text
    with pytest.raises(DebugError, match="up to the end of memory"):
        debugger.watch(0xFFFFFFF0, 17)


def test_a_step_that_never_ended_leaves_no_stop_condition() -> None:
    program = c40.assemble(
        """
        .text
start:  ldhi 2Fh,sp
        or 0FB00h,sp
        ldi 0,r0
        call waits
        ldi 7,r1
end:    bu end
waits:  cmpi 0,r0
        bz waits
        rets
        """
    )
    debugger = Network([program]).debug()
    for _ in range(3):
        debugger.step()
    stopped = debugger.step("over")
    assert stopped.reason == "over" and "repeats a loop" in stopped.text
    debugger.go_to(1e-6)
    debugger.set_register("R0", 1)
    stopped = debugger.go()
    assert stopped.reason == "over" and "branches to itself" in stopped.text  # past the place behind the call


def test_the_pc_of_a_docks_dsp_is_set_between_its_instructions() -> None:
    """An idle DSP continues at its new place, looks for work, and rests again. In an access it cannot leave."""
    debugger = dock(0.03, 2, **{"machine.slots": 3}).debug()
    with pytest.raises(DebugError, match="the PC of DSP 2 cannot be set: no board is in the slot"):
        debugger.set_register("pc", "pc", chip=2)
    seen = set()
    for n in range(60):
        debugger.go_to(0.015 + n * 131e-6)
        for chip in (0, 1):
            idle = re.search(rf"^DSP {chip}: idle", debugger.page("dsps"), re.MULTILINE) is not None
            before = debugger.value("instructions", chip=chip)
            try:
                debugger.set_register("pc", "pc", chip=chip)
            except DebugError as error:
                assert str(error).endswith("waits for a bus or a link; its instruction has to end first (stepi)")
                assert not idle
                seen.add("in an access")
                continue
            if idle:
                debugger.step("instruction", chip=chip)
                assert debugger.value("instructions", chip=chip) == before + 1
                seen.add("idle")
    assert seen == {"in an access", "idle"}
    assert debugger.go().reason == "over"
    changed = debugger._core.state()
    debugger.go_to(0.015)
    debugger.go()
    assert debugger._core.state() == changed
