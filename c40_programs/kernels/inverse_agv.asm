; Sub-process 2 of an AGV: from a point and the measured pose to the drive's set-point (docs/kernels_job.md).
;
; The drive obeys this set-point after those that wait before it. So the measured pose is extrapolated to that instant,
;     t = (waiting + 3/2) period,  turn = k_a v t,  x += v t cos(heading + turn/2),  ...,  heading += turn
; and compared with the point: e across (left positive), e_x along, e_th = heading - heading_ref - k_a v_ref^2 m / (2
; C), whose last term is the angle at which tyres of cornering stiffness C carry the mass m round a bend. With k_a the
; curvature ahead,
;     k = k_a - k_e e - k_th sin e_th,   front = atan(l k / 2) within +-30 degrees,   rear = -front
;     speed = v_ref + k_x e_x
; v_ref is physical: the nominal one times dt/period, since points of equal spacing are held for a period.

IA_POINT            .set SCRATCH                ; as in AG_POINT
IA_PERIOD           .set SCRATCH + 8            ; s
IA_SPEED            .set SCRATCH + 9            ; m/s, v_ref
IA_STATUS           .set SCRATCH + 11
IA_MEASURED_SPEED   .set SCRATCH + 12           ; m/s
IA_ALONG            .set SCRATCH + 13           ; m
IA_LATERAL          .set SCRATCH + 14           ; m
IA_FRONT            .set SCRATCH + 15           ; microradians
IA_COMMAND          .set SCRATCH + 16           ; mm/s
IA_SHIFT            .set SCRATCH + 17           ; m, slope, 1/m of the shift across the lane

kernel_inverse_agv:
        ldhi    hi16(WINDOW_B), ar5
        addi    *+ar6(AG_UNIT), ar5
        ldi     @TASK + TB_ARGUMENT, r6
        addi3   1, r6, r0
        cmpi    *+ar6(AG_PRODUCED), r0          ; a DSP that was given up afterwards has pushed it: do not push again
        bne     inverse_agv_run
        ldi     0, r1
        rets
inverse_agv_run:
        call    inverse_agv_read
        call    inverse_agv_errors
        call    inverse_agv_steer
        call    inverse_agv_speed

        ldi     *+ar6(AG_PERIOD_US), r0
        sti     r0, *+ar5(AGV_PERIOD)
        ldi     @IA_COMMAND, r0
        sti     r0, *+ar5(AGV_SPEED_COMMAND)
        ldi     @IA_FRONT, r0
        sti     r0, *+ar5(AGV_FRONT_COMMAND)
        negi    r0
        sti     r0, *+ar5(AGV_REAR_COMMAND)     ; this write pushes
        ldi     @TASK + TB_ARGUMENT, r0
        addi    1, r0
        sti     r0, *+ar6(AG_PRODUCED)
        ldi     0, r1
        rets

; ---- the point, v_ref; R8, R9 = x, y, R10 = heading, as measured ----
inverse_agv_read:
        and     1, r6
        lsh     3, r6
        addi3   r6, ar6, ar0
        addi    AG_POINT, ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(IA_POINT), ar1
        ldi     6, rc
        call    copy_words
        lsh     -1, r6
        addi3   r6, ar6, ar0
        float   *+ar0(AG_SHIFT), r0
        mpyf    @K_MICRO, r0
        stf     r0, @IA_SHIFT
        float   *+ar0(AG_SHIFT + 1), r0
        mpyf    @K_MICRO, r0
        stf     r0, @IA_SHIFT + 1
        float   *+ar0(AG_SHIFT + 2), r0
        mpyf    @K_MICRO, r0
        stf     r0, @IA_SHIFT + 2
        float   *+ar6(AG_PERIOD_US), r0
        mpyf    @K_MICRO, r0
        stf     r0, @IA_PERIOD
        call    m_reciprocal
        mpyf    *+ar6(AG_STEP_TIME), r0         ; dt / period
        ldf     @IA_POINT + 4, r1
        mpyf    r0, r1
        stf     r1, @IA_SPEED

        float   *+ar5(AGV_X), r8
        mpyf    @K_MILLI, r8
        float   *+ar5(AGV_Y), r9
        mpyf    @K_MILLI, r9
        float   *+ar5(AGV_HEADING), r10
        mpyf    @K_MICRO, r10
        float   *+ar5(AGV_SPEED), r0
        mpyf    @K_MILLI, r0
        stf     r0, @IA_MEASURED_SPEED
        ldi     *+ar5(AGV_STATUS), r0
        sti     r0, @IA_STATUS
        rets

        .if AGV_WAITING != 0Fh
        .error "inverse_agv_errors takes the number of set-points that wait from the lowest 4 bits"
        .endif

