; C := A B for matrices of 64 x 64 floats on a ring of 1, 2, 4, 8, 16 or more chips:
; `emulator exec matrix_ring.asm --topology ring:8`.
;
; Chip k has m = 64 / chips rows of A in `a_part` (row by row) and as many columns of B in `b_part` (column by column),
; from row and column k m on. It computes its rows of C in `c_part`. The columns go round the ring past every chip.
;
; To see: all chips send at the same time, so no chip may send a whole part before it reads. Two FIFOs hold 16 words,
; and a ring of chips that all wait for room is a deadlock (the emulator would report it). So a chip sends eight words,
; then reads eight, then sends the next eight.

                .include "../examples.inc"
                .include "ports.inc"

N               .set    64

                .bss    variables,0
                .bss    chips,1
                .bss    rows,1                  ; m
                .bss    part,1                  ; number of the chip whose columns of B are here
a_part          .usect  "parts",N*N
b_part          .usect  "parts",N*N
c_part          .usect  "parts",N*N

                .text
start:          set_up
                sti     r0,@part                ; at first its own
                sti     r1,@chips
                ldi     N,r4
halve:          cmpi    1,r1
                beq     halved
                lsh     -1,r1
                lsh     -1,r4
                bu      halve
halved:         sti     r4,@rows
                ldi     @chips,ar7
                subi    1,ar7

step:           address c_part,ar2
                ldi     @part,r5
                mpyi    @rows,r5
                addi    r5,ar2                  ; where row 0 meets these columns
                address a_part,ar4
                ldi     @rows,ar6
                subi    1,ar6
next_row:       address b_part,ar1
                ldi     ar2,ar5
                ldi     @rows,ar3
                subi    1,ar3
next_column:    ldi     ar4,ar0
                mpyf3   *ar0++(1),*ar1++(1),r0
                ldf     0.0,r2
                rpts    N-2
                mpyf3   *ar0++(1),*ar1++(1),r0
        ||      addf3   r0,r2,r2
                addf    r0,r2
                rnd     r2
                stf     r2,*ar5++
                db      ar3,next_column
                addi    N,ar4
                addi    N,ar2
                db      ar6,next_row

                cmpi    0,ar7
                beq     done
                address port_control + output,ar0               ; on through port 0
                address port_control + 3 * port_step + input,ar4        ; from port 3
                address b_part,ar1
                ldi     @rows,r5
                mpyi    N/8,r5
                subi    1,r5
                ldi     r5,ar2
pass:           ldi     ar1,ar5                 ; eight words out
                ldi     *ar5++,r2
                rpts    6
                ldi     *ar5++,r2
        ||      sti     r2,*ar0
                sti     r2,*ar0
                ldi     *ar4,r2                 ; and read eight, into the same places
                rpts    6
                ldi     *ar4,r2
        ||      sti     r2,*ar1++
                sti     r2,*ar1++
                db      ar2,pass
                ldi     @part,r5                ; now the columns of the chip before
                subi    1,r5
                ldi     @chips,r6
                subi    1,r6
                and     r6,r5
                sti     r5,@part
                db      ar7,step
done:           b       done
