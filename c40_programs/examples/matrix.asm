; Product of two matrices of floats, stored by rows: C (rows x columns) := A (rows x inner) B (inner x columns).
;
; To see: the C40's inner loop, one multiply and one add per cycle under RPTS; a column walked with a stride in IR1; RND
; before a store.

                .include "examples.inc"

                .bss    variables,0
                .bss    rows,1
                .bss    inner,1
                .bss    columns,1
                .bss    a,1024
                .bss    b_matrix,1024
                .bss    c_matrix,1024

                .text
start:          set_up
                address a,ar4                   ; row of A
                address c_matrix,ar2
                ldi     @columns,ir1
                ldi     @inner,r9
                subi    2,r9                    ; products after the first, less one
                ldi     @rows,ar6
                subi    1,ar6
next_row:       address b_matrix,ar5            ; column of B
                ldi     ir1,ar7
                subi    1,ar7
next_column:    ldi     ar4,ar0
                ldi     ar5,ar1
                mpyf3   *ar0++(1),*ar1++(ir1),r0
                ldf     0.0,r2
                cmpi    0,r9
                blt     summed                  ; inner = 1
                rpts    r9
                mpyf3   *ar0++(1),*ar1++(ir1),r0
        ||      addf3   r0,r2,r2
summed:         addf    r0,r2
                rnd     r2
                stf     r2,*ar2++
                addi    1,ar5
                db      ar7,next_column
                addi    @inner,ar4
                db      ar6,next_row
done:           b       done
