; void *malloc(size_t words), void free(void *): first fit in .sysmem; the linker gives __SYSMEM_SIZE. Full: null.
;
; A block is a word with its size and then that many words. A free block's first word is the address of the next free
; block, by rising address, or 0 in the last one. free() joins neighbours that are both free.

                .include "c_runtime.inc"
                .global _malloc, _free, __sys_memory
                .ref    __SYSMEM_SIZE

                .if     !defined(HEAP_WORDS)
HEAP_WORDS      .set    1000h
                .endif
__sys_memory    .usect  ".sysmem",HEAP_WORDS
                .data
heap_first:     .word   0                       ; the first free block
heap_ready:     .word   0

                .text
_malloc:        whole_argument r0
                cmpi    0,r0
                ldiz    1,r0                    ; malloc(0) gets a pointer of its own too
                blt     no_room
                address heap_ready,ar0
                ldi     *ar0,r1
                bnz     search
                ldi     1,r1
                sti     r1,*ar0
                address __SYSMEM_SIZE,r1
                subi    1,r1                    ; but the block's size
                ble     no_room
                address __sys_memory,ar1
                sti     r1,*ar1
                ldi     0,r1
                sti     r1,*+ar1(1)
                ldi     ar1,r1
                address heap_first,ar0
                sti     r1,*ar0

search:         address heap_first,ar0          ; AR0: the word that points to the block
next_free:      ldi     *ar0,r1
                bz      no_room
                lda     r1,ar1
                ldi     *ar1,r2
                subi3   r0,r2,r3                ; words too many
                bge     take
                addi3   1,ar1,r1
                lda     r1,ar0
                b       next_free

take:           ldi     *+ar1(1),r1             ; the word that pointed to this block now points to the next
                cmpi    2,r3
                blt     taken                   ; the rest is too small for a block
                sti     r0,*ar1
                addi3   1,ar1,r2
                addi    r0,r2
                lda     r2,ar2                  ; the rest becomes a free block
                subi    1,r3
                sti     r3,*ar2
                sti     r1,*+ar2(1)
                ldi     ar2,r1
taken:          sti     r1,*ar0
                addi3   1,ar1,r0
                rets
no_room:        ldi     0,r0
                rets

_free:          whole_argument r0
                cmpi    0,r0
                retsz
                subi    1,r0                    ; the block
                lda     r0,ar2
                address heap_first,ar0
                ldi     0,r2                    ; the free block before it
find_place:     ldi     *ar0,r1
                bz      insert
                cmpi    r0,r1
                bhi     insert
                ldi     r1,r2
                addi    1,r1
                lda     r1,ar0
                b       find_place

insert:         ldi     *ar0,r1
                sti     r0,*ar0
                sti     r1,*+ar2(1)
                lda     r0,ar1                  ; joined with the next free block
                call    join_next
                cmpi    0,r2
                retsz
                lda     r2,ar1                  ; and with the free block before

; AR1: a free block. Joins it with the next free block if that follows directly.
join_next:      ldi     *+ar1(1),r1
                retsz
                ldi     *ar1,r3
                addi3   1,ar1,ar0
                addi    r3,ar0
                cmpi    r1,ar0
                retsnz
                lda     r1,ar0
                ldi     *ar0,r1
                addi    r1,r3
                addi    1,r3
                sti     r3,*ar1
                ldi     *+ar0(1),r1
                sti     r1,*+ar1(1)
                rets
