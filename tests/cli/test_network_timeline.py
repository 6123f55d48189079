"""`emulator exec --perfetto`: the links and FIFOs of a network, against its own counters."""

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
import timeline
from locations import BUILD, ROOT

EMULATOR = BUILD / "bin" / "emulator"
NETWORKS = ROOT / "c40_programs" / "examples" / "networks"


def execute(folder: Path, *arguments: object) -> tuple[timeline.Timeline, Any]:
    done = subprocess.run(
        [EMULATOR, "exec", *map(str, arguments), "--json", "--perfetto", "t.gz"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    drawn = timeline.read(folder / "t.gz")
    timeline.check_order(drawn)
    return drawn, json.loads(done.stdout)


def last(drawn: timeline.Timeline, track: int) -> float:
    return drawn.values[track][-1][1] if drawn.values[track] else 0


@pytest.mark.parametrize("cut", [(), ("--action", "6,cut,1.0:2.3")])
def test_words_and_fifos_are_those_of_the_counters(tmp_path: Path, cut: tuple[str, ...]) -> None:
    drawn, report = execute(tmp_path, NETWORKS / "ring.asm", "--topology", "ring:4", *cut)
    words = 0
    for link in report["links"]:
        for way, ends in ((link["forth"], (link["a"], link["b"])), (link["back"], (link["b"], link["a"]))):
            name = " > ".join(ends)
            arrived = [one for one in drawn.instants if one.track == drawn.track("links", name)]
            assert len(arrived) == way["arrived"]
            values = [value for _, value in drawn.values[drawn.track("links", f"on the way {name}")]]
            assert all(value >= 0 for value in values)
            chip, port = map(int, ends[0].split("."))
            assert last(drawn, drawn.track("links", f"on the way {name}")) == way["under_way"] + len(
                report["chips"][chip]["ports"][port]["output"]
            )
            words += len(arrived)
    assert words > 0
    for n, chip in enumerate(report["chips"]):
        for track in drawn.below(f"chip {n}"):
            if "FIFO" in drawn.paths[track][1]:
                port = chip["ports"][int(drawn.paths[track][1].split()[-1])]
                assert last(drawn, track) == len(port["input"])
                assert all(value >= 0 for _, value in drawn.values[track])


def test_dma_blocks_and_interrupts_are_drawn(tmp_path: Path) -> None:
    program = NETWORKS / "bandwidth_dma.asm"
    drawn, report = execute(tmp_path, program, program, "--link", "0.0:1.3")
    blocks = [
        one for track in drawn.below("chip 0") for one in drawn.slices[track] if drawn.paths[track][1].startswith("DMA")
    ]
    taken = [
        one
        for one in drawn.instants
        if drawn.paths[one.track] == ("chip 0", "interrupts and timers") and one.name == "interrupt"
    ]
    assert len(blocks) >= 9 and len(taken) >= 9
    assert sum(chip["causes"]["interrupt"] for chip in report["chips"]) > 0


def test_drawing_changes_nothing(tmp_path: Path) -> None:
    program = [EMULATOR, "exec", NETWORKS / "ring.asm", "--topology", "ring:4", "--json"]
    without = subprocess.run(program, cwd=tmp_path, capture_output=True, check=True).stdout
    drawn = subprocess.run([*program, "--perfetto", "t"], cwd=tmp_path, capture_output=True, check=True).stdout
    events = json.loads(without)["events"]
    assert json.loads(drawn)["chips"] == json.loads(without)["chips"] and events == []


def test_one_chip_has_no_links_to_draw(tmp_path: Path) -> None:
    (tmp_path / "s.asm").write_text("        .text\n_start: b _start\n")
    done = subprocess.run(
        [EMULATOR, "exec", "s.asm", "--perfetto", "t"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and "--perfetto: draws the links of a network" in done.stderr
    assert not (tmp_path / "t").exists()


def test_an_output_is_no_other_one(tmp_path: Path) -> None:
    arguments = [NETWORKS / "ring.asm", "--topology", "ring:4", "--perfetto", "t", "--link-trace", "t"]
    done = subprocess.run([EMULATOR, "exec", *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "--link-trace" in done.stderr and not (tmp_path / "t").exists()


# A program that waits long enough for what its pins are sent.
WAITS = "        .text\nstart:  ldi 100,ar0\nw:      db ar0,w\n        nop\ndone:   b done\n"


@pytest.mark.parametrize(
    ("actions", "levels"),
    [
        ([], [(0, 1)]),
        (["1,pulse,index,0.5"], [(0, 1), (1000, 0), (1500, 1)]),
        (["0,low,index", "1.5,high,index"], [(0, 0), (1500, 1)]),
        (["2,low,index"], [(0, 1), (2000, 0)]),
    ],
)
def test_a_net_is_high_until_it_falls(tmp_path: Path, actions: list[str], levels: list[tuple[int, int]]) -> None:
    (tmp_path / "wait.asm").write_text(WAITS)
    drawn, _ = execute(
        tmp_path, "wait.asm", "--net", "index: >0.IIOF2", *(word for one in actions for word in ("--action", one))
    )
    assert drawn.values[drawn.track("net index")] == levels
