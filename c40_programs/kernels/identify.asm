; Process 1: is the job done, or where is the next container? (docs/kernels_job.md)
;
; Each row of the bay is scanned: h_i is the height of the topmost surface above the deck at x_i = x0 + i dx. Tops of
; tier T are at H = T CR_BOX_HEIGHT; a sample fits by g_i = max(0, 1 - ((h_i - H)/0.25 m)^2). A container's template
; is W = floor(12.192 m / dx) ones with a guard of -1/2 on either side; its correlation with g over all shifts m is
;     c_m = g_m + ... + g_(m+W-1) - (g_(m-1) + g_(m+W)) / 2
; A maximum of at least 0.93 W is a container. A sample is the mean height of a cell dx long, so its edges show in the
; cells they cut: with i the last cell to the left that no longer fits (g = 0), and j the first to the right,
;     left edge at i + 3/2 - (h_i + h_(i+1))/H,  right edge at j - 3/2 + (h_j + h_(j-1))/H,  in cells
; and its middle is the middle of these. The next container is in the highest tier, and there the nearest to the
; crane's column. CR_BAY is the box around everything in the bay, for the grab path.

ID_FIT              .set SCRATCH + 128          ; g, 128 samples between two zeros
ID_TEMPLATE         .set SCRATCH + 258          ; up to 126 ones between two guards
ID_SCORE            .set SCRATCH + 386          ; c, up to 127 shifts between two zeros
ID_ROW              .set SCRATCH + 516          ; i
ID_ROWS             .set SCRATCH + 517          ; i
ID_Y                .set SCRATCH + 518          ; m, of the row
ID_X0               .set SCRATCH + 519          ; m
ID_DX               .set SCRATCH + 520          ; m
ID_DECK             .set SCRATCH + 521          ; m
ID_WIDTH            .set SCRATCH + 522          ; i, W
ID_SHIFTS           .set SCRATCH + 523          ; i, 129 - W
ID_TIER             .set SCRATCH + 524          ; i
ID_BEST_TIER        .set SCRATCH + 525          ; i, 0: none yet
ID_BEST_RANGE       .set SCRATCH + 526          ; m^2
ID_BEST             .set SCRATCH + 528          ; x, y, z, yaw
ID_BOX              .set SCRATCH + 532          ; m, height of a container
ID_ENOUGH           .set SCRATCH + 533          ; least score
ID_TOP              .set SCRATCH + 534          ; m, highest surface of all rows
ID_FIRST            .set SCRATCH + 535          ; i, lowest sample above the deck, of all rows
ID_LAST             .set SCRATCH + 536          ; i, highest
ID_Y_LEAST          .set SCRATCH + 537          ; m, of all rows
ID_Y_MOST           .set SCRATCH + 538
ID_LEFT             .set SCRATCH + 539          ; i, of the present container
ID_RIGHT            .set SCRATCH + 540          ; j
ID_HEIGHT           .set SCRATCH + 542          ; h, 128 samples between two zeros
ID_SHIFTS_BEAT      .set 16
ID_NARROWEST        .set 4                      ; samples that a container must have

identify_begin  .macro
        ldhi    hi16(WINDOW_B), ar5
        ldf     *+ar6(CR_BOX_HEIGHT), r0
        stf     r0, @ID_BOX
        ldi     0, r0
        sti     r0, @ID_BEST_TIER
        sti     r0, @ID_ROW
        ldf     @K_ID_FAR, r0
        stf     r0, @ID_BEST_RANGE
        stf     r0, @ID_Y_LEAST
        negf    r0
        stf     r0, @ID_Y_MOST
        stf     r0, @ID_TOP
        ldi     SCAN_COUNT, r0
        sti     r0, @ID_FIRST
        ldi     -1, r0
        sti     r0, @ID_LAST
        ldi     *+ar5(SCAN_ROWS), r0
        sti     r0, @ID_ROWS
        .endm

kernel_identify:
        identify_begin
        ble     identify_done
