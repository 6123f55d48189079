; Sub-process 1 of an AGV: the next point of its leg (docs/kernels_job.md).
;
; A leg is at most 8 lines and arcs. With s the arc length and v the speed at the last point, dt = AG_STEP_TIME:
;     v' = min( v + a dt, limit of the segment at s, sqrt(q) - h/2 ),  h = B dt,  q = h^2/4 - h v + min over what lies
;     ahead of (u^2 + 2 B d) s' = s + (v + v') dt / 2
; where d is the distance to a segment ahead and u its speed limit, or the distance to the leg's end and u = 0: from v'
; the brake B still meets every u. The state is kept at 40 bits and twice, by the parity of k: a block that runs
; again gives the same point. At the end of the leg the point repeats until the vehicle stands there.

TA_SEGMENTS         .set SCRATCH                ; 8 segments of 8 words: x0, y0, heading0, length, curvature, speed
TA_DT               .set SCRATCH + 64           ; s
TA_SLOW             .set SCRATCH + 65           ; physical speed / nominal speed = dt / held period
TA_COUNT            .set SCRATCH + 66           ; segments of the leg
TA_TOTAL            .set SCRATCH + 67           ; m, length of the leg (2 words, 40 bits)
TA_SETTLED          .set SCRATCH + 70           ; points made since the end of the leg was reached, before it 0
TA_POINT            .set SCRATCH + 72           ; the point being made, as in AG_POINT
TA_CHORD            .set SCRATCH + 80
TA_LIMIT            .set SCRATCH + 81           ; i AG_AVOID_LIMIT
TA_SHIFT            .set SCRATCH + 82           ; m, slope, 1/m: as in AG_SHIFT, of the point before, then of this one
TA_WANTED           .set SCRATCH + 85           ; m, AG_AVOID_SHIFT
TA_STATE            .set AG_TRAJECTORY          ; + (k & 1) * 8: s, v (float and mantissa words), settled

TA_SEGMENT_X        .set 0
TA_SEGMENT_Y        .set 1
TA_SEGMENT_HEADING  .set 2
TA_SEGMENT_LENGTH   .set 3
TA_SEGMENT_CURVE    .set 4
TA_SEGMENT_SPEED    .set 5
TA_SETTLE_MOST      .set 250                    ; points after which the leg ends wherever the vehicle is

kernel_trajectory_agv:
        call    trajectory_agv_read
        ldi     @TA_COUNT, r0
        ble     trajectory_agv_empty
        call    trajectory_agv_speed
        call    trajectory_agv_shift
        call    trajectory_agv_place
        call    trajectory_agv_preview
        call    trajectory_agv_write
        call    trajectory_agv_arrived          ; R0 = RESULT_END_OF_LEG or 0
        ldi     MUST_INVERSE, r1
        cmpi    0, r0
        bne     trajectory_agv_return
        or      MUST_TRAJECTORY, r1
trajectory_agv_return:
        rets

trajectory_agv_empty:                               ; a leg without segments ends at once and has no point
        ldi     RESULT_END_OF_LEG, r0
        ldi     0, r1
        rets

