"""Snapshots as bytes, and what is refused: by name, and before anything is changed."""

import math
import os
import pickle
import random
import struct
import subprocess
import sys
import zlib

import pytest
from cmrc import _core, c40
from cmrc.network import Network
from locations import BUILD

COUNT = """        .text
start:  ldi 0,r0
        ldp @cell
again:  addi 1,r0
        sti r0,@cell
        br again
cell:   .word 0
"""


def counting(cycles=500):
    processor = c40.Processor(c40.assemble(COUNT))
    processor.run(cycles)
    return processor


def test_a_processor_goes_back():
    processor = counting()
    snapshot, before = processor.snapshot(), processor.registers["R0"]
    processor.run(300)
    there = processor.registers["R0"], processor.cycles, processor.instructions, processor.causes
    assert there[0] > before
    processor.restore(snapshot)
    assert processor.registers["R0"] == before and processor.snapshot() == snapshot
    processor.run(300)
    assert (processor.registers["R0"], processor.cycles, processor.instructions, processor.causes) == there


def test_two_futures_of_one_past():
    processor = counting()
    other = processor.fork()
    before = processor.registers["R0"]
    other.registers["R0"] = before + 1_000_000
    other.run(100)
    assert processor.registers["R0"] == before
    processor.run(100)
    assert processor.cycles == other.cycles
    assert before < processor.registers["R0"] == other.registers["R0"] - 1_000_000


def test_a_snapshot_is_bytes_and_can_be_pickled():
    snapshot = counting().snapshot()
    assert c40.ChipSnapshot.from_bytes(snapshot.to_bytes()) == snapshot == pickle.loads(pickle.dumps(snapshot))
    assert snapshot.kind == "processor"
    assert len(snapshot.to_bytes()) < 20_000  # three megawords of memory, of which hardly any page is used


def test_another_process_continues_from_a_file(tmp_path):
    processor = counting()
    (tmp_path / "state").write_bytes(processor.snapshot().to_bytes())
    (tmp_path / "count.asm").write_text(COUNT)
    script = f"""
from cmrc import _core, c40
processor = c40.Processor(c40.assemble_file({str(tmp_path / "count.asm")!r}))
processor.restore(c40.ChipSnapshot.from_bytes(open({str(tmp_path / "state")!r}, "rb").read()))
processor.run(1000)
print(processor.registers["R0"], processor.cycles, processor.causes)
"""
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python")}
    printed = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment
    ).stdout
    processor.run(1000)
    assert printed.strip() == f"{processor.registers['R0']} {processor.cycles} {processor.causes}"


def test_every_flipped_bit_and_every_cut_is_refused():
    sealed = counting().snapshot().to_bytes()
    rng = random.Random(1)
    for at in [*range(120), *rng.sample(range(len(sealed)), 300)]:
        damaged = bytearray(sealed)
        damaged[at] ^= 1 << rng.randrange(8)
        with pytest.raises(c40.SnapshotError, match=r"not a snapshot|version|cut short|damaged"):
            c40.ChipSnapshot.from_bytes(bytes(damaged))
    for length in [0, 1, 10, 11, 20, 35, 36, *rng.sample(range(len(sealed)), 100)]:
        with pytest.raises(c40.SnapshotError, match=r"not a snapshot|cut short"):
            c40.ChipSnapshot.from_bytes(sealed[:length])
    with pytest.raises(c40.SnapshotError, match="cut short or extended"):
        c40.ChipSnapshot.from_bytes(sealed + b"\0")


def test_another_version_is_refused_by_its_number():
    sealed = bytearray(counting().snapshot().to_bytes())
    at = len(b"CMRC state\n")
    sealed[at] += 1
    says = f"a snapshot of version {sealed[at]}; this emulator reads version {sealed[at] - 1}"
    with pytest.raises(c40.SnapshotError, match=says):
        c40.ChipSnapshot.from_bytes(bytes(sealed))


@pytest.mark.parametrize(
    ("processor", "message"),
    [
        (lambda: c40.Processor(c40.assemble(COUNT), board="flat"), "the board is not the same"),
        (lambda: c40.Processor(c40.assemble(COUNT.replace("addi 1", "addi 2"))), "the program is not the same"),
        (lambda: c40.Processor(), "the program is not the same"),
        (lambda: c40.Processor(c40.assemble(COUNT), checks=True), "with checks"),
    ],
)
def test_another_processor_refuses_and_is_as_before(processor, message):
    other = processor()
    other.run(10) if other.program else None
    before = other.cycles, other.registers["R0"], other.pc
    with pytest.raises(c40.SnapshotError, match=message):
        other.restore(counting().snapshot())
    assert (other.cycles, other.registers["R0"], other.pc) == before


