; Sub-process 4: one tick of the five joints' servo (plant-and-bus.md 2.1; docs/kernels.md for the design).
;   e = r - y      D <- T_d / (T_d + N h) (D + K N (e - e_old))      v = K e + I + D + tau_ff      u = clamp(v, +-u_max)
;   I <- I + K h / T_i e + h / T_t (u - v)
; r: cubic between the joint points of the ring, plus the hoist ramp, plus what damps the sway: the suspension moves towards the
; side to which the load hangs off its reference, x' = k theta - leak x, turned into luff and slew by 1/(L sin phi) and 1/r.
;
; Stages: 0 take the pose at the start from the encoders as joint point -1; 1 wait until torque compensation has spoken;
; 2 enable the drives and servo.

PD_STATE        .set SCRATCH + 56       ; the area's words from CR_PID on:
PD_CONSUMED     .set PD_STATE + 0
PD_SEGMENT      .set PD_STATE + 1
PD_STAGE        .set PD_STATE + 2
PD_SERVOING     .set 2                  ; the stage in which errors are computed
PD_LAST_TICK    .set PD_STATE + 3       ; refresh of the last run
PD_OUT_TICK     .set PD_STATE + 4       ; refresh at which something was last out of tolerance
PD_WATCH        .set PD_STATE + 7       ; i bits 4..0: joints beyond their following error, bits 12..8: whose encoders do not follow (pid_watch.asm)
PD_SHIFT        .set PD_STATE + 5       ; f x2: suspension's shift against sway: radial, tangential, m
PD_LAST         .set PD_STATE + 8       ; CR_ENCODER_LAST
PD_SWAY         .set PD_STATE + 13      ; f x2: filtered sway off its reference, rad
PD_TOTAL        .set PD_STATE + 16      ; CR_ENCODER_TOTAL
PD_SEEN         .set PD_STATE + 21      ; i the last sample of the sway sensor in use: alpha, beta << 12, its number << 24
PD_SAMPLED      .set PD_STATE + 22      ; i refresh at which that was looked at
PD_SAME         .set PD_STATE + 23      ; i samples for which it has not changed: alpha, beta << 16
PD_I            .set PD_STATE + 24      ; f x5
PD_D            .set PD_STATE + 29      ; f x5
PD_E            .set PD_STATE + 34      ; f x5: the last error
PD_REJOIN       .set PD_STATE + 39      ; i not 0: CR_REJOIN holds
PD_OFFSET       .set PD_STATE + 40      ; i x5: total - 24-bit count
PD_STATE_WORDS  .set 45
PD_Y_OLD        .set PD_STATE + 45      ; f x5: the last measurement (second build only)

PD_COUNTS       .set SCRATCH + 112      ; encoders, alpha, beta, spreader status
PD_ANGLES       .set SCRATCH + 117
PD_STATUS       .set SCRATCH + 119
PD_FEED         .set SCRATCH + 120      ; f x5
PD_SWAY_FROM    .set SCRATCH + 128      ; f x4 each: alpha, beta, d phi/d r, d psi/d t
PD_SWAY_TO      .set SCRATCH + 132
PD_Y            .set SCRATCH + 136      ; f x5
PD_R            .set SCRATCH + 144      ; f x5
PD_CODE         .set SCRATCH + 152      ; i x5
PD_H            .set SCRATCH + 160      ; s since the last run
PD_RAMP         .set SCRATCH + 161      ; 0 none, 1 not ended, 2 ended
PD_RAMP_L       .set SCRATCH + 162
PD_RESULT       .set SCRATCH + 163
PD_MOVING       .set SCRATCH + 164      ; not 0: a joint point of this segment is not at rest, or a ramp runs
PD_OUT          .set SCRATCH + 165      ; not 0: out of tolerance
PD_PHASE        .set SCRATCH + 166
PD_PRODUCED     .set SCRATCH + 167
PD_BUILD        .set SCRATCH + 168      ; 0: kernel_pid, 1: kernel_pid_document
PD_WORDS        .set SCRATCH + 169      ; words of the state, less 1
PD_DRIVES       .set SCRATCH + 170      ; DRIVE_STATUS
PD_STILL        .set SCRATCH + 171      ; bit 4 - j: encoder j shows the same count as at the last run
PD_ERRORS       .set SCRATCH + 173      ; TB_NOTIFY
PD_BACK         .set SCRATCH + 176      ; CR_REJOIN

