; Sub-process 1, crane: Cartesian point k of the present leg (docs/kernels.md, "Trajectory").
;
; The payload's path through the via points P_0 .. P_n is a sum of blends of degree 9 that overlap by half the shorter
; one:
;   p(t) = P_0 + sum (P_i - P_i-1) S((t - t_i) / T_i),    t_i+1 = t_i + T_i - min(T_i, T_i+1) / 2
; The written point is the suspension above which such a payload hangs without sway:
;   x, y: p + (l / g) p''     with its rates, l the rope's length there; z, yaw: p
; The payload's own p'' in x, y follows, for the reference of the sway.
;
; State: a selector word (0: never run), then two banks. A leg's bank is written before the selector selects it. So two
; DSPs can compute the same point with the same result.

TJ_BANK_STRIDE  .set 23
TJ_BANK_WORDS   .set 21
TJ_K0           .set SCRATCH + 0        ; first point of the leg
TJ_COUNT        .set SCRATCH + 1        ; its number of points
TJ_SEGMENTS     .set SCRATCH + 2        ; n
TJ_ROUTE        .set SCRATCH + 3        ; offset of its via points in the area; 0: an alignment, which has none
TJ_BEGIN        .set SCRATCH + 4        ; P_0
TJ_END          .set SCRATCH + 8        ; P_n
TJ_DURATION     .set SCRATCH + 12       ; T_i, 8 words
TJ_PERIOD       .set SCRATCH + 20       ; s between points
TJ_CHAIN        .set SCRATCH + 32       ; P_0 .. P_n, 4 words each
TJ_SUM          .set SCRATCH + 80       ; p and its derivatives 1..4, 4 words each; the output is built in place
TJ_START        .set SCRATCH + 112      ; t_i, 8 words
TJ_TOTAL        .set SCRATCH + 120
TJ_SELECTOR     .set SCRATCH + 121
TJ_SHAPED       .set SCRATCH + 122      ; 0: this build, 1: trajectory_crane_shaper.asm; of a gantry -1 and 2
TJ_SPEED        .set SCRATCH + 126      ; CR_SPEED, 7 words
TJ_MAX_SEGMENTS .set 8

kernel_trajectory_crane:
        ldi     0, r0
trajectory_crane_build:
        sti     r0, @TJ_SHAPED
        ldi     ar6, ar5
        addi    CR_TRAJECTORY, ar5
        ldi     *ar5, r0
        sti     r0, @TJ_SELECTOR
        beq     trajectory_crane_first
        ldi     r0, ar1
        subi    1, ar1
        mpyi    TJ_BANK_STRIDE, ar1
        addi3   ar5, ar1, ar0
        addi    1, ar0
        ldhi    hi16(TJ_K0), ar1
        or      lo16(TJ_K0), ar1
        ldi     TJ_BANK_WORDS - 1, rc
        call    copy_words
        ldi     @TASK + TB_ARGUMENT, r1
        subi    @TJ_K0, r1
        cmpi    @TJ_COUNT, r1
        bge     trajectory_crane_next
        call    trajectory_crane_chain
        call    trajectory_crane_starts
        br      trajectory_crane_point

; A leg begins at the end of the last leg, the first leg at home.
trajectory_crane_next:
        ldhi    hi16(TJ_END), ar0
        or      lo16(TJ_END), ar0
        br      trajectory_crane_begin
trajectory_crane_first:
        ldi     ar6, ar0
        addi    CR_HOME, ar0
trajectory_crane_begin:
        ldhi    hi16(TJ_BEGIN), ar1
        or      lo16(TJ_BEGIN), ar1
        ldi     3, rc
        call    copy_words
        ldf     *+ar6(CR_POINT_PERIOD), r0
        stf     r0, @TJ_PERIOD
        ldi     *+ar6(CR_LEG), r8
        cmpi    LEG_ALIGN, r8
        beq     trajectory_crane_align
        ldi     ar6, ar0
        addi    r8, ar0
        ldi     *+ar0(CR_ROUTE_COUNT), r0
        cmpi    TJ_MAX_SEGMENTS, r0
        ldigt   TJ_MAX_SEGMENTS, r0
        sti     r0, @TJ_SEGMENTS
        ldi     r8, r0
        subi    1, r0
        lsh     5, r0
        addi    CR_ROUTE, r0
        sti     r0, @TJ_ROUTE
        call    trajectory_crane_chain
        ldi     @TJ_SEGMENTS, ar0               ; P_n
        lsh     2, ar0
        ldhi    hi16(TJ_CHAIN), ar1
        or      lo16(TJ_CHAIN), ar1
        addi    ar1, ar0
        ldhi    hi16(TJ_END), ar1
        or      lo16(TJ_END), ar1
        ldi     3, rc
        call    copy_words
        br      trajectory_crane_laid
