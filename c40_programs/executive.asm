; The executive: claims the block at the work pointer (ruling 21), runs it, marks it done, and claims the next one.
; It idles when no block waits. With OWN_BLOCKS it claims the first block that this DSP may run (claim_own.asm).

IDLE_DOORBELL   .set 0                  ; announce idleness, sleep until IIOF0 rings
IDLE_PAUSE      .set 1                  ; look again after pause_count NOPs
IDLE_SPIN       .set 2                  ; look again at once

IIF_DOORBELL    .set 9                  ; IIF: IIOF0 is an edge-triggered interrupt, enabled
IIF_RING        .set 4                  ; IIOF0's interrupt flag
ST_CACHE        .set 0800h              ; ST: instruction cache enabled
ST_GIE          .set 2000h

; The doorbell, and pins that nets drive: these interrupts only end IDLE.
isr_wake:
        reti

_start:
        ldi     ST_CACHE, st
        ldpk    PAGE
        ldhi    hi16(STACK), ar0
        or      lo16(STACK), ar0
        ldi     ar0, sp
        ldhi    hi16(vectors), ar0
        or      lo16(vectors), ar0
        ldpe    ar0, ivtp
        ldi     0, iie
        ldi     IIF_DOORBELL, iif                       ; the other nibbles belong to the task that uses the pins

        ldi     ar0, ar2
        addi    dsp_slot - vectors, ar2
        ldi     *ar2, r0
        sti     r0, @EXEC_SLOT
        addi    1, r0
        sti     r0, *+ar3(2)                            ; AR3 <- loader: the port's CPCR. Answer to the program's sender
        ldi     *+ar2(1), r0
        sti     r0, @EXEC_POLICY
        ldi     *+ar2(2), r0
        sti     r0, @EXEC_PAUSE

        addi    constants - vectors, ar0                ; constants: image -> on-chip RAM
        ldhi    hi16(CONSTANTS), ar1
        or      lo16(CONSTANTS), ar1
        ldi     constants_end - constants - 1, rc
        call    copy_words

; Take the next block and run it.
exec_next:
        call    exec_claim
        cmpi    0, r0
        beq     exec_idle
exec_run:
        ldi     ar2, ar0
        ldhi    hi16(TASK), ar1
        or      lo16(TASK), ar1
        ldi     BLOCK_WORDS - 1, rc
        call    copy_words
        ldhi    hi16(WINDOW_A), ar6
        ldi     @TASK + TB_AREA, r0
        addi    r0, ar6
        ldhi    hi16(TASK), ar7
        or      lo16(TASK), ar7
        ldi     @TASK + TB_KIND, ir0
        cmpi    KIND_COUNT, ir0
        bhs     exec_unknown                            ; unsigned: catches negative kinds too
        ldhi    hi16(exec_kernels), ar0
        or      lo16(exec_kernels), ar0
        ldi     *+ar0(ir0), r0
        callu   r0
exec_done:
        ldi     @EXEC_BLOCK, ar0
        ldi     FLAG_DONE, r2
        sti     r0, *+ar0(TB_RESULT)
        sti     r1, *+ar0(TB_NOTIFY)
        sti     r2, *+ar0(TB_FLAG)                      ; last: from here on the block belongs to the host
        br      exec_next

; This image has no kernel for the kind: result FFFFFFFFh, no notice, done. The host sees the result; the list continues.
exec_unknown:
        ldi     -1, r0
        ldi     0, r1
        br      exec_done

; A user's row for which the configuration gives no program.
kernel_none:
        ldi     -1, r0
        ldi     0, r1
        rets

exec_kernels:
        kind_kernels                                    ; task_block.inc
        .rept   KIND_COUNT - KIND_USER
        .word   kernel_none                             ; [[tasks]] of the configuration put their programs here
        .endr

; R0 <- 1 and AR2, EXEC_BLOCK <- address of the block in window A; or R0 <- 0 if no block is to be run.
exec_claim:
        ldhi    hi16(WINDOW_A), ar0
        ldhi    hi16(WINDOW_A + SEMAPHORE_LIST), ar1
exec_acquire:
        ldi     *ar1, r0                                ; 0: this DSP now has the semaphore
        beq     exec_acquired
        rpts    15                                      ; let the owner have the bus
        nop
        br      exec_acquire
exec_acquired:
        ldi     *+ar0(LIST_WORK_POINTER), r0
        beq     exec_none
        .ifdef  OWN_BLOCKS
        br      own_claim                               ; some blocks are for one DSP only (claim_own.asm)
        .else
        addi3   r0, ar0, ar2
        .endif
        ldi     *+ar2(TB_J), r0
        beq     exec_none                               ; waiting, but not to be run early
        ldi     *+ar2(TB_LINK), r1
        ldi     0, r2
        ldi     FLAG_TAKEN, r3
        sti     r2, *+ar2(TB_T)
        sti     r3, *+ar2(TB_FLAG)
        ldi     @EXEC_SLOT, r3
        addi    1, r3
        sti     r3, *+ar2(TB_OWNER)
        sti     r1, *+ar0(LIST_WORK_POINTER)
        sti     r2, *ar1                                ; release
        sti     ar2, @EXEC_BLOCK
        ldi     1, r0
        rets
exec_none:
        sti     r0, *ar1                                ; release
        ldi     0, r0
        rets

exec_idle:
        ldi     @EXEC_POLICY, r0
        cmpi    IDLE_PAUSE, r0
        bgt     exec_next                               ; IDLE_SPIN
        beq     exec_pause

; Doorbell. Nobody may ring before this DSP has announced itself, so an older ring is cleared first. After the
; announcement the DSP looks at the list again: the host may have added a block in between without ringing.
        andn    IIF_RING, iif
        ldhi    hi16(WINDOW_A + DOORBELL_IDLE), ar3
        or      lo16(WINDOW_A + DOORBELL_IDLE), ar3
        ldi     @EXEC_SLOT, r0
        sti     r0, *ar3
        call    exec_claim
        cmpi    0, r0
        bne     exec_busy
        idle                                            ; GIE <- 1; the ring clears this DSP's idle bit before it wakes
        andn    ST_GIE, st
        br      exec_next
exec_busy:
        ldhi    hi16(WINDOW_A + DOORBELL_BUSY), ar3
        or      lo16(WINDOW_A + DOORBELL_BUSY), ar3
        ldi     @EXEC_SLOT, r0
        sti     r0, *ar3
        br      exec_run

exec_pause:
        ldi     @EXEC_PAUSE, r0
        rpts    r0
        nop
        br      exec_next
