"""16,000 single instructions against two other C3x cores, one of them checked against a VC33 board."""

import lzma
from pathlib import Path

import vectors
from cmrc._core import c40

DATA = Path(__file__).parent / "data" / "c3x-common-vectors.txt.xz"


def test_every_common_vector_agrees() -> None:
    processor = c40.Processor("flat")
    failures = []
    count = 0
    with lzma.open(DATA, "rt") as lines:
        for line in lines:
            count += 1
            found = vectors.differences(processor, vectors.parse(line))
            if found:
                failures.append((line.split()[0], found, line))
    assert count == 16000
    assert not failures, f"{len(failures)} lines differ; the first: {failures[:5]}"


def test_the_runner_sees_a_wrong_register_flag_and_word() -> None:
    processor = c40.Processor("flat")
    line = (
        "id=x m=7f R0=0000000001 R1=0000000002 AR0=00002000 ST=00000000 @2000=00000007 op=02600001"
        " -> PC=001001 R0=0000000003 ST=00000001 @2000=00000008"
    )
    found = vectors.differences(processor, vectors.parse(line))
    assert [entry.split(":")[0] for entry in found] == ["R0", "ST", "@002000"]
