; Between floats and 64-bit integers, under the names that GCC calls (docs/from-c.md). Integers as in integer64.asm.
; Rounding: to an integer towards zero; to a float the nearest of 24 bits (after a cut to 32); to a long double a cut.

                .include "c_runtime.inc"
                .global ___fix_truncqfhi2, ___ufix_truncqfhi2, ___fix_trunchfhi2, ___ufix_trunchfhi2
                .global ___floathiqf2, ___ufloathiqf2, ___floathihf2, ___ufloathihf2
                .global ___unsfltconst, ___unsfltcompare

                .sect   ".const"
___unsfltconst: .float  4294967296.0
___unsfltcompare:
                .float  2147483648.0

                .text
___fix_truncqfhi2:
___ufix_truncqfhi2:
                float_argument
                b       to_whole
___fix_trunchfhi2:
___ufix_trunchfhi2:
                .if     !defined(REGPARM)
                lda     sp,ar0
                long_double 1,r2
                .endif

; R1:R0 := R2, of which only |R2| < 2^64 has one.
to_whole:       pushf   r2                      ; its sign
                absf    r2
                pushf   r2
                pop     r3
                ash     -24,r3                  ; exponent e
                blt     below_one
                ldi     r2,r0                   ; the mantissa's 31 bits
                ldhi    8000h,r1
                or      r1,r0                   ; and the 1 before them: times 2^(e - 31)
                subi    31,r3
                subi3   32,r3,r1
                lsh3    r1,r0,r1                ; the bits of the high word
                lsh     r3,r0
                pop     r3
                lsh     8,r3                    ; the sign bit follows the exponent
                cmpi    0,r3
                retsge
                ldi     0,r2
                subi3   r0,r2,r0
                subb3   r1,r2,r1
                rets
below_one:      ldi     0,r0
                ldi     0,r1
                pop     r3
                rets

operand         .macro                          ; R1:R0 := the argument
                lda     sp,ar0
                ldi     *-ar0(2),r0
                ldi     *-ar0(1),r1
                .endm

___floathiqf2:  operand
                call    signed_to_float
                rnd     r0
                rets
___ufloathiqf2: operand
                call    to_float
                rnd     r0
                rets
___floathihf2:  operand
signed_to_float:
                cmpi    0,r1
                bge     to_float
                ldi     0,r2
                subi3   r0,r2,r0
                subb3   r1,r2,r1
                call    to_float
                negf    r0
                rets
___ufloathihf2: operand

; R0 := R1:R0 as an unsigned number. Uses R2, AR0.
to_float:       address ___unsfltconst,ar0
                float   r0,r2
                bge     low_done
                addf    *ar0,r2                 ; bit 31 counts 2^31, not -2^31
low_done:       float   r1,r0
                bge     high_done
                addf    *ar0,r0
high_done:      mpyf    *ar0,r0
                addf    r2,r0
                rets
