"""A DSP's accesses through its windows: values, order, time."""

import pytest
from cmrc._core import plant
from cmrc_test import machine
from programs import MS, ON_CHIP, US, assemble, config


def run(body: str, time: int = 100 * US, **options: object) -> machine.Machine:
    result = machine.Machine(assemble(body), config(dsps=1), record=True, **options)
    result.run_until(time)
    return result


def transactions(m: machine.Machine, bus: int) -> list[tuple[int, int, int]]:
    """(address, words, write) of each on the bus."""
    return [(v[2], v[3], v[4]) for _, what, v in m.events if what == "transaction" and v[0] == bus]


def test_what_is_written_is_read_back() -> None:
    m = run("""
        ldi     5, r0
        sti     r0, *ar0
        ldi     *ar0, r1
        addi    1, r1
        sti     r1, *+ar0(1)
        ldi     *+ar0(1), r2
        sti     r2, *ar3
    """)
    assert (m.peek(0), m.peek(1), m.chip_word(0, ON_CHIP)) == (5, 6, 6)
    assert transactions(m, 0) == [(0, 1, 1), (0, 8, 0), (1, 1, 1), (1, 7, 0)]


def test_a_read_waits_for_the_posted_writes_before_it() -> None:
    m = run(
        "        ldi     100, r0\n"
        + "".join(f"        sti     r0, *+ar0({20 - 2 * i})\n        addi    1, r0\n" for i in range(8))
        + "        ldi     *+ar0(6), r1\n        sti     r1, *ar3\n"
    )
    assert [m.peek(20 - 2 * i) for i in range(8)] == list(range(100, 108))
    assert m.chip_word(0, ON_CHIP) == 107
    assert transactions(m, 0)[-1] == (6, 2, 0)


def test_rising_writes_combine_into_bursts() -> None:
    m = run(
        "        ldi     40, r0\n"
        + "".join(f"        sti     r0, *+ar0({i})\n        addi    1, r0\n" for i in range(40))
    )
    assert [m.peek(i) for i in range(40)] == list(range(40, 80))
    bursts = transactions(m, 0)
    assert sum(words for _, words, _ in bursts) == 40 and len(bursts) < 20


def test_falling_writes_fill_the_fifo_and_the_chip_stalls() -> None:
    """Each is a transaction of 5 clocks, 150 ns; the chip makes one in 120 ns at most: 40 of them cannot all wait in 8
    words."""
    m = run("        ldi     40, r0\n" + "".join(f"        sti     r0, *+ar0({40 - i})\n" for i in range(40)))
    assert [m.peek(40 - i) for i in range(40)] == [40] * 40
    assert len(transactions(m, 0)) == 40
    assert m.causes(0)["bus_transfer"] > 20
    landed = [(v[2], v[4], time) for time, what, v in m.events if what == "write"]
    assert [offset for offset, _, _ in landed] == [40 - i for i in range(40)]
    for i in range(9, 40):  # write i is issued when write i - 1 has been taken, so write i - 9 has left
        assert landed[i][1] >= landed[i - 9][2]


def test_the_line_serves_the_reads_that_follow_and_goes_with_a_write() -> None:
    m = machine.Machine(
        assemble(
            "".join(f"        ldi     *+ar0({i}), r{i & 3}\n        addi    r{i & 3}, r4\n" for i in range(16))
            + "        sti r4, *ar3\n"
        ),
        config(dsps=1),
        record=True,
    )
    for i in range(16):
        m.poke(i, 3**i)
    m.run_until(100 * US)
    assert m.chip_word(0, ON_CHIP) == sum(3**i for i in range(16)) & 0xFFFFFFFF
    assert transactions(m, 0) == [(0, 8, 0), (8, 8, 0)]
    assert m.statistics(0).prefetch_hits == 14
    dropped = run("        ldi *ar0, r0\n        sti r0, *+ar0(100)\n        ldi *+ar0(1), r0\n")
    assert transactions(dropped, 0) == [(0, 8, 0), (100, 1, 1), (1, 7, 0)]


def test_the_cost_of_one_read_by_hand() -> None:
    """A semaphore: 2 clocks in, grant elsewhere 2, address 1, devsel 2, W_i 3, data, 2 clocks back, on clocks of 30 ns;
    the chip counts 40 ns."""
    m = run("        ldi     *ar1, r0\n")
    (event,) = [v for _, what, v in m.events if what == "transaction"]
    requested, framed, ended = event[6:9]
    assert framed - requested == 2  # bus A is parked on the host
    assert ended - framed == 1 + 2 + 3
    causes = m.causes(0)
    waited = causes["bus_arbitration"] + causes["bus_transfer"]
    # from the access to 2 clocks after the data: 2 + 2 + 6 + 2 clocks = 360 ns, and up to a clock and a cycle of
    # alignment
    assert 360 <= waited * 40 < 360 + 30 + 40
    assert causes["bus_arbitration"] == 2 * 30 // 40