identify_row:
        call    alive
        call    identify_scan
        ldi     @ID_WIDTH, r0
        cmpi    ID_NARROWEST, r0
        blt     identify_next_row               ; with a wider spacing no container can be seen
        cmpi    126, r0
        bgt     identify_next_row
        call    identify_template
        ldi     BAY_TIERS, r0
        sti     r0, @ID_TIER
identify_tier:
        ldi     @ID_TIER, r0
        cmpi    @ID_BEST_TIER, r0
        blt     identify_next_row               ; a higher container is known already
        call    identify_fit
        call    identify_correlate
        call    identify_peaks
        ldi     @ID_TIER, r0
        subi    1, r0
        sti     r0, @ID_TIER
        bnz     identify_tier
identify_next_row:
        ldi     @ID_ROW, r0
        addi    1, r0
        sti     r0, @ID_ROW
        cmpi    @ID_ROWS, r0
        blt     identify_row
identify_done:
        ldi     @ID_BEST_TIER, r0
        bz      identify_none
        call    identify_bay
        ldhi    hi16(SCRATCH), ar0
        or      lo16(ID_BEST), ar0
        ldi     ar6, ar1
        addi    CR_TARGET, ar1
        ldi     3, rc
        call    copy_words
        ldi     1, r0
        ldi     MUST_PROCESS * 4, r1            ; must load 2
        rets
identify_none:
        ldi     0, r0
        ldhi    180h, r1                        ; MAY_PROCESS << 7 | MAY_PROCESS << 8
        rets

; ---- CR_BAY: from the first to the last sample above the deck, and half a container's width beyond the outer rows ----
identify_bay:
        ldhi    hi16(SCRATCH), ar0
        or      lo16(ID_SCORE), ar0             ; the scores are no longer needed
        ldi     ar6, ar1
        addi    CR_BAY, ar1
        float   @ID_FIRST, r0
        subf    1.0, r0
        mpyf    @ID_DX, r0
        addf    @ID_X0, r0
        stf     r0, *ar0
        float   @ID_LAST, r0
        addf    1.0, r0
        mpyf    @ID_DX, r0
        addf    @ID_X0, r0
        stf     r0, *+ar0(1)
        ldf     @ID_Y_LEAST, r0
        subf    @K_ID_HALF_WIDTH, r0
        stf     r0, *+ar0(2)
        ldf     @ID_Y_MOST, r0
        addf    @K_ID_HALF_WIDTH, r0
        stf     r0, *+ar0(3)
        ldf     @ID_DECK, r0
        stf     r0, *+ar0(4)
        ldf     @ID_TOP, r0
        stf     r0, *+ar0(5)
        ldi     5, rc
        call    copy_words
        rets

; ---- the profile of row ID_ROW, and W ----
identify_scan:
        ldi     @ID_ROW, r0
        sti     r0, *+ar5(SCAN_ROW)
        float   *+ar5(SCAN_Y), r0
        mpyf    @K_MILLI, r0
        stf     r0, @ID_Y
        ldf     @ID_Y_LEAST, r1
        cmpf    r1, r0
        ldflt   r0, r1
        stf     r1, @ID_Y_LEAST
        ldf     @ID_Y_MOST, r1
        cmpf    r1, r0
        ldfgt   r0, r1
        stf     r1, @ID_Y_MOST
        float   *+ar5(SCAN_X0), r0
        mpyf    @K_MILLI, r0
        stf     r0, @ID_X0
        float   *+ar5(SCAN_DECK), r6
        mpyf    @K_MILLI, r6
        stf     r6, @ID_DECK
        float   *+ar5(SCAN_DX), r0
        mpyf    @K_MILLI, r0
        stf     r0, @ID_DX
        call    m_reciprocal
        mpyf    @K_ID_LENGTH, r0
        fix     r0, r1                          ; floor
        sti     r1, @ID_WIDTH
        subri   SCAN_COUNT + 1, r1
        sti     r1, @ID_SHIFTS

        ldi     ar5, ar0
        addi    SCAN_PROFILE, ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(ID_HEIGHT), ar1
        ldf     @ID_TOP, r7
        ldi     @ID_FIRST, r8
        ldi     @ID_LAST, r9
        ldi     0, r10
        ldf     1.0, r2                         ; a higher surface is no deck
