; Sub-process 5 as a vector-field histogram. The nearest echo within 25 m in each of 72 sectors of 2.5 degrees adds
; (1 - d/25)^2 to the sectors that the vehicle's half width covers at its distance. The histogram is smoothed over five
; sectors. The method steers for the free sector nearest to the lane; present side, or away from echoes, first.

VF_SECTORS      .set 72
VF_HISTOGRAM    .set AV_MINIMA              ; f, after the method has made points of the sectors' minima
VF_SMOOTH       .set AV_MINIMA + VF_SECTORS
VF_GOAL         .set SCRATCH + 200          ; i sector of the lane
VF_NEAREST      .set SCRATCH + 201          ; f m
VF_BESIDE       .set SCRATCH + 202          ; f m, that echo's lateral place
VF_DENSITY      .set SCRATCH + 203          ; f sectors per radian

kernel_avoidance_vfh:
        ldi     VF_SECTORS, r0
        call    avoid_look
        cmpi    0, r0
        beq     avoid_nothing
        call    vfh_histogram
        call    vfh_smooth
        call    vfh_goal
        call    vfh_valley
        br      avoid_decide

vfh_histogram:
        call    alive
        float   @AV_RAYS, r0
        mpyf    @AV_STEP, r0
        call    m_reciprocal
        mpyf    72.0, r0
        stf     r0, @VF_DENSITY
        ldf     0.0, r0
        ldhi    hi16(VF_HISTOGRAM), ar0
        or      lo16(VF_HISTOGRAM), ar0
        rpts    VF_SECTORS - 1
        stf     r0, *ar0++
        ldf     @K_VF_ACTIVE, r0
        stf     r0, @VF_NEAREST
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldi     @AV_FOUND, ar2
        br      vfh_next
vfh_point:
        absf    *+ar1(AV_PLATERAL), r0
        cmpf    @K_AV_STANDS, r0
        bge     vfh_after
        ldf     *+ar1(AV_RANGE), r6
        cmpf    @K_VF_ACTIVE, r6
        bge     vfh_after
        cmpf    @VF_NEAREST, r6
        bge     vfh_not_nearest
        stf     r6, @VF_NEAREST
        ldf     *+ar1(AV_PLATERAL), r0
        stf     r0, @VF_BESIDE
vfh_not_nearest:
        cmpf    0.5, r6
        ldflt   0.5, r6
        ldf     r6, r0
        call    m_reciprocal
        mpyf    @K_AV_HALF, r0                  ; sine of the half angle that the vehicle takes there
        cmpf    @K_VF_SINE_MOST, r0
        ldfgt   @K_VF_SINE_MOST, r0
        mpyf3   r0, r0, r1
        ldf     @K_VF_ASIN5, r2
        mpyf    r1, r2
        addf    @K_VF_ASIN3, r2
        mpyf    r1, r2
        addf    1.0, r2
        mpyf    r2, r0                          ; asin x = x + x^3/6 + 3 x^5/40
        mpyf    @VF_DENSITY, r0
        fix     r0, r4                          ; sectors to either side
        ldi     *+ar1(AV_PSECTOR), r3
        ldi     r3, r5
        addi    r4, r5
        cmpi    VF_SECTORS - 1, r5
        ldigt   VF_SECTORS - 1, r5
        subi    r4, r3
        cmpi    0, r3
        ldilt   0, r3
        ldf     r6, r0
        mpyf    @K_VF_ONE_OVER, r0
        subrf   1.0, r0
        mpyf    r0, r0                          ; how dark
        ldhi    hi16(VF_HISTOGRAM), ar0
        or      lo16(VF_HISTOGRAM), ar0
        addi    r3, ar0
        subi    r3, r5
        ldi     r5, rc
        rptb    vfh_dark
        ldf     *ar0, r1
        cmpf    r0, r1
        ldflt   r0, r1
vfh_dark:
        stf     r1, *ar0++
vfh_after:
        addi    AV_POINT_WORDS, ar1
vfh_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     vfh_point
        rets