trajectory_crane_align:
        call    trajectory_crane_aim
        call    trajectory_crane_chain
trajectory_crane_laid:
        ldi     ar6, ar0
        addi    CR_SPEED, ar0
        ldhi    hi16(TJ_SPEED), ar1
        or      lo16(TJ_SPEED), ar1
        ldi     SPEED_WORDS - 1, rc
        call    copy_words
        ldhi    hi16(TJ_CHAIN), ar3
        or      lo16(TJ_CHAIN), ar3
        ldhi    hi16(TJ_DURATION), ar4
        or      lo16(TJ_DURATION), ar4
        ldi     @TJ_SEGMENTS, ar2
        br      trajectory_crane_more
trajectory_crane_durations:
        call    trajectory_crane_duration
        mpyf    *+ar6(CR_STRETCH), r0
        rnd     r0, r0
        stf     r0, *ar4++
        addi    4, ar3
trajectory_crane_more:
        subi    1, ar2
        cmpi    0, ar2
        bge     trajectory_crane_durations
        call    trajectory_crane_starts
        ldi     @TJ_SHAPED, r0
        callnz  shaper_ahead

trajectory_crane_points:
        ldf     @TJ_PERIOD, r0                  ; points: ceil(total / period), at least one
        call    m_reciprocal
        mpyf    @TJ_TOTAL, r0
        negf    r0, r0
        fix     r0, r0
        negi    r0, r0
        cmpi    1, r0
        ldilt   1, r0
        sti     r0, @TJ_COUNT
        ldi     @TASK + TB_ARGUMENT, r0
        sti     r0, @TJ_K0

        ldi     1, r8                           ; the other bank, then the selector
        ldi     @TJ_SELECTOR, r0
        cmpi    1, r0
        ldieq   2, r8
        ldi     r8, ar1
        subi    1, ar1
        mpyi    TJ_BANK_STRIDE, ar1
        addi    ar5, ar1
        addi    1, ar1
        ldhi    hi16(TJ_K0), ar0
        or      lo16(TJ_K0), ar0
        ldi     TJ_BANK_WORDS - 1, rc
        call    copy_words
        sti     r8, *ar5

; The payload at t = (k - k0 + 1) period.
trajectory_crane_point:
        ldi     @TJ_SHAPED, r0
        bgt     shaper_point
        ldhi    hi16(TJ_CHAIN), ar3
        or      lo16(TJ_CHAIN), ar3
        ldhi    hi16(TJ_DURATION), ar4
        or      lo16(TJ_DURATION), ar4
        ldi     ar3, ar0
        ldhi    hi16(TJ_SUM), ar1
        or      lo16(TJ_SUM), ar1
        ldi     3, rc
        call    copy_words                      ; p = P_0
        ldf     0.0, r0
        rpts    15
        stf     r0, *ar1++                      ; derivatives
        ldi     @TASK + TB_ARGUMENT, r0
        subi    @TJ_K0, r0
        addi    1, r0
        float   r0, r8
        mpyf    @TJ_PERIOD, r8                  ; t
        ldi     @TJ_SEGMENTS, ar2
        br      trajectory_crane_segment_next
trajectory_crane_segment:
        ldf     *+ar4(TJ_START - TJ_DURATION), r9
        cmpf    r9, r8
        ble     trajectory_crane_summed         ; this and the following segments have not begun
        addf    *ar4, r9
        cmpf    r9, r8
        bge     trajectory_crane_passed
        ldf     *ar4, r0
        call    m_reciprocal
        ldf     r0, r10                         ; 1 / T
        ldf     r8, r0
        subf    *+ar4(TJ_START - TJ_DURATION), r0
        mpyf    r10, r0
        call    m_blend9
        ldf     r10, r5
        mpyf    r5, r1
        mpyf    r10, r5
        mpyf    r5, r2
        mpyf    r10, r5
        mpyf    r5, r3
        mpyf    r10, r5
        mpyf    r5, r4
        ldi     ar3, ar0
        ldhi    hi16(TJ_SUM), ar1
        or      lo16(TJ_SUM), ar1
        ldi     3, rc
        rptb    trajectory_crane_coordinate
        ldf     *+ar0(4), r5                    ; P_i - P_i-1
        subf    *ar0++, r5
        mpyf3   r5, r0, r6
        addf    *ar1, r6
        stf     r6, *ar1
        mpyf3   r5, r1, r6
        addf    *+ar1(4), r6
        stf     r6, *+ar1(4)
        mpyf3   r5, r2, r6
        addf    *+ar1(8), r6
        stf     r6, *+ar1(8)
        mpyf3   r5, r3, r6
        addf    *+ar1(12), r6
        stf     r6, *+ar1(12)
        mpyf3   r5, r4, r6
        addf    *+ar1(16), r6
        stf     r6, *+ar1(16)
