; PID's law (plant-and-bus.md 2.1; docs/control.md for the gains):
;   e = r - y      D <- T_d / (T_d + N h) (D + K N (e - e_old))      v = P + D + share tau_ff      u = clamp(v, +-u_max)
; P <- P + K (e - e_old) at the start of a tick, P <- P + h (K / T_i e + (u - v) / T_t) at its end: proportional and
; integral part in one. While K is constant that is K e + I; where K changes, the output does not jump.
; K follows the luff angle and the mass on the rope: K = k_0 + k_m m + cos phi (k_1 + cos phi (k_2 + k_2m m)). The host
; writes all these words (CR_CONTROL_BLOCK). Each DSP keeps a copy on chip. It reads them again if CR_CONTROL, which
; is read at every tick anyway, shows another generation than the copy's.

SV_CONTROL      .set SV_HEAD + CR_CONTROL

; After the state has been read. If the parameters have changed, P takes over the decrease of the feed-forward.
pid_control:
        ldi     @SV_CONTROL, r0
        cmpi    @K_PC_GENERATION, r0
        callne  pid_control_read
        ldi     @SV_CONTROL, r0
        lsh     1, r0
        ldi     @PD_LAW, r1
        andn3   PD_DRY, r1, r2
        cmpi    r0, r2
        retseq
        and     PD_DRY, r1
        or      r1, r0
        sti     r0, @PD_LAW
        ldhi    hi16(PD_FEED), ar0
        or      lo16(PD_FEED), ar0
        ldhi    hi16(PD_PI), ar1
        or      lo16(PD_PI), ar1
        ldhi    hi16(K_PC_JOINTS), ar2
        or      lo16(K_PC_JOINTS), ar2
        ldi     4, rc
        rptb    pid_control_share
        ldf     *+ar2(PC_SHARE_BEFORE), r0
        subf    *+ar2(PC_SHARE), r0
        mpyf    *ar0++, r0
        addf    *ar1, r0
        rnd     r0, r0
        addi    PC_ROW, ar2
pid_control_share:
        stf     r0, *ar1++
        rets

pid_control_read:
        sti     r0, @K_PC_GENERATION
        ldi     ar6, ar0
        addi    CR_CONTROL_BLOCK, ar0
        ldhi    hi16(K_PC_JOINTS), ar1
        or      lo16(K_PC_JOINTS), ar1
        ldi     CR_CONTROL_WORDS - 1, rc
        call    copy_words
        ldf     -1.0, r0
        stf     r0, @K_PC_PERIOD
        rets

; FILTER <- T_d / (T_d + N h) of each joint, and the h-dependent factors against sway. Kept while h stays the same:
; always, if no tick is missed.
pid_filters:
        ldf     @PD_H, r10
        cmpf    @K_PC_PERIOD, r10
        retseq
        stf     r10, @K_PC_PERIOD
        ldhi    hi16(K_PC_JOINTS), ar0
        or      lo16(K_PC_JOINTS), ar0
        ldhi    hi16(K_PC_FILTER), ar1
        or      lo16(K_PC_FILTER), ar1
        ldi     4, ar2
pid_filter:
        ldf     *+ar0(PC_N), r0
        mpyf    r10, r0
        addf    *+ar0(PC_DERIVATIVE), r0
        call    m_reciprocal
        mpyf    *+ar0(PC_DERIVATIVE), r0
        rnd     r0, r0
        stf     r0, *ar1++
        addi    PC_ROW, ar0
        dbu     ar2, pid_filter
        ldf     @K_PC_SWAY_FILTER, r0           ; and the factors of pid_sway.asm
        addf    r10, r0
        call    m_reciprocal
        mpyf    r10, r0
        rnd     r0, r0
        stf     r0, @K_PC_SMOOTH
        ldf     @K_PD_LONGEST, r0
        cmpf    r10, r0
        ldfgt   r10, r0
        stf     r0, @K_PC_STEP
        ldf     @K_PC_SWAY_WIND, r1
        mpyf    r1, r0
        mpyf    3.0, r0
        rnd     r0, r2
        stf     r2, @K_PC_OBSERVE
        mpyf    r1, r0
        rnd     r0, r2
        stf     r2, @K_PC_OBSERVE + 1
        mpyf    r1, r0
        mpyf    @K_PD_THIRD, r0
        rnd     r0, r0
        stf     r0, @K_PC_OBSERVE + 2
        ldf     @K_PC_SWAY_GAIN, r0
        mpyf    @K_ONE_OVER_G, r0
        rnd     r0, r0
        stf     r0, @K_PC_BRAKE
        rets