; ---- inputs: all of the leg on chip, s in R8, v in R9 (40 bits) ----
trajectory_agv_read:
        ldf     *+ar6(AG_STEP_TIME), r6
        stf     r6, @TA_DT
        float   *+ar6(AG_PERIOD_US), r0
        call    m_reciprocal
        mpyf    @K_TA_MICRO, r0
        mpyf    r6, r0
        stf     r0, @TA_SLOW
        ldi     *+ar6(AG_AVOID_LIMIT), r0
        sti     r0, @TA_LIMIT
        float   *+ar6(AG_AVOID_SHIFT), r0
        mpyf    @K_MILLI, r0
        stf     r0, @TA_WANTED
        ldi     *+ar6(AG_LEG), r6
        call    trajectory_agv_load

        ldf     0.0, r8
        ldf     0.0, r9
        stf     r8, @TA_SHIFT
        stf     r8, @TA_SHIFT + 1
        ldi     0, r0
        sti     r0, @TA_SETTLED
        ldi     @TASK + TB_ARGUMENT, r1
        bz      trajectory_agv_read_done        ; point 0 starts the leg at rest
        subi    1, r1
        and     1, r1
        lsh     2, r1
        addi3   r1, ar6, ar0
        float   *+ar0(AG_SHIFT), r0
        mpyf    @K_MICRO, r0
        stf     r0, @TA_SHIFT
        float   *+ar0(AG_SHIFT + 1), r0
        mpyf    @K_MICRO, r0
        stf     r0, @TA_SHIFT + 1
        addi    r1, ar0
        ldf     *+ar0(TA_STATE), r8
        ldi     *+ar0(TA_STATE + 1), r8
        ldf     *+ar0(TA_STATE + 2), r9
        ldi     *+ar0(TA_STATE + 3), r9
        ldi     *+ar0(TA_STATE + 4), r0
        sti     r0, @TA_SETTLED
trajectory_agv_read_done:
        rets

; ---- leg R6 of the area AR6 to TA_SEGMENTS and TA_COUNT (0 to 8); AR3 = its address ----
trajectory_agv_load:
        addi3   r6, ar6, ar0
        ldi     *+ar0(AG_SEGMENT_COUNT), r1
        ldi     SEGMENTS_MAX, r2
        cmpi    r2, r1
        ldigt   r2, r1
        ldi     0, r2
        cmpi    r2, r1
        ldilt   r2, r1
        sti     r1, @TA_COUNT
        subi    1, r6
        lsh     6, r6
        addi3   r6, ar6, ar3
        addi    AG_SEGMENT, ar3
        cmpi    0, r1
        bz      trajectory_agv_load_done
        lsh     3, r1
        subi    1, r1
        ldi     r1, rc
        ldi     ar3, ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        call    copy_words
trajectory_agv_load_done:
        rets

; ---- v' and s': R8, R9 advance; TA_TOTAL ----
trajectory_agv_speed:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        ldi     @TA_COUNT, ar2
        subi    1, ar2
        ldf     0.0, r10                        ; start of the segment
        ldf     @K_TA_HUGE, r11                 ; min (u^2 + 2 B d)
trajectory_agv_ahead:
        subf3   r8, r10, r0                     ; d = start - s
        bgt     trajectory_agv_further
        ldf     *+ar1(TA_SEGMENT_SPEED), r7     ; the last segment that has begun gives the limit
        br      trajectory_agv_next
trajectory_agv_further:
        mpyf    @K_TA_BRAKE_TWICE, r0
        ldf     *+ar1(TA_SEGMENT_SPEED), r1
        mpyf    r1, r1
        addf    r1, r0
        cmpf    r11, r0
        ldflt   r0, r11
trajectory_agv_next:
        addf    *+ar1(TA_SEGMENT_LENGTH), r10
        addi    8, ar1
        dbu     ar2, trajectory_agv_ahead

        stf     r10, @TA_TOTAL
        sti     r10, @TA_TOTAL + 1
        subf3   r8, r10, r0                     ; the end of the leg: u = 0
        mpyf    @K_TA_BRAKE_TWICE, r0
        cmpf    r11, r0
        ldflt   r0, r11

        ldf     @TA_DT, r6
        mpyf    @K_TA_BRAKE, r6                 ; h
        mpyf3   r6, r6, r0
        mpyf    0.25, r0
        mpyf3   r6, r9, r1
        subf    r1, r0
        addf    r11, r0                         ; q
        call    m_sqrt
        mpyf    0.5, r6
        subf    r6, r0                          ; sqrt(q) - h/2
        ldf     @TA_DT, r1
        mpyf    @K_TA_ACCELERATE, r1
        addf    r9, r1
        cmpf    r0, r1
        ldflt   r1, r0
        cmpf    r0, r7
        ldflt   r7, r0
        ldf     0.0, r1
        cmpf    r1, r0
        ldflt   r1, r0                          ; v'
        ldi     @TA_LIMIT, r1
        callnz  trajectory_agv_limit

        addf3   r9, r0, r1
        mpyf    0.5, r1
        mpyf    @TA_DT, r1
        addf    r1, r8                          ; s'
        ldf     r0, r9

        subf3   r8, r10, r0                     ; what is left
        cmpf    @K_TA_ARRIVED, r0
        bge     trajectory_agv_speed_done
        ldf     r10, r8                         ; arrived: stand still at the end
        ldf     0.0, r9
        ldi     @TA_SETTLED, r0
        addi    1, r0
        sti     r0, @TA_SETTLED