; The law as plant-and-bus.md 2.1 prints it: the derivative acts on the measurement alone, D <- T_d / (T_d + N h) (D - K N (y - y_old)), and the set-point
; runs straight from joint point to joint point (first-order hold).
kernel_pid_document:
        ldi     1, r0
        ldi     PD_STATE_WORDS + 4, r1
        br      pid_build
kernel_pid:
        ldi     0, r0
        ldi     PD_STATE_WORDS - 1, r1
pid_build:
        sti     r0, @PD_BUILD
        sti     r1, @PD_WORDS
        ldhi    hi16(WINDOW_B), ar0
        addi    ENCODER, ar0
        ldhi    hi16(PD_COUNTS), ar1
        or      lo16(PD_COUNTS), ar1
        ldi     4, rc
        call    copy_words
        ldi     *+ar0(SPREADER_STATUS - ENCODER - 5), r0
        sti     r0, @PD_STATUS
        ldi     *+ar0(DRIVE_STATUS - ENCODER - 5), r0
        sti     r0, @PD_DRIVES
        ldi     0, r0
        sti     r0, @PD_ERRORS
        call    servo_head
        ldi     @SV_SWAY_SENSOR, r0
        mpyi    SWAY2_ALPHA - SWAY_ALPHA, r0
        ldhi    hi16(WINDOW_B), ar0
        addi    SWAY_ALPHA, ar0
        addi    r0, ar0
        ldi     *ar0, r0
        sti     r0, @PD_ANGLES
        ldi     *+ar0(1), r0
        sti     r0, @PD_ANGLES + 1
        call    servo_path
        ldi     ar6, ar2
        addi    CR_PRODUCED, ar2
        ldi     *ar2, r0
        sti     r0, @PD_PRODUCED
        ldi     ar6, ar0
        addi    CR_FEED_FORWARD, ar0
        ldhi    hi16(PD_FEED), ar1
        or      lo16(PD_FEED), ar1
        ldi     4, rc
        call    copy_words
        ldi     ar6, ar0
        addi    CR_PID, ar0
        ldhi    hi16(PD_STATE), ar1
        or      lo16(PD_STATE), ar1
        ldi     @PD_WORDS, rc
        call    copy_words
        call    pid_status
        ldi     @PD_STAGE, r0
        callz   pid_first
        call    pid_encoders
        call    servo_ramp
        sti     r4, @PD_RAMP
        stf     r0, @PD_RAMP_L
        ldi     @PD_STAGE, r0
        cmpi    1, r0
        blt     pid_take_pose
        bgt     pid_servo
        absf    @PD_FEED + 2, r0        ; what holds the jib: thousands of N m once computed (and a word of 0 is 1.0)
        cmpf    2.0, r0
        ble     pid_finish
pid_enable:
        ldhi    hi16(WINDOW_B), ar0
        ldi     1Fh, r0
        sti     r0, *+ar0(DRIVE_ENABLE)
        ldi     PD_SERVOING, r0
        sti     r0, @PD_STAGE

pid_servo:
        ldf     @SV_RATE, r0
        call    m_reciprocal
        ldi     @TASK + TB_TICK, r1
        subi    @PD_LAST_TICK, r1
        cmpi    0, r1
        ldile   @SV_SERVO_TICKS, r1     ; the same tick again
        float   r1, r1
        mpyf    r1, r0
        stf     r0, @PD_H
        call    pid_advance
        call    pid_reference
        call    pid_sway
        ldf     @PD_R + 3, r0
        addf    @PD_RAMP_L, r0
        rnd     r0, r0
        stf     r0, @PD_R + 3
        call    pid_left_alone
        call    pid_joints
        call    pid_watch

        ldhi    hi16(WINDOW_B), ar1     ; five codes, then the spreader
        ldhi    hi16(PD_CODE), ar0
        or      lo16(PD_CODE), ar0
        ldi     4, rc
        call    copy_words
        ldhi    hi16(WINDOW_B), ar1
        ldi     @SV_SPREADER, r0
        sti     r0, *+ar1(SPREADER_COMMAND)

; Settled: at rest and within tolerance for long enough
        ldi     @TASK + TB_TICK, r0
        ldi     @PD_OUT, r1
        or      @PD_MOVING, r1
        beq     pid_within
        sti     r0, @PD_OUT_TICK
