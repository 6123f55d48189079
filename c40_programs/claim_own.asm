; The claim where tasks have a DSP of their own (dsp of [[tasks]], docs/add-a-task.md). It is in the image only then.
;
; A block whose TB_OWNER is 0 is for any DSP, else for that one alone. From the work pointer on, by falling J, a DSP
; passes what is taken and what is another's, and takes the first block that is left. It moves the work pointer only if
; that is the block it pointed to: so all before the pointer are taken, and nobody passes a block that anyone may claim.

; Goes on from exec_claim, which has the list and has read the work pointer: R0 the pointer, not 0; AR0 window A; AR1
; the semaphore. Ends as exec_claim does.
own_claim:
        ldi     @EXEC_SLOT, r4
        addi    1, r4
        ldi     r0, r5
own_look:
        addi3   r0, ar0, ar2
        ldi     *+ar2(TB_J), r0
        beq     exec_none                               ; the rest is not to be run early
        ldi     *+ar2(TB_LINK), r0
        ldi     *+ar2(TB_OWNER), r1
        beq     own_take                                ; it waits, for anybody: a taken one has an owner
        cmpi    r4, r1
        bne     own_next
        ldi     *+ar2(TB_FLAG), r1
        beq     own_take                                ; it waits for this DSP, or else is what this DSP took before
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
