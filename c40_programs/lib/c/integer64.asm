; 64-bit integers, GCC's `long long`: two words, low first. Arguments always on the stack, results in R0 (low) and R1
; (high) (docs/from-c.md). Division by zero gives the quotient -1 and the dividend as remainder.

                .include "c_runtime.inc"
                .global ___mulhi3, ___umulhi3_high, ___smulhi3_high
                .global ___udivhi3, ___umodhi3, ___divhi3, ___modhi3

operands        .macro                          ; R1:R0 and AR1:AR0 := the two arguments
                lda     sp,ar2
                ldi     *-ar2(2),r0
                ldi     *-ar2(1),r1
                lda     *-ar2(4),ar0
                lda     *-ar2(3),ar1
                .endm

negate          .macro  low,high                ; as one number; uses R9, R11: only R0 to R11 keep the borrow
                ldi     0,r9
                subi3   low,r9,r11
                subb3   high,r9,r9
                ldi     r11,low
                ldi     r9,high
                .endm

                .text
___mulhi3:      operands
                mpyi3   r1,ar0,r2               ; the cross products add only their low words
                mpyi3   r0,ar1,r3
                mpyuhi3 r0,ar0,r1
                mpyi    ar0,r0
                addi    r2,r1
                addi    r3,r1
                rets

; The high word of a product of two words.
___umulhi3_high:
                whole_arguments r0,r1
                mpyuhi  r1,r0
                rets
___smulhi3_high:
                whole_arguments r0,r1
                mpyshi  r1,r0
                rets

___udivhi3:     operands
                b       divide
___umodhi3:     operands
                call    divide
                ldi     r2,r0
                ldi     r3,r1
                rets

___divhi3:      operands
                xor3    r1,ar1,r9
                push    r9                      ; the quotient's sign
                call    divide_magnitudes
                pop     r10
                cmpi    0,r10
                retsge
                negate  r0,r1
                rets

___modhi3:      operands
                push    r1                      ; the remainder's sign is the dividend's
                call    divide_magnitudes
                pop     r10
                ldi     r2,r0
                ldi     r3,r1
                cmpi    0,r10
                retsge
                negate  r0,r1
                rets

divide_magnitudes:
                cmpi    0,r1
                bge     divisor
                negate  r0,r1
divisor:        cmpi    0,ar1
                bge     divide
                negate  ar0,ar1

; R1:R0, R3:R2 := quotient and remainder of R1:R0 / AR1:AR0, bit by bit. Uses R9 to R11, RC, RS, RE.
divide:         ldi     0,r2
                ldi     0,r3
                ldi     63,rc
                rptb    bit_done
                addi    r0,r0
                rolc    r1
                rolc    r2
                rolc    r3                      ; the carry is bit 64 of the remainder
                ldihs   0,r10
                ldilo   1,r10
                subi3   ar0,r2,r9
                subb3   ar1,r3,r11
                ldihs   1,r10                   ; it fits, or bit 64 says so
                cmpi    0,r10
                ldinz   r9,r2
                ldinz   r11,r3
bit_done:       or      r10,r0
                rets

