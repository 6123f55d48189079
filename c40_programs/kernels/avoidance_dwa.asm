; Sub-process 5 as a dynamic window, the stress test: 11 speeds that the drive can reach times 11 curvatures about the
; lane's. Each arc has 10 steps of 0.4 s (at least 1.6 m), tested against 16 discs (nearest echoes, filled up if few).
; An arc that meets a disc may be taken only at speeds that still allow braking before it. The best one maximises
;   W_speed v + W_clear min(clearance, 2 m) - W_lane (distance of the end of a 12-m arc of this curvature from the lane)

DW_SAMPLES      .set 11
DW_STEPS        .set 10
DW_DISCS        .set 16
DW_SECTORS      .set 64
DW_SPOTS        .set SCRATCH + 856          ; -2 x, -2 y of each disc
DW_SQUARES      .set SCRATCH + 888          ; x^2 + y^2 of each
DW_LANE         .set SCRATCH + 904          ; per curvature: W_lane times the distance of the arc's end from the lane
DW_SIDE         .set SCRATCH + 934          ; per curvature: m by which the arc's end is left of the lane's point
DW_V0           .set SCRATCH + 920          ; m/s, slowest speed of the window, and step between two speeds
DW_DV           .set SCRATCH + 921
DW_BEND         .set SCRATCH + 922          ; 1/m, the lane's curvature
DW_V            .set SCRATCH + 923          ; of the sample
DW_K            .set SCRATCH + 924
DW_CLEAR        .set SCRATCH + 925          ; least squared distance of the arc from a disc, m^2
DW_FREE         .set SCRATCH + 926          ; m of arc before a disc is met; K_AV_NO_LIMIT: no disc is met
DW_BEST         .set SCRATCH + 927
DW_BEST_V       .set SCRATCH + 928
DW_BEST_SIDE    .set SCRATCH + 929          ; m, its DW_SIDE
DW_MET          .set SCRATCH + 930          ; i, not 0: an arc meets a disc
DW_I            .set SCRATCH + 931          ; i, speed
DW_J            .set SCRATCH + 932          ; i, curvature
DW_LEAST        .set SCRATCH + 933          ; m^2, least of DW_CLEAR
DW_END          .set DW_SIDE + DW_SAMPLES

kernel_avoidance_dwa:
        ldi     DW_SECTORS, r0
        call    avoid_look
        cmpi    0, r0
        beq     avoid_nothing
        call    dwa_discs
        call    dwa_window
        call    dwa_lanes
        ldi     0, r0
        sti     r0, @DW_I
dwa_speed:
        float   @DW_I, r0
        mpyf    @DW_DV, r0
        addf    @DW_V0, r0
        stf     r0, @DW_V
        ldi     0, r0
        sti     r0, @DW_J
dwa_bend:
        call    dwa_arc
        call    dwa_score
        ldi     @DW_J, r0
        addi    1, r0
        sti     r0, @DW_J
        cmpi    DW_SAMPLES, r0
        blt     dwa_bend
        ldi     @DW_I, r0
        addi    1, r0
        sti     r0, @DW_I
        cmpi    DW_SAMPLES, r0
        blt     dwa_speed

dwa_done:
        ldi     @DW_MET, r0
        bne     dwa_decide
        ldf     @DW_LEAST, r0
        cmpf    @K_DW_EASY2, r0
        bge     avoid_decide                    ; no disc near any arc: no shift, no limit
dwa_decide:
        ldf     @DW_BEST_V, r0
        stf     r0, @AV_SPEED
        ldf     @DW_BEST_SIDE, r0               ; lateral place to which that arc leads
        ldf     @DW_BEST, r1
        cmpf    @K_DW_WORST, r1
        ldfeq   @AV_SHIFT_OLD, r0               ; nothing is admissible: stand
        stf     r0, @AV_SHIFT
        br      avoid_decide

dwa_discs:
        call    avoid_nearest
        ldhi    hi16(AV_NEAR), ar3
        or      lo16(AV_NEAR), ar3
        ldhi    hi16(DW_SPOTS), ar1
        or      lo16(DW_SPOTS), ar1
        ldhi    hi16(DW_SQUARES), ar2
        or      lo16(DW_SQUARES), ar2
        ldi     0, r4