trajectory_crane_coordinate:
        nop     *ar1++
        br      trajectory_crane_segment_after
trajectory_crane_passed:                        ; this segment and all before it are complete: p = P_i
        ldi     ar3, ar0
        addi    4, ar0
        ldhi    hi16(TJ_SUM), ar1
        or      lo16(TJ_SUM), ar1
        ldi     3, rc
        call    copy_words
trajectory_crane_segment_after:
        addi    4, ar3
        addi    1, ar4
trajectory_crane_segment_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     trajectory_crane_segment

; The suspension: l = h_p + sqrt(L^2 - (r - a0)^2) - z
trajectory_crane_summed:
        ldf     @TJ_SUM, r0
        mpyf    r0, r0
        ldf     @TJ_SUM + 1, r1
        mpyf    r1, r1
        addf    r1, r0
        call    m_sqrt
        subf    @K_A0, r0
        mpyf    r0, r0
        subrf   @K_JIB_SQUARED, r0
        call    m_sqrt
        addf    @K_PIVOT, r0
        subf    @TJ_SUM + 2, r0
        mpyf    @K_ONE_OVER_G, r0               ; l / g
        ldhi    hi16(TJ_SUM), ar1
        or      lo16(TJ_SUM), ar1
        ldi     1, rc
        rptb    trajectory_crane_suspend
        ldf     *+ar1(8), r1                    ; p''
        mpyf3   r0, r1, r2
        addf    *ar1, r2
        rnd     r2, r2
        stf     r2, *ar1
        ldf     *+ar1(12), r2
        mpyf    r0, r2
        addf    *+ar1(4), r2
        stf     r2, *+ar1(4)
        ldf     *+ar1(16), r2
        mpyf    r0, r2
        addf    r1, r2
        stf     r2, *+ar1(8)
        stf     r1, *+ar1(12)
trajectory_crane_suspend:
        nop     *ar1++

trajectory_crane_write:
        ldi     @TASK + TB_ARGUMENT, ar1
        and     1, ar1
        lsh     4, ar1
        addi    ar6, ar1
        addi    CR_POINT, ar1
        ldhi    hi16(TJ_SUM), ar0
        or      lo16(TJ_SUM), ar0
        ldi     13, rc
        call    copy_words

        ldi     @TASK + TB_ARGUMENT, r1
        subi    @TJ_K0, r1
        addi    1, r1
        ldi     r1, r2
        ldi     0, r0
        ldi     MUST_TRAJECTORY + MUST_INVERSE, r1
        cmpi    @TJ_COUNT, r2
        ldige   RESULT_END_OF_LEG, r0
        ldige   MUST_INVERSE, r1
        rets

; CHAIN <- P_0 and the n via points of the leg; of an alignment P_0 and P_n, which the leg's bank keeps.
trajectory_crane_chain:
        ldhi    hi16(TJ_BEGIN), ar0
        or      lo16(TJ_BEGIN), ar0
        ldhi    hi16(TJ_CHAIN), ar1
        or      lo16(TJ_CHAIN), ar1
        ldi     3, rc
        call    copy_words
        ldi     @TJ_SEGMENTS, rc
        lsh     2, rc
        subi    1, rc
        cmpi    0, rc
        retslt
        ldi     @TJ_ROUTE, ar0
        cmpi    0, ar0
        beq     trajectory_crane_chain_end
        addi    ar6, ar0
        br      copy_words
trajectory_crane_chain_end:
        ldhi    hi16(TJ_END), ar0
        or      lo16(TJ_END), ar0
        br      copy_words

