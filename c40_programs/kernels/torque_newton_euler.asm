; Sub-process 3, second build: joint forces by recursive Newton-Euler over a table of links (docs/kernels.md).
;
; Six links hang on each other: gantry (P, x), slewing platform (R, z), jib (R, -y), a massless link that turns back by
; the luff angle, because the load does not tilt (R, y, the same angle), load (P, -z), spreader's yaw (R, z). Each joint
; turns or slides along one coordinate axis k; b, c are the two that follow it cyclically, so a turn touches two
; components. Outwards, in the frame of each link:
;   w = R w_p + qd e_k          wd = R wd_p + (R w_p) x qd e_k + qdd e_k          (R alone where the joint slides)
;   a = R (wd_p x p + w_p x (w_p x p) + a_p) [+ 2 w x qd e_k + qdd e_k]
;   F = m (a + wd x s + w x (w x s))        N = I wd + w x I w
; and back inwards: f = F + R' f_out, n = N + s x F + R' n_out + p_out x R' f_out, joint force = n_k or f_k. Links that
; share a joint's q add up, each with its sign (virtual work).

NE_LINKS        .set 6
NE_PLAN         .set SCRATCH + 128      ; the table's rows, NE_ROW words each:
NE_ROW          .set 17
NE_B            .set 0                  ; i: b, c, k as 0, 1, 2
NE_C            .set 1
NE_K            .set 2
NE_JOINT        .set 3                  ; i: joint that moves this link
NE_SLIDES       .set 4                  ; i
NE_SIGN         .set 5
NE_P            .set 6                  ; joint's place in the frame before, m
NE_S            .set 9                  ; centre of mass, m
NE_MASS         .set 12
NE_INERTIA      .set 13                 ; about the centre of mass, along x, y, z
NE_HAS          .set 16                 ; i: which of these are not zero:
NE_HAS_ARM      .set 1                  ;    p (or the joint slides)
NE_HAS_CENTRE   .set 2                  ;    s
NE_HAS_INERTIA  .set 4
NE_STATE        .set SCRATCH + 256      ; per link, the base first, NE_WORDS each:
NE_WORDS        .set 24
NE_W            .set 0
NE_WD           .set 3
NE_A            .set 6
NE_F            .set 9
NE_N            .set 12
NE_SIN          .set 15
NE_COS          .set 16
NE_ARM          .set 17                 ; p with the joint's slide, in the frame before
NE_RATE         .set 20                 ; qd, qdd with the sign
NE_ACCELERATION .set 21
NE_HELP         .set SCRATCH + 448      ; two vectors, 4 words apart

kernel_torque_newton_euler:
        call    torque_set_point
        ldi     @TQ_STAGE, r0
        beq     torque_nothing
        call    newton_euler_prepare
newton_euler_outwards:
        call    newton_euler_joint
        call    newton_euler_motion
        call    newton_euler_force
        addi    NE_ROW, ar4
        ldi     ar5, ar3
        addi    NE_WORDS, ar5
        subi    1, ar7
        cmpi    0, ar7
        bgt     newton_euler_outwards
        ldi     NE_LINKS, ar7
newton_euler_inwards:
        subi    NE_ROW, ar4
        ldi     ar3, ar5
        subi    NE_WORDS, ar3
        call    newton_euler_back
        subi    1, ar7
        cmpi    0, ar7
        bgt     newton_euler_inwards
        ldhi    hi16(TASK), ar7
        or      lo16(TASK), ar7
        br      torque_motors

; The table on chip with the payload's mass and yaw inertia, the base with gravity upwards, joint forces 0. AR4 row, AR5
; link, AR3 the one before, AR7 links to go.
newton_euler_prepare:
        ldhi    hi16(K_NE_TABLE), ar0
        or      lo16(K_NE_TABLE), ar0
        ldhi    hi16(NE_PLAN), ar1
        or      lo16(NE_PLAN), ar1
        ldi     NE_LINKS * NE_ROW - 1, rc
        call    copy_words
        ldf     @SV_LOAD, r0
        stf     r0, @NE_PLAN + 4 * NE_ROW + NE_MASS
        call    torque_yaw_inertia
        rnd     r0, r0
        stf     r0, @NE_PLAN + 5 * NE_ROW + NE_INERTIA + 2
        ldf     0.0, r0
        ldhi    hi16(NE_STATE), ar3
        or      lo16(NE_STATE), ar3
        ldi     ar3, ar0
        rpts    7
        stf     r0, *ar0++
        ldf     @K_GRAVITY, r1
        stf     r1, *ar0
        ldhi    hi16(TQ_TAU), ar0
        or      lo16(TQ_TAU), ar0
        rpts    4
        stf     r0, *ar0++
        ldhi    hi16(NE_PLAN), ar4
        or      lo16(NE_PLAN), ar4
        ldi     ar3, ar5
        addi    NE_WORDS, ar5
        ldi     NE_LINKS, ar7
        rets