dwa_disc:
        ldf     @K_DW_FAR, r0
        ldf     0.0, r1
        cmpi    @AV_NEAR_FOUND, r4
        bge     dwa_disc_far
        ldi     *ar3++, ar0
        ldf     *+ar0(AV_PX), r0
        ldf     *+ar0(AV_PY), r1
dwa_disc_far:
        mpyf3   r0, r0, r2
        mpyf3   r1, r1, r3
        addf    r3, r2
        stf     r2, *ar2++
        mpyf    -2.0, r0
        stf     r0, *ar1++
        mpyf    -2.0, r1
        stf     r1, *ar1++
        addi    1, r4
        cmpi    DW_DISCS, r4
        blt     dwa_disc
        rets

dwa_window:
        ldf     @AV_SPEED_NOW, r0
        ldf     r0, r1
        subf    @K_DW_DOWN, r0
        cmpf    0.0, r0
        ldflt   0.0, r0
        stf     r0, @DW_V0
        addf    @K_DW_UP, r1
        cmpf    @K_DW_FASTEST, r1
        ldfgt   @K_DW_FASTEST, r1
        subf    r0, r1
        mpyf    @K_DW_TENTH, r1
        stf     r1, @DW_DV
        ldi     *+ar6(AG_PRODUCED), r0          ; the lane's curvature, as trajectory planning steers it now
        ldf     0.0, r1
        cmpi    0, r0
        beq     dwa_window_bend
        subi    1, r0
        and     1, r0
        lsh     3, r0
        addi3   r0, ar6, ar0
        addi    AG_POINT, ar0
        ldf     *+ar0(6), r1
dwa_window_bend:
        stf     r1, @DW_BEND
        ldf     @K_DW_WORST, r0
        stf     r0, @DW_BEST
        ldf     0.0, r0
        stf     r0, @DW_BEST_V
        stf     r0, @DW_BEST_SIDE
        ldi     0, r0
        sti     r0, @DW_MET
        ldf     @K_AV_NO_LIMIT, r0
        stf     r0, @DW_LEAST
        rets

; LANE[j]: the front after LOOK metres of curvature j, relative to the lane's point there.
dwa_lanes:
        call    alive
        ldf     @AV_MOUNT, r8
        addf    @K_DW_LOOK, r8
        call    avoid_target
        ldi     0, r0
        sti     r0, @DW_J
dwa_lane:
        call    dwa_curvature
        mpyf    @K_DW_LOOK, r0
        mpyf    0.5, r0
        ldf     r0, r6                          ; half the turn
        call    m_sincos
        mpyf    @K_DW_LOOK, r1                  ; chord, as long as the arc to 1.5 %
        mpyf    @K_DW_LOOK, r0
        ldf     r1, r7
        ldf     r0, r8
        ldf     r6, r0
        addf    r0, r0
        call    m_sincos
        mpyf    @AV_MOUNT, r1
        addf    r7, r1
        subf    @AV_TARGET, r1
        mpyf    @AV_MOUNT, r0
        addf    r8, r0
        subf    @AV_TARGET + 1, r0
        ldhi    hi16(DW_SIDE), ar0
        or      lo16(DW_SIDE), ar0
        ldi     @DW_J, ir0
        stf     r0, *+ar0(ir0)
        mpyf    r0, r0
        mpyf    r1, r1
        addf    r1, r0
        call    m_sqrt
        mpyf    @K_DW_W_LANE, r0
        ldhi    hi16(DW_LANE), ar0
        or      lo16(DW_LANE), ar0
        ldi     @DW_J, ir0
        stf     r0, *+ar0(ir0)
        addi    1, ir0
        sti     ir0, @DW_J
        cmpi    DW_SAMPLES, ir0
        blt     dwa_lane
        rets

; R0, K <- curvature of sample J.
dwa_curvature:
        ldi     @DW_J, r0
        subi    DW_SAMPLES / 2, r0
        float   r0, r0
        mpyf    @K_DW_BEND, r0
        addf    @DW_BEND, r0
        stf     r0, @DW_K
        rets