pid_within:
        subi    @PD_OUT_TICK, r0
        float   r0, r0
        ldf     @K_PD_SETTLE, r1
        mpyf    @SV_RATE, r1
        cmpf    r1, r0
        blt     pid_finish
        ldi     @PD_RESULT, r0
        ldhi    hi16(PID_SETTLED), r1
        or      r1, r0
        sti     r0, @PD_RESULT

pid_finish:
        ldi     @TASK + TB_TICK, r0
        sti     r0, @PD_LAST_TICK
        ldhi    hi16(PD_STATE), ar0
        or      lo16(PD_STATE), ar0
        ldi     ar6, ar1
        addi    CR_PID, ar1
        ldi     @PD_WORDS, rc
        call    copy_words
        ldi     @PD_CONSUMED, r0
        and     0FFFFh, r0
        or      @PD_RESULT, r0
        ldi     @PD_ERRORS, r1
        rets

; Joint point -1: the measured pose, at rest; the sway's reference 0 and its factors -1/(L sin phi), 1/(a0 + L cos phi).
pid_take_pose:
        ldhi    hi16(PD_Y), ar0
        or      lo16(PD_Y), ar0
        ldhi    hi16(PD_Y_OLD), ar1
        or      lo16(PD_Y_OLD), ar1
        ldi     4, rc
        call    copy_words
        ldhi    hi16(PD_Y), ar0
        or      lo16(PD_Y), ar0
        ldi     ar6, ar1
        addi    CR_RING + 3 * 16, ar1
        ldi     4, rc
        call    copy_words
        ldf     0.0, r0
        ldi     9, rc
        rptb    pid_take_rates
pid_take_rates:
        stf     r0, *ar1++
        ldi     ar6, ar1
        addi    CR_SWAY + 3 * 4, ar1
        stf     r0, *ar1
        stf     r0, *+ar1(1)
        ldf     @PD_Y + 2, r0
        call    m_sincos
        ldf     r1, r8
        mpyf    @K_JIB, r0
        call    m_reciprocal
        negf    r0, r0
        stf     r0, *+ar1(2)
        ldf     r8, r0
        mpyf    @K_JIB, r0
        addf    @K_A0, r0
        call    m_reciprocal
        stf     r0, *+ar1(3)
        ldi     1, r0
        sti     r0, @PD_STAGE
        br      pid_finish

; Start of the state: nothing consumed; total - count is kept, so that the total follows from any count.
pid_first:
        ldi     0, r0
        sti     r0, @PD_CONSUMED
        ldi     @SV_PATH_TICK, r0
        sti     r0, @PD_SEGMENT
        ldi     @TASK + TB_TICK, r0
        sti     r0, @PD_LAST_TICK
        sti     r0, @PD_OUT_TICK
        ldf     0.0, r0
        stf     r0, @PD_SHIFT
        stf     r0, @PD_SHIFT + 1
        stf     r0, @PD_SWAY
        stf     r0, @PD_SWAY + 1
        ldhi    hi16(PD_I), ar0
        or      lo16(PD_I), ar0
        rpts    14
        stf     r0, *ar0++
        ldhi    hi16(PD_TOTAL), ar0
        or      lo16(PD_TOTAL), ar0
        ldi     4, rc
        rptb    pid_first_offset
        ldi     *ar0, r0
        subi    *-ar0(PD_TOTAL - PD_LAST), r0
        sti     r0, *+ar0(PD_OFFSET - PD_TOTAL)
pid_first_offset:
        nop     *ar0++
        rets

; TOTAL, Y from the counts: total += (count + offset - total), the low 24 bits taken as signed. STILL.
pid_encoders:
        ldi     0, r4
        ldhi    hi16(PD_TOTAL), ar0
        or      lo16(PD_TOTAL), ar0
        ldhi    hi16(PD_Y), ar1
        or      lo16(PD_Y), ar1
        ldhi    hi16(K_PD_UNIT), ar2
        or      lo16(K_PD_UNIT), ar2
        ldi     4, rc
        rptb    pid_encoder
        ldi     *+ar0(PD_COUNTS - PD_TOTAL), r0
        addi    *+ar0(PD_OFFSET - PD_TOTAL), r0
        subi    *ar0, r0
        lsh     8, r0
        ash     -8, r0
        cmpi    1, r0                           ; a borrow where it is 0
        rolc    r4
        addi    *ar0, r0
        sti     r0, *ar0++
        float   r0, r0
        mpyf    *ar2++, r0
        rnd     r0, r0