identify_scan_half:
        ldi     SCAN_COUNT / 2 - 1, rc
        rptb    identify_scanned
        float   *ar0++(1), r0
        mpyf    @K_MILLI, r0
        cmpf    r7, r0
        ldfgt   r0, r7
        subf    r6, r0
        stf     r0, *ar1++(1)
        ldi     SCAN_COUNT, r11
        ldi     -1, r1
        cmpf    r2, r0
        ldigt   r10, r11                        ; i, if it stands above the deck
        ldigt   r10, r1
        cmpi    r8, r11
        ldilt   r11, r8
        cmpi    r9, r1
        ldigt   r1, r9
identify_scanned:
        addi    1, r10
        call    alive
        cmpi    SCAN_COUNT, r10
        blt     identify_scan_half
        ldf     0.0, r0                         ; the zeros at both ends of h
        stf     r0, *ar1
        stf     r0, *-ar1(SCAN_COUNT + 1)
        sti     r8, @ID_FIRST
        sti     r9, @ID_LAST
        stf     r7, @ID_TOP
        rets

; ---- guard, W ones, guard; the least score ----
identify_template:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(ID_TEMPLATE), ar1
        ldf     -0.5, r0
        ldf     1.0, r1
        stf     r0, *ar1++(1)
        ldi     @ID_WIDTH, rc
        subi    1, rc
        rpts    rc
        stf     r1, *ar1++(1)
        stf     r0, *ar1
        float   @ID_WIDTH, r0
        mpyf    @K_ID_ENOUGH, r0
        stf     r0, @ID_ENOUGH
        rets

; ---- g for ID_TIER ----
identify_fit:
        float   @ID_TIER, r6
        mpyf    @ID_BOX, r6                     ; H
        ldf     @K_ID_TOLERANCE, r7
        ldhi    hi16(SCRATCH), ar0
        or      lo16(ID_HEIGHT), ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(ID_FIT), ar1
        ldf     0.0, r2
        ldf     1.0, r3
        stf     r2, *ar1++(1)
        ldi     SCAN_COUNT - 1, rc
        rptb    identify_fitted
        subf3   r6, *ar0++(1), r0
        mpyf    r0, r0
        mpyf    r7, r0
        subrf   r3, r0                          ; 1 - ((h - H)/0.25)^2
        ldflt   r2, r0
identify_fitted:
        stf     r0, *ar1++(1)
        stf     r2, *ar1
        rets

; ---- c_m for every shift: one multiply and one add per cycle ----
identify_correlate:
        call    alive
        ldhi    hi16(SCRATCH), ar2
        or      lo16(ID_FIT), ar2
        ldhi    hi16(SCRATCH), ar3
        or      lo16(ID_TEMPLATE), ar3
        ldhi    hi16(SCRATCH), ar4
        or      lo16(ID_SCORE), ar4
        ldi     @ID_SHIFTS, ar1
        subi    1, ar1
        ldi     @ID_WIDTH, r6
        addi    1, r6                           ; taps - 1
        ldi     ar1, r7
        ldf     0.0, r3
        stf     r3, *ar4++(1)
identify_shifts:
        ldi     r7, ir0                         ; a heartbeat after this many
        subi    ID_SHIFTS_BEAT, ir0
        cmpi    -1, ir0
        ldilt   -1, ir0
identify_shift:
        ldi     ar2, ar0
        ldi     ar3, ar1
        ldf     0.0, r0
        ldf     0.0, r2
        rpts    r6
        mpyf3   *ar0++(1), *ar1++(1), r0
        || addf3   r0, r2, r2
        addf    r0, r2
        stf     r2, *ar4++(1)
        addi    1, ar2
        subi    1, r7
        cmpi    ir0, r7
        bgt     identify_shift
        call    alive
        cmpi    0, r7
        bge     identify_shifts
        stf     r3, *ar4
        rets

