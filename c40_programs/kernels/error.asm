; The error block (x = 1): decides the response by error_table and logs the error (areas.inc). TB_ARGUMENT gives the
; event and what the host knows; host and PID carry out the response. docs/controller.md, Errors, explains the rows.

; The first matching row decides: its origin is the error's; of the bits in word 2 exactly those in word 3 are set.
error_table:
        .word   ERROR_FOLLOWING, ERROR_LOWERING + ERROR_HOIST, ERROR_LOWERING, RESPOND_SET_DOWN
        .word   ERROR_FOLLOWING, 0, 0, RESPOND_STOP
        .word   ERROR_FAULT, ERROR_LOWERING + ERROR_HOIST, ERROR_LOWERING, RESPOND_SET_DOWN
        .word   ERROR_FAULT, 0, 0, RESPOND_STOP
        .word   ERROR_OVERSPEED, ERROR_LOWERING + ERROR_HOIST, ERROR_LOWERING, RESPOND_SET_DOWN
        .word   ERROR_OVERSPEED, 0, 0, RESPOND_STOP
        .word   ERROR_SATURATION, ERROR_LOWERING + ERROR_HOIST, ERROR_LOWERING, RESPOND_SET_DOWN
        .word   ERROR_SATURATION, 0, 0, RESPOND_STOP
        .word   ERROR_HEAT, ERROR_LOWERING + ERROR_HOIST, ERROR_LOWERING, RESPOND_SET_DOWN
        .word   ERROR_HEAT, 0, 0, RESPOND_STOP
        .word   ERROR_LATE, ERROR_TRIES, ERROR_TRIES, RESPOND_RETRY
        .word   ERROR_LATE, 0, 0, RESPOND_HOLD
        .word   ERROR_ENCODER, ERROR_LOWERING + ERROR_HOIST, ERROR_LOWERING, RESPOND_SET_DOWN
        .word   ERROR_ENCODER, 0, 0, RESPOND_STOP
        .word   ERROR_SWAY, ERROR_SECOND, ERROR_SECOND, RESPOND_SECOND
        .word   ERROR_SWAY, ERROR_LOWERING, ERROR_LOWERING, RESPOND_SET_DOWN
        .word   ERROR_SWAY, 0, 0, RESPOND_STOP
        .word   ERROR_LANDING, ERROR_TRIES, ERROR_TRIES, RESPOND_RETRY
        .word   ERROR_LANDING, 0, 0, RESPOND_HOLD
        .word   ERROR_BLOCK, ERROR_TRIES, ERROR_TRIES, RESPOND_RETRY
        .word   ERROR_BLOCK, 0, 0, RESPOND_STOP
        .word   0, 0, 0, RESPOND_HOLD                   ; ends the table: an unknown origin

kernel_error:
        ldi     @TASK + TB_ARGUMENT, r4
        and3    0Fh, r4, r0                     ; the origin
        ldi     r4, r1                          ; the situation bits, and whether the hoist is concerned
        tstb    8 << ERROR_OF, r4
        beq     error_not_hoist
        ldhi    hi16(ERROR_HOIST), r2
        or      r2, r1
error_not_hoist:
        ldhi    hi16(error_table), ar0
        or      lo16(error_table), ar0
error_row:
        ldi     *ar0, r2
        beq     error_decided
        cmpi    r2, r0
        bne     error_next_row
        and3    *+ar0(1), r1, r2
        cmpi    *+ar0(2), r2
        beq     error_decided
error_next_row:
        addi    4, ar0
        br      error_row
error_decided:
        ldi     *+ar0(3), r5                    ; the response
; The entry first, then the count, so that a second run writes the same words.
        ldhi    hi16(WINDOW_A + ER_BASE), ar0
        or      lo16(WINDOW_A + ER_BASE), ar0
        lsh3    28, r5, r3
        or      r4, r3
        ldi     *ar0, r2                        ; errors so far
        beq     error_new
        subi    1, r2
        call    error_entry
        addi    1, r2
        ldi     *+ar1(ER_TICK), r0
        cmpi    @TASK + TB_TICK, r0
        bne     error_new
        cmpi    *+ar1(ER_WHAT), r3
        bne     error_new
        ldi     *+ar1(ER_AREA), r0
        cmpi    @TASK + TB_AREA, r0
        beq     error_done                      ; the last entry is of this same error: its block runs again
error_new:
        call    error_entry
        ldi     @TASK + TB_TICK, r0
        sti     r0, *+ar1(ER_TICK)
        sti     r3, *+ar1(ER_WHAT)
        ldi     @TASK + TB_AREA, r0
        sti     r0, *+ar1(ER_AREA)
        ldi     @TASK + TB_GENERATION, r0
        sti     r0, *+ar1(ER_GENERATION)
        addi    1, r2
        sti     r2, *ar0
error_done:
        ldi     r2, r0
        and     0FFFFh, r0
        lsh     RESPOND_PLACE, r5
        or      r5, r0
        ldi     0, r1
        rets
; AR1 <- entry R2 of the log at AR0.
error_entry:
        ldi     r2, ar1
        and     ER_ENTRIES - 1, ar1
        lsh     2, ar1
        addi    ar0, ar1
        addi    ER_LOG, ar1
        rets
