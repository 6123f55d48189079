; The claim where tasks have a DSP of their own (dsp of [[tasks]], docs/add-a-task.md). Only such an image contains it.
;
; A block whose TB_OWNER is 0 is for any DSP; any other block is for one DSP only. A DSP starts at the work pointer and
; takes the first free block that it may run, by falling J. It moves the work pointer only if that block is the one it
; points to. So all blocks before the pointer are taken, and no DSP passes a block that any DSP may claim.

; Continues exec_claim, which has acquired the list and read the work pointer: R0 the pointer, not 0; AR0 window A; AR1
; the semaphore. Ends as exec_claim does.
own_claim:
        ldi     @EXEC_SLOT, r4
        addi    1, r4
        ldi     r0, r5
own_look:
        addi3   r0, ar0, ar2
        ldi     *+ar2(TB_J), r0
        beq     exec_none                               ; the other blocks are not to be run early
        ldi     *+ar2(TB_LINK), r0
        ldi     *+ar2(TB_OWNER), r1
        beq     own_take                                ; it waits, for any DSP: a taken block has an owner
        cmpi    r4, r1
        bne     own_next
        ldi     *+ar2(TB_FLAG), r1
        beq     own_take                                ; it waits for this DSP, or this DSP took it before
own_next:
        cmpi    0, r0
        bne     own_look
        br      exec_none
own_take:
        ldi     0, r2
        ldi     FLAG_TAKEN, r3
        sti     r2, *+ar2(TB_T)
        sti     r3, *+ar2(TB_FLAG)
        sti     r4, *+ar2(TB_OWNER)
        addi    ar0, r5
        cmpi    ar2, r5
        bne     own_taken                               ; the pointer stays where it is
        sti     r0, *+ar0(LIST_WORK_POINTER)
own_taken:
        sti     r2, *ar1                                ; release
        sti     ar2, @EXEC_BLOCK
        ldi     1, r0
        rets