; ---- maxima of c: places, and the best container so far ----
identify_peaks:
        ldhi    hi16(SCRATCH), ar2
        or      lo16(ID_SCORE), ar2             ; *+AR2(1) = c_m
        ldi     0, r8                           ; m
identify_peak:
        ldf     *+ar2(1), r6
        cmpf    @ID_ENOUGH, r6
        blt     identify_no_peak
        cmpf    *ar2, r6
        ble     identify_no_peak                ; must rise before ...
        cmpf    *+ar2(2), r6
        blt     identify_no_peak                ; ... and does not rise after it
        call    identify_place
identify_no_peak:
        addi    1, ar2
        addi    1, r8
        cmpi    @ID_SHIFTS, r8
        blt     identify_peak
        rets

; ---- the container at shift R8: edges, middle, height ----
; From the middle cell outwards as far as cells fit; the zeros at both ends of g end the search.
identify_place:
        call    alive
        ldi     @ID_WIDTH, r0
        lsh     -1, r0
        addi    r8, r0                          ; a cell in the middle
        ldhi    hi16(SCRATCH), ar0
        or      lo16(ID_FIT + 1), ar0
        addi    r0, ar0
        ldi     ar0, ar1
identify_left:
        ldf     *--ar0(1), r1
        bgt     identify_left
identify_right:
        ldf     *++ar1(1), r1
        bgt     identify_right
        ldhi    hi16(SCRATCH), ar3
        or      lo16(ID_FIT + 1), ar3
        subi    ar3, ar0
        subi    ar3, ar1
        sti     ar0, @ID_LEFT
        sti     ar1, @ID_RIGHT

        float   @ID_TIER, r0
        mpyf    @ID_BOX, r0                     ; H
        call    m_reciprocal
        ldhi    hi16(SCRATCH), ar0
        or      lo16(ID_HEIGHT), ar0
        ldi     ar0, ar1
        addi    @ID_LEFT, ar0
        addi    @ID_RIGHT, ar1
        ldf     *ar1, r1
        addf    *-ar1(1), r1
        subf    *ar0, r1
        subf    *+ar0(1), r1
        mpyf    r0, r1                          ; (h_j + h_(j-1) - h_i - h_(i+1)) / H
        ldi     @ID_LEFT, r2
        addi    @ID_RIGHT, r2
        float   r2, r2
        addf    r2, r1
        mpyf    0.5, r1                         ; middle, in cells
        mpyf    @ID_DX, r1
        ldf     r1, r0
        addf    @ID_X0, r0                      ; x of the middle
        mpyf3   r0, r0, r1
        ldf     @ID_Y, r2
        mpyf    r2, r2
        addf    r2, r1                          ; distance^2 from the column
        ldi     @ID_TIER, r2
        cmpi    @ID_BEST_TIER, r2
        bgt     identify_better
        cmpf    @ID_BEST_RANGE, r1
        bge     identify_place_done
identify_better:
        sti     r2, @ID_BEST_TIER
        stf     r1, @ID_BEST_RANGE
        rnd     r0
        stf     r0, @ID_BEST
        ldf     @ID_Y, r0
        stf     r0, @ID_BEST + 1
        ldf     0.0, r0
        stf     r0, @ID_BEST + 3                ; rows lie along x
        ldi     @ID_RIGHT, rc                   ; z: deck + mean of the cells i + 2 .. j - 2, which no edge cuts, + half
                                                ; a quantum
        subi    @ID_LEFT, rc
        subi    3, rc
        float   rc, r0
        subi    1, rc
        addi    2, ar0
        ldf     0.0, r4
        rpts    rc
        addf    *ar0++(1), r4
        call    m_reciprocal
        mpyf    r4, r0
        addf    @ID_DECK, r0
        addf    @K_ID_QUANTUM, r0
        rnd     r0
        stf     r0, @ID_BEST + 2
identify_place_done:
        rets
