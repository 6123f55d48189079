"""Links between the dock's DSPs (docs/add-a-task.md, Links between DSPs): words, cuts, what is lost, and what changes
nothing."""

import random
import shutil
from pathlib import Path
from typing import Any

import cmrc
import pytest
from locations import AT_ONCE, ROOT
from own_dsp_run import toml_of
from slot_scenes import area_of, check_cuts_orders_and_snapshots

# What both programs end with: jobs so far in word 0 of the area, and their result in word 1.
LINK_END = """
link_end:
        sti     r4, *+ar6(1)
        ldi     *ar6, r2
        addi    1, r2
        sti     r2, *ar6
        ldi     r4, r0
        ldi     0, r1
        rets
"""

# The one sends the words n, n - 1, ..., 1 over port 0, and the other answers each k over port 4 by 2 k + 1.
KERNELS = """
kernel_ask:
        ldhi    0010h, ar0
        or      0040h, ar0
        ldi     @TASK + TB_ARGUMENT, r3
        ldi     0, r4
ask_next:
        sti     r3, *+ar0(2)
        addi    *+ar0(1), r4
        subi    1, r3
        bnz     ask_next
        br      link_end
kernel_answer:
        ldhi    0010h, ar0
        or      0080h, ar0
        ldi     @TASK + TB_ARGUMENT, r3
        ldi     0, r4
answer_next:
        ldi     *+ar0(1), r5
        addi    r5, r4
        ash     1, r5
        addi    1, r5
        sti     r5, *+ar0(2)
        subi    1, r3
        bnz     answer_next
        br      link_end
"""

# The one's DMA 0 sends 24 words, and the other's DMA 4 takes them, while both processors read shared memory all the
# time.
DMA_KERNELS = """
kernel_ask:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(SCRATCH), ar1
        ldi     ar1, r6
        ldi     24, rc
        subi    1, rc
        ldi     0, r4
        rptb    ask_filled
        addi    3, r4
ask_filled:
        sti     r4, *ar1++
        ldhi    0010h, ar2
        or      00A0h, ar2
        ldi     1, r7
        ldi     r6, r9
        ldhi    0010h, r10
        or      0042h, r10              ; output FIFO of port 0
        ldi     0, r11
        ldi     4, die                  ; write synchronised by OCRDY0
        ldi     80h, r8
        call    dma_runs
        ldi     0, r4
        br      link_end
kernel_answer:
        ldhi    0010h, ar2
        or      00E0h, ar2
        ldhi    hi16(SCRATCH), r10
        or      lo16(SCRATCH), r10
        ldi     1, r11
        ldhi    0010h, r9
        or      0081h, r9               ; input FIFO of port 4
        ldi     0, r7
        ldhi    10h, die                ; read synchronised by ICRDY4
        ldi     40h, r8
        call    dma_runs
        ldhi    hi16(SCRATCH), ar1
        or      lo16(SCRATCH), ar1
        ldi     23, rc
        ldi     0, r4
        rptb    answer_summed
answer_summed:
        addi    *ar1++, r4
        br      link_end

; AR2 channel, R9 source, R7 its index, R10 destination, R11 its index, R8 the way of synchronisation.
dma_runs:
        sti     r9, *+ar2(1)
        sti     r7, *+ar2(2)
        ldi     24, r5
        sti     r5, *+ar2(3)
        sti     r10, *+ar2(4)
        sti     r11, *+ar2(5)
        ldhi    00C0h, r5               ; START
        or      4, r5                   ; stop at the end
        or      r8, r5
        sti     r5, *ar2
dma_left:
        ldi     *ar6, r5                ; shared memory
        sti     r5, *+ar6(2)
        ldi     *+ar2(3), r5
        bnz     dma_left
        ldi     0, die
        rets
"""
WORDS = 40


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return programs_with(KERNELS, tmp_path_factory.mktemp("links") / "programs")


