; Division of 32-bit integers, rounded towards zero, under the names that compilers call (docs/from-c.md). Division by
; zero: quotient FFFFFFFFh, remainder the dividend; in a signed division the quotient then gets its sign.
;
; TI's DIV_I, MOD_I, DIV_U, MOD_U, MPY_I: R0 := R0 op R1. Like TI's of 1992 they change R0, R1, AR0, AR1, RC, RS, RE, ST

                .include "c_runtime.inc"
                .global DIV_U, MOD_U, DIV_I, MOD_I, MPY_I
                .global DIV_U30, MOD_U30, DIV_I30, MOD_I30, MPY_I30, DIV_U40, MOD_U40, DIV_I40, MOD_I40, MPY_I40
                .global ___udivqi3, ___umodqi3, ___divqi3, ___modqi3, ___mulqi3, ___ffs

                .text
MOD_U40:
MOD_U30:
MOD_U:          call    divide
                ldi     r1,r0
                rets

; R0, R1 := quotient and remainder of R0 / R1.
DIV_U40:
DIV_U30:
DIV_U:
divide:         cmpi    r1,r0
                blo     smaller
                cmpi    0,r1
                beq     by_zero
                blt     once                    ; both have bit 31
                ldi     r1,ar1
                cmpi    0,r0
                blt     by_halves
                float   r0,r1                   ; the exponents are the places of the top bits
                pushf   r1
                pop     ar0
                ash     -24,ar0
                float   ar1,r1
                pushf   r1
                pop     rc
                ash     -24,rc
                subi    rc,ar0
                lsh     ar0,ar1                 ; the top bits now have the same place
                rpts    ar0
                subc    ar1,r0                  ; remainder : quotient
                addi    1,ar0
                negi    ar0,rc
                lsh3    rc,r0,r1
                ldi     1,ar1
                lsh     ar0,ar1
                subi    1,ar1
                and     ar1,r0
                rets
by_halves:      push    r0                      ; SUBC's shift would lose bit 31: divide half of the number first
                push    r1
                lsh     -1,r0
                ldi     ar1,r1
                call    divide
                pop     ar1
                pop     ar0
                addi    r0,r0
                lsh     1,r1
                and     1,ar0
                or      ar0,r1
                cmpi    ar1,r1
                retslo
                subi    ar1,r1
                addi    1,r0
                rets
once:           subi    r1,r0
                ldi     r0,r1
                ldi     1,r0
                rets
smaller:        ldi     r0,r1
                ldi     0,r0
                rets
by_zero:        ldi     r0,r1
                ldi     -1,r0
                rets

DIV_I40:
DIV_I30:
DIV_I:          push    r0
                push    r1
                absi    r0
                absi    r1
                call    divide
                pop     ar1
                pop     ar0
                xor     ar1,ar0
                cmpi    0,ar0
                retsge
                negi    r0,r0
                rets

MOD_I40:
MOD_I30:
MOD_I:          push    r0
                absi    r0
                absi    r1
                call    divide
                ldi     r1,r0
                pop     ar0
                cmpi    0,ar0
                retsge
                negi    r0,r0                   ; the dividend's sign
                rets

MPY_I40:
MPY_I30:
MPY_I:          mpyi    r1,r0
                rets

; GCC's, as C functions.
___udivqi3:     whole_arguments r0,r1
                b       DIV_U
___umodqi3:     whole_arguments r0,r1
                b       MOD_U
___divqi3:      whole_arguments r0,r1
                b       DIV_I
___modqi3:      whole_arguments r0,r1
                b       MOD_I
___mulqi3:      whole_arguments r0,r1
                b       MPY_I

; int ffs(int): the place of the lowest 1, counted from 1; 0 if the argument is 0.
___ffs:         whole_argument r0
                negi    r0,r1
                and     r1,r0                   ; that bit alone
                retsz
                blt     top                     ; as a float this value would be negative
                float   r0,r1
                pushf   r1
                pop     r0
                ash     -24,r0
                addi    1,r0
                rets
top:            ldi     32,r0
                rets