; CLEAR, FREE of the arc of V, K. The middle of the vehicle continues by v step along the heading in the middle of the
; step; its front is MOUNT ahead.
dwa_arc:
        call    alive
        call    dwa_curvature
        ldf     @DW_V, r11
        mpyf    @K_DW_STEP, r11                 ; length of a step
        cmpf    @K_DW_STEP_LEAST, r11
        ldflt   @K_DW_STEP_LEAST, r11           ; a slow sample must not look clear only because it is short
        ldf     r0, r10
        mpyf    r11, r10                        ; change of heading in a step
        ldf     @K_AV_NO_LIMIT, r0
        stf     r0, @DW_CLEAR
        stf     r0, @DW_FREE
        ldf     0.0, r8                         ; x, y of the middle
        ldf     0.0, r9
        ldf     r10, r4
        mpyf    0.5, r4                         ; heading
        ldi     0, ar4                          ; steps gone
dwa_step:
        ldf     r4, r0
        call    m_sincos
        mpyf3   r1, r11, r2
        addf    r2, r8
        mpyf3   r0, r11, r2
        addf    r2, r9
        mpyf    @AV_MOUNT, r1
        addf3   r1, r8, r6                      ; the front
        mpyf    @AV_MOUNT, r0
        addf3   r0, r9, r7
        ldhi    hi16(DW_SPOTS), ar0
        or      lo16(DW_SPOTS), ar0
        ldhi    hi16(DW_SQUARES), ar1
        or      lo16(DW_SQUARES), ar1
        ldf     @K_DW_FAR2, r5
        ldi     DW_DISCS - 1, rc
        rptb    dwa_nearest                     ; least of q - 2 x X - 2 y Y
        mpyf3   *ar0++, r6, r0
        mpyf3   *ar0++, r7, r1
||      addf3   *ar1++, r0, r2
        addf3   r1, r2, r2
        cmpf    r5, r2
dwa_nearest:
        ldflt   r2, r5
        mpyf3   r6, r6, r0
        mpyf3   r7, r7, r1
        addf    r1, r0
        addf    r0, r5                          ; + X^2 + Y^2: squared distance
        addi    1, ar4
        cmpf    @DW_CLEAR, r5
        bge     dwa_step_not_nearer
        stf     r5, @DW_CLEAR
dwa_step_not_nearer:
        cmpf    @K_DW_RADIUS2, r5
        bge     dwa_step_clear
        ldf     @DW_FREE, r0
        cmpf    @K_AV_NO_LIMIT, r0
        blt     dwa_step_clear                  ; met before
        float   ar4, r0
        subf    1.0, r0
        mpyf    r11, r0
        stf     r0, @DW_FREE
dwa_step_clear:
        addf    r10, r4
        cmpi    DW_STEPS, ar4
        blt     dwa_step
        rets

dwa_score:
        ldf     @DW_CLEAR, r0
        cmpf    @DW_LEAST, r0
        bge     dwa_score_not_least
        stf     r0, @DW_LEAST
dwa_score_not_least:
        ldf     @DW_FREE, r0
        cmpf    @K_AV_NO_LIMIT, r0
        bge     dwa_score_admissible
        ldi     1, r1
        sti     r1, @DW_MET
        subf    @K_AV_STAND, r0
        ldf     @DW_V, r1
        ldf     r1, r2
        mpyf    @K_DW_HALF_OVER_B, r2
        addf    @K_AV_T, r2
        mpyf    r2, r1                          ; v T + v^2 / (2 B)
        cmpf    r0, r1
        retsgt
dwa_score_admissible:
        ldf     @DW_CLEAR, r0
        call    m_sqrt
        subf    @K_AV_HALF, r0
        cmpf    @K_DW_CLEAR_MOST, r0
        ldfgt   @K_DW_CLEAR_MOST, r0
        mpyf    @K_DW_W_CLEAR, r0
        ldf     @DW_V, r1
        mpyf    @K_DW_W_SPEED, r1
        addf    r1, r0
        ldhi    hi16(DW_LANE), ar0
        or      lo16(DW_LANE), ar0
        ldi     @DW_J, ir0
        subf    *+ar0(ir0), r0
        cmpf    @DW_BEST, r0
        retsle
        stf     r0, @DW_BEST
        ldf     @DW_V, r0
        stf     r0, @DW_BEST_V
        addi    DW_SIDE - DW_LANE, ar0
        ldf     *+ar0(ir0), r0
        stf     r0, @DW_BEST_SIDE
        rets
