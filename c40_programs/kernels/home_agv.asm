; Process 8: prepares leg 3, on which the AGV goes home (docs/kernels_job.md).
;
; The host writes leg 3 as the whole lane from the dock to the home slot. The vehicle's measured pose is projected onto
; the lane, to the nearest point sigma in 0..length of any segment. The part behind is dropped; the point's segment then
; starts at the vehicle. Arcs turn by at most half a circle.
;
; Leg 3 is written over the words from which it is computed. So these are first copied to leg 2, which the vehicle has
; behind it; then AG_HOME_TICK says so. If the block runs again, it reads the copy.
;     line: sigma = (p - p0) . t
;     arc:  heading of the nearest point = atan2(sx, -sy) of s (p - centre), s the sign of the curvature; sigma =
;     wrap(heading - heading0)/curvature

HA_X                .set SCRATCH + 96
HA_Y                .set SCRATCH + 97
HA_INDEX            .set SCRATCH + 98           ; i, the present segment
HA_BEST             .set SCRATCH + 99           ; m^2
HA_BEST_INDEX       .set SCRATCH + 100
HA_BEST_SIGMA       .set SCRATCH + 101
HA_BEST_POSE        .set SCRATCH + 102          ; x, y, heading
HA_SIGMA            .set SCRATCH + 105
HA_LEG              .set 3
HA_KEPT             .set 2                      ; the leg whose words hold the copy

kernel_home_agv:
        ldhi    hi16(WINDOW_B), ar5
        addi    *+ar6(AG_UNIT), ar5
        float   *+ar5(AGV_X), r0
        mpyf    @K_MILLI, r0
        stf     r0, @HA_X
        float   *+ar5(AGV_Y), r0
        mpyf    @K_MILLI, r0
        stf     r0, @HA_Y
        ldi     HA_LEG, r6
        ldi     @TASK + TB_TICK, r9
        addi    1, r9
        cmpi    *+ar6(AG_HOME_TICK), r9
        ldieq   HA_KEPT, r6                     ; this block has run before
        call    trajectory_agv_load
        ldf     @K_TA_HUGE, r0
        stf     r0, @HA_BEST
        ldi     0, r0
        sti     r0, @HA_INDEX
        cmpi    @TA_COUNT, r0
        bge     home_agv_nothing
        ldi     @TA_COUNT, rc                   ; leg 2 := the segments; then AG_HOME_TICK
        sti     rc, *+ar6(AG_SEGMENT_COUNT + HA_KEPT)
        lsh     3, rc
        subi    1, rc
        ldhi    hi16(SCRATCH), ar0
        or      lo16(TA_SEGMENTS), ar0
        ldi     ar6, ar1
        addi    AG_SEGMENT + (HA_KEPT - 1) * 64, ar1
        call    copy_words
        sti     r9, *+ar6(AG_HOME_TICK)
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
home_agv_segment:
        call    home_agv_project
        addi    8, ar1
        ldi     @HA_INDEX, r0
        addi    1, r0
        sti     r0, @HA_INDEX
        cmpi    @TA_COUNT, r0
        blt     home_agv_segment
        br      home_agv_cut
home_agv_nothing:
        ldi     0, r0
        ldi     0, r1
        rets

; ---- the nearest point of the segment *AR1 to (HA_X, HA_Y), kept if it is the best so far ----
home_agv_project:
        ldf     *+ar1(TA_SEGMENT_HEADING), r0
        call    m_sincos                        ; R0 = s0, R1 = c0
        ldf     @HA_X, r6
        subf    *+ar1(TA_SEGMENT_X), r6         ; dx from the segment's start
        ldf     @HA_Y, r7
        subf    *+ar1(TA_SEGMENT_Y), r7
        ldf     *+ar1(TA_SEGMENT_CURVE), r8
        bz      home_agv_line
                    ; k (p - centre) = k d - n, n = (-s0, c0) the left normal: at the nearest point it is -(left normal)
                    ; there
        mpyf    r8, r6
        addf    r0, r6                          ; sin of the heading there, times a positive length
        mpyf    r8, r7
        subrf   r1, r7                          ; cos of it: c0 - k dy
        ldf     r6, r0
        ldf     r7, r1
        call    m_atan2
        subf    *+ar1(TA_SEGMENT_HEADING), r0
        call    m_wrap
        ldf     r0, r6
        ldf     r8, r0
        call    m_reciprocal
        mpyf    r6, r0
        br      home_agv_clamp
home_agv_line:
        mpyf    r6, r1
        mpyf    r7, r0
        addf    r1, r0
home_agv_clamp:
        ldf     0.0, r1
        cmpf    r1, r0
        ldflt   r1, r0
        ldf     *+ar1(TA_SEGMENT_LENGTH), r1
        cmpf    r1, r0
        ldfgt   r1, r0
        stf     r0, @HA_SIGMA
        ldf     r0, r6
        call    trajectory_agv_pose             ; R0, R1, R6
        ldf     @HA_X, r2
        subf    r0, r2
        mpyf    r2, r2
        ldf     @HA_Y, r3
        subf    r1, r3
        mpyf    r3, r3
        addf    r3, r2
        cmpf    @HA_BEST, r2
        bge     home_agv_projected
        stf     r2, @HA_BEST
        rnd     r0
        stf     r0, @HA_BEST_POSE
        rnd     r1
        stf     r1, @HA_BEST_POSE + 1
        rnd     r6
        stf     r6, @HA_BEST_POSE + 2
        ldf     @HA_SIGMA, r0
        stf     r0, @HA_BEST_SIGMA
        ldi     @HA_INDEX, r0
        sti     r0, @HA_BEST_INDEX
home_agv_projected:
        rets

; ---- leg 3 := the part ahead of the best point; R0 = its number of segments ----
home_agv_cut:
        ldi     @HA_BEST_INDEX, r6
        lsh     3, r6
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        addi    r6, ar1
        ldf     @HA_BEST_POSE, r0
        stf     r0, *+ar1(TA_SEGMENT_X)
        ldf     @HA_BEST_POSE + 1, r0
        stf     r0, *+ar1(TA_SEGMENT_Y)
        ldf     @HA_BEST_POSE + 2, r0
        stf     r0, *+ar1(TA_SEGMENT_HEADING)
        ldf     *+ar1(TA_SEGMENT_LENGTH), r0
        subf    @HA_BEST_SIGMA, r0
        rnd     r0
        stf     r0, *+ar1(TA_SEGMENT_LENGTH)
        ldi     @TA_COUNT, r7
        subi    @HA_BEST_INDEX, r7
        ldi     r7, r0
        lsh     3, r0
        subi    1, r0
        ldi     r0, rc
        ldi     ar1, ar0
        ldi     ar6, ar1
        addi    AG_SEGMENT + (HA_LEG - 1) * 64, ar1
        call    copy_words
        sti     r7, *+ar6(AG_SEGMENT_COUNT + HA_LEG)
        ldi     r7, r0
        ldi     0, r1
        rets
