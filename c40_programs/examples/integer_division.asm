; Division of 32-bit integers by SUBC: for each of `count` pairs at `dividends`, `divisors` the unsigned quotient and
; remainder, then the signed ones, rounded towards zero as in C. Division by zero gives FFFFFFFFh and the dividend.
;
; To see: SUBC does one step of restoring division. The exponents from FLOAT, read with PUSHF and POP, give the number
; of steps. The results come packed in one register.

                .include "examples.inc"

                .bss    variables,0
                .bss    count,1
                .bss    dividends,256
                .bss    divisors,256
                .bss    quotients,256
                .bss    remainders,256
                .bss    signed_quotients,256
                .bss    signed_remainders,256

                .text
start:          set_up
                address dividends,ar0
                address divisors,ar1
                ldi     @count,ar5
                subi    1,ar5
                ldi     0,ir0
next_pair:      ldi     *+ar0(ir0),r0
                ldi     *+ar1(ir0),r1
                call    unsigned_division
                address quotients,ar2
                address remainders,ar3
                sti     r0,*+ar2(ir0)
                sti     r1,*+ar3(ir0)
                ldi     *+ar0(ir0),r0
                ldi     *+ar1(ir0),r1
                call    signed_division
                address signed_quotients,ar2
                address signed_remainders,ar3
                sti     r0,*+ar2(ir0)
                sti     r1,*+ar3(ir0)
                addi    1,ir0
                db      ar5,next_pair
done:           b       done

; R0, R1 := quotient and remainder of R0 / R1, signed. The remainder has the dividend's sign.
signed_division:
                push    r4
                push    r5
                ldi     r0,r4
                xor3    r0,r1,r5
                absi    r0
                absi    r1
                call    unsigned_division
                cmpi    0,r5                    ; signs differ?
                ldi     r0,r2
                negi    r0,r3
                cmpi    0,r5
                ldilt   r3,r2
                ldi     r2,r0
                negi    r1,r3
                cmpi    0,r4
                ldilt   r3,r1
                pop     r5
                pop     r4
                rets

; R0, R1 := quotient and remainder of R0 / R1, unsigned. Uses R2, R3, RC.
unsigned_division:
                cmpi    0,r1
                beq     by_zero
                cmpi    r1,r0
                blo     too_small               ; unsigned: R0 < R1
                cmpi    0,r1
                blt     once                    ; divisor and dividend both have bit 31
                cmpi    0,r0
                bge     steps
                push    r0                      ; SUBC's shift would lose bit 31: divide half of the dividend first
                lsh     -1,r0
                call    unsigned_division_steps
                ldi     r0,r2
                addi    r2,r2                   ; 2 q
                pop     r0
                lsh     1,r1                    ; remainder of R0: 2 r + its last bit
                and     1,r0
                or      r0,r1
                ldi     r2,r0
                ldi     @divisor,r3
                cmpi    r3,r1
                blo     halved
                subi    r3,r1
                addi    1,r0
halved:         rets
once:           subi    r1,r0
                ldi     r0,r1
                ldi     1,r0
                rets
too_small:      ldi     r0,r1
                ldi     0,r0
                rets
by_zero:        ldi     r0,r1
                ldi     -1,r0
                rets

                .bss    divisor,1
; The same for 0 < R1 and R0 < 2^31.
unsigned_division_steps:
                cmpi    r1,r0
                bhs     steps
                sti     r1,@divisor
                b       too_small
steps:          sti     r1,@divisor
                float   r0,r2                   ; exponents: places of the top bits
                pushf   r2
                pop     r2
                ash     -24,r2
                float   r1,r3
                pushf   r3
                pop     r3
                ash     -24,r3
                subi    r3,r2                   ; k
                lsh     r2,r1                   ; aligned with the dividend
                ldi     r2,rc
                rpts    rc
                subc    r1,r0                   ; k + 1 times
                ldi     r2,r3
                addi    1,r3
                negi    r3,r2
                lsh3    r2,r0,r1                ; remainder: above the quotient's k + 1 bits
                ldi     1,r2
                lsh     r3,r2
                subi    1,r2
                and     r2,r0
                rets
