; SHA-1 (FIPS 180-4) of `length` bytes at `message`, four bytes to a word, the first in bits 7-0. Result: five words at
; `digest`.
;
; To see: part-word moves (LBU, MB) reverse a word's bytes; padding computed at run time; rotations by shifts; one macro
; for four kinds of rounds; the schedule of 80 words is in on-chip RAM block 1.

                .include "examples.inc"

                .bss    variables,0
                .bss    length,1
                .bss    digest,5
                .bss    blocks,1                ; 64-byte blocks, padding included
                .bss    block,1
                .bss    message,1024

W               .set    2FFC00h                 ; message schedule

rotate          .macro  n,source,target,scratch ; target := source rotated left by n
                ldi     source,target
                lsh     n,target
                ldi     source,scratch
                lsh     n-32,scratch
                or      scratch,target
                .endm

                .text
start:          set_up
                address digest,ar2
                address initial,ar1
                ldi     4,rc
                rptb    copied
                ldi     *ar1++,r0
copied:         sti     r0,*ar2++
                ldi     @length,r0              ; blocks := (length + 8)/64 + 1
                addi    8,r0
                lsh     -6,r0
                addi    1,r0
                sti     r0,@blocks
                ldi     0,r0
                sti     r0,@block
next_block:     call    fill
                call    expand
                call    rounds
                ldi     @block,r0
                addi    1,r0
                sti     r0,@block
                cmpi    @blocks,r0
                blt     next_block
done:           b       done

initial:        .word   067452301h,0EFCDAB89h,098BADCFEh,010325476h,0C3D2E1F0h

; W(0..15): the block's words, bytes reversed; after the last byte 80h, zeros, and at the very end the length in bits.
fill:           address W,ar0
                address message,ar1
                ldi     @block,r1
                lsh     4,r1                    ; number of its first word
                addi    r1,ar1
                ldi     @length,r2
                lsh     -2,r2                   ; full words
                ldi     15,ar5
fill_word:      cmpi    r2,r1
                blt     fill_full
                beq     fill_last
                ldi     0,r3
                b       fill_put
fill_full:      ldi     *ar1,r4
                call    turn
                b       fill_put
fill_last:      ldi     @length,r5              ; 0 to 3 bytes, then 80h
                and     3,r5
                mpyi    8,r5
                ldi     1,r3
                lsh     r5,r3
                subi    1,r3
                and     *ar1,r3
                ldi     80h,r4
                lsh     r5,r4
                or      r3,r4
                call    turn
fill_put:       sti     r3,*ar0++
                addi    1,ar1
                addi    1,r1
                db      ar5,fill_word
                ldi     @blocks,r0
                subi    1,r0
                cmpi    @block,r0
                bne     fill_done
                ldi     @length,r0
                lsh     3,r0
                sti     r0,*-ar0(1)
fill_done:      rets

; R3 := R4 with its bytes in reverse order. Uses R0.
turn:           lbu0    r4,r0
                mb3     r0,r3
                lbu1    r4,r0
                mb2     r0,r3
                lbu2    r4,r0
                mb1     r0,r3
                lbu3    r4,r0
                mb0     r0,r3
                rets

; W(t) := rotate(W(t-3) xor W(t-8) xor W(t-14) xor W(t-16), 1), t = 16..79
expand:         address W + 16,ar0
                ldi     63,rc
                rptb    expanded
                ldi     *-ar0(3),r0
                xor     *-ar0(8),r0
                xor     *-ar0(14),r0
                xor     *-ar0(16),r0
                rol     r0
expanded:       sti     r0,*ar0++
                rets

; Twenty rounds; `choose` puts f(b,c,d) into R5. a to e are R0 to R4; K in R8; AR0 goes through W.
twenty          .macro  choose,high,low
                ldhi    high,r8
                or      low,r8
                ldi     19,rc
                rptb    last?
                choose
                addi    r5,r4
                addi    r8,r4
                addi    *ar0++,r4
                rotate  5,r0,r5,r6
                addi    r4,r5                   ; the new a
                ldi     r3,r4
                ldi     r2,r3
                rotate  30,r1,r2,r6
                ldi     r0,r1
last?:          ldi     r5,r0
                .endm

choice          .macro                          ; d xor (b and (c xor d))
                xor3    r2,r3,r5
                and     r1,r5
                xor     r3,r5
                .endm
parity          .macro
                xor3    r1,r2,r5
                xor     r3,r5
                .endm
majority        .macro                          ; (b and c) or (d and (b or c))
                and3    r1,r2,r5
                or3     r1,r2,r6
                and     r3,r6
                or      r6,r5
                .endm

rounds:         address W,ar0
                address digest,ar2
                ldi     *+ar2(0),r0
                ldi     *+ar2(1),r1
                ldi     *+ar2(2),r2
                ldi     *+ar2(3),r3
                ldi     *+ar2(4),r4
                twenty  choice,5A82h,7999h
                twenty  parity,6ED9h,0EBA1h
                twenty  majority,8F1Bh,0BCDCh
                twenty  parity,0CA62h,0C1D6h
                addi    *+ar2(0),r0
                addi    *+ar2(1),r1
                addi    *+ar2(2),r2
                addi    *+ar2(3),r3
                addi    *+ar2(4),r4
                sti     r0,*+ar2(0)
                sti     r1,*+ar2(1)
                sti     r2,*+ar2(2)
                sti     r3,*+ar2(3)
                sti     r4,*+ar2(4)
                rets