@pytest.fixture(scope="module")
def dma_programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return programs_with(DMA_KERNELS, tmp_path_factory.mktemp("dma") / "programs")


def programs_with(kernels: str, directory: Path) -> Path:
    shutil.copytree(ROOT / "c40_programs", directory)
    (directory / "kernels" / "user.asm").write_text(kernels + LINK_END)
    return directory


def rows(**fields: Any) -> list[dict[str, Any]]:
    common = {"importance": 0x7000, "period_ms": 5, "deadline_ms": 4, "argument": WORDS} | fields
    return [
        common | {"name": name, "program": f"kernel_{name}", "dsp": dsp} for name, dsp in (("ask", 0), ("answer", 1))
    ]


def simulation(
    programs: Path, tmp_path: Path, duration_s: float = 0.1, dsps: int = 2, links: str = "0.0:1.4", **settings: Any
) -> cmrc.Simulation:
    config = tmp_path / "links.toml"
    config.write_text(toml_of(rows()))
    given = {"machine.programs": str(programs), "machine.links": links, "report.reference": "none", **settings}
    return cmrc.Simulation(config=config, dsps=dsps, duration_s=duration_s, settings=given)


def test_words_go_over_the_link_both_ways_and_are_counted(programs: Path, tmp_path: Path) -> None:
    run = simulation(programs, tmp_path)
    report = run.run().report
    jobs = [report["tasks"][f"user.{name}"]["response_ps"]["count"] for name in ("ask", "answer")]
    assert min(jobs) >= 15 and report["tasks"]["user.ask"]["misses"] == 0
    (link,) = report["links"]
    forth, back = link["directions"]
    assert (forth["from"], forth["to"], back["from"], back["to"]) == ("0.0", "1.4", "1.4", "0.0")
    assert WORDS * jobs[0] <= forth["arrived"] <= forth["sent"] <= WORDS * (jobs[0] + 1)
    assert WORDS * jobs[1] <= back["sent"] <= WORDS * (jobs[1] + 1)
    assert forth["lost"] == forth["discarded"] == back["lost"] == back["discarded"] == 0
    assert link["joined"] == 1 and not link["is_cut"]
    # A word takes 5 cycles and each way 1 to be seen at either end (docs/networks.md): 2 x 7 of 40 ns at 25 MHz, and
    # nothing may take no time. So ask runs at least so long.
    assert report["tasks"]["user.ask"]["response_ps"]["best"] > WORDS * 14 * 40_000
    causes = report["tasks"]["user.ask"]["execution_cycles"]
    assert causes["comm_port"] > 0


def test_dma_moves_words_while_the_processors_wait_for_the_bus(dma_programs: Path, tmp_path: Path) -> None:
    run = simulation(dma_programs, tmp_path)
    report = run.run().report
    jobs = report["tasks"]["user.answer"]["response_ps"]["count"]
    forth, back = report["links"][0]["directions"]
    assert jobs >= 15 and forth["arrived"] in (24 * jobs, 24 * (jobs + 1)) and back["sent"] == 0
    assert run.peek(area_of(1) + 1) == sum(range(3, 73, 3))
    assert report["tasks"]["user.answer"]["execution_cycles"]["bus_transfer"] > 0


@pytest.mark.parametrize(
    "seed", [*range(4), *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(4, 40))]
)
def test_cuts_turn_orders_and_snapshots_change_nothing(
    programs: Path, dma_programs: Path, tmp_path: Path, seed: int
) -> None:
    """With a DSP that is reset in the middle: the wires are cut and joined again."""
    rng = random.Random(seed)
    programs = dma_programs if seed % 2 else programs
    at = rng.uniform(0.02, 0.04)

    def scene(order: int) -> cmrc.Simulation:
        made = simulation(programs, tmp_path, duration_s=0.08, **{"run.turn_order": order})
        made.at(at, "reset", dsp=1)
        return made

    whole = check_cuts_orders_and_snapshots(scene, rng, seed, 0.08, at, cuts=12)
    assert whole["links"][0]["joined"] >= 2


