; Sub-process 2, crane: joint point k from Cartesian point k, closed form of plant-and-bus.md 1.2 with the gantry at s =
; 0. Besides q, qd, qdd it writes what PID needs against sway: the reference angles alpha = -p''.e_r / g, beta =
; -p''.e_t / g of the payload, d phi/d r = -1/(L sin phi) and d psi/d t = 1/r.

IK_X            .set SCRATCH + 0        ; pose, velocity, acceleration, f x4 each: x, y, z, yaw
IK_Y            .set SCRATCH + 1
IK_Z            .set SCRATCH + 2
IK_YAW          .set SCRATCH + 3
IK_XD           .set SCRATCH + 4
IK_YD           .set SCRATCH + 5
IK_ZD           .set SCRATCH + 6
IK_YAWD         .set SCRATCH + 7
IK_XDD          .set SCRATCH + 8
IK_YDD          .set SCRATCH + 9
IK_ZDD          .set SCRATCH + 10
IK_YAWDD        .set SCRATCH + 11
IK_PX           .set SCRATCH + 12       ; acceleration of the payload
IK_PY           .set SCRATCH + 13
IK_Q            .set SCRATCH + 16       ; q, qd, qdd, f x5 each: s, psi, phi, l, kappa
IK_QD           .set SCRATCH + 21
IK_QDD          .set SCRATCH + 26
IK_SWAY         .set SCRATCH + 32
IK_UNREACHABLE  .set SCRATCH + 36
IK_R            .set SCRATCH + 37
IK_RD           .set SCRATCH + 38

kernel_inverse_crane:
        ldi     @TASK + TB_ARGUMENT, ar0
        and     1, ar0
        lsh     4, ar0
        addi    ar6, ar0
        addi    CR_POINT, ar0
        ldhi    hi16(IK_X), ar1
        or      lo16(IK_X), ar1
        ldi     13, rc
        call    copy_words

        ldf     @IK_X, r1
        mpyf    r1, r1
        ldf     @IK_Y, r0
        mpyf    r0, r0
        addf    r1, r0
        ldf     r0, r3                          ; r^2
        call    m_rsqrt
        ldf     r0, r8                          ; R8 = 1/r
        mpyf    r3, r0
        stf     r0, @IK_R
        subf    @K_A0, r0
        mpyf    @K_ONE_OVER_JIB, r0
        ldf     r0, r9
        ldf     @K_IK_COS_HIGH, r1
        cmpf    r1, r9
        ldfgt   r1, r9
        ldf     @K_IK_COS_LOW, r1
        cmpf    r1, r9
        ldflt   r1, r9                          ; R9 = cos phi within the luff's range
        ldi     0, r1
        ldhi    hi16(RESULT_UNREACHABLE), r2
        cmpf    r0, r9
        ldine   r2, r1
        sti     r1, @IK_UNREACHABLE
        mpyf3   r9, r9, r0
        subrf   1.0, r0
        ldf     r0, r3
        call    m_rsqrt
        mpyf3   r0, r3, r10                     ; R10 = sin phi
        mpyf    @K_ONE_OVER_JIB, r0
        ldf     r0, r11                         ; R11 = 1/(L sin phi)

        ldf     r10, r0
        ldf     r9, r1
        call    m_atan2
        rnd     r0, r0
        stf     r0, @IK_Q + 2                   ; phi
        ldf     @IK_Y, r0
        ldf     @IK_X, r1
        call    m_atan2
        ldf     r0, r6
        rnd     r0, r0
        stf     r0, @IK_Q + 1                   ; psi
        ldf     @IK_YAW, r0
        subf    r6, r0
        call    m_wrap
        rnd     r0, r0
        stf     r0, @IK_Q + 4                   ; kappa
        ldf     r10, r0
        mpyf    @K_JIB, r0
        addf    @K_PIVOT, r0
        subf    @IK_Z, r0
        rnd     r0, r0
        stf     r0, @IK_Q + 3                   ; l
        ldf     0.0, r0
        stf     r0, @IK_Q
        stf     r0, @IK_QD
        stf     r0, @IK_QDD