; SIN, COS, ARM, RATE, ACCELERATION of link AR5 by row AR4.
newton_euler_joint:
        ldi     *+ar4(NE_JOINT), ir0
        ldhi    hi16(TQ_Q), ar0
        or      lo16(TQ_Q), ar0
        ldf     *+ar4(NE_SIGN), r4
        ldf     *+ar0(ir0), r0
        mpyf    r4, r0                          ; q
        addi    ir0, ar0
        ldf     *+ar0(TQ_QD - TQ_Q), r1
        mpyf    r4, r1
        stf     r1, *+ar5(NE_RATE)
        ldf     *+ar0(TQ_QDD - TQ_Q), r1
        mpyf    r4, r1
        stf     r1, *+ar5(NE_ACCELERATION)
        ldi     ar4, ar0
        addi    NE_P, ar0
        ldi     ar5, ar1
        addi    NE_ARM, ar1
        ldf     *ar0, r1
        stf     r1, *ar1
        ldf     *+ar0(1), r1
        stf     r1, *+ar1(1)
        ldf     *+ar0(2), r1
        stf     r1, *+ar1(2)
        ldi     *+ar4(NE_SLIDES), r1
        bz      newton_euler_turns
        ldi     *+ar4(NE_K), ir0
        addf    *+ar1(ir0), r0
        rnd     r0, r0
        stf     r0, *+ar1(ir0)
        ldf     0.0, r0
        ldf     1.0, r1
        br      newton_euler_joint_done
newton_euler_turns:
        call    m_sincos
newton_euler_joint_done:
        rnd     r0, r0
        stf     r0, *+ar5(NE_SIN)
        rnd     r1, r1
        stf     r1, *+ar5(NE_COS)
        rets

; R3, R4, R5 <- *AR0 x *AR1. Clobbers R0 .. R2.
newton_euler_cross:
        ldf     *ar0, r0
        ldf     *+ar0(1), r1
        ldf     *+ar0(2), r2
        mpyf3   *+ar1(2), r1, r3
        mpyf3   *+ar1(1), r2, r4
        subf    r4, r3
        mpyf3   *ar1, r2, r4
        mpyf3   *+ar1(2), r0, r5
        subf    r5, r4
        mpyf3   *+ar1(1), r0, r5
        mpyf3   *ar1, r1, r2
        subf    r2, r5
        rets

; R6, R7, R8 <- wd x r + w x (w x r): AR2 = link whose motion it is, AR1 = r. Clobbers R0 .. R5, AR0.
newton_euler_swing:
        ldi     ar2, ar0
        addi    NE_WD, ar0
        call    newton_euler_cross
        ldf     r3, r6
        ldf     r4, r7
        ldf     r5, r8
        ldi     ar2, ar0
        call    newton_euler_cross
        ldhi    hi16(NE_HELP), ar1
        or      lo16(NE_HELP), ar1
        stf     r3, *ar1
        stf     r4, *+ar1(1)
        stf     r5, *+ar1(2)
        call    newton_euler_cross
        addf    r3, r6
        addf    r4, r7
        addf    r5, r8
        rets

; *AR1 <- *AR0 in link AR5's frame, which is turned by its angle about k. Clobbers R0 .. R3.
newton_euler_turn:
        ldi     *+ar4(NE_K), ir0
        ldf     *+ar0(ir0), r0
        stf     r0, *+ar1(ir0)
        ldi     *+ar4(NE_B), ir0
        ldi     *+ar4(NE_C), ir1
        ldf     *+ar0(ir0), r0
        ldf     *+ar0(ir1), r1
        mpyf3   *+ar5(NE_COS), r0, r2
        mpyf3   *+ar5(NE_SIN), r1, r3
        addf    r3, r2
        rnd     r2, r2
        stf     r2, *+ar1(ir0)
        mpyf    *+ar5(NE_COS), r1
        mpyf    *+ar5(NE_SIN), r0
        subf    r0, r1
        rnd     r1, r1
        stf     r1, *+ar1(ir1)
        rets

