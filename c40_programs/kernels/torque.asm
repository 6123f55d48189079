; Sub-process 3: motor torques that make the L0 crane (no sway) follow the set-point of TB_TICK: closed form of
; plant-and-bus.md 1.3, rotors, friction, gears. torque_newton_euler.asm is the second build of the same task.
;   A = m_p L + m_j c_j        R = a0 + L cos phi        mu = m_j (a0 + c_j cos phi) + m_p R - m_cw r_cw
;   H = I_j + m_j c_j^2 + m_p L^2        C = H cos phi + a0 A
;   M_psi = J_s + I_j cos^2 phi + m_cw r_cw^2 + m_j (a0 + c_j cos phi)^2 + m_p R^2

TQ_LOAD_TICK    .set SCRATCH + 95       ; CR_LOAD_TICK, CR_CONSUMED, CR_SEGMENT_START, CR_PID_STAGE
TQ_CONSUMED     .set SCRATCH + 96
TQ_SEGMENT      .set SCRATCH + 97
TQ_STAGE        .set SCRATCH + 98
TQ_WIND         .set SCRATCH + 99       ; i TB_RESULT: TORQUE_WIND when the anemometer is above its limit
TQ_Q            .set SCRATCH + 64       ; set-point: q, qd, qdd, f x5 each
TQ_QD           .set SCRATCH + 69
TQ_QDD          .set SCRATCH + 74
TQ_TAU          .set SCRATCH + 80       ; f x5: joint forces, then motor torques
TQ_A            .set SCRATCH + 86
TQ_MU           .set SCRATCH + 87
TQ_H            .set SCRATCH + 88
TQ_C            .set SCRATCH + 89
TQ_M_PSI        .set SCRATCH + 90
TQ_SIN_PSI      .set SCRATCH + 91
TQ_COS_PSI      .set SCRATCH + 92
TQ_RADIUS       .set SCRATCH + 93

kernel_torque:
        call    torque_set_point
        ldi     @TQ_STAGE, r0
        beq     torque_nothing          ; PID has not yet taken the pose at the start
        call    torque_closed_form
        br      torque_motors

; Q, QD, QDD <- the set-point of TB_TICK, SV_LOAD <- kg on the rope; if STAGE is 0, only STAGE.
torque_set_point:
        call    servo_head
        ldi     ar6, ar0
        addi    CR_LOAD_TICK, ar0
        ldhi    hi16(TQ_LOAD_TICK), ar1
        or      lo16(TQ_LOAD_TICK), ar1
        ldi     3, rc
        call    copy_words
        ldi     @TQ_STAGE, r0
        retseq

        ldi     @TQ_CONSUMED, r0
        call    servo_slots
        ldi     r1, r8
        lsh     4, r0
        ldi     r0, ar0
        addi    ar6, ar0
        addi    CR_RING, ar0
        ldhi    hi16(SV_FROM), ar1
        or      lo16(SV_FROM), ar1
        ldi     14, rc
        call    copy_words
        lsh     4, r8
        ldi     r8, ar0
        addi    ar6, ar0
        addi    CR_RING, ar0
        ldhi    hi16(SV_TO), ar1
        or      lo16(SV_TO), ar1
        ldi     14, rc
        call    copy_words
        call    servo_path
        ldi     @TQ_SEGMENT, r0
        call    servo_phase

        ldhi    hi16(SV_FROM), ar0      ; set-point = from + phase (to - from), all 15 words
        or      lo16(SV_FROM), ar0
        ldhi    hi16(TQ_Q), ar1
        or      lo16(TQ_Q), ar1
        ldi     14, rc
        rptb    torque_between
        ldf     *+ar0(SV_TO - SV_FROM), r1
        subf    *ar0, r1
        mpyf    r0, r1
        addf    *ar0++, r1
torque_between:
        stf     r1, *ar1++
        call    servo_ramp
        addf    @TQ_Q + 3, r0
        stf     r0, @TQ_Q + 3
        addf    @TQ_QD + 3, r1
        stf     r1, @TQ_QD + 3
        addf    @TQ_QDD + 3, r2
        stf     r2, @TQ_QDD + 3
        call    torque_load
        ldi     @SV_STOPPED, r0
        retseq
        ldf     @SV_PATH_RATE, r2               ; the path's clock has a rate p other than 1: qd p, qdd p^2 + qd p'
        ldf     @SV_PATH_CHANGE, r3
        mpyf    @SV_RATE, r3
        ldhi    hi16(TQ_QD), ar0
        or      lo16(TQ_QD), ar0
        ldi     4, rc
        rptb    torque_rated
        ldf     *ar0, r0
        mpyf3   r0, r3, r1
        mpyf    r2, r0
        stf     r0, *ar0
        ldf     *+ar0(TQ_QDD - TQ_QD), r0
        mpyf    r2, r0
        mpyf    r2, r0
        addf    r1, r0
        stf     r0, *+ar0(TQ_QDD - TQ_QD)
