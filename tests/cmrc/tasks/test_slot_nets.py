"""Nets between pins of the dock's DSPs (docs/add-a-task.md, Pins): edges, when they are seen, and what changes
nothing."""

import json
import random
import shutil
from pathlib import Path
from typing import Any

import cmrc
import pytest
from locations import ROOT
from own_dsp_run import toml_of
from slot_scenes import area_of, check_cuts_orders_and_snapshots

# The one lets timer 0 give pulses at TCLK0, PERIOD ticks apart, and makes IIOF1 an output that changes at each job. The
# other's timer 1 counts the pulses; it keeps what it has counted, and the level of its IIOF2 (FLAG is bit 10 of IIF).
KERNELS = """
kernel_gives:
        ldhi    0010h, ar0
        ldi     *ar6, r2
        bnz     gives_on
        ldi     @TASK + TB_ARGUMENT, r3
        sti     r3, *+ar0(28h)
        ldi     2c1h, r3                ; pulse mode, own clock, GO: TCLK0 is its output
        sti     r3, *+ar0(20h)
        or      20h, iif                ; IIOF1 is an output, and low
gives_on:
        xor     40h, iif
        addi    1, r2
        sti     r2, *ar6
        ldi     r2, r0
        ldi     0, r1
        rets
kernel_takes:
        ldhi    0010h, ar0
        ldi     *ar6, r2
        bnz     takes_on
        ldhi    0ffffh, r3
        sti     r3, *+ar0(38h)
        ldi     0c1h, r3                ; counts edges of TCLK1
        sti     r3, *+ar0(30h)
takes_on:
        ldi     *+ar0(34h), r3
        sti     r3, *+ar6(1)
        ldi     iif, r3
        and     400h, r3
        sti     r3, *+ar6(2)
        addi    1, r2
        sti     r2, *ar6
        ldi     r2, r0
        ldi     0, r1
        rets
kernel_resets:
        ldi     *ar6, r2
        addi    1, r2
        sti     r2, *ar6
        or      20h, iif                ; an output, which takes the level that the pin has
        or      40h, iif                ; high, but low from the first job to the second
        cmpi    1, r2
        bhi     resets_end
        andn    40h, iif
resets_end:
        ldi     r2, r0
        ldi     0, r1
        rets
kernel_pulls:
        ldi     *ar6, r2
        addi    1, r2
        sti     r2, *ar6
        mpyi    37, r2                  ; the pin goes low at another instant of each job
        and     1ffh, r2
        or      20h, iif
        or      40h, iif
pulls_high:
        subi    1, r2
        bnn     pulls_high
        andn    40h, iif
        ldi     32, r2
pulls_low:
        subi    1, r2
        bnn     pulls_low
        or      40h, iif
        ldi     0, r0
        ldi     0, r1
        rets
kernel_writes:
        ldi     300, r2
writes_on:
        ldi     *ar6, r3
        addi    1, r3
        sti     r3, *ar6
        sti     r3, *+ar6(1)
        subi    1, r2
        bnn     writes_on
        ldi     0, r0
        ldi     0, r1
        rets
"""
PERIOD, CYCLE = 100, 40_000  # ticks of two cycles; ps at 25 MHz
NETS = "pulses: 0.TCLK0>1.TCLK1, flag: 0.IIOF1>1.IIOF2"


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("nets") / "programs"
    shutil.copytree(ROOT / "c40_programs", directory)
    (directory / "kernels" / "user.asm").write_text(KERNELS)
    return directory


def rows(*names: str, period_ms: int = 5) -> list[dict[str, Any]]:
    common = {"importance": 0x7000, "period_ms": period_ms, "deadline_ms": min(4, period_ms), "argument": PERIOD}
    return [common | {"name": name, "program": f"kernel_{name}", "dsp": dsp} for dsp, name in enumerate(names)]


def simulation(
    programs: Path,
    tmp_path: Path,
    *names: str,
    nets: str = NETS,
    duration_s: float = 0.1,
    period_ms: int = 5,
    **settings: Any,
) -> cmrc.Simulation:
    config = tmp_path / "nets.toml"
    config.write_text(toml_of(rows(*(names or ("gives", "takes")), period_ms=period_ms)))
    given = {"machine.programs": str(programs), "machine.nets": nets, "report.reference": "none", **settings}
    return cmrc.Simulation(config=config, dsps=2, duration_s=duration_s, settings=given)


