; void *memset(void *, int, size_t), void *memcpy(void *, const void *, size_t): compilers call them for variables of
; several words (docs/from-c.md).
; Sizes count words.

                .include "c_runtime.inc"
                .global _memset, _memcpy

three_arguments .macro                          ; AR2, R2, R3
                .if     !defined(REGPARM)
                lda     sp,ar0
                lda     *-ar0(1),ar2
                ldi     *-ar0(2),r2
                ldi     *-ar0(3),r3
                .endif
                .endm

                .text
_memset:        three_arguments
                ldi     ar2,r0
                cmpi    0,r3
                retsz
                subi3   1,r3,rc
                rptb    filled
filled:         sti     r2,*ar2++
                rets

_memcpy:        three_arguments
                ldi     ar2,r0
                cmpi    0,r3
                retsz
                lda     r2,ar1
                subi3   1,r3,rc
                rptb    copied
                ldi     *ar1++,r1
copied:         sti     r1,*ar2++
                rets