; ---- IA_ALONG, IA_LATERAL; R10 = heading carried on ----
inverse_agv_errors:
        ldi     @IA_STATUS, r0
        and     0Fh, r0
        float   r0, r0
        addf    1.5, r0
        mpyf    @IA_PERIOD, r0
        mpyf    @IA_MEASURED_SPEED, r0
        ldf     r0, r7                          ; travel
        ldf     @IA_POINT + 6, r6
        mpyf    r7, r6                          ; turn
        ldf     r6, r0
        mpyf    0.5, r0
        addf    r10, r0
        call    m_sincos
        mpyf    r7, r1
        addf    r1, r8
        mpyf    r7, r0
        addf    r0, r9
        addf    r6, r10
        subf    @IA_POINT, r8                   ; dx = x - x_ref
        subf    @IA_POINT + 1, r9               ; dy
        ldf     @IA_POINT + 2, r0
        call    m_sincos                        ; R0 = s, R1 = c of the reference
        mpyf3   r1, r8, r2
        mpyf3   r0, r9, r3
        addf    r3, r2
        negf    r2
        stf     r2, @IA_ALONG                   ; - (c dx + s dy)
        mpyf3   r1, r9, r2
        mpyf3   r0, r8, r3
        subf    r3, r2
        subf    @IA_SHIFT, r2
        stf     r2, @IA_LATERAL                 ; c dy - s dx, against the shift
        rets

; ---- IA_FRONT ----
inverse_agv_steer:
        ldf     @K_IA_HEADING, r6               ; k_th
        ldf     @IA_SPEED, r0
        cmpf    2.5, r0
        ble     inverse_agv_gains
        call    m_reciprocal
        mpyf    1.25, r0
        ldf     r0, r6
inverse_agv_gains:
        ldf     @K_IA_DRIFT_EMPTY, r0
        ldi     @IA_STATUS, r1
        tstb    AGV_LOADED, r1
        ldfnz   @K_IA_DRIFT_LOADED, r0
        mpyf    @IA_SPEED, r0
        mpyf    @IA_SPEED, r0
        mpyf    @IA_POINT + 6, r0
        subf3   r0, r10, r0                     ; heading - drift
        subf    @IA_POINT + 2, r0
        subf    @IA_SHIFT + 1, r0
        call    m_sincos
        mpyf    r6, r0
        ldf     @IA_LATERAL, r1
        mpyf    @K_IA_LATERAL, r1
        mpyf    r6, r1
        mpyf    r6, r1
        addf    r1, r0
        subrf   @IA_POINT + 6, r0
        addf    @IA_SHIFT + 2, r0               ; k
        mpyf    @K_IA_HALF_BASE, r0
        call    m_atan
        ldf     @K_IA_STEER_LIMIT, r1
        cmpf    r1, r0
        ldfgt   r1, r0
        negf    r1
        cmpf    r1, r0
        ldflt   r1, r0
        mpyf    @K_IA_MEGA, r0
        addf    0.5, r0
        fix     r0, r0                          ; to the nearest
        sti     r0, @IA_FRONT
        rets

; ---- IA_COMMAND ----
inverse_agv_speed:
        ldf     @IA_ALONG, r2
        ldf     @IA_POINT + 5, r0               ; distance left
        bnz     inverse_agv_under_way
        absf    r2, r3
        cmpf    @K_IA_AT_SPOT, r3
        bge     inverse_agv_moving
        ldi     0, r0                           ; at the end of the leg: stand still
        br      inverse_agv_command
inverse_agv_under_way:                          ; stopped by avoidance: stand still here, there is no sensor at the rear
        ldi     0, r0
        ldf     @IA_SPEED, r1
        bz      inverse_agv_command
inverse_agv_moving:
        ldf     @K_IA_ALONG, r0
        mpyf    r2, r0
        addf    @IA_SPEED, r0
        ldf     @K_IA_FASTEST, r1
        cmpf    r1, r0
        ldfgt   r1, r0
        ldf     @K_IA_SLOWEST, r1
        cmpf    r1, r0
        ldflt   r1, r0
        mpyf    @K_IA_KILO, r0
        addf    0.5, r0
        fix     r0, r0
inverse_agv_command:
        sti     r0, @IA_COMMAND
        rets