trajectory_agv_speed_done:
        rets

; ---- obstacle avoidance: R0 = v' is cut to the limit, which is physical; 1 m/s^2 is the most that the drive's ramp
; brakes. Clobbers R1, R2, R6 ----
trajectory_agv_limit:
        ldf     r0, r6
        ldf     @TA_SLOW, r0
        call    m_reciprocal
        ldi     @TA_LIMIT, r1
        subi    1, r1
        float   r1, r1
        mpyf    @K_MILLI, r1
        mpyf    r0, r1                          ; nominal limit
        mpyf    r0, r0
        mpyf    @TA_DT, r0
        subf3   r0, r9, r2                      ; v - dt 1 m/s^2 (period / dt)^2
        cmpf    r2, r1
        ldflt   r2, r1
        cmpf    0.0, r1
        ldflt   0.0, r1
        ldf     r6, r0
        cmpf    r1, r0
        ldfgt   r1, r0
        rets

; ---- the shift across the lane follows AG_AVOID_SHIFT as a critically damped system over the way: o'' = w^2 (wanted -
; o) - 2 w o',
; |o''| <= 0.04 1/m, w = 0.3 1/m, above 2.5 m/s slower: 0.75 1/s. The curvature that is written is that of 0.35 s ahead,
; for the wheels' lag ----
trajectory_agv_shift:
        ldf     @TA_SLOW, r0
        mpyf    r9, r0                          ; physical speed
        ldf     r0, r6
        mpyf    @K_TA_SHIFT_LEAD, r6            ; lead, m
        ldf     @K_TA_SHIFT_RATE, r7
        cmpf    2.5, r0
        ble     trajectory_agv_shift_rate
        call    m_reciprocal
        mpyf    0.75, r0
        ldf     r0, r7
trajectory_agv_shift_rate:                      ; R7 = w
        ldf     @TA_SHIFT, r4
        ldf     @TA_SHIFT + 1, r5
        call    trajectory_agv_bend
        mpyf3   r5, r6, r1                      ; ahead: o + o' lead, o' + o'' lead
        addf    r1, r4
        mpyf3   r0, r6, r1
        addf    r1, r5
        ldf     r0, r6
        call    trajectory_agv_bend
        stf     r0, @TA_SHIFT + 2
        mpyf3   r9, r6, r1                      ; times the way v dt
        mpyf    @TA_DT, r1
        addf    @TA_SHIFT + 1, r1
        stf     r1, @TA_SHIFT + 1
        mpyf    r9, r1
        mpyf    @TA_DT, r1
        addf    @TA_SHIFT, r1
        stf     r1, @TA_SHIFT
        rets

; R0 <- o'' at o = R4, o' = R5. Clobbers R1.
trajectory_agv_bend:
        ldf     @TA_WANTED, r0
        subf    r4, r0
        mpyf    r7, r0
        subf    r5, r0
        subf    r5, r0
        mpyf    r7, r0
        ldf     @K_TA_SHIFT_MOST, r1
        cmpf    r1, r0
        ldfgt   r1, r0
        negf    r1, r1
        cmpf    r1, r0
        ldflt   r1, r0
        rets