; The same back: R0, R1, R2 by place b, c, k <- *AR0 seen from the frame before. Clobbers R3.
newton_euler_unturn:
        ldi     *+ar4(NE_B), ir0
        ldi     *+ar4(NE_C), ir1
        ldf     *+ar0(ir0), r0
        ldf     *+ar0(ir1), r1
        mpyf3   *+ar5(NE_SIN), r1, r2
        mpyf3   *+ar5(NE_SIN), r0, r3
        mpyf    *+ar5(NE_COS), r0
        subf    r2, r0
        mpyf    *+ar5(NE_COS), r1
        addf    r3, r1
        ldi     *+ar4(NE_K), ir0
        ldf     *+ar0(ir0), r2
        rets

; W, WD, A of link AR5 from those of AR3.
newton_euler_motion:
        ldf     0.0, r6
        ldf     0.0, r7
        ldf     0.0, r8
        ldi     *+ar4(NE_HAS), r0
        tstb    NE_HAS_ARM, r0
        bz      newton_euler_no_arm
        ldi     ar3, ar2
        ldi     ar5, ar1
        addi    NE_ARM, ar1
        call    newton_euler_swing
newton_euler_no_arm:
        ldhi    hi16(NE_HELP), ar0
        or      lo16(NE_HELP), ar0
        addf    *+ar3(NE_A), r6
        rnd     r6, r6
        stf     r6, *ar0
        addf    *+ar3(NE_A + 1), r7
        rnd     r7, r7
        stf     r7, *+ar0(1)
        addf    *+ar3(NE_A + 2), r8
        rnd     r8, r8
        stf     r8, *+ar0(2)
        ldi     ar5, ar1
        addi    NE_A, ar1
        call    newton_euler_turn
        ldi     ar3, ar0
        addi    NE_WD, ar0
        ldi     ar5, ar1
        addi    NE_WD, ar1
        call    newton_euler_turn
        ldi     ar3, ar0
        ldi     ar5, ar1
        call    newton_euler_turn

        ldf     *+ar5(NE_RATE), r0
        ldi     ar5, ar0                        ; the vector on which qd, qdd act: WD, or A with twice the rate
        ldi     *+ar4(NE_SLIDES), r2
        bz      newton_euler_turning
        mpyf    2.0, r0
        addi    NE_A - NE_WD, ar0
newton_euler_turning:
        addi    NE_WD, ar0
        ldi     *+ar4(NE_B), ir0
        ldi     *+ar4(NE_C), ir1
        mpyf3   *+ar5(ir1), r0, r1              ; (w x qd e_k)_b = w_c qd, (..)_c = -w_b qd
        addf    *+ar0(ir0), r1
        rnd     r1, r1
        stf     r1, *+ar0(ir0)
        mpyf3   *+ar5(ir0), r0, r1
        subrf   *+ar0(ir1), r1
        rnd     r1, r1
        stf     r1, *+ar0(ir1)
        ldi     *+ar4(NE_K), ir0
        ldf     *+ar5(NE_ACCELERATION), r1
        addf    *+ar0(ir0), r1
        rnd     r1, r1
        stf     r1, *+ar0(ir0)
        cmpi    0, r2
        retsne
        ldf     *+ar5(NE_RATE), r1
        addf    *+ar5(ir0), r1
        rnd     r1, r1
        stf     r1, *+ar5(ir0)
        rets

; F, N of link AR5: its own inertia.
newton_euler_force:
        ldf     0.0, r6
        ldf     0.0, r7
        ldf     0.0, r8
        ldi     *+ar4(NE_HAS), r0
        tstb    NE_HAS_CENTRE, r0
        bz      newton_euler_no_centre
        ldi     ar5, ar2
        ldi     ar4, ar1
        addi    NE_S, ar1
        call    newton_euler_swing
newton_euler_no_centre:
        addf    *+ar5(NE_A), r6
        mpyf    *+ar4(NE_MASS), r6
        rnd     r6, r6
        stf     r6, *+ar5(NE_F)
        addf    *+ar5(NE_A + 1), r7
        mpyf    *+ar4(NE_MASS), r7
        rnd     r7, r7
        stf     r7, *+ar5(NE_F + 1)
        addf    *+ar5(NE_A + 2), r8
        mpyf    *+ar4(NE_MASS), r8
        rnd     r8, r8
        stf     r8, *+ar5(NE_F + 2)
        ldf     0.0, r6
        ldf     0.0, r7
        ldf     0.0, r8
        ldi     *+ar4(NE_HAS), r0
        tstb    NE_HAS_INERTIA, r0
        bz      newton_euler_no_inertia
        ldhi    hi16(NE_HELP), ar1              ; I w
        or      lo16(NE_HELP), ar1
        ldf     *ar5, r0
        mpyf    *+ar4(NE_INERTIA), r0
        stf     r0, *ar1
        ldf     *+ar5(1), r0
        mpyf    *+ar4(NE_INERTIA + 1), r0
        stf     r0, *+ar1(1)
        ldf     *+ar5(2), r0
        mpyf    *+ar4(NE_INERTIA + 2), r0
        stf     r0, *+ar1(2)
        ldi     ar5, ar0
        call    newton_euler_cross
        ldf     *+ar5(NE_WD), r0
        mpyf    *+ar4(NE_INERTIA), r0
        addf3   r0, r3, r6
        ldf     *+ar5(NE_WD + 1), r0
        mpyf    *+ar4(NE_INERTIA + 1), r0
        addf3   r0, r4, r7
        ldf     *+ar5(NE_WD + 2), r0
        mpyf    *+ar4(NE_INERTIA + 2), r0
        addf3   r0, r5, r8
