; Strings of bytes, four to a word, the first in bits 7-0, ended by a zero byte: length, comparison, upper case, and a
; copy of `size` bytes from any byte of a word to the beginning of another. Inputs `first`, `second`, `size`, `offset`;
; results `first_length`, `order` (-1, 0, 1), `upper` and `copy`.
;
; To see: LBU and MB change bytes in place; LWR and LWL build an unaligned word from two aligned words.

                .include "examples.inc"

                .bss    variables,0
                .bss    size,1
                .bss    offset,1
                .bss    first_length,1
                .bss    order,1
                .bss    first,64
                .bss    second,64
                .bss    upper,64
                .bss    copy,65

                .text
start:          set_up
                address first,ar0
                call    string_length
                sti     r1,@first_length
                address first,ar0
                address second,ar1
                call    compare
                sti     r2,@order
                address first,ar0
                address upper,ar1
                call    upper_case
                call    copy_bytes
done:           b       done

test_byte       .macro  n,found                 ; byte n of R0
                lbu:n:  r0,r2
                bz      found
                addi    1,r1
                .endm

; R1: number of bytes before the zero, from AR0 on.
string_length:  ldi     0,r1
length_word:    ldi     *ar0++,r0
                test_byte 0,length_found
                test_byte 1,length_found
                test_byte 2,length_found
                test_byte 3,length_found
                b       length_word
length_found:   rets

compare_byte    .macro  n
                lbu:n:  *ar0,r0
                lbu:n:  *ar1,r1
                cmpi    r1,r0
                bne     differ
                cmpi    0,r0
                beq     same
                .endm

; R2: -1, 0 or 1: the string at AR0 sorts before, is equal to, or sorts after the string at AR1.
compare:        compare_byte 0
                compare_byte 1
                compare_byte 2
                compare_byte 3
                addi    1,ar0
                addi    1,ar1
                b       compare
differ:         ldigt   1,r2
                ldilt   -1,r2
                rets
same:           ldi     0,r2
                rets

upper_byte      .macro  n
                lbu:n:  r0,r1
                ldi     r1,r2
                subi    'a',r2
                cmpi    26,r2
                bhs     skip?                   ; unsigned: no small letter
                subi    32,r1
                mb:n:   r1,r0
skip?:
                cmpi    0,r1
                beq     upper_done
                .endm

upper_case:     ldi     *ar0++,r0
                upper_byte 0
                upper_byte 1
                upper_byte 2
                upper_byte 3
                sti     r0,*ar1++
                b       upper_case
upper_done:     sti     r0,*ar1++
                rets

; copy(0 ..) := bytes `offset` .. of `first`, `size` of them, in whole words.
fit             .macro  n                       ; words that begin at byte n of the word at AR0
                .if     n == 0
                ldi     *ar0++,r0
                .else
                .eval   4-n,rest
                lwr:n:  *ar0++,r0               ; the upper bytes of this word move down
                lwl:rest: *ar0,r0               ; the lower bytes of the next word go above them
                .endif
                .endm

copy_bytes:     address first,ar0
                address copy,ar1
                ldi     @offset,r1
                ldi     r1,r2
                lsh     -2,r2
                addi    r2,ar0
                and     3,r1
                ldi     @size,r3
                addi    3,r3
                lsh     -2,r3
                ldi     r3,ar5
                subi    1,ar5
                blt     copy_done
                cmpi    1,r1
                beq     from_1
                cmpi    2,r1
                beq     from_2
                cmpi    3,r1
                beq     from_3
from_0:         fit     0
                sti     r0,*ar1++
                db      ar5,from_0
                rets
from_1:         fit     1
                sti     r0,*ar1++
                db      ar5,from_1
                rets
from_2:         fit     2
                sti     r0,*ar1++
                db      ar5,from_2
                rets
from_3:         fit     3
                sti     r0,*ar1++
                db      ar5,from_3
copy_done:      rets