def test_a_network_and_a_processor_refuse_each_others():
    network = Network(c40.assemble(COUNT), topology="ring:2")
    with pytest.raises(c40.SnapshotError, match="a snapshot of a network; one of a processor is expected"):
        counting().restore(network.snapshot())
    with pytest.raises(c40.SnapshotError, match="a snapshot of a processor; one of a network is expected"):
        network.restore(counting().snapshot())
    with pytest.raises(TypeError, match="snapshot"):
        network.restore("x")


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"topology": "ring:3"}, "number of chips"),
        ({"clocks_mhz": 50}, "the clock of chip 0 is not the same"),
        ({"boards": "flat"}, "the board of chip 0 is not the same"),
        ({"topology": "line:2"}, "the set of links is not the same"),
        ({"until": "again"}, "the program of chip 0 is not the same"),
    ],
)
def test_another_network_refuses(changed, message):
    program = c40.assemble(COUNT)
    snapshot = Network(program, topology="ring:2").snapshot()
    with pytest.raises(c40.SnapshotError, match=message):
        Network(program, **({"topology": "ring:2"} | changed)).restore(snapshot)


def smooth(count):
    """What a run records: places in nanometres, times that a clock gives with a jitter, and doubles that move
    little."""
    draw = random.Random(1)
    return [word for n in range(count) for word in (
        struct.pack("<d", int(2**30 * math.sin(n / 300)) / 2**30), struct.pack("<q", n * 500_000_123 + draw.randrange(1000)), struct.pack("<d", math.exp(n / 900)))]  # fmt: skip


def nasty(count):
    """Any bits, and doubles that have an other self: zeros of both signs, infinities, numbers that are none, the
    smallest ones."""
    draw = random.Random(2)
    doubles = [
        0.0,
        -0.0,
        math.inf,
        -math.inf,
        math.nan,
        5e-324,
        -5e-324,
        2.0**22,
        -(2.0**22),
        2.0**22 + 2.0**-30,
        2.0**-31,
        1e308,
    ]
    return [
        draw.choice(
            [
                struct.pack("<d", draw.choice(doubles)),
                draw.randbytes(8),
                struct.pack("<q", draw.choice([-1, 0, 1, 2**63 - 1, -(2**63)])),
            ]
        )
        for _ in range(3 * count)
    ]


# As numbers of 2^-30 they would not fit.
LARGE = [struct.pack("<d", 2.0**power) for power in range(60, 90)]


@pytest.mark.parametrize("words", [smooth(700), nasty(700), nasty(1), [struct.pack("<d", -0.0)] * 900, LARGE, []])
@pytest.mark.parametrize("columns", [1, 3])
def test_tables_come_back_from_a_file_bit_for_bit(words, columns):
    rows = b"".join(words)
    written, how = _core.to_columns(rows, columns)
    assert len(written) == len(rows) and len(how) == columns
    assert _core.from_columns(written, columns, how) == rows


def test_a_table_that_moves_smoothly_takes_little_room():
    rows = b"".join(smooth(20_000))
    assert len(zlib.compress(_core.to_columns(rows, 3)[0], 1)) < len(zlib.compress(rows, 1)) / 2.5


def test_a_column_that_is_written_in_no_known_way_is_refused():
    for how in (b"\xff", b""):
        with pytest.raises(c40.SnapshotError, match="the snapshot is damaged: "):
            _core.from_columns(bytes(8), 1, how)


def test_a_fork_of_a_network_has_its_past_and_its_own_future():
    ring = Network(
        [c40.assemble("        .text\nstart:  addi 1,r5\n        b start\n")] * 2, links=["0.3:1.0"], turn_order=3
    )
    ring.run(max_cycles=100)
    other = ring.fork()
    assert other.snapshot() == ring.snapshot()
    ring.hold(0, at_us=20)
    ring.run(until_us=40), other.run(until_us=40)
    assert ring.chips[0].status == "held" and other.chips[0].status == "running"
    assert other.chips[1].registers["R5"] == ring.chips[1].registers["R5"] > 100