def test_a_partner_that_dies_is_a_cut_link_until_it_runs_again(programs: Path, tmp_path: Path) -> None:
    """DSP 1 fails for good while it answers, its board is pulled and another is put in: the asking DSP waits at its
    port, is taken for hung by the watchdog and reset; then both work again."""
    run = simulation(programs, tmp_path, duration_s=0.6)
    run.at(0.1013, "fail", dsp=1)
    run.at(0.11, "unplug", dsp=1)
    run.at(0.12, "plug", dsp=1)
    run.run_until(0.115)
    (link,) = run.result().report["links"]
    assert link["is_cut"]
    before = link["directions"][0]["arrived"]
    report = run.run().report
    (link,) = report["links"]
    assert not link["is_cut"] and link["joined"] >= 2 and link["directions"][0]["arrived"] > before
    assert report["tasks"]["user.ask"]["misses"] > 0
    for way in link["directions"]:
        assert way["sent"] - way["arrived"] - way["lost"] in range(9)  # under way


def test_a_wait_for_a_word_that_never_comes_is_in_every_account(programs: Path, tmp_path: Path) -> None:
    """The DSP still waits at the end: its cycles are those of the whole time, and the wait has its name in the report,
    in the chain of the miss and in the profile."""
    config = tmp_path / "answer.toml"
    config.write_text(toml_of([row for row in rows(period_ms=1, deadline_ms=0.1) if row["name"] == "answer"]))
    settings = {"machine.programs": str(programs), "machine.links": "0.0:1.4", "report.reference": "none", **AT_ONCE}
    result = cmrc.run(config=config, dsps=2, duration_s=0.0035, settings=settings, profile=True)
    report, dsp = result.report, result.report["dsps"][1]
    assert dsp["cycles"] == sum(dsp["causes"].values()) == 87_500  # 3.5 ms at 25 MHz
    (miss,) = [miss for miss in report["misses"] if miss["kind"] == "user.answer"]
    ran_ps, waited_ps = miss["end_ps"] - miss["runs"][0]["claimed_ps"], dsp["causes"]["comm_port"] * 40_000
    assert miss["outcome"] == "unfinished" and ran_ps > 2 * 10**9
    assert ran_ps - 10**7 < waited_ps < ran_ps
    assert miss["parts_ps"]["execution.comm_port"] == pytest.approx(waited_ps, rel=0.001)
    assert result.profile is not None
    profile = result.profile.data
    assert profile["cycles"] == sum(one["cycles"] for one in report["dsps"])
    (unfinished,) = [group for group in profile["groups"] if group["name"] == "not finished"]
    assert unfinished["causes"]["comm_port"] == dsp["causes"]["comm_port"]


@pytest.mark.parametrize(
    ("links", "says"),
    [
        ("0.0:1.3", "port 3 of every DSP is linked to the link adapter"),
        ("0.0:2.4", "there is no slot 2; the last is 1"),
        ("0.0:1.1", "one of ports 0, 1, 2, which begin with the token"),
        ("0.4:1.5", "one of ports 0, 1, 2, which begin with the token"),
        ("0.0:0.4", "both ends are in slot 0"),
        ("0.0:1.4, 0.0:1.5", "port 0.0 already has a link"),
        ("0.0", "SLOT.PORT:SLOT.PORT is expected"),
        ("0.0:1.4:2.5", "SLOT.PORT:SLOT.PORT is expected"),
        ("0.0:1.6", "a DSP has no port 6"),
        ("0.0:99.4", "there is no slot 99; the last is 1"),
    ],
)
def test_links_that_cannot_be_are_refused(links: str, says: str) -> None:
    with pytest.raises(ValueError, match="machine.links") as refused:
        cmrc.Simulation(dsps=2, settings={"machine.links": links})
    assert says in str(refused.value)