; CODE, and PI, D, E of the state; OUT.
pid_joints:
        ldf     @PD_COSINE, r9                  ; on a gantry no term of K depends on it
        ldf     @PD_H, r10
        ldf     @SV_LOAD, r11                   ; m: at least the spreader's mass, also while the rope is slack
        cmpf    @K_TQ_SPREADER, r11
        ldflt   @K_TQ_SPREADER, r11
        ldi     0, r6
        ldi     1, r7
        ldhi    hi16(K_PC_FILTER), ar0
        or      lo16(K_PC_FILTER), ar0
        ldhi    hi16(PD_R), ar2
        or      lo16(PD_R), ar2
        ldhi    hi16(K_PC_JOINTS), ar3
        or      lo16(K_PC_JOINTS), ar3
        ldhi    hi16(K_PD_JOINTS), ar5
        or      lo16(K_PD_JOINTS), ar5
        ldi     4, ar4
pid_joint:
        ldf     *ar2, r8
        subf    *-ar2(PD_R - PD_Y), r8          ; e
        absf    r8, r0
        cmpf    *+ar5(2), r0
        ble     pid_joint_within
        or      r7, r6
pid_joint_within:
        lsh     1, r7
        ldf     *+ar3(PC_COS2_MASS), r3
        mpyf    r11, r3
        addf    *+ar3(PC_COS2), r3
        mpyf    r9, r3
        addf    *+ar3(PC_COS), r3
        mpyf    r9, r3
        ldf     *+ar3(PC_MASS), r0
        mpyf    r11, r0
        addf    r0, r3
        addf    *+ar3(PC_K), r3                 ; K
        ldf     r8, r1
        subf    *-ar2(PD_R - PD_E), r1
        mpyf3   r1, r3, r4
        addf    *-ar2(PD_R - PD_PI), r4         ; P
        ldi     @PD_BUILD, r0
        bz      pid_joint_change
        ldf     *-ar2(PD_R - PD_Y), r2          ; in the law as printed the derivative acts on the measurement
        ldf     *-ar2(PD_R - PD_Y_OLD), r1
        subf    r2, r1
        stf     r2, *-ar2(PD_R - PD_Y_OLD)
pid_joint_change:
        mpyf    r3, r1
        mpyf    *+ar3(PC_N), r1
        addf    *-ar2(PD_R - PD_D), r1
        mpyf    *ar0++, r1                      ; D
        stf     r1, *-ar2(PD_R - PD_D)
        stf     r8, *-ar2(PD_R - PD_E)
        ldf     *-ar2(PD_R - PD_FEED), r2
        mpyf    *+ar3(PC_SHARE), r2
        addf    r1, r2
        addf    r4, r2                          ; v
        ldf     *ar5, r1
        ldf     r2, r5
        cmpf    r1, r5
        ldfgt   r1, r5
        negf    r1, r1
        cmpf    r1, r5
        ldflt   r1, r5                          ; u
        ldf     r5, r0
        subf    r2, r0
        mpyf    *+ar3(PC_TRACKING), r0
        mpyf    r8, r3
        mpyf    *+ar3(PC_INTEGRAL), r3
        addf    r3, r0
        mpyf    r10, r0
        addf    r4, r0
        rnd     r0, r0
        stf     r0, *-ar2(PD_R - PD_PI)
        mpyf    *+ar5(1), r5
        addf    0.5, r5
        fix     r5, r5
        sti     r5, *+ar2(PD_CODE - PD_R)
        addi    1, ar2
        addi    PC_ROW, ar3
        addi    3, ar5
        dbu     ar4, pid_joint
        or      @PD_OUT, r6
        sti     r6, @PD_OUT
        rets