pid_encoder:
        stf     r0, *ar1++
        sti     r4, @PD_STILL
        rets

; RESULT <- the spreader's bits, PID_RAMP_DONE
pid_status:
        ldi     0, r0
        ldi     @PD_STATUS, r1
        ldi     r1, r2
        and     SPREADER_CORNERS, r2
        cmpi    SPREADER_CORNERS, r2
        bne     pid_not_landed
        ldhi    hi16(PID_LANDED), r2
        or      r2, r0
pid_not_landed:
        tstb    SPREADER_LOCKED, r1
        beq     pid_not_locked
        ldhi    hi16(PID_LOCKED), r2
        or      r2, r0
pid_not_locked:
        tstb    SPREADER_OPEN, r1
        beq     pid_not_open
        ldhi    hi16(PID_OPEN), r2
        or      r2, r0
pid_not_open:
        ldi     @SV_RAMP_TICKS, r2
        beq     pid_no_ramp
        ldi     @SV_PATH_TICK, r1
        subi    @SV_RAMP_START, r1
        cmpi    r2, r1
        blt     pid_no_ramp
        ldhi    hi16(PID_RAMP_DONE), r2
        or      r2, r0
pid_no_ramp:
        sti     r0, @PD_RESULT
        rets

; Consume the next joint point when the segment has been run through. R10 <- 1 if one was due and there was none.
pid_advance:
        ldi     0, r10
        ldi     @PD_CONSUMED, r0
        ldi     @SV_PATH_TICK, r1
        cmpi    0, r0
        bne     pid_advance_due
        cmpi    @PD_PRODUCED, r0
        retseq
        sti     r1, @PD_SEGMENT                 ; the first point
        addi    1, r0
        sti     r0, @PD_CONSUMED
        rets
pid_advance_due:
        ldi     @SV_POINT_TICKS, r2
        ldi     r1, r3
        subi    @PD_SEGMENT, r3                 ; refreshes since it began
        cmpi    r2, r3
        retslt
        cmpi    @PD_PRODUCED, r0
        bge     pid_advance_dry
        addi    1, r0
        sti     r0, @PD_CONSUMED
        ldi     r2, r0
        addi    @SV_SERVO_TICKS, r0
        cmpi    r0, r3
        ldige   r3, r2                          ; it had starved: the segment begins now
        addi    @PD_SEGMENT, r2
        sti     r2, @PD_SEGMENT
        rets
pid_advance_dry:
        ldi     1, r10
        rets

; R <- the set-point: cubic with the points' positions and rates. MOVING, PID_STARVED. SWAY_FROM, SWAY_TO, PHASE.
pid_reference:
        ldi     @PD_CONSUMED, r0
        call    servo_slots
        ldi     r0, r8
        ldi     r1, r9
        ldi     r8, ar0
        lsh     4, ar0
        addi    ar6, ar0
        addi    CR_RING, ar0
        ldhi    hi16(SV_FROM), ar1
        or      lo16(SV_FROM), ar1
        ldi     9, rc
        call    copy_words
        ldi     r9, ar0
        lsh     4, ar0
        addi    ar6, ar0
        addi    CR_RING, ar0
        ldhi    hi16(SV_TO), ar1
        or      lo16(SV_TO), ar1
        ldi     9, rc
        call    copy_words
        ldi     r8, ar0
        lsh     2, ar0
        addi    ar6, ar0
        addi    CR_SWAY, ar0
        ldhi    hi16(PD_SWAY_FROM), ar1
        or      lo16(PD_SWAY_FROM), ar1
        ldi     3, rc
        call    copy_words
        ldi     r9, ar0
        lsh     2, ar0
        addi    ar6, ar0
        addi    CR_SWAY, ar0
        ldi     3, rc
        call    copy_words                      ; AR1 has come to PD_SWAY_TO
        ldi     @PD_SEGMENT, r0
        call    servo_phase                     ; f
        stf     r0, @PD_PHASE
        ldf     1.0, r1
        subf    r0, r1                          ; 1 - f
        mpyf3   r1, r1, r2                      ; (1 - f)^2
        mpyf3   r0, r0, r3                      ; f^2
        ldf     r0, r4
        mpyf    2.0, r4
        ldf     3.0, r5
        subf    r4, r5
        mpyf    r3, r5                          ; R5: weight of the latter's position
        addf    1.0, r4
        mpyf    r2, r4                          ; R4: of the former's
        ldf     @SV_POINT_PERIOD, r6
        mpyf    r0, r2
        mpyf    r6, r2                          ; R2: of the former's rate
        mpyf    r1, r3
        mpyf    r6, r3
        negf    r3, r3                          ; R3: of the latter's
        ldi     @PD_BUILD, r7
        bz      pid_reference_weights
        ldf     r1, r4
        ldf     r0, r5
        ldf     0.0, r2
        ldf     0.0, r3
