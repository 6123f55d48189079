"""Code, data, stack and tables in the chip's own RAM."""

from cmrc import c40

CODE, DATA = 0x2FFC00, 0x2FF800
VECTORS, TRAPS, STACK = 0x2FFA00, 0x2FFA00, 0x2FF900


def processor(text: str) -> c40.Processor:
    chip = c40.Processor(c40.assemble(text, sections={".text": CODE}))
    chip.pc = CODE
    chip.registers["SP"] = STACK
    chip.registers["IVTP"] = VECTORS
    chip.registers["TVTP"] = TRAPS
    return chip
