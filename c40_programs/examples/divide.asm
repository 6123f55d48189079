; Division and square root of floats by seed and Newton's method: for each of `count` pairs at `dividends`, `divisors`
;     quotients = dividend / divisor,   roots = square root of the dividend's magnitude
;
; To see: RCPF and RSQRF give about 8 bits; x := x (2 - v x) and x := x (3/2 - v/2 x x) double them. A last step on the
; quotient, q := q + x (a - v q), leaves an error below that of the 24 bits that are stored.

                .include "examples.inc"

                .bss    variables,0
                .bss    count,1
                .bss    dividends,256
                .bss    divisors,256
                .bss    quotients,256
                .bss    roots,256

                .text
start:          set_up
                address dividends,ar0
                address divisors,ar1
                address quotients,ar2
                address roots,ar3
                ldi     @count,ar5
                subi    1,ar5
next_pair:      ldf     *ar0,r0
                ldf     *ar1++,r1
                call    quotient
                rnd     r2
                stf     r2,*ar2++
                absf    *ar0++,r0
                call    square_root
                rnd     r2
                stf     r2,*ar3++
                db      ar5,next_pair
done:           b       done

; R2 := R0 / R1. Uses R3.
quotient:       rcpf    r1,r2
                mpyf3   r1,r2,r3
                subrf   2.0,r3
                mpyf    r3,r2
                mpyf3   r1,r2,r3
                subrf   2.0,r3
                mpyf    r3,r2                   ; 1 / R1
                ldf     r2,r4
                mpyf    r0,r2                   ; q
                mpyf3   r1,r2,r3
                subrf   r0,r3                   ; a - v q
                mpyf    r4,r3
                addf    r3,r2
                rets

; R2 := square root of R0, which is not negative. Uses R3, R4.
square_root:    ldf     r0,r2
                bz      root_known              ; of zero
                rsqrf   r0,r2
                ldf     r0,r4
                mpyf    0.5,r4
                mpyf3   r2,r2,r3
                mpyf    r4,r3
                subrf   1.5,r3
                mpyf    r3,r2
                mpyf3   r2,r2,r3
                mpyf    r4,r3
                subrf   1.5,r3
                mpyf    r3,r2                   ; 1 / sqrt
                ldf     r2,r4
                mpyf    r0,r2                   ; s
                mpyf3   r2,r2,r3
                subrf   r0,r3                   ; a - s s
                mpyf    r4,r3
                mpyf    0.5,r3
                addf    r3,r2
root_known:     rets