def test_semaphores_doorbell_and_fence_as_registers() -> None:
    m = run(
        """
        ldi     *ar1, r0
        ldi     *ar1, r1
        sti     r0, *ar3
        sti     r1, *+ar3(1)
        sti     r1, *ar1
        ldi     *ar1, r0
        sti     r0, *+ar3(2)
        ldi     DOORBELL_IDLE - SEMAPHORE, ir0
        ldi     0, r2
        sti     r2, *+ar1(ir0)
        """,
        host=[
            (50 * US, 0x10101, [], 1),
            (60 * US, 0x10040, [], 1),
            (70 * US, 0x10080, [], 1),
            (71 * US, 0x10040, [], 2),
        ],
    )
    assert [m.chip_word(0, ON_CHIP + i) for i in range(3)] == [0, 1, 0]
    idle, owner, held, owners = [words for _, _, words in m.reads]
    assert (idle, owner, owners) == ([1], [1], [1, 0])
    acquired = [time for time, what, v in m.events if what == "semaphore" and v[1] == 0][-1]
    assert held[0] in ((70 * US - acquired) // US, (70 * US - acquired) // US + 1)


def test_bus_b_reaches_the_dock() -> None:
    dock = plant.Dock(plant.default_dock())
    expected = dock.encoder(3, 0)
    m = run(
        """
        ldi     *+ar2(ENCODER + 3), r0
        sti     r0, *ar3
        ldi     *+ar2(SCAN_ROWS), r0
        sti     r0, *+ar3(1)
        ldi     1, r0
        sti     r0, *+ar2(SCAN_ROW)
        ldi     *+ar2(SCAN_Y), r0
        sti     r0, *+ar3(2)
        """,
        time=MS,
        dock=dock,
    )
    assert m.chip_word(0, ON_CHIP) == expected & 0xFFFFFF
    assert m.chip_word(0, ON_CHIP + 1) == 2
    assert m.chip_word(0, ON_CHIP + 2) == 26600
    assert transactions(m, 1) == [(0x13, 1, 0), (0x40, 1, 0), (0x41, 1, 1), (0x42, 1, 0)]
    assert dock.time >= MS - 125 * US


@pytest.mark.parametrize(
    "body, address, word",
    [
        ("        ldi *+ar2(3Fh), r0", 0x7000003F, "bus B"),
        ("        ldhi 0C100h, ar5\n        ldi *ar5, r0", 0xC1000000, "bus A"),
        ("        sti r0, *+ar2(ENCODER)", 0x70000010, "bus B"),
        ("        ldi DOORBELL_RING - SEMAPHORE, ir0\n        sti r0, *+ar1(ir0)", 0xC0010100, "bus A"),
        ("        ldhi 0060h, ar5\n        ldi *ar5, r0", 0x00600000, ""),
    ],
)
def test_an_access_that_nothing_answers_is_a_typed_fault(body: str, address: int, word: str) -> None:
    m = run(body + "\n", dock=plant.Dock(plant.default_dock()))
    (fault,) = m.faults
    assert fault.address == address and m.standing(0)
    for text in ("DSP 0", f"{fault.pc:08X}h", str(fault.cycle), f"{address:08X}h", word):
        assert text in fault.message
    causes = m.causes(0)
    assert causes["halted"] > 2000 and sum(causes.values()) == m.cycle(0)


def test_a_program_without_the_shared_names_is_refused() -> None:
    from cmrc._core import toolchain

    with pytest.raises(ValueError, match="WINDOW_A, .*_start, dsp_slot, idle_policy, pause_count"):
        machine.Machine(toolchain.assemble("        nop\n"))


DMA = """
        ldhi    0010h, ar5              ; channel 0
        or      00A0h, ar5
        sti     {source}, *+ar5(1)
        ldi     1, r0
        sti     r0, *+ar5(2)
        sti     r0, *+ar5(5)
        ldi     64, r0
        sti     r0, *+ar5(3)
        sti     {destination}, *+ar5(4)
        ldhi    00C0h, r0               ; START 11, stop at the end
        or      4, r0
        sti     r0, *ar5
"""


def test_the_dma_reads_in_bursts_through_the_line() -> None:
    m = machine.Machine(assemble(DMA.format(source="ar0", destination="ar3")), config(dsps=1), record=True)
    for i in range(64):
        m.poke(i, 3 * i + 1)
    m.run_until(100 * US)
    assert [m.chip_word(0, ON_CHIP + i) for i in range(64)] == [3 * i + 1 for i in range(64)]
    assert transactions(m, 0) == [(8 * i, 8, 0) for i in range(8)]
    assert m.statistics(0).prefetch_hits == 56 and m.faults == []


def test_the_dmas_writes_combine_into_bursts() -> None:
    m = run(DMA.format(source="ar3", destination="ar0"))
    bursts = transactions(m, 0)
    assert [m.peek(i) for i in range(64)] == [m.chip_word(0, ON_CHIP + i) for i in range(64)]
    assert sum(words for _, words, _ in bursts) == 64 and len(bursts) < 50 and all(write for _, _, write in bursts)