newton_euler_no_inertia:
        ldi     *+ar4(NE_HAS), r0
        tstb    NE_HAS_CENTRE, r0
        bz      newton_euler_moment_of_own
        ldi     ar4, ar0                        ; s x F
        addi    NE_S, ar0
        ldi     ar5, ar1
        addi    NE_F, ar1
        call    newton_euler_cross
        addf    r3, r6
        addf    r4, r7
        addf    r5, r8
newton_euler_moment_of_own:
        rnd     r6, r6
        stf     r6, *+ar5(NE_N)
        rnd     r7, r7
        stf     r7, *+ar5(NE_N + 1)
        rnd     r8, r8
        stf     r8, *+ar5(NE_N + 2)
        rets

; The joint's force of link AR5, and the part that it passes on to AR3 (at the base the part is dropped).
newton_euler_back:
        ldi     *+ar4(NE_K), ir0
        ldi     ar5, ar0
        addi    NE_N, ar0
        ldi     *+ar4(NE_SLIDES), r1
        bz      newton_euler_moment
        subi    NE_N - NE_F, ar0
newton_euler_moment:
        ldf     *+ar0(ir0), r0
        mpyf    *+ar4(NE_SIGN), r0
        ldhi    hi16(TQ_TAU), ar0
        or      lo16(TQ_TAU), ar0
        ldi     *+ar4(NE_JOINT), ir0
        addf    *+ar0(ir0), r0
        rnd     r0, r0
        stf     r0, *+ar0(ir0)

        ldi     ar5, ar0
        addi    NE_F, ar0
        call    newton_euler_unturn
        ldhi    hi16(NE_HELP), ar1
        or      lo16(NE_HELP), ar1
        stf     r2, *+ar1(ir0)
        ldi     *+ar4(NE_B), ir0
        rnd     r0, r0
        stf     r0, *+ar1(ir0)
        rnd     r1, r1
        stf     r1, *+ar1(ir1)
        ldf     *ar1, r6
        addf    *+ar3(NE_F), r6
        rnd     r6, r6
        stf     r6, *+ar3(NE_F)
        ldf     *+ar1(1), r6
        addf    *+ar3(NE_F + 1), r6
        rnd     r6, r6
        stf     r6, *+ar3(NE_F + 1)
        ldf     *+ar1(2), r6
        addf    *+ar3(NE_F + 2), r6
        rnd     r6, r6
        stf     r6, *+ar3(NE_F + 2)
        ldf     0.0, r6
        ldf     0.0, r7
        ldf     0.0, r8
        ldi     *+ar4(NE_HAS), r0
        tstb    NE_HAS_ARM, r0
        bz      newton_euler_no_lever
        ldi     ar5, ar0
        addi    NE_ARM, ar0
        call    newton_euler_cross
        ldf     r3, r6
        ldf     r4, r7
        ldf     r5, r8
newton_euler_no_lever:
        ldi     ar5, ar0
        addi    NE_N, ar0
        call    newton_euler_unturn
        stf     r2, *+ar1(ir0)
        ldi     *+ar4(NE_B), ir0
        rnd     r0, r0
        stf     r0, *+ar1(ir0)
        rnd     r1, r1
        stf     r1, *+ar1(ir1)
        addf    *ar1, r6
        addf    *+ar3(NE_N), r6
        rnd     r6, r6
        stf     r6, *+ar3(NE_N)
        addf    *+ar1(1), r7
        addf    *+ar3(NE_N + 1), r7
        rnd     r7, r7
        stf     r7, *+ar3(NE_N + 1)
        addf    *+ar1(2), r8
        addf    *+ar3(NE_N + 2), r8
        rnd     r8, r8
        stf     r8, *+ar3(NE_N + 2)
        rets
