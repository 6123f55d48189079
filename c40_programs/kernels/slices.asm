; Long tasks in several blocks (scheduling.slice_cycles; plant-and-bus.md 4.6 item 4). MUST_CONTINUE: loaded again, with
; TB_SLICE one higher. Any DSP may take that block, so the task keeps what it still needs in shared memory, at SV_BASE.
;
; Slice k reads the half that slice k - 1 has written and writes the other half, so that a slice can run again.

        .if AG_WORDS != 100h
        .error "slice_place takes an AGV's number from its area by a shift"
        .endif

SL_LEFT         .set SCRATCH + 1000             ; i units of work left in this block
SL_ROWS         .set SCRATCH + 1001             ; i rows of the bay
SL_DWA          .set SCRATCH + 96               ; what the dynamic window needs: points, discs, the best so far
SL_DWA_WORDS    .set DW_END - SL_DWA
SL_IDENTIFY     .set ID_ROW                     ; what identify needs between two rows
SL_IDENTIFY_WORDS .set 26
SL_GRAB_WORDS   .set 172                        ; SCRATCH from the start: what the grab path needs between its routes

; AR0 <- half R0 & 1 of this block's robot.
slice_place:
        and     1, r0
        lsh     10, r0
        ldi     @TASK + TB_AREA, r1
        subi    AG_BASE, r1
        bn      slice_place_crane
        lsh     -8, r1
        addi    1, r1
        br      slice_place_robot
slice_place_crane:
        ldi     0, r1
slice_place_robot:
        lsh     11, r1
        addi    r1, r0
        ldhi    hi16(WINDOW_A + SV_BASE), ar0
        or      lo16(WINDOW_A + SV_BASE), ar0
        addi    r0, ar0
        rets

; RC + 1 words at AR1 <- the words that the block before kept.
slice_restore:
        ldi     @TASK + TB_SLICE, r0
        call    slice_place
        br      copy_words

; Keeps RC + 1 words from AR1 on, and ends the block: R0, R1 as a kernel returns them.
slice_keep:
        ldi     @TASK + TB_SLICE, r0
        addi    1, r0
        call    slice_place
        ldi     ar0, ar2
        ldi     ar1, ar0
        ldi     ar2, ar1
        call    copy_words
        ldi     0, r0
        ldi     MUST_CONTINUE, r1
        rets

; LEFT <- units of work in a block, at least one; *AR1 is 1/cycles of a unit.
slice_units:
        ldhi    hi16(WINDOW_A), ar0
        float   *+ar0(SLICE_CYCLES), r0
        mpyf    *ar1, r0
        fix     r0, r0
        cmpi    1, r0
        ldilt   1, r0
        sti     r0, @SL_LEFT
        rets
slice_sample:   .float  1.0 / 1839.0            ; a sample of the dynamic window
slice_row:      .float  1.0 / 24990.0           ; a row of the bay, with its 128 reads on bus B

; ---- synthetic load: slices of SLICE_CYCLES
kernel_avoidance_sliced:
        ldhi    hi16(WINDOW_A), ar0
        ldi     *+ar0(SLICE_CYCLES), r3
        ldi     @TASK + TB_SLICE, r0
        mpyi    r3, r0
        ldi     @TASK + TB_ARGUMENT, r1
        subi    r0, r1                          ; work that is left
        ldi     0, r2
        cmpi    r3, r1
        ble     slice_avoidance
        ldi     r3, r1
        ldi     MUST_CONTINUE, r2
slice_avoidance:
        sti     r1, @TASK + TB_ARGUMENT
        sti     r2, @SL_LEFT
        call    kernel_avoidance
        ldi     @SL_LEFT, r1
        rets

; ---- dynamic window: some of its 121 samples
kernel_avoidance_dwa_sliced:
        ldhi    hi16(slice_sample), ar1
        or      lo16(slice_sample), ar1
        call    slice_units
        ldi     @TASK + TB_SLICE, r0
        bnz     slice_dwa_on
        ldi     DW_SECTORS, r0
        call    avoid_look
        cmpi    0, r0
        beq     avoid_nothing
        call    dwa_discs
        call    dwa_window
        call    dwa_lanes
        ldi     0, r0
        sti     r0, @DW_I
        sti     r0, @DW_J
        br      slice_dwa
slice_dwa_on:
        ldhi    hi16(SL_DWA), ar1
        or      lo16(SL_DWA), ar1
        ldi     SL_DWA_WORDS - 1, rc
        call    slice_restore
slice_dwa:
        float   @DW_I, r0
        mpyf    @DW_DV, r0
        addf    @DW_V0, r0
        stf     r0, @DW_V
        call    dwa_arc
        call    dwa_score
        ldi     @DW_J, r0
        addi    1, r0
        sti     r0, @DW_J
        cmpi    DW_SAMPLES, r0
        blt     slice_dwa_next
        ldi     0, r0
        sti     r0, @DW_J
        ldi     @DW_I, r0
        addi    1, r0
        sti     r0, @DW_I
        cmpi    DW_SAMPLES, r0
        bge     dwa_done
slice_dwa_next:
        ldi     @SL_LEFT, r0
        subi    1, r0
        sti     r0, @SL_LEFT
        bnz     slice_dwa
        ldhi    hi16(SL_DWA), ar1
        or      lo16(SL_DWA), ar1
        ldi     SL_DWA_WORDS - 1, rc
        br      slice_keep

; ---- identify: some rows. Each block writes a target and a bay box; those of the last block are the result.
kernel_identify_sliced:
        ldhi    hi16(slice_row), ar1
        or      lo16(slice_row), ar1
        call    slice_units
        ldi     @TASK + TB_SLICE, r0
        bnz     slice_identify_on
        identify_begin
        br      slice_identify
slice_identify_on:
        ldhi    hi16(SL_IDENTIFY), ar1
        or      lo16(SL_IDENTIFY), ar1
        ldi     SL_IDENTIFY_WORDS - 1, rc
        call    slice_restore
        ldhi    hi16(WINDOW_B), ar5
slice_identify:
        ldi     *+ar5(SCAN_ROWS), r0
        sti     r0, @SL_ROWS
        cmpi    0, r0
        ble     identify_done
        ldi     @ID_ROW, r1
        addi    @SL_LEFT, r1
        cmpi    r0, r1
        ldigt   r0, r1
        sti     r1, @ID_ROWS
        call    identify_row
        ldi     @ID_ROWS, r2
        cmpi    @SL_ROWS, r2
        retsge
        ldhi    hi16(SL_IDENTIFY), ar1
        or      lo16(SL_IDENTIFY), ar1
        ldi     SL_IDENTIFY_WORDS - 1, rc
        br      slice_keep

; ---- grab path: one route after the other
kernel_grab_path_sliced:
        ldi     @TASK + TB_SLICE, r0
        bnz     slice_grab_on
        grab_path_first
        ldhi    hi16(SCRATCH), ar1
        or      lo16(SCRATCH), ar1
        ldi     SL_GRAB_WORDS - 1, rc
        br      slice_keep
slice_grab_on:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(SCRATCH), ar1
        ldi     SL_GRAB_WORDS - 1, rc
        call    slice_restore
        br      grab_path_second