; An alignment is one segment without a route: END <- where the AGV stands, measured: x, y, its heading to within a half
; turn, deck + box + clearance.
trajectory_crane_aim:
        ldi     1, r0
        sti     r0, @TJ_SEGMENTS
        ldi     0, r0
        sti     r0, @TJ_ROUTE
        ldhi    hi16(WINDOW_B), ar0
        addi    *+ar6(CR_AGV), ar0
        ldi     *+ar0(AGV_X), r0
        float   r0, r0
        mpyf    @K_MILLI, r0
        stf     r0, @TJ_END
        ldi     *+ar0(AGV_Y), r0
        float   r0, r0
        mpyf    @K_MILLI, r0
        stf     r0, @TJ_END + 1
        ldf     *+ar6(CR_AGV_DECK), r0
        addf    *+ar6(CR_BOX_HEIGHT), r0
        addf    *+ar6(CR_CLEARANCE), r0
        stf     r0, @TJ_END + 2
        ldi     *+ar0(AGV_HEADING), r0
        float   r0, r0
        mpyf    @K_MICRO, r0
        ldf     @TJ_BEGIN + 3, r1
        call    trajectory_crane_half_turn
        stf     r0, @TJ_END + 3
        rets

; R0 <- heading R0 or its opposite, the one nearer to the yaw R1: a box fits both ways. Changes R1.
trajectory_crane_half_turn:
        negf    r1, r1                          ; heading - pi floor((heading - yaw) / pi + 1/2)
        addf    r0, r1
        mpyf    @K_TWO_OVER_PI, r1
        mpyf    0.5, r1
        addf    0.5, r1
        fix     r1, r1
        float   r1, r1
        mpyf    @K_PI, r1
        subf    r1, r0
        rets

; R0 <- T of the segment from *AR3 to *+AR3(4): the longest T among the limits of docs/kernels.md.
trajectory_crane_duration:
        ldhi    hi16(K_TJ_XY1), ar1
        or      lo16(K_TJ_XY1), ar1
        ldi     @TJ_SHAPED, r0
        ble     trajectory_crane_limits
        addi    K_TJ_SHAPED - K_TJ_XY1, ar1
trajectory_crane_limits:
        ldf     *+ar3(4), r0
        subf    *ar3, r0
        mpyf    r0, r0
        ldf     *+ar3(5), r1
        subf    *+ar3(1), r1
        mpyf    r1, r1
        addf    r1, r0
        call    m_sqrt                          ; h
        ldf     r0, r8
        mpyf    *ar1, r8
        mpyf    @TJ_SPEED, r8                   ; longest T
        ldf     r8, r10
        ldf     r0, r9
        mpyf    *+ar1(1), r9                   ; longest T^2
        mpyf    *+ar1(2), r0
        call    m_sqrt
        cmpf    r9, r0
        ldfgt   r0, r9
        ldf     *+ar3(6), r0
        subf    *+ar3(2), r0
        absf    r0, r0
        ldf     r0, r1
        mpyf    *+ar1(3), r1
        mpyf    @TJ_SPEED + 1, r1
        cmpf    r8, r1
        ldfgt   r1, r8
        mpyf    *+ar1(4), r0
        cmpf    r9, r0
        ldfgt   r0, r9
        ldf     *+ar3(7), r0
        subf    *+ar3(3), r0
        absf    r0, r0
        ldf     r0, r1
        mpyf    *+ar1(5), r1
        mpyf    @TJ_SPEED + 2, r1
        addf    r10, r1                         ; the rotator turns the box, and turns against the slewing
        cmpf    r8, r1
        ldfgt   r1, r8
        mpyf    *+ar1(6), r0
        cmpf    r9, r0
        ldfgt   r0, r9
        ldf     r9, r0
        call    m_sqrt
        cmpf    r8, r0
        ldflt   r8, r0
        rets

; START <- t_i, TOTAL <- t_n-1 + T_n-1 from DURATION.
trajectory_crane_starts:
        ldhi    hi16(TJ_DURATION), ar0
        or      lo16(TJ_DURATION), ar0
        ldi     ar0, ar1
        addi    TJ_START - TJ_DURATION, ar1
        ldf     0.0, r0
        stf     r0, *ar1
        stf     r0, @TJ_TOTAL
        ldi     @TJ_SEGMENTS, rc
        cmpi    0, rc
        retseq
        subi    2, rc
        cmpi    0, rc
        blt     trajectory_crane_total
        rptb    trajectory_crane_started
        ldf     *ar0++, r1
        addf    r1, r0
        cmpf    *ar0, r1
        ldfgt   *ar0, r1                        ; the shorter of the two
        mpyf    0.5, r1
        subf    r1, r0
trajectory_crane_started:
        stf     r0, *++ar1
trajectory_crane_total:
        addf    *ar0, r0
        stf     r0, @TJ_TOTAL
        rets
