; The crane's sub-processes for a ship-to-shore gantry (dock.crane = "gantry"; docs/kernels.md). The configuration puts
; these entries into the executive's table, gantry_constants into the image. Channels: 0 spare, 1 travel, 2 trolley,
; 3 hoist, 4 rotator. Travel moves the load like the slew, trolley like the luff: most programs are shared.

; Sub-process 1: that of the slewing crane. Before a leg's bank is written, segments that the travel cannot follow are
; lengthened; with the shaper that takes the place of its look-ahead.
kernel_trajectory_gantry_shaper:
        ldi     2, r0
        br      trajectory_crane_build
kernel_trajectory_gantry:
        ldi     -1, r0
        br      trajectory_crane_build
trajectory_gantry_ahead:
        ldi     @TJ_SEGMENTS, r0
        ble     trajectory_gantry_total
        subi3   1, r0, ar2
        ldhi    hi16(gantry_travel), ar1
        or      lo16(gantry_travel), ar1
        ldi     @TJ_SHAPED, r0
        ble     trajectory_gantry_limits
        addi    2, ar1
trajectory_gantry_limits:
        ldhi    hi16(TJ_CHAIN), ar3
        or      lo16(TJ_CHAIN), ar3
        ldhi    hi16(TJ_DURATION), ar4
        or      lo16(TJ_DURATION), ar4
trajectory_gantry_segment:
        ldf     *+ar3(4), r0
        subf    *ar3, r0
        absf    r0, r0                          ; h along the quay
        mpyf3   *ar1, r0, r4
        mpyf    @TJ_SPEED + 3, r4               ; T by speed
        mpyf    *+ar1(1), r0
        call    m_sqrt                          ; by acceleration
        cmpf    r4, r0
        ldflt   r4, r0
        mpyf    *+ar6(CR_STRETCH), r0
        rnd     r0, r0
        cmpf    *ar4, r0
        ldflt   *ar4, r0
        stf     r0, *ar4++
        addi    4, ar3
        dbu     ar2, trajectory_gantry_segment
        call    trajectory_crane_starts
trajectory_gantry_total:
        ldi     @TJ_SHAPED, r0
        retslt
        br      shaper_total

; Sub-process 2: travel = x, trolley = y, l = h_p - z, kappa = yaw - 90 degrees, each within its limits. The payload's
; reference sway is alpha = -p_y''/g, beta = p_x''/g. A load shift towards the water moves the trolley by as much, one
; along -x moves the travel back.
kernel_inverse_gantry:
        ldi     @TASK + TB_ARGUMENT, ar0
        and     1, ar0
        lsh     4, ar0
        addi    ar6, ar0
        addi    CR_POINT, ar0
        ldhi    hi16(IK_X), ar1
        or      lo16(IK_X), ar1
        ldi     13, rc
        call    copy_words
        ldhi    hi16(IK_X), ar0
        or      lo16(IK_X), ar0
        ldhi    hi16(IK_Q), ar1
        or      lo16(IK_Q), ar1
        ldi     2, rc                           ; q, qd, qdd: 0, x, y, -z, yaw
        rptb    inverse_gantry_joints
        ldf     0.0, r0
        stf     r0, *ar1++
        ldf     *ar0++, r0
        stf     r0, *ar1++
        ldf     *ar0++, r0
        stf     r0, *ar1++
        negf    *ar0++, r0
        stf     r0, *ar1++
        ldf     *ar0++, r0
inverse_gantry_joints:
        stf     r0, *ar1++
        ldf     @IK_Q + 3, r0
        addf    @K_PIVOT, r0
        rnd     r0, r0
        stf     r0, @IK_Q + 3
        ldf     @IK_YAW, r0
        subf    @K_HALF_PI, r0
        subf    @K_HALF_PI_LOW, r0
        call    m_wrap
        rnd     r0, r0
        stf     r0, @IK_Q + 4

        ldhi    hi16(gantry_limits), ar0
        or      lo16(gantry_limits), ar0
        ldhi    hi16(IK_Q + 1), ar1
        or      lo16(IK_Q + 1), ar1
        ldhi    hi16(RESULT_UNREACHABLE), r2
        ldi     0, r3
        ldi     2, rc
        rptb    inverse_gantry_limit
        ldf     *ar1, r0
        ldf     *ar0++, r1                      ; the lower one
        cmpf    r0, r1
        ldflt   r0, r1
        cmpf    *ar0, r1
        ldfgt   *ar0, r1
        nop     *ar0++
        cmpf    r0, r1
        ldine   r2, r3
inverse_gantry_limit:
        stf     r1, *ar1++
        sti     r3, @IK_UNREACHABLE

        ldf     @IK_PY, r0
        mpyf    @K_ONE_OVER_G, r0
        negf    r0, r0
        stf     r0, @IK_SWAY                    ; alpha
        ldf     @IK_PX, r0
        mpyf    @K_ONE_OVER_G, r0
        stf     r0, @IK_SWAY + 1                ; beta
        ldf     1.0, r0
        stf     r0, @IK_SWAY + 2
        negf    r0, r0
        stf     r0, @IK_SWAY + 3
        br      inverse_crane_write

; Sub-process 3: the load hangs plumb, so every axis moves its own mass: travel (m_g + m_t + m_p) sdd, trolley (m_t +
; m_p) ydd, hoist m_p (ldd - g), rotator I_k kappadd. Newton-Euler (torque_newton_euler.asm) does the same by its table
; of links, which gantry_constants replaces.
kernel_torque_gantry:
        call    torque_set_point
        ldi     @TQ_STAGE, r0
        beq     torque_nothing
        ldhi    hi16(gantry_masses), ar0
        or      lo16(gantry_masses), ar0
        ldf     @SV_LOAD, r2                    ; m_p
        ldf     0.0, r0
        stf     r0, @TQ_TAU
        ldf     *ar0, r0
        addf    r2, r0
        mpyf    @TQ_QDD + 1, r0
        stf     r0, @TQ_TAU + 1
        ldf     *+ar0(1), r0
        addf    r2, r0
        mpyf    @TQ_QDD + 2, r0
        stf     r0, @TQ_TAU + 2
        ldf     @TQ_QDD + 3, r0
        subf    @K_GRAVITY, r0
        mpyf    r2, r0
        stf     r0, @TQ_TAU + 3
        call    torque_yaw_inertia
        mpyf    @TQ_QDD + 4, r0
        stf     r0, @TQ_TAU + 4
        br      torque_motors

; Sub-process 4: the slewing crane's program once the drives are on. Before that, it corrects the sway damping
; factors that are stored with the starting pose: they are those of a jib. It enables the drives when the hoist's feed-forward holds the load: no jib.
kernel_pid_gantry_document:
        call    kernel_pid_document
        br      pid_gantry_start
kernel_pid_gantry:
        call    kernel_pid
pid_gantry_start:
        ldi     @PD_STAGE, r2
        cmpi    1, r2
        retsne
        ldi     ar6, ar1
        addi    CR_SWAY + 3 * 4 + 2, ar1
        ldf     1.0, r2
        stf     r2, *ar1
        negf    r2, r2
        stf     r2, *+ar1(1)
        absf    @PD_FEED + 3, r2
        cmpf    2.0, r2
        retsle
        br      pid_enable
