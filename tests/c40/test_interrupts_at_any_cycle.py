"""An interrupt at every cycle of a program with slots, repeats, calls and traps; interrupt flags and their order.
Expected values by hand from c40-isa.md 3.10 and 8."""

from __future__ import annotations

import pytest
from cmrc import c40
from on_chip_code import CODE, DATA, TRAPS, VECTORS, processor

SWEPT = """
 ldi 9,iif              ; IIOF0: edge, enabled
 or 2000h,st
 ldi 3,r1
 brd skip               ; slots: no interrupt
slot_a: addi 1,r0
slot_b: addi 2,r0
slot_c: addi 4,r0
 addi 100,r0
skip: cmpi 1,r1
 beqd skip              ; not taken: no interrupt in its slots either
slot_d: addi 1,r0
slot_e: addi 2,r0
slot_f: addi 4,r0
 beqaf skip             ; annulled slots
slot_g: addi 100,r0
slot_h: addi 100,r0
slot_i: addi 100,r0
 ldi 3,rc
 rptb last
 addi3 *ar0,r1,r2
|| sti r2,*ar1++(1)
last: addi 1,r3
 ldi 1,rc
 rptbd block
slot_j: addi 1,r0
slot_k: addi 1,r0
slot_l: addi 1,r0
 addi 1,r4
block: addi 2,r4
 rpts 5
repeated: addi 1,r5
 laj leaf
slot_m: addi 1,r0
slot_n: addi 1,r0
slot_o: addi 1,r0
 ldi 2,ar5
again: dbd ar5,again
slot_p: addi 1,r6
slot_q: nop
slot_r: nop
 call sub
 trapu 5
 push r0
 pop r8
 b stop
sub: addi 7,r0
 rets
leaf: bu r11
handler: retiud
slot_s: addi 16,r0
slot_t: addi 16,r0
slot_u: addi 16,r0
stop: b stop

isr: push st
 push r7
 pushf r7
 push ar7
 push dp
 push rs
 push re
 push rc
 ldpk count
 ldi sp,ar7
 ldi *-ar7(8),r7        ; where it will return to
 sti r7,@where
 ldi @count,r7
 addi 1,r7
 sti r7,@count
 ldi 2,rc               ; a repeat of its own
 rptb own
own: nop
 pop rc
 pop re
 pop rs
 pop dp
 pop ar7
 popf r7
 pop r7
 pop st
 reti
count .word 0
where .word 0
"""


def swept(raise_at: int | None, source: str = "IIOF0") -> tuple[dict[str, int], c40.Processor]:
    chip = processor(SWEPT)
    vector = {"IIOF0": 3, "NMI": 1}[source]
    chip.memory[VECTORS + vector] = chip.address("isr")
    chip.memory[TRAPS + 5] = chip.address("handler")
    chip.memory[DATA] = 40
    chip.registers["AR0"], chip.registers["AR1"] = DATA, DATA + 1
    if raise_at is not None:
        while chip.cycles < raise_at:
            chip.step()
        chip.raise_interrupt(source)
    chip.run(3000, until="stop")
    chip.run(100)  # one that came last is taken here
    names = [f"R{n}" for n in range(9)] + [f"AR{n}" for n in range(8)] + ["SP", "RC", "RS", "RE"]
    state = {name: chip.registers[name] for name in names}
    state["stored"] = sum(chip.memory[DATA + 1 : DATA + 6])
    return state, chip


@pytest.mark.parametrize("source", ["IIOF0", "NMI"])
def test_an_interrupt_at_any_cycle_changes_nothing_but_its_own_words(source: str) -> None:
    plain, chip = swept(None)
    slots = {chip.address(f"slot_{letter}") for letter in "abcdefghijklmnopqrstu"}
    returns = set()
    for cycle in range(3 if source == "IIOF0" else 0, 200):
        state, chip = swept(cycle, source)
        assert state == plain, cycle
        assert chip.memory[chip.address("count")] == 1, cycle
        returns.add(chip.memory[chip.address("where")])
    # It returns to every instruction that is executed but those that must follow the one before: slots, and what RPTS
    # repeats. A maskable one comes neither before interrupts are enabled nor in the trap's handler.
    way = set(range(CODE, chip.address("stop") + 1)) - slots - {chip.address("repeated"), chip.address("skip") - 1}
    if source == "IIOF0":
        way -= {CODE, CODE + 1, CODE + 2, chip.address("handler")}
    assert returns == way


def test_two_requests_come_one_after_the_other_highest_first() -> None:
    chip = processor("""
 ldi 99h,iif
 or 2000h,st
 nop
stop: b stop
first: ldi 1,r0
 reti
second: ldi r0,r1
 ldi 2,r0
 reti
""")
    chip.memory[VECTORS + 3], chip.memory[VECTORS + 4] = chip.address("first"), chip.address("second")
    chip.run(1)
    chip.raise_interrupt("iiof1")  # small letters do, too
    chip.raise_interrupt("IIOF0")
    chip.run(200)
    assert (chip.registers["R0"] & 0xFF, chip.registers["R1"] & 0xFF) == (2, 1)
    assert chip.registers["IIF"] == 0x99


@pytest.mark.parametrize(
    ("source", "vector", "iie"),
    [("TINT0", 0x02, 1), ("DMAINT0", 0x25, 1 << 25), ("DMAINT5", 0x2A, 1 << 30), ("TINT1", 0x2B, 1 << 31)],
)
def test_internal_sources_by_their_flags(source: str, vector: int, iie: int) -> None:
    for enabled in (False, True):
        chip = processor(" or 2000h,st\nstop: b stop\nisr: addi 1,r0\n reti\n")
        chip.memory[VECTORS + vector] = chip.address("isr")
        chip.registers["IIE"] = iie if enabled else 0
        chip.run(10)
        chip.raise_interrupt(source)
        chip.run(100)
        assert chip.registers["R0"] & 0xFFFFFFFF == enabled
        assert (chip.registers["IIF"] != 0) == (not enabled)


def test_an_unknown_source_is_refused() -> None:
    chip = processor("stop: b stop\n")
    with pytest.raises(ValueError, match="ICRDY0 is not an interrupt that can be raised; NMI, IIOF0, "):
        chip.raise_interrupt("ICRDY0")
