; Obstacle avoidance: the echoes as points on the lane, and the nearest of them.

; ---- POINTS, FOUND: the minima within K_AV_ACROSS of the lane ahead ----
avoid_points:
        ldhi    hi16(AV_MINIMA), ar3
        or      lo16(AV_MINIMA), ar3
        ldhi    hi16(AV_POINTS), ar5
        or      lo16(AV_POINTS), ar5
        ldi     0, ar1                          ; sector
avoid_points_some:
        call    alive
        ldi     ar1, ir1
        addi    8, ir1
        cmpi    @AV_SECTORS, ir1
        ldigt   @AV_SECTORS, ir1
avoid_point:
        ldi     *ar3, r0
        cmpi    -1, r0
        beq     avoid_point_next
        addi    1, r0
        float   r0, r6
        mpyf    @K_MILLI, r6
        stf     r6, *+ar5(AV_RANGE)
        float   *+ar3(1), r0
        mpyf    @AV_STEP, r0
        addf    @AV_FIRST, r0
        call    m_sincos
        mpyf    r6, r1
        addf    @AV_MOUNT, r1                   ; x
        mpyf    r6, r0                          ; y
        stf     r1, *+ar5(AV_PX)
        stf     r0, *+ar5(AV_PY)
        ldf     r1, r10
        mpyf    @AV_COS, r10
        ldf     r0, r2
        mpyf    @AV_SIN, r2
        subf    r2, r10
        addf    @AV_X, r10
        ldf     r1, r11
        mpyf    @AV_SIN, r11
        mpyf    @AV_COS, r0
        addf    r0, r11
        addf    @AV_Y, r11
        call    avoid_project
        cmpi    0, r0
        beq     avoid_point_next
        ldf     @AV_ALONG, r0
        subf    @AV_S, r0
        stf     r0, *+ar5(AV_PALONG)
        ldf     @AV_ACROSS, r0
        stf     r0, *+ar5(AV_PLATERAL)
        sti     ar1, *+ar5(AV_PSECTOR)
        call    avoid_swing
        stf     r0, *+ar5(AV_PSWING)
        addi    AV_POINT_WORDS, ar5
        ldi     @AV_FOUND, r0
        addi    1, r0
        sti     r0, @AV_FOUND
avoid_point_next:
        addi    2, ar3
        addi    1, ar1
        cmpi    ir1, ar1
        blt     avoid_point
        cmpi    @AV_SECTORS, ar1
        blt     avoid_points_some
        rets

; R0 <- swing at the projected point: half the vehicle's length squared / 2 times the curvature, to the outer side;
; before and behind a bend less, by the square of the distance from the bend. Clobbers R1 .. R4, AR0.
avoid_swing:
        ldi     @AV_PIECE, ar0
        ldf     *+ar0(4), r0
        bz      avoid_swing_straight
        mpyf    @K_AV_SWING, r0
        rets
avoid_swing_straight:
        ldf     @AV_ALONG, r1
        subf    *+ar0(6), r1                    ; behind the piece before
        ldf     *+ar0(5), r2
        subf    r1, r2                          ; before the next
        ldf     0.0, r0
        ldhi    hi16(AV_PATH), ar4
        or      lo16(AV_PATH), ar4
        ldi     ar0, r3
        subi    ar4, r3
        bz      avoid_swing_next                ; the first piece
        subi    8, ar0
        ldf     *+ar0(4), r4
        call    avoid_swing_end
        addi    8, ar0
        ldi     ar0, r3
        subi    ar4, r3
avoid_swing_next:
        lsh     -3, r3
        addi    1, r3
        cmpi    @AV_PATH_COUNT, r3
        retsge                                  ; the last
        addi    8, ar0
        ldf     *+ar0(4), r4
        ldf     r2, r1
; R0 += the swing R1 metres from a bend of curvature R4.
avoid_swing_end:
        subrf   @K_AV_HALF_LENGTH, r1
        retslt
        cmpf    @K_AV_HALF_LENGTH, r1
        ldfgt   @K_AV_HALF_LENGTH, r1
        mpyf    r1, r1
        mpyf    -0.5, r1
        mpyf    r4, r1
        addf    r1, r0
        rets

; ---- TARGET: the lane's point R8 metres ahead of the vehicle's middle, in the vehicle's frame ----
avoid_target:
        addf    @AV_S, r8
        ldf     0.0, r9                         ; beyond the leg's end
        ldf     @AV_TOTAL, r0
        cmpf    r0, r8
        ble     avoid_target_within
        ldf     r8, r9
        subf    r0, r9
        ldf     r0, r8
avoid_target_within:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        ldi     @TA_COUNT, ar2
        ldf     0.0, r10
        call    trajectory_agv_find             ; TA_POINT
        ldf     @TA_POINT + 2, r0
        call    m_sincos
        mpyf    r9, r1
        addf    @TA_POINT, r1
        subf    @AV_X, r1
        mpyf    r9, r0
        addf    @TA_POINT + 1, r0
        subf    @AV_Y, r0
        ldf     r1, r2
        mpyf    @AV_COS, r2
        ldf     r0, r3
        mpyf    @AV_SIN, r3
        addf    r3, r2
        stf     r2, @AV_TARGET
        mpyf    @AV_COS, r0
        mpyf    @AV_SIN, r1
        subf    r1, r0
        stf     r0, @AV_TARGET + 1
        rets

; ---- NEAR, NEAR_FOUND: of each four sectors the nearest point within K_AV_STANDS of the lane, for methods that look at
; 16. Clobbers R0 .. R5 ----
avoid_nearest:
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldhi    hi16(AV_NEAR), ar0
        or      lo16(AV_NEAR), ar0
        subi    1, ar0
        ldi     -1, r4                          ; the four sectors of the last one
        ldi     0, r5
        ldi     @AV_FOUND, ar2
        br      avoid_nearest_next
avoid_nearest_point:
        absf    *+ar1(AV_PLATERAL), r0
        cmpf    @K_AV_STANDS, r0
        bge     avoid_nearest_after
        ldi     *+ar1(AV_PSECTOR), r3
        lsh     -2, r3
        ldf     *+ar1(AV_RANGE), r0
        cmpi    r4, r3
        beq     avoid_nearest_same
        ldi     r3, r4
        addi    1, r5
        addi    1, ar0
        br      avoid_nearest_take
avoid_nearest_same:
        cmpf    r2, r0
        bge     avoid_nearest_after
avoid_nearest_take:
        ldf     r0, r2
        sti     ar1, *ar0
avoid_nearest_after:
        addi    AV_POINT_WORDS, ar1
avoid_nearest_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     avoid_nearest_point
        sti     r5, @AV_NEAR_FOUND
        rets