def test_a_timer_of_one_counts_pulses_of_another(programs: Path, tmp_path: Path) -> None:
    run = simulation(programs, tmp_path)
    report = run.run().report
    pulses, flag = report["nets"]
    assert (pulses["name"], pulses["pins"]) == ("pulses", "0.TCLK0>1.TCLK1") and pulses["missed"] == flag["missed"] == 0
    jobs = run.peek(area_of(0))
    assert flag["edges"] - jobs in (0, 1)  # at rest it is high: the first job pulls it low and lets it go up at once
    # From the first job on, a pulse of one cycle every 200; the last job reads the counter up to 5 ms before the end.
    started = report["tasks"]["user.gives"]["released"]
    counted, whole, each = run.peek(area_of(1) + 1), pulses["edges"] // 2, 2 * PERIOD * CYCLE
    assert abs(whole - 5e9 * started / each) < 5e9 / each
    assert whole - 5e9 / each - 1 <= counted <= whole


@pytest.mark.parametrize(
    "seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(2, 20))]
)
def test_cuts_turn_orders_and_snapshots_change_nothing(programs: Path, tmp_path: Path, seed: int) -> None:
    rng = random.Random(seed)
    at = rng.uniform(0.02, 0.04)

    def scene(order: int) -> cmrc.Simulation:
        made = simulation(programs, tmp_path, duration_s=0.06, **{"run.turn_order": order})
        made.at(at, "reset", dsp=seed % 2)
        return made

    whole = check_cuts_orders_and_snapshots(scene, rng, seed, 0.06, at, cuts=8)
    # DSP 0 gives an edge every 4 us from its first job on, which comes before 26 ms; not after a reset of its own.
    until = at if seed % 2 == 0 else 0.06
    assert whole["nets"][0]["edges"] >= (until - 0.026) / (PERIOD * CYCLE * 1e-12)


def test_a_pin_resets_another_dsp(programs: Path, tmp_path: Path) -> None:
    run = simulation(programs, tmp_path, "resets", "takes", nets="reset: 0.IIOF1>1.RESET")
    report = run.run().report
    assert report["nets"][0]["edges"] == 2 and report["nets"][0]["level"] == 1
    # The DSP was in a block. The host knows nothing of the pin, but the DSP asks for its program: it is not reset again
    # when the block does not continue.
    _first, by_pin = report["dsps"][1]["boots"]
    assert len(report["dsps"][0]["boots"]) == 1 and by_pin["reset_at_s"] > 0.02 and by_pin["boot_s"] is not None


def test_a_pin_resets_another_dsp_at_many_instants_of_its_accesses(programs: Path, tmp_path: Path) -> None:
    def scene(order: int) -> cmrc.Simulation:
        return simulation(
            programs,
            tmp_path,
            "pulls",
            "writes",
            nets="reset: 0.IIOF1>1.RESET",
            duration_s=0.04,
            period_ms=1,
            **{"run.turn_order": order},
        )

    whole = check_cuts_orders_and_snapshots(scene, random.Random(7), 7, 0.04, 0.03, cuts=20)
    assert whole["nets"][0]["edges"] > 24 and len(whole["dsps"][1]["boots"]) > 12


def test_nets_that_are_not_used_change_nothing(tmp_path: Path) -> None:
    """The hash has the net's state in it, and so the configuration; all else is equal."""
    reports = [
        cmrc.Simulation(dsps=2, duration_s=0.1, settings={"machine.nets": nets, "report.reference": "none"})
        .run()
        .report
        for nets in ("", NETS)
    ]
    for report in reports:
        for key in ("hash", "elapsed_s", "nets", "configuration", "configuration_toml"):
            report.pop(key, None)
    assert json.dumps(reports[0], sort_keys=True) == json.dumps(reports[1], sort_keys=True)


@pytest.mark.parametrize(
    ("nets", "says"),
    [
        ("0.TCLK0>1.IIOF0", "IIOF0 of every DSP is the host's doorbell; IIOF1 to IIOF3 are free"),
        ("0.TCLK0>2.IIOF1", "there is no chip 2; 0 or 1 is expected"),
        (">1.IIOF1", "no pin drives it"),
        ("0.TCLK0+0.TCLK1>1.IIOF1", "two pins drive it"),
        ("0.TCLK0", "DRIVER>RECEIVER is expected"),
        ("0.TCLK0>1.IIOF1, 0.TCLK1>1.IIOF1", "pin 1.IIOF1 is already on net 0"),
        ("0.RESET>1.IIOF1", "0.RESET cannot drive it"),
        ("0.TCLK0>1.IIOF1,", "DRIVER>RECEIVER is expected"),
    ],
)
def test_nets_that_cannot_be_are_refused(nets: str, says: str) -> None:
    with pytest.raises(ValueError, match="machine.nets") as refused:
        cmrc.Simulation(dsps=2, settings={"machine.nets": nets})
    assert says in str(refused.value)
