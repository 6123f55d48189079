"""An executable specification of the TMS320C4x's instructions, in exact rationals and unlimited integers.

Written from the reference text (c40-isa.md 2 to 8), not from the emulator, and sharing
nothing with it: its own formats, arithmetic, decoder and machine. Slow and plain on purpose. Registers R0 to R11 are
40-bit integers, exponent byte in bits 39..32; all others 32-bit.

    formats      the floating-point formats and what they mean (2)
    flags        what an operation says about ST, and what ST becomes (1.4, 5)
    floats       floating-point arithmetic (7.1 to 7.7, 7.10, 2.3)
    integers     integer arithmetic, logic, shifts, part-words (6.1 to 6.3, 7.8, 7.9, 7.11)
    addressing   indirect addressing (3.9)
    state        registers, memory, operands (1, 3)
    flow         program control (6.6, 8)
    machine      the instructions of every other group, and one step (6)
    fields       random fields of words
    encodings    every encoding with its operand forms, for generators (3, 6), those of program control apart
    vectors      single-step vectors: states in, states out
    campaign     a million cases of every operation against the C++ reference of tests/reference
"""
