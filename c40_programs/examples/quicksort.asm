; Quicksort (Hoare's partition, the middle element as pivot) of `count` signed words at `numbers`, in place.
;
; To see: recursion on a stack that grows upwards; scans by pre-increment; parallel stores that swap two words in the
; slots of a delayed branch; signed comparison.

                .include "examples.inc"

                .bss    variables,0
                .bss    count,1
                .bss    deepest,1               ; words of stack used
                .bss    numbers,4096

                .text
start:          set_up
                address numbers,ar0
                ldi     ar0,ar1
                addi    @count,ar1
                subi    1,ar1                   ; AR0, AR1: first and last
                address stack,ar7
                ldi     0,r0
                sti     r0,@deepest
                call    sort
done:           b       done

sort:           ldi     sp,r0
                subi    ar7,r0
                cmpi    @deepest,r0
                ble     sort_part
                sti     r0,@deepest
sort_part:      cmpi    ar1,ar0
                bge     sorted
                ldi     ar1,r1
                subi    ar0,r1
                lsh     -1,r1
                ldi     r1,ir0
                ldi     *+ar0(ir0),r2           ; the pivot
                ldi     ar0,ar2
                subi    1,ar2
                ldi     ar1,ar3
                addi    1,ar3
partition:      ldi     *++ar2(1),r3
                cmpi    r2,r3
                blt     partition
from_above:     ldi     *--ar3(1),r4
                cmpi    r2,r4
                bgt     from_above
                cmpi    ar3,ar2
                bge     parted
                bd      partition
                sti     r4,*ar2
        ||      sti     r3,*ar3
                nop
                nop
parted:         push    ar3                     ; the first part by recursion, the second by the loop
                push    ar1
                ldi     ar3,ar1                 ; first .. AR3
                call    sort
                pop     ar1
                pop     ar0
                addi    1,ar0                   ; AR3 + 1 .. last
                b       sort_part
sorted:         rets