; ---- the segment of s' and the pose on it ----
trajectory_agv_place:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        ldi     @TA_COUNT, ar2
        ldf     0.0, r10
trajectory_agv_find:
        subi    1, ar2
        cmpi    0, ar2
        bz      trajectory_agv_found            ; the last segment takes the rest
        addf3   *+ar1(TA_SEGMENT_LENGTH), r10, r0
        cmpf    r0, r8
        ble     trajectory_agv_found
        ldf     r0, r10
        addi    8, ar1
        br      trajectory_agv_find
trajectory_agv_found:
        subf3   r10, r8, r6
        call    trajectory_agv_pose
        rnd     r0
        stf     r0, @TA_POINT
        rnd     r1
        stf     r1, @TA_POINT + 1
        rnd     r6
        stf     r6, @TA_POINT + 2
        ldf     *+ar1(TA_SEGMENT_CURVE), r0
        stf     r0, @TA_POINT + 3
        rnd     r9, r0
        stf     r0, @TA_POINT + 4
        ldf     @TA_TOTAL, r0
        ldi     @TA_TOTAL + 1, r0
        subf    r8, r0
        rnd     r0
        stf     r0, @TA_POINT + 5
        rets

; ---- pose at R6 = sigma along the segment *AR1 (on chip): R0 = x, R1 = y, R6 = heading in -pi..pi ----
; chord = sigma sinc(u), u = curvature sigma / 2, along the direction heading0 + u; the same for a line, where u = 0.
; |u| <= pi. Changes R2..R7, AR0.
trajectory_agv_pose:
        mpyf3   *+ar1(TA_SEGMENT_CURVE), r6, r7
        mpyf    0.5, r7                         ; u
        mpyf3   r7, r7, r1
        ldf     @K_TA_SINC7, r0
        mpyf    r1, r0
        addf    @K_TA_SINC6, r0
        mpyf    r1, r0
        addf    @K_TA_SINC5, r0
        mpyf    r1, r0
        addf    @K_TA_SINC4, r0
        mpyf    r1, r0
        addf    @K_TA_SINC3, r0
        mpyf    r1, r0
        addf    @K_TA_SINC2, r0
        mpyf    r1, r0
        addf    @K_TA_SINC1, r0
        mpyf    r1, r0
        addf    1.0, r0
        mpyf    r6, r0
        ldf     r0, r6                          ; chord
        addf3   *+ar1(TA_SEGMENT_HEADING), r7, r0
        call    m_sincos                        ; R0 = sin, R1 = cos
        mpyf    r6, r1
        mpyf    r6, r0
        addf3   *+ar1(TA_SEGMENT_X), r1, r6
        stf     r6, @TA_CHORD
        addf3   *+ar1(TA_SEGMENT_Y), r0, r6
        addf3   *+ar1(TA_SEGMENT_HEADING), r7, r0
        addf    r7, r0
        call    m_wrap
        ldf     r6, r1
        ldf     r0, r6
        ldf     @TA_CHORD, r0
        rets

; ---- mean curvature of the leg from s' + SWEEP_FROM v to s' + SWEEP_TO v, v the physical speed: the command for
; the wheels now ----
trajectory_agv_preview:
        ldf     @TA_SLOW, r0
        mpyf    r9, r0                          ; physical speed
        ldf     @K_TA_SWEEP_FROM, r6
        mpyf    r0, r6
        addf    r8, r6
        subf    @K_TA_SWEEP_LEAST, r6           ; low
        ldf     @K_TA_SWEEP_TO, r7
        mpyf    r0, r7
        addf    r8, r7
        addf    @K_TA_SWEEP_LEAST, r7           ; high
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        ldi     @TA_COUNT, ar2
        subi    1, ar2
        ldf     0.0, r10                        ; start of the segment
        ldf     0.0, r4                         ; turn, rad
        ldf     0.0, r0                         ; length of leg in the window, m