pid_reference_weights:
        ldhi    hi16(SV_FROM), ar0
        or      lo16(SV_FROM), ar0
        ldhi    hi16(PD_R), ar1
        or      lo16(PD_R), ar1
        ldf     0.0, r6                         ; fastest of the latter, of both
        ldf     0.0, r7
        ldi     4, rc
        rptb    pid_reference_joint
        ldf     *ar0, r0
        mpyf    r4, r0
        ldf     *+ar0(SV_TO - SV_FROM), r1
        mpyf    r5, r1
        addf    r1, r0
        ldf     *+ar0(5), r1
        mpyf    r2, r1
        addf    r1, r0
        ldf     *+ar0(SV_TO - SV_FROM + 5), r1
        mpyf    r3, r1
        addf    r1, r0
        rnd     r0, r0
        stf     r0, *ar1++
        absf    *+ar0(SV_TO - SV_FROM + 5), r0
        cmpf    r6, r0
        ldfgt   r0, r6
        absf    *+ar0(5), r0
        cmpf    r7, r0
        ldfgt   r0, r7
pid_reference_joint:
        nop     *ar0++
        ldi     0, r0
        cmpf    @K_PD_REST, r6
        ble     pid_reference_rest
        ldi     1, r0
        cmpi    0, r10
        beq     pid_reference_rest
        ldhi    hi16(PID_STARVED), r1           ; dry in full motion
        or      @PD_RESULT, r1
        sti     r1, @PD_RESULT
pid_reference_rest:
        cmpf    @K_PD_REST, r7
        ldigt   1, r0
        ldi     @PD_RAMP, r1
        cmpi    1, r1
        ldieq   1, r0
        sti     r0, @PD_MOVING
        rets

; Sway: OUT <- out of tolerance; R + 1, R + 2 shifted.
pid_sway:
        ldi     0, r0
        sti     r0, @PD_OUT
        ldhi    hi16(PD_SWAY_FROM), ar0         ; FROM <- interpolated
        or      lo16(PD_SWAY_FROM), ar0
        ldf     @PD_PHASE, r2
        ldi     3, rc
        rptb    pid_sway_between
        ldf     *+ar0(4), r0
        subf    *ar0, r0
        mpyf    r2, r0
        addf    *ar0, r0
pid_sway_between:
        stf     r0, *ar0++
        ldi     @SV_STOPPED, r0
        beq     pid_sway_at_rate
        ldf     @SV_PATH_RATE, r0               ; the reference sway goes with the acceleration: with the square of the path's rate
        mpyf    r0, r0
        ldf     @PD_SWAY_FROM, r1
        mpyf    r0, r1
        stf     r1, @PD_SWAY_FROM
        mpyf    @PD_SWAY_FROM + 1, r0
        stf     r0, @PD_SWAY_FROM + 1