; SMOOTH[k] <- (H[k-2] + 2 H[k-1] + 3 H[k] + 2 H[k+1] + H[k+2]) / 9, the ends repeated.
vfh_smooth:
        call    alive
        ldhi    hi16(VF_HISTOGRAM), ar0
        or      lo16(VF_HISTOGRAM), ar0
        ldhi    hi16(VF_SMOOTH), ar1
        or      lo16(VF_SMOOTH), ar1
        ldf     *ar0, r0                        ; R0 .. R4: five neighbours
        ldf     r0, r1
        ldf     r0, r2
        ldf     *+ar0(1), r3
        ldf     *+ar0(2), r4
        addi    3, ar0
        ldf     @K_VF_NINTH, r6
        ldi     VF_SECTORS - 1, rc
        rptb    vfh_smoothed
        addf3   r1, r3, r5
        addf    r2, r5
        mpyf    2.0, r5
        addf    r0, r5
        addf    r2, r5
        addf    r4, r5
        mpyf    r6, r5
        stf     r5, *ar1++
        ldf     r1, r0
        ldf     r2, r1
        ldf     r3, r2
        ldf     r4, r3
        cmpi    2, rc
        ldfgt   *ar0++, r4
vfh_smoothed:
        nop
        rets

; GOAL <- the sector in which the lane lies VF_LOOK ahead of the front.
vfh_goal:
        ldf     @AV_MOUNT, r8
        addf    @K_VF_LOOK, r8
        call    avoid_target
        ldf     @AV_TARGET, r1
        subf    @AV_MOUNT, r1
        ldf     @AV_TARGET + 1, r0
        call    m_atan2
        subf    @AV_FIRST, r0
        mpyf    @VF_DENSITY, r0
        fix     r0, r0
        cmpi    0, r0
        ldilt   0, r0
        cmpi    VF_SECTORS - 1, r0
        ldigt   VF_SECTORS - 1, r0
        sti     r0, @VF_GOAL
        rets

; SHIFT, SPEED from the free sector nearest to the goal.
vfh_valley:
        call    alive
        ldi     @VF_GOAL, ar0
        ldhi    hi16(VF_SMOOTH), ar1
        or      lo16(VF_SMOOTH), ar1
        ldi     ar0, ir0
        ldf     *+ar1(ir0), r0
        cmpf    @K_VF_THRESHOLD, r0
        retslt                                  ; the lane is free: no shift, no limit
        mpyf    @K_VF_SLOWING, r0
        subrf   1.0, r0
        mpyf    @K_VF_FASTEST, r0
        stf     r0, @AV_SPEED
        ldi     -1, r6                          ; side to try first: that of the present shift, or away from the echo
        ldi     4, r7                           ; sectors by which the other side is worse
        ldf     @AV_SHIFT_OLD, r0
        bnz     vfh_side
        ldi     2, r7
        negf    @VF_BESIDE, r0
vfh_side:
        cmpf    0.0, r0
        ldigt   1, r6
        ldi     1, r5
vfh_try:
        mpyi3   r5, r6, r0
        call    vfh_free
        cmpi    0, r1
        bne     vfh_found
        ldi     r5, r0
        subi    r7, r0
        cmpi    1, r0
        blt     vfh_again
        mpyi    r6, r0
        negi    r0, r0
        call    vfh_free
        cmpi    0, r1
        bne     vfh_found
vfh_again:
        addi    1, r5
        cmpi    VF_SECTORS, r5
        blt     vfh_try
        ldf     0.0, r0                         ; no free way: stop, and keep the place
        stf     r0, @AV_SPEED
        ldf     @AV_SHIFT_OLD, r0
        stf     r0, @AV_SHIFT
        rets
vfh_found:                                      ; R0 sectors from the goal
        float   r0, r4
        ldf     @VF_DENSITY, r0
        call    m_reciprocal
        mpyf    r4, r0
        call    m_sincos
        ldf     @VF_NEAREST, r1
        cmpf    @K_VF_NEAR, r1
        ldflt   @K_VF_NEAR, r1
        mpyf    r1, r0
        addf    @AV_LATERAL, r0
        stf     r0, @AV_SHIFT
        rets

; R1 <- 1 if the sector R0 from the goal is there and free. Keeps R0.
vfh_free:
        ldi     0, r1
        ldi     @VF_GOAL, ir0
        addi    r0, ir0
        cmpi    0, ir0
        retslt
        cmpi    VF_SECTORS - 1, ir0
        retsgt
        ldf     *+ar1(ir0), r2
        cmpf    @K_VF_THRESHOLD, r2
        ldilt   1, r1
        rets
