"""The emulator's instruction table against the tables of the reference text: mnemonics, flag classes, cycles,
families."""

import pytest
from cmrc._core import isa

# c40-isa.md 6.1 to 6.6: mnemonic, flag class, cycles; a star marks what the C3x has not.
TABLE = """
absf F 1 | absi B 1 | addc A 1 | addf F 1 | addi A 1 | and L 1 | andn L 1 | ash SA 1 | cmpf F 1 | cmpi A 1 | fix B 1 | float G 1
idle - 1 | idle2 - 1 * | lde - 1 | ldf G 1 | ldfi G 1 | ldi L 1 | ldii L 1 | ldm - 1 | lsh S 1 | mpyf F 1 | mpyi B 1 | negb A 1
negf F 1 | negi A 1 | nop - 1 | norm NORM 1 | not L 1 | pop L 1 | popf G 1 | push - 1 | pushf - 1 | or L 1 | rnd RND 1 | rol S 1
rolc S 1 | ror S 1 | rorc S 1 | rpts - 4 | stf - 1 | stfi - 1 | sti - 1 | stik - 1 * | stii - 1 | sigi L 1 * | subb A 1 | subc - 1
subf F 1 | subi A 1 | subrb A 1 | subrf F 1 | subri A 1 | tstb L 1 | xor L 1 | iack - 1 | toieee F* 1 * | frieee F* 1 * | rsqrf F 1 *
rcpf F 1 * | mpyshi B 1 * | mpyuhi B 1 * | lda - 1 * | ldpk - 1 * | ldhi - 1 *
lb0 L 1 * | lb1 L 1 * | lb2 L 1 * | lb3 L 1 * | lbu0 L 1 * | lbu1 L 1 * | lbu2 L 1 * | lbu3 L 1 * | lwl0 L 1 * | lwl1 L 1 *
lwl2 L 1 * | lwl3 L 1 * | lwr0 L 1 * | lwr1 L 1 * | lwr2 L 1 * | lwr3 L 1 * | mb0 L 1 * | mb1 L 1 * | mb2 L 1 * | mb3 L 1 *
lh0 L 1 * | lh1 L 1 * | lhu0 L 1 * | lhu1 L 1 * | mh0 L 1 * | mh1 L 1 *
addc3 A 1 | addf3 F 1 | addi3 A 1 | and3 L 1 | andn3 L 1 | ash3 SA 1 | cmpf3 F 1 | cmpi3 A 1 | lsh3 S 1 | mpyf3 F 1 | mpyi3 B 1
or3 L 1 | subb3 A 1 | subf3 F 1 | subi3 A 1 | tstb3 L 1 | xor3 L 1 | mpyshi3 B 1 * | mpyuhi3 B 1 * | ldf? - 1 | ldi? - 1
stf||stf - 1 | sti||sti - 1 | ldf||ldf - 1 | ldi||ldi - 1 | absf||stf F 1 | absi||sti B 1 | addf3||stf F 1 | addi3||sti A 1
and3||sti L 1 | ash3||sti SA 1 | fix||sti B 1 | float||stf G 1 | ldf||stf - 1 | ldi||sti - 1 | lsh3||sti S 1 | mpyf3||stf F 1
mpyi3||sti B 1 | negf||stf F 1 | negi||sti A 1 | not||sti L 1 | or3||sti L 1 | subf3||stf F 1 | subi3||sti A 1 | xor3||sti L 1
toieee||stf F* 1 * | frieee||stf F* 1 * | mpyf3||addf3 MPY|| 1 | mpyf3||subf3 MPY|| 1 | mpyi3||addi3 MPY|| 1 | mpyi3||subi3 MPY|| 1
br - 4 | brd - 1 | call - 4 | laj - 1 * | rptb - 4 | rptbd - 1 * | swi - 4 | b? - 4 | b?d - 1 | b?at - 1 * | b?af - 1 * | db? - 4
db?d - 1 | call? - 5 | laj? - 1 * | trap? - 5 | lat? - 1 * | ldep - 1 * | ldpe - 1 * | reti? - 4 | reti?d - 1 * | rets? - 4
"""
COLUMNS = {}
for entry in TABLE.replace(" | ", "\n").strip().split("\n"):
    name, flags, cycles, *star = entry.split()
    COLUMNS[name] = ("" if flags == "-" else flags, int(cycles), bool(star))


def test_the_table_names_every_mnemonic_of_the_text_and_no_other() -> None:
    names = {row["mnemonic"] + (f"||{row['mnemonic2']}" if row["mnemonic2"] else "") for row in isa.rows()}
    assert names == set(COLUMNS)


@pytest.mark.parametrize("name", COLUMNS)
def test_flags_cycles_and_family_are_those_of_the_text(name: str) -> None:
    rows = [r for r in isa.rows() if r["mnemonic"] + (f"||{r['mnemonic2']}" if r["mnemonic2"] else "") == name]
    flags, cycles, c4x_only = COLUMNS[name]
    for row in rows:
        # Second encodings of C3x instructions (type 2, RPTB of a register) are the C4x's own.
        new_form = row["picture"].startswith("001 1") or row["picture"].startswith("01111001")
        assert (row["flags"], row["cycles"]) == (flags, cycles), row
        assert row["c4x_only"] == (c4x_only or new_form), row
