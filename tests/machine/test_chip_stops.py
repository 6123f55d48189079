"""What every reason for which a chip stops means to every front end. Rows come from the C++ enum: a new reason fails
here until it has its row, and in C++ does not compile until it has a name and a meaning
(emulator/machine/chips/chip_stop.hpp)."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from cmrc import c40
from cmrc.network import Network
from cmrc_test import machine
from locations import BUILD
from programs import US, assemble, config

# What provokes each: the body of a program whose AR0 is window A, AR1 on-chip RAM and AR2 on the registers of port 0.
LOOP = "loop:   addi    1, r0\n        br      loop\n"
READ_WINDOW = "        ldi     *ar0, r0\n        ldi     5, r1\n"
READ_PORT = "        ldi     *+ar2(1), r0\n"
RESERVED = "        .word   0FFFFFFFFh\n"
SWI = "        ldi     7, r1\n        swi\n        ldi     9, r1\n"

# reason: its meaning; the program; exec, network and Python's Processor: (reason or status, exit status); what becomes
# of the dock's DSP. None: that front end cannot come to it, or does not show it.
TABLE: dict[str, tuple[str, str, tuple[str, int] | None, tuple[str, int] | None, str | None, str | None]] = {
    "limit": ("limit", LOOP, ("limit", 1), ("running", 1), "limit", "runs"),
    "external_access": (
        "window_access",
        READ_WINDOW,
        ("external_access", 1),
        ("external_access", 1),
        "external_access",
        "ends",
    ),
    "breakpoint": ("breakpoint", "", ("halt", 0), ("halt", 0), None, "ends"),
    "fault": ("fault", RESERVED, ("fault", 1), ("fault", 1), "fault", "faults"),
    "port_access": (
        "port_access",
        READ_PORT,
        None,
        ("waiting", 1),
        None,
        None,
    ),  # of a linked port; the dock's are tested with its boot
    "port_wait": ("port_wait", READ_PORT, ("port_wait", 1), ("waiting", 1), "port_wait", "faults"),
    "horizon": (
        "asks_again",
        "",
        None,
        None,
        None,
        None,
    ),  # only the driver of linked chips sees it; no run ends by it
    "software_interrupt": ("fault", SWI, ("fault", 1), ("fault", 1), "software_interrupt", "faults"),
}
HEAD = """
        .text
start:  ldhi    0C000h, ar0
        ldhi    002Fh, ar1
        or      0F800h, ar1
        ldhi    0010h, ar2
        or      0040h, ar2
"""


@pytest.fixture
def program(tmp_path: Path) -> Callable[[str], Path]:
    def write(body: str) -> Path:
        path = tmp_path / "program.asm"
        path.write_text(HEAD + body + "halt:   b       halt\n")
        return path

    return write


def execute(path: Path, *arguments: object) -> tuple[int, dict]:
    command = [BUILD / "bin" / "emulator", "exec", path, *map(str, arguments), "--json", "--max-cycles", "20000"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    return done.returncode, json.loads(done.stdout)


def test_the_table_has_every_reason_and_every_reason_its_meaning() -> None:
    assert machine.stop_meanings == {reason: row[0] for reason, row in TABLE.items()}


@pytest.mark.parametrize("reason", TABLE)
def test_exec(program: Callable[[str], Path], reason: str) -> None:
    _, body, expected, *_ = TABLE[reason]
    if expected is None:
        pytest.skip("one chip alone does not come to it")
    status, report = execute(program(body))
    assert (report["stop"]["reason"], status) == expected


@pytest.mark.parametrize("reason", TABLE)
def test_network(program: Callable[[str], Path], reason: str) -> None:
    """Chip 1 of a pair; what chip 0 does has ended at once."""
    _, body, _, expected, *_ = TABLE[reason]
    if expected is None:
        pytest.skip("a chip of a network does not show it")
    first = program("").rename(program("").with_name("first.asm"))
    link = "0.3:1.0" if reason == "port_access" else "0.0:1.3"
    status, report = execute(first, program(body), "--link", link)
    assert (report["chips"][1]["status"], status) == expected
    assert report["chips"][0]["status"] == "halt"


@pytest.mark.parametrize("reason", TABLE)
def test_processor(program: Callable[[str], Path], reason: str) -> None:
    """Python's Processor acts as a debugger: it reports the chip's own reason."""
    _, body, _, _, expected, _ = TABLE[reason]
    if expected is None:
        pytest.skip("without breakpoint and link it does not come to it")
    assert c40.Processor(c40.assemble_file(program(body))).run(20000).reason == expected


@pytest.mark.parametrize("reason", TABLE)
def test_dock(reason: str) -> None:
    """A DSP of the dock, which continues in an endless loop or stops in a fault. Window A answers there; port 0
    has nothing attached."""
    _, body, *_, expected = TABLE[reason]
    if expected is None:
        pytest.skip("its driver's own, or tested with the boot over links")
    m = machine.Machine(assemble("        ldhi    0010h, ar2\n        or      0040h, ar2\n" + body), config(dsps=2))
    m.run_until(100 * US)
    if expected == "faults":
        assert [fault.slot for fault in m.faults] == [0, 1]
    else:
        assert m.faults == []
        m.run_until(200 * US)


def test_swi_is_named_with_its_place(program: Callable[[str], Path]) -> None:
    """The faults file of issue 16: it hung in exec and in the dock, and crashed in a network."""
    at = 0x300000 + 5 + 1
    status, report = execute(program(SWI))
    assert status == 1 and report["stop"]["pc"] == at
    for part in ("software_interrupt", "SWI", f"{at:08X}h"):
        assert part in report["stop"]["message"]
    assert report["registers"]["R1"] & 0xFFFFFFFF == 7, "nothing behind it was done"
    network = Network([c40.assemble_file(program(SWI)), c40.assemble_file(program(""))], links=["0.0:1.3"])
    network.run()
    assert network.chips[0].status == "fault" and network.chips[1].status == "halt"
    assert "software_interrupt" in network.chips[0].message
    m = machine.Machine(assemble(SWI), config(dsps=1))
    m.run_until(100 * US)
    assert "software_interrupt" in m.faults[0].message and "DSP 0 at PC" in m.faults[0].message
    before = m.chip_word(0, 0x2FF800)
    m.run_until(200 * US)
    assert m.chip_word(0, 0x2FF800) == before and len(m.faults) == 1


def test_a_debugger_stops_at_swi_and_may_continue_behind_it(program: Callable[[str], Path]) -> None:
    processor = c40.Processor(c40.assemble_file(program(SWI)))
    at = processor.address("start") + 6
    for _ in range(2):  # it stops there again
        stop = processor.run(100)
        assert (stop.reason, stop.pc) == ("software_interrupt", at)
    assert processor.step().reason == "software_interrupt"
    processor.pc = at + 1
    assert processor.run(100, until="halt").reason == "until"
    assert processor.registers["R1"] & 0xFFFFFFFF == 9


def test_swi_ends_a_traced_and_a_checked_run_too(program: Callable[[str], Path], tmp_path: Path) -> None:
    path = program(SWI)
    plain = execute(path)
    assert execute(path, "--trace", tmp_path / "t") == plain
    status, checked = execute(path, "--check", "--profile")
    assert status == 1 and checked["stop"] == plain[1]["stop"]