torque_rated:
        nop     *ar0++
        rets

; SV_LOAD <- kg on the rope: load cell, low-pass filtered (K_TQ_LOAD_FILTER); LOAD_TICK. No change at the same tick.
; changes nothing. WIND <- whether the anemometer is above its limit.
torque_load:
        ldhi    hi16(WINDOW_B), ar0
        absi    *+ar0(WIND_MEAN), r0
        ldi     0, r1
        cmpi    @K_TQ_WIND_LIMIT, r0
        ldigt   TORQUE_WIND, r1
        sti     r1, @TQ_WIND
        float   *+ar0(LOAD_CELL), r4
        ldi     @TASK + TB_TICK, r1
        ldi     r1, r3
        subi    @TQ_LOAD_TICK, r3
        cmpi    0, r3
        ldilt   0, r3
        float   r3, r3                          ; refreshes since the last reading
        sti     r1, @TQ_LOAD_TICK
        ldf     @K_TQ_LOAD_FILTER, r0
        mpyf    @SV_RATE, r0
        addf    r3, r0
        call    m_reciprocal
        mpyf    r3, r0                          ; h / (T + h)
        subf    @SV_LOAD, r4
        mpyf    r4, r0
        addf    @SV_LOAD, r0
        rnd     r0, r0
        stf     r0, @SV_LOAD
        stf     r0, *+ar6(CR_LOAD)
        ldi     ar6, ar1
        addi    CR_LOAD_TICK, ar1
        ldi     @TQ_LOAD_TICK, r1
        sti     r1, *ar1
        rets

; R0 <- I_k, kg m2: the spreader's, and the load's.
torque_yaw_inertia:
        ldf     @SV_LOAD, r0
        subf    @K_TQ_SPREADER, r0
        cmpf    0.0, r0
        ldflt   0.0, r0
        mpyf    @K_TQ_YAW_PER_KG, r0
        addf    @K_TQ_YAW_BASE, r0
        rets

; TAU <- the joint forces.
torque_closed_form:
; Configuration
        ldf     @TQ_Q + 1, r0
        call    m_sincos
        stf     r0, @TQ_SIN_PSI
        stf     r1, @TQ_COS_PSI
        ldf     @TQ_Q + 2, r0
        call    m_sincos
        ldf     r0, r10                 ; R10 = sin phi
        ldf     r1, r9                  ; R9 = cos phi
        ldf     @SV_LOAD, r11           ; R11 = m_p

        ldf     @K_JIB, r0
        mpyf    r11, r0
        addf    @K_TQ_JIB_MOMENT, r0
        stf     r0, @TQ_A
        ldf     @K_JIB, r1
        mpyf    r9, r1
        addf    @K_A0, r1
        stf     r1, @TQ_RADIUS
        mpyf3   r11, r1, r2             ; m_p R
        mpyf3   r1, r2, r3              ; m_p R^2
        ldf     @K_TQ_JIB_MOMENT, r4
        mpyf    r9, r4
        addf    @K_TQ_A0_MASS, r4
        addf    r2, r4
        subf    @K_TQ_CW_MOMENT, r4
        stf     r4, @TQ_MU
        ldf     @K_JIB_SQUARED, r4
        mpyf    r11, r4
        addf    @K_TQ_JIB_PIVOT, r4
        stf     r4, @TQ_H
        mpyf    r9, r4
        mpyf    @K_A0, r0
        addf    r0, r4
        stf     r4, @TQ_C
        mpyf3   r9, r9, r4
        mpyf    @K_TQ_JIB_INERTIA, r4
        addf    r3, r4
        addf    @K_TQ_SLEW_FIXED, r4
        ldf     @K_TQ_JIB_CENTRE, r5
        mpyf    r9, r5
        addf    @K_A0, r5
        mpyf    r5, r5
        mpyf    @K_TQ_JIB_MASS, r5
        addf    r5, r4
        stf     r4, @TQ_M_PSI

; tau_kappa = I_k (psidd + kappadd)
        call    torque_yaw_inertia
        ldf     @TQ_QDD + 1, r1
        addf    @TQ_QDD + 4, r1
        mpyf    r1, r0
        stf     r0, @TQ_TAU + 4

; tau_psi = M_psi psidd - mu sin psi sdd - 2 sin phi phid psid C + tau_kappa
        ldf     @TQ_M_PSI, r1
        mpyf    @TQ_QDD + 1, r1
        addf    r1, r0
        ldf     @TQ_MU, r1
        mpyf    @TQ_SIN_PSI, r1
        mpyf    @TQ_QDD, r1
        subf    r1, r0
        ldf     @TQ_QD + 2, r1
        mpyf    @TQ_QD + 1, r1
        mpyf    r10, r1
        ldf     r1, r8                  ; R8 = sin phi phid psid
        mpyf    2.0, r1
        mpyf    @TQ_C, r1
        subf    r1, r0
        stf     r0, @TQ_TAU + 1

