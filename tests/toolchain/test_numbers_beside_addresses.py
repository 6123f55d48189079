"""A number beside an address that the linker settles: in an object as in one source, and what immediates take."""

import pytest
from cmrc._core import toolchain
from linked import contents, link, link_errors


@pytest.mark.parametrize(
    "operand",
    [operation.format(number) for operation in ("rpts {}", "ldi {},r0", "subc {},r0", "and {},r0", ".word {}")
     for number in ("x-300000h", "x-2F8000h", "x-2F7FFFh", "x-2F0000h", "x-300003h", "x-308002h", "x-308003h", "x",
                    "y-300000h", "x-10300000h", "x+80000000h", "x+100000000h", "x-180000000h")],
)  # fmt: skip
def test_an_object_takes_the_numbers_beside_an_address_that_a_source_takes(operand: str) -> None:
    source = f"\t.text\n\tnop\nx:\tnop\n\t{operand}\n\tnop\n\t.data\ny:\t.word 1\n"
    made: list[object] = []
    for make in (toolchain.assemble, lambda text: link(text)):
        try:
            made.append(contents(make(source)))
        except (toolchain.AssemblyError, toolchain.LinkError, AssertionError):
            made.append(None)
    assert made[0] == made[1]


@pytest.mark.parametrize(
    ("instruction", "n", "takes"),
    [
        ("rpts n", -1, False), ("rpts n", 0xFFFF, True), ("rpts n+2", -1, True), ("rpts n-1", 0, False),
        ("ldi n,r0", -1, True), ("ldi n,r0", 0xFFFF, True), ("ldi n,r0", -32769, False), ("subc n,r0", -1, True),
        ("and n,r0", -1, False), ("and n,r0", 0xFFFF, True), ("ldhi n,r0", 5, True), ("ldpk n", -1, False),
    ],
)  # fmt: skip
def test_an_immediate_takes_of_the_linker_what_it_takes_of_a_source(instruction: str, n: int, takes: bool) -> None:
    source = f"\t.global n\n\tnop\n\t{instruction}\n\tnop\n"
    definition = f"\t.def n\nn\t.set {n}\n\tnop\n"
    if takes:
        assert link(source, definition).sections
    else:
        (error,) = link_errors(source, definition)
        assert "does not fit in the 16 bits of R_RELWORD" in error


def test_an_address_of_another_object_is_no_negative_number() -> None:
    source, definition = "\t.ref x\n\tldi x,r0\n", '\t.def x\n\t.sect "low"\nx:\tnop\n'
    where = '[memory]\nm = {{ origin = 0, length = 0x10000 }}\n[sections]\n"low" = {{ address = {} }}\n'
    assert link(source, definition, map=where.format(0x7FFF)).sections
    (error,) = link_errors(source, definition, map=where.format(0x8000))
    assert "the value 32768 does not fit in the 16 bits of R_RELWORD" in error


@pytest.mark.parametrize(
    ("instruction", "fits"),
    [
        ("ldi x+7FFFh,r0", True), ("ldi x-8000h,r0", True), ("ldi x+8000h,r0", False), ("ldi x-300000h,r0", False),
        ("bz x+7000h", True), ("bz x+10000h", False), ("br x+7FFFF0h", True), ("br x+1000000h", False),
        (".word x+80000000h", True), (".word x+100000000h", False), ("ldhi hi16(x+123456h),r0", True),
        ("or lo16(x+123456h),r0", True), ("ldp x+123456h", True),
    ],
)  # fmt: skip
def test_a_number_beside_a_symbol_of_another_object_has_the_bits_of_its_field(instruction: str, fits: bool) -> None:
    source = f"\t.ref x\n\tnop\n\t{instruction}\n\tnop\n"
    if fits:
        assert toolchain.assemble_object(source).sections
        return
    with pytest.raises(toolchain.AssemblyError, match="the object has (16|24) bits for it|does not fit in 32 bits"):
        toolchain.assemble_object(source)
