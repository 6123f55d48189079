; 64-bit integer arithmetic, low word first. For each of `count` pairs at `left`, `right` (two words each): the sum, the
; difference, the low 64 bits of the product, the left operand shifted by one, the unsigned comparison (-1, 0 or 1).
;
; To see: ADDC and SUBB carry from word to word; MPYI and MPYUHI together give 64 bits; ROLC shifts the carry in.

                .include "examples.inc"

                .bss    variables,0
                .bss    count,1
                .bss    left,128
                .bss    right,128
                .bss    sums,128
                .bss    differences,128
                .bss    products,128
                .bss    shifted,128
                .bss    orders,64

                .text
start:          set_up
                address left,ar0
                address right,ar1
                address sums,ar2
                address differences,ar3
                address products,ar4
                address shifted,ar5
                address orders,ar6
                ldi     @count,ar7
                subi    1,ar7
next_pair:      ldi     *ar0++,r0               ; R1:R0 left, R3:R2 right
                ldi     *ar0++,r1
                ldi     *ar1++,r2
                ldi     *ar1++,r3

                ldi     r0,r4
                ldi     r1,r5
                addi    r2,r4
                addc    r3,r5
                sti     r4,*ar2++
                sti     r5,*ar2++

                ldi     r0,r4
                ldi     r1,r5
                subi    r2,r4
                subb    r3,r5
                sti     r4,*ar3++
                sti     r5,*ar3++

                mpyi3   r0,r2,r4                ; low x low: 64 bits
                mpyuhi3 r0,r2,r5
                mpyi3   r0,r3,r6                ; the cross products add only their low words
                addi    r6,r5
                mpyi3   r1,r2,r6
                addi    r6,r5
                sti     r4,*ar4++
                sti     r5,*ar4++

                ldi     r0,r4
                ldi     r1,r5
                addi    r4,r4                   ; carry: bit 31
                rolc    r5
                sti     r4,*ar5++
                sti     r5,*ar5++

                ldi     0,r4
                ldi     1,r5
                ldi     -1,r6
                cmpi    r3,r1
                bne     decided
                cmpi    r2,r0
decided:        ldihi   r5,r4
                ldilo   r6,r4
                sti     r4,*ar6++
                db      ar7,next_pair
done:           b       done
