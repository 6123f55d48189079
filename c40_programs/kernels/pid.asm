; Sub-process 4: one tick of the five joints' servo (plant-and-bus.md 2.1; docs/kernels.md for the design).
; pid_set_point.asm: where the joints should be; pid_sway.asm: corrections against sway and wind;
; pid_law.asm: the torques that move them there; pid_watch.asm: errors.
;
; Stages: 0 take the pose at the start from the encoders as joint point -1; 1 wait until torque compensation has spoken;
; 2 enable the drives and servo.

PD_STATE        .set SCRATCH + 56       ; the area's words from CR_PID on:
PD_CONSUMED     .set PD_STATE + 0
PD_SEGMENT      .set PD_STATE + 1
PD_STAGE        .set PD_STATE + 2
PD_SERVOING     .set 2                  ; the first stage in which errors are computed
PD_LAST_TICK    .set PD_STATE + 3       ; refresh of the last run
PD_OUT_TICK     .set PD_STATE + 4       ; refresh at which a joint or the sway was last out of tolerance
PD_WATCH        .set PD_STATE + 7       ; i bits 4..0: joints beyond their following error, bits 12..8: whose encoders
                                        ; do not follow (pid_watch.asm)
PD_BESIDE       .set PD_STATE + 5       ; f x2: the load's offset from its path: radial, tangential, m (pid_sway.asm)
PD_LAST         .set PD_STATE + 8       ; CR_ENCODER_LAST
PD_SWAY         .set PD_STATE + 13      ; f x2: filtered angle of the rope from its reference, rad
PD_LAW          .set PD_STATE + 15      ; i twice the generation of the parameters (CR_CONTROL) of the last tick, plus:
PD_DRY          .set 1                  ; a point was due and missing
PD_TOTAL        .set PD_STATE + 16      ; CR_ENCODER_TOTAL
PD_SEEN         .set PD_STATE + 21      ; i the last sample of the sway sensor in use: alpha, beta << 12, its number <<
                                        ; 24
PD_SAMPLED      .set PD_STATE + 22      ; i refresh of that sample
PD_SAME         .set PD_STATE + 23      ; i number of samples without a change: alpha, beta << 16
PD_PI           .set PD_STATE + 24      ; f x5: proportional and integral part, from which the next tick starts
PD_D            .set PD_STATE + 29      ; f x5
PD_E            .set PD_STATE + 34      ; f x5: the last error
PD_REJOIN       .set PD_STATE + 39      ; i not 0: CR_REJOIN holds
PD_OFFSET       .set PD_STATE + 40      ; i x5: total - 24-bit count
PD_SPEED        .set PD_STATE + 45      ; f x2: the load's speed relative to its path, m/s
PD_WIND         .set PD_STATE + 47      ; f x2: the load's acceleration by the wind, m/s2
PD_STATE_WORDS  .set 49
PD_Y_OLD        .set PD_STATE + 49      ; f x5: the last measurement (second build only)

PD_COSINE       .set SCRATCH + 111      ; f cos phi
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
PD_OUT          .set SCRATCH + 165      ; i bit j: joint j is out of tolerance; and the sway:
PD_OUT_SWAY     .set 20h
PD_PHASE        .set SCRATCH + 166
PD_PRODUCED     .set SCRATCH + 167
PD_BUILD        .set SCRATCH + 168      ; 0: kernel_pid, 1: kernel_pid_document
PD_WORDS        .set SCRATCH + 169      ; words of the state, less 1
PD_DRIVES       .set SCRATCH + 170      ; DRIVE_STATUS
PD_STILL        .set SCRATCH + 171      ; bit 4 - j: encoder j shows the same count as at the last run
PD_ERRORS       .set SCRATCH + 173      ; TB_NOTIFY
PD_BACK         .set SCRATCH + 176      ; CR_REJOIN
PD_SHIFT        .set SCRATCH + 186      ; f x2: the suspension's shift against sway and wind, the other way: radial,
                                        ; tangential, m

; The law as plant-and-bus.md 2.1 prints it: the derivative acts on the measurement alone, and the set-point runs
; straight from joint point to joint point (first-order hold).
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
        addi    r0, ar0
        ldi     *+ar0(SWAY_ALPHA), r0
        sti     r0, @PD_ANGLES
        ldi     *+ar0(SWAY_ALPHA + 1), r0
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
        call    pid_control
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
        absf    @PD_FEED + 2, r0        ; the torque that holds the jib: thousands of N m once computed (and a word of 0
                                        ; is 1.0)
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
        ldile   @SV_SERVO_TICKS, r1     ; this tick runs again
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
        ldi     @PD_OUT, r1                     ; the joints at rest
        xor     1Fh, r1
        and     1Fh, r1
        lsh     PIDE_RESTS, r1
        ldi     @PD_MOVING, r2
        ldinz   0, r1
        or      @PD_ERRORS, r1
        sti     r1, @PD_ERRORS
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
        stf     r0, @PD_BESIDE
        stf     r0, @PD_BESIDE + 1
        stf     r0, @PD_SWAY
        stf     r0, @PD_SWAY + 1
        stf     r0, @PD_SPEED
        stf     r0, @PD_SPEED + 1
        stf     r0, @PD_WIND
        stf     r0, @PD_WIND + 1
        ldhi    hi16(PD_PI), ar0
        or      lo16(PD_PI), ar0
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

        .if DRIVE_COUNT != 5 | ENCODER_BITS != 24
        .error "PID works on five drives whose encoders count 24 bits"
        .endif

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
        and3    SPREADER_CORNERS, r1, r2
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
