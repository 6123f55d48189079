; Division and multiplication of floats, under the names that compilers call (docs/from-c.md).
;
; TI's DIV_F: R0 := R0 / R1, rounded to 24 bits; INV_F: R0 := 1 / R0 with 32 bits of mantissa. They change R0, R1 and ST
; only. The reciprocal of a number above 2^127 is 0, and so is a quotient with such a divisor.

                .include "c_runtime.inc"
                .global DIV_F, DIV_F30, DIV_F40, INV_F, INV_F30, INV_F40
                .global ___divqf3, ___divhf3, ___mulhf3

keep            .macro  register                ; all 40 bits
                push    register
                pushf   register
                .endm
bring_back      .macro  register
                popf    register
                pop     register
                .endm

                .text
DIV_F40:
DIV_F30:
DIV_F:          keep    r2
                keep    r3
                ldf     r0,r2
                ldf     r1,r3
                call    divide
                rnd     r0
                bring_back r3
                bring_back r2
                rets

INV_F40:
INV_F30:
INV_F:          keep    r3
                ldf     r0,r3
                call    reciprocal
                bring_back r3
                rets

; GCC's, as C functions: floats; and floats of 40 bits, `long double`.
___divqf3:      float_arguments
                call    divide
                rnd     r0
                rets
___divhf3:      long_doubles
divide:         call    reciprocal
                mpyf    r2,r0
                rets
___mulhf3:      long_doubles
                mpyf3   r2,r3,r0
                rets

; R0 := 1 / R3: a seed of 8 bits, twice x (2 - v x), which squares its error. Uses R1.
reciprocal:     rcpf    r3,r0
                mpyf3   r0,r3,r1
                subrf   2.0,r1
                mpyf    r1,r0
                mpyf3   r0,r3,r1
                subrf   2.0,r1
                mpyf    r1,r0
                rets