pid_sway_at_rate:
        ldf     @PD_H, r0
        addf    @K_PD_SWAY_FILTER, r0
        call    m_reciprocal
        mpyf    @PD_H, r0
        ldf     r0, r7                          ; h / (T + h)
        ldhi    hi16(PD_ANGLES), ar0
        or      lo16(PD_ANGLES), ar0
        ldhi    hi16(PD_SWAY_FROM), ar1
        or      lo16(PD_SWAY_FROM), ar1
        ldhi    hi16(PD_SHIFT), ar2
        or      lo16(PD_SHIFT), ar2
        ldi     1, rc
        rptb    pid_sway_axis
        ldi     *ar0++, r0
        lsh     20, r0                          ; signed 12 bits
        ash     -20, r0
        float   r0, r0
        mpyf    @K_PD_SWAY_UNIT, r0
        subf    *ar1++, r0
        ldf     @K_PD_SWAY_LIMIT, r1
        cmpf    r1, r0
        ldfgt   r1, r0
        negf    r1, r1
        cmpf    r1, r0
        ldflt   r1, r0
        ldf     *+ar2(PD_SWAY - PD_SHIFT), r1
        subf    r1, r0
        mpyf    r7, r0
        addf    r1, r0
        rnd     r0, r0
        stf     r0, *+ar2(PD_SWAY - PD_SHIFT)
        absf    r0, r1
        ldi     @PD_OUT, r3
        cmpf    @K_PD_SWAY_TOLERANCE, r1
        ldigt   1, r3
        sti     r3, @PD_OUT
        mpyf    @K_PD_SWAY_GAIN, r0
        ldf     *ar2, r1
        mpyf    @K_PD_SWAY_LEAK, r1
        subf    r1, r0
        mpyf    @PD_H, r0
        addf    *ar2, r0
        rnd     r0, r0
pid_sway_axis:
        stf     r0, *ar2++
        ldf     @PD_SHIFT, r0
        mpyf    @PD_SWAY_FROM + 2, r0
        addf    @PD_R + 2, r0
        rnd     r0, r0
        stf     r0, @PD_R + 2
        ldf     @PD_SHIFT + 1, r0
        mpyf    @PD_SWAY_FROM + 3, r0
        addf    @PD_R + 1, r0
        rnd     r0, r0
        stf     r0, @PD_R + 1
        rets

; CODE, and I, D, E of the state; OUT.
pid_joints:
        ldf     @PD_H, r10
        ldf     20.0, r11
        mpyf    r10, r11                        ; N h
        ldhi    hi16(PD_R), ar2
        or      lo16(PD_R), ar2
        ldhi    hi16(K_PD_JOINTS), ar3
        or      lo16(K_PD_JOINTS), ar3
        ldi     4, ar4
pid_joint:
        ldf     *ar2, r8
        subf    *-ar2(PD_R - PD_Y), r8          ; e
        absf    r8, r0
        cmpf    *+ar3(7), r0
        ble     pid_joint_within
        ldi     1, r0
        sti     r0, @PD_OUT
pid_joint_within:
        ldf     *+ar3(2), r0
        addf    r11, r0
        call    m_reciprocal
        mpyf    *+ar3(2), r0                    ; T_d / (T_d + N h)
        ldf     r8, r1
        subf    *-ar2(PD_R - PD_E), r1
        ldi     @PD_BUILD, r2
        bz      pid_joint_change
        ldf     *-ar2(PD_R - PD_Y), r2
        ldf     *-ar2(PD_R - PD_Y_OLD), r1
        subf    r2, r1
        stf     r2, *-ar2(PD_R - PD_Y_OLD)
pid_joint_change:
        mpyf    *+ar3(1), r1
        addf    *-ar2(PD_R - PD_D), r1
        mpyf    r0, r1                          ; D
        stf     r1, *-ar2(PD_R - PD_D)
        stf     r8, *-ar2(PD_R - PD_E)
        ldf     r8, r2
        mpyf    *ar3, r2
        addf    r1, r2
        addf    *-ar2(PD_R - PD_I), r2
        addf    *-ar2(PD_R - PD_FEED), r2       ; v
        ldf     *+ar3(5), r1
        ldf     r2, r3
        cmpf    r1, r3
        ldfgt   r1, r3
        negf    r1, r1
        cmpf    r1, r3
        ldflt   r1, r3                          ; u
        ldf     r8, r0
        mpyf    *+ar3(3), r0
        ldf     r3, r1
        subf    r2, r1
        mpyf    *+ar3(4), r1
        addf    r1, r0
        mpyf    r10, r0
        addf    *-ar2(PD_R - PD_I), r0
        rnd     r0, r0
        stf     r0, *-ar2(PD_R - PD_I)
        mpyf    *+ar3(6), r3
        addf    0.5, r3
        fix     r3, r3
        sti     r3, *+ar2(PD_CODE - PD_R)
        addi    1, ar2
        addi    8, ar3
        dbu     ar4, pid_joint
        rets