trajectory_agv_window:
        addf3   *+ar1(TA_SEGMENT_LENGTH), r10, r5
        ldf     r5, r1
        cmpf    r7, r1
        ldfgt   r7, r1                          ; min(end, high)
        cmpf    r6, r10
        ldflt   r6, r10                         ; max(start, low)
        subf    r10, r1
        ble     trajectory_agv_outside
        addf    r1, r0
        mpyf    *+ar1(TA_SEGMENT_CURVE), r1
        addf    r1, r4
trajectory_agv_outside:
        ldf     r5, r10
        addi    8, ar1
        dbu     ar2, trajectory_agv_window
        cmpf    0.0, r0
        bz      trajectory_agv_straight         ; a leg of no length
        call    m_reciprocal
        mpyf    r4, r0
trajectory_agv_straight:
        rnd     r0
        stf     r0, @TA_POINT + 6
        rets

; ---- the point, then the state, both by the parity of k ----
trajectory_agv_write:
        ldi     @TASK + TB_ARGUMENT, r6
        and     1, r6
        lsh     3, r6
        ldhi    hi16(SCRATCH), ar0
        or      lo16(TA_POINT), ar0
        addi3   r6, ar6, ar1
        addi    AG_POINT, ar1
        ldi     6, rc
        call    copy_words
        addi3   r6, ar6, ar0
        stf     r8, *+ar0(TA_STATE)
        sti     r8, *+ar0(TA_STATE + 1)
        stf     r9, *+ar0(TA_STATE + 2)
        sti     r9, *+ar0(TA_STATE + 3)
        ldi     @TA_SETTLED, r0
        sti     r0, *+ar0(TA_STATE + 4)
        lsh     -1, r6
        subi    r6, ar0                         ; 4 words apart, where the state has 8
        ldf     @TA_SHIFT, r0
        call    trajectory_agv_millionths
        sti     r0, *+ar0(AG_SHIFT)
        ldf     @TA_SHIFT + 1, r0
        call    trajectory_agv_millionths
        sti     r0, *+ar0(AG_SHIFT + 1)
        ldf     @TA_SHIFT + 2, r0
        call    trajectory_agv_millionths
        sti     r0, *+ar0(AG_SHIFT + 2)
        rets
trajectory_agv_millionths:
        mpyf    @K_IA_MEGA, r0
        addf    0.5, r0
        fix     r0, r0
        rets

; ---- R0 = RESULT_END_OF_LEG when the vehicle stands at the end of the leg, or enough time has passed ----
trajectory_agv_arrived:
        ldi     0, r0
        ldi     @TA_SETTLED, r1
        bz      trajectory_agv_arrived_done
        cmpi    TA_SETTLE_MOST, r1
        bge     trajectory_agv_end
        ldhi    hi16(WINDOW_B), ar3
        addi    *+ar6(AG_UNIT), ar3
        ldi     *+ar3(AGV_STATUS), r1
        tstb    AGV_STANDING, r1
        bz      trajectory_agv_arrived_done
        float   *+ar3(AGV_X), r6
        float   *+ar3(AGV_Y), r7
        mpyf    @K_MILLI, r6
        mpyf    @K_MILLI, r7
        subrf   @TA_POINT, r6                   ; x of the end - x
        subrf   @TA_POINT + 1, r7
        ldf     @TA_POINT + 2, r0
        call    m_sincos
        mpyf    r7, r0
        mpyf    r6, r1
        addf3   r0, r1, r2                      ; along the leg
        absf    r2
        ldi     0, r0
        cmpf    @K_TA_AT_SPOT, r2
        bge     trajectory_agv_arrived_done
trajectory_agv_end:
        ldi     RESULT_END_OF_LEG, r0
trajectory_agv_arrived_done:
        rets