; Rates
        ldf     @IK_X, r0
        mpyf    @IK_XD, r0
        ldf     @IK_Y, r1
        mpyf    @IK_YD, r1
        addf    r1, r0
        mpyf    r8, r0
        stf     r0, @IK_RD                      ; R0 = rd
        ldf     @IK_X, r1
        mpyf    @IK_YD, r1
        ldf     @IK_Y, r2
        mpyf    @IK_XD, r2
        subf    r2, r1
        mpyf    r8, r1
        mpyf    r8, r1                          ; R1 = psid
        stf     r1, @IK_QD + 1
        mpyf3   r0, r11, r2
        negf    r2, r2                          ; R2 = phid
        stf     r2, @IK_QD + 2
        mpyf3   r9, r2, r3
        mpyf    @K_JIB, r3                      ; R3 = L cos phi phid
        ldf     r3, r4
        subf    @IK_ZD, r4
        stf     r4, @IK_QD + 3
        ldf     @IK_YAWD, r4
        subf    r1, r4
        stf     r4, @IK_QD + 4

; Accelerations
        ldf     @IK_X, r4
        mpyf    @IK_YDD, r4
        ldf     @IK_Y, r5
        mpyf    @IK_XDD, r5
        subf    r5, r4
        mpyf    r8, r4                          ; (x ydd - y xdd) / r
        mpyf3   r0, r1, r5
        mpyf    2.0, r5
        subf    r5, r4
        mpyf    r8, r4                          ; R4 = psidd
        stf     r4, @IK_QDD + 1
        ldf     @IK_YAWDD, r5
        subf    r4, r5
        stf     r5, @IK_QDD + 4
        ldf     @IK_XD, r4
        mpyf    r4, r4
        ldf     @IK_YD, r5
        mpyf    r5, r5
        addf    r5, r4
        ldf     @IK_X, r5
        mpyf    @IK_XDD, r5
        addf    r5, r4
        ldf     @IK_Y, r5
        mpyf    @IK_YDD, r5
        addf    r5, r4
        mpyf    r0, r0
        subf    r0, r4
        mpyf    r8, r4                          ; R4 = rdd
        mpyf3   r2, r3, r5                      ; L cos phi phid^2
        addf    r5, r4
        mpyf    r11, r4
        negf    r4, r4                          ; R4 = phidd
        stf     r4, @IK_QDD + 2
        mpyf    r9, r4
        mpyf    r2, r2
        mpyf    r10, r2
        subf    r2, r4
        mpyf    @K_JIB, r4
        subf    @IK_ZDD, r4
        stf     r4, @IK_QDD + 3                 ; ldd

; Sway
        ldf     @K_ONE_OVER_G, r3
        mpyf    r8, r3
        negf    r3, r3                          ; -1 / (r g)
        ldf     @IK_PX, r0
        mpyf    @IK_X, r0
        ldf     @IK_PY, r1
        mpyf    @IK_Y, r1
        addf    r1, r0
        mpyf    r3, r0
        stf     r0, @IK_SWAY                    ; alpha
        ldf     @IK_PY, r0
        mpyf    @IK_X, r0
        ldf     @IK_PX, r1
        mpyf    @IK_Y, r1
        subf    r1, r0
        mpyf    r3, r0
        stf     r0, @IK_SWAY + 1                ; beta
        negf    r11, r0
        stf     r0, @IK_SWAY + 2
        stf     r8, @IK_SWAY + 3

inverse_crane_write:
        ldi     @TASK + TB_ARGUMENT, r2
        and     3, r2
        ldi     r2, ar1
        lsh     2, ar1
        addi    ar6, ar1
        addi    CR_SWAY, ar1
        ldhi    hi16(IK_SWAY), ar0
        or      lo16(IK_SWAY), ar0
        ldi     3, rc
        call    copy_words
        ldi     r2, ar1
        lsh     4, ar1
        addi    ar6, ar1
        addi    CR_RING, ar1
        ldhi    hi16(IK_Q), ar0
        or      lo16(IK_Q), ar0
        ldi     14, rc
        call    copy_words
        ldi     @TASK + TB_ARGUMENT, r0
        addi    1, r0
        ldi     ar6, ar0
        addi    CR_PRODUCED, ar0
        sti     r0, *ar0                        ; last: from now on PID may use the point
        and     0FFFFh, r0
        or      @IK_UNREACHABLE, r0
        ldi     0, r1
        rets