; tau_s = m sdd - mu (psid^2 cos psi + psidd sin psi) - A [cos psi (cos phi phid^2 + sin phi phidd) - 2 sin psi sin phi
; phid psid]
        ldf     @K_TQ_GANTRY, r0
        addf    r11, r0
        mpyf    @TQ_QDD, r0
        ldf     @TQ_QD + 1, r1
        mpyf    r1, r1
        ldf     r1, r7                  ; R7 = psid^2
        mpyf    @TQ_COS_PSI, r1
        ldf     @TQ_QDD + 1, r2
        mpyf    @TQ_SIN_PSI, r2
        addf    r2, r1
        mpyf    @TQ_MU, r1
        subf    r1, r0
        ldf     @TQ_QD + 2, r1
        mpyf    r1, r1
        ldf     r1, r6                  ; R6 = phid^2
        mpyf    r9, r1
        ldf     @TQ_QDD + 2, r2
        mpyf    r10, r2
        addf    r2, r1
        mpyf    @TQ_COS_PSI, r1
        ldf     @TQ_SIN_PSI, r2
        mpyf    r8, r2
        mpyf    2.0, r2
        subf    r2, r1
        mpyf    @TQ_A, r1
        subf    r1, r0
        stf     r0, @TQ_TAU

; tau_phi = H phidd - A sin phi cos psi sdd - m_p L cos phi ldd + g A cos phi + sin phi psid^2 C
        ldf     @TQ_H, r0
        mpyf    @TQ_QDD + 2, r0
        ldf     @TQ_A, r1
        mpyf    r10, r1
        mpyf    @TQ_COS_PSI, r1
        mpyf    @TQ_QDD, r1
        subf    r1, r0
        ldf     @K_JIB, r5
        mpyf    r9, r5                  ; R5 = L cos phi
        mpyf3   r5, r11, r1
        mpyf    @TQ_QDD + 3, r1
        subf    r1, r0
        ldf     @TQ_A, r1
        mpyf    r9, r1
        mpyf    @K_GRAVITY, r1
        addf    r1, r0
        mpyf3   r10, r7, r1
        mpyf    @TQ_C, r1
        addf    r1, r0
        stf     r0, @TQ_TAU + 2

; tau_l = m_p (ldd - g - L cos phi phidd + L sin phi phid^2)
        ldf     @TQ_QDD + 3, r0
        subf    @K_GRAVITY, r0
        mpyf    @TQ_QDD + 2, r5
        subf    r5, r0
        ldf     @K_JIB, r1
        mpyf    r10, r1
        mpyf    r6, r1
        addf    r1, r0
        mpyf    r11, r0
        stf     r0, @TQ_TAU + 3
        rets

; motor torque = (tau + J_m n^2 qdd + F_c tanh(qd / v_0) + b qd) / (n eta)
torque_motors:
        ldhi    hi16(TQ_TAU), ar2
        or      lo16(TQ_TAU), ar2
        ldhi    hi16(K_TQ_DRIVES), ar3
        or      lo16(K_TQ_DRIVES), ar3
        ldi     4, ar4
torque_drive:
        ldf     *-ar2(TQ_TAU - TQ_QD), r0
        mpyf    *+ar3(2), r0
        call    m_tanh
        mpyf    *+ar3(1), r0
        ldf     *-ar2(TQ_TAU - TQ_QD), r1
        mpyf    *+ar3(3), r1
        addf    r1, r0
        ldf     *-ar2(TQ_TAU - TQ_QDD), r1
        mpyf    *ar3, r1
        addf    r1, r0
        addf    *ar2, r0
        mpyf    *+ar3(4), r0
        rnd     r0, r0
        stf     r0, *ar2++
        addi    5, ar3
        dbu     ar4, torque_drive
        br      torque_write

torque_nothing:
        ldi     0, r0
        sti     r0, @TQ_WIND
        ldf     0.0, r0
        ldhi    hi16(TQ_TAU), ar1
        or      lo16(TQ_TAU), ar1
        rpts    4
        stf     r0, *ar1++
torque_write:
        ldhi    hi16(TQ_TAU), ar0
        or      lo16(TQ_TAU), ar0
        ldi     ar6, ar1
        addi    CR_FEED_FORWARD, ar1
        ldi     4, rc
        call    copy_words
        fix     @SV_LOAD, r0
        lsh     TORQUE_LOAD, r0
        or      @TQ_WIND, r0
        ldi     0, r1
        rets
