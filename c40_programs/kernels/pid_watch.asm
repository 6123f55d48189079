; PID's part of the errors (docs/controller.md, Errors): which joints it leaves alone, how they come back to their path,
; what is wrong.

        .if DRIVE_LATE != DRIVE_FAULT + 8 | TRIP_OVERSPEED != 0 | TRIP_SATURATION != 8 | TRIP_HEAT != 16
        .error "PID takes the drives' bits from octets one above the other"
        .endif
        .if SWAY_BITS != 12
        .error "PID packs codes of the sway sensors in 12 bits"
        .endif

; Drives' errors go to ERRORS. CR_REJOIN is added to the set-point of a joint whose drive is or was failed, late or off
; (R9). While off: the set-point's error, so nothing pulls at a closed brake. When on: decays to 0, damped by K_PD_BACK.
; The last tick may be long ago: from here on PD_H is at most K_PD_LONGEST.
pid_left_alone:
        ldi     @PD_DRIVES, r0
        lsh     -DRIVE_FAULT, r0
        and     1F1Fh, r0                       ; faults, and above them time-outs
        ldi     r0, r1
        or      @SV_STOPPED, r1
        or      @PD_REJOIN, r1
        retseq
        and3    1Fh, r0, r1
        lsh     DRIVE_FAULT - DRIVE_LATE, r0
        or3     r0, r1, r9
        ldi     @SV_STOPPED, r2
        bz      pid_alone_drives
        ldi     @SV_DRIVES, r2
        ldhi    hi16(WINDOW_B), ar0
        sti     r2, *+ar0(DRIVE_ENABLE)
        and     r2, r0                          ; of those that are off the host knows
        and     r2, r1
        xor     1Fh, r2
        or      r2, r9
pid_alone_drives:
        ldi     0, r3                           ; why those have tripped
        cmpi    0, r1
        beq     pid_alone_no_trip
        ldhi    hi16(WINDOW_B), ar0
        ldi     *+ar0(DRIVE_TRIP), r2
        ldhi    hi16(1 << PIDE_TRIP), r5
        ldi     2, rc
        rptb    pid_alone_trip
        ldi     0, r4
        tstb    r1, r2
        ldinz   r5, r4
        or      r4, r3
        lsh     1, r5
pid_alone_trip:
        lsh     -8, r2
pid_alone_no_trip:
        lsh     PIDE_LATE, r0
        lsh     PIDE_FAULT, r1
        or      r1, r0
        or      r3, r0
        sti     r0, @PD_ERRORS
        ldi     r9, r0
        or      @PD_REJOIN, r0
        retseq

        ldi     ar6, ar0
        addi    CR_REJOIN, ar0
        ldhi    hi16(PD_BACK), ar1
        or      lo16(PD_BACK), ar1
        ldi     9, rc
        call    copy_words
        subi    10, ar1
        ldf     @K_PC_STEP, r0                  ; time in which PID did not control is no sample of its law
        stf     r0, @PD_H
        ldi     @PD_REJOIN, r0
        bnz     pid_alone_joints
        ldf     0.0, r0
        ldi     ar1, ar2
        rpts    9
        stf     r0, *ar2++
pid_alone_joints:
        ldhi    hi16(PD_R), ar2
        or      lo16(PD_R), ar2
        ldi     1, r5
        ldi     r9, r7                          ; not 0: it is not over
        ldi     4, ar4
pid_alone_joint:
        tstb    r5, r9
        beq     pid_alone_back
        ldf     *-ar2(PD_R - PD_Y), r0
        subf    *ar2, r0
        rnd     r0, r0
        ldf     0.0, r1
        stf     r1, *-ar2(PD_R - PD_PI)
        stf     r1, *-ar2(PD_R - PD_D)
        stf     r1, *-ar2(PD_R - PD_E)
        br      pid_alone_add
pid_alone_back:
        ldf     *ar1, r0
        ldf     *+ar1(5), r1
        ldf     @K_PD_BACK, r2                  ; w
        mpyf3   r2, r0, r3
        addf    r1, r3
        addf    r1, r3
        mpyf    r2, r3                          ; w (w d + 2 d')
        mpyf    @PD_H, r3
        subf    r3, r1
        rnd     r1, r1
        ldf     @PD_H, r3
        mpyf    r1, r3
        addf    r3, r0
        rnd     r0, r0
pid_alone_add:
        stf     r1, *+ar1(5)
        stf     r0, *ar1++
        absf    r0, r2
        cmpf    @K_PD_BACK_ENDS, r2
        ldigt   1, r7
        addf    *ar2, r0
        rnd     r0, r0
        stf     r0, *ar2++
        lsh     1, r5
        dbu     ar4, pid_alone_joint
        sti     r7, @PD_REJOIN
        or      @PD_MOVING, r7
        sti     r7, @PD_MOVING
        ldhi    hi16(PD_BACK), ar0
        or      lo16(PD_BACK), ar0
        ldi     ar6, ar1
        addi    CR_REJOIN, ar1
        ldi     9, rc
        br      copy_words

; PID's own checks set bits of ERRORS. In ordinary motion they cost little: no error is beyond its limit, WATCH is 0,
; an encoder that has moved does not stick, and the sway sensor has a new sample at each tenth run.
pid_watch:
        ldhi    hi16(PD_E), ar0
        or      lo16(PD_E), ar0
        ldhi    hi16(K_PD_FOLLOW), ar1
        or      lo16(K_PD_FOLLOW), ar1
        ldi     0, r3
        ldi     4, rc
        rptb    pid_watch_beyond
        absf    *ar0++, r0
        subrf   *ar1++, r0
pid_watch_beyond:
        or      r0, r3                          ; the sign of the mantissa: some joint is beyond its limit
        ldi     0, r2                           ; R2: joints that are
        cmpi    0, r3
        bge     pid_watch_encoders
        subi    5, ar0
        subi    5, ar1
        ldi     1, r5
        ldi     4, rc
        rptb    pid_watch_following
        ldi     0, r1
        absf    *ar0++, r0
        cmpf    *ar1++, r0
        ldigt   r5, r1
        or      r1, r2
pid_watch_following:
        lsh     1, r5
pid_watch_encoders:
        ldi     @PD_STILL, r0
        beq     pid_watch_since
        ldhi    hi16(WINDOW_B), ar0             ; those whose encoders stand still: do their drives turn?
        addi    DRIVE_SPEED, ar0
        ldhi    hi16(pid_watch_first), ar1
        or      lo16(pid_watch_first), ar1
pid_watch_still:
        ldi     r0, ir0
        ldi     *+ar1(ir0), ir1
        absi    *+ar0(ir1), r1
        cmpi    @K_PD_TURNS, r1
        bgt     pid_watch_turns
pid_watch_next:
        subi3   1, r0, r1
        and     r1, r0
        bnz     pid_watch_still

pid_watch_since:
        ldi     @PD_WATCH, r3
        or3     r2, r3, r0
        beq     pid_watch_sway
        sti     r2, @PD_WATCH
        ldi     0, r7
        ldi     ar6, ar0
        addi    CR_WATCH, ar0
        ldi     1, r5
        ldi     @K_PD_FOLLOW_TICKS, r6
        call    pid_watch_five
        ldi     100h, r5
        ldi     @K_PD_ENCODER_TICKS, r6
        call    pid_watch_five
        ldi     r7, r0
        and     1Fh, r0
        lsh     PIDE_FOLLOWING, r0
        lsh     -8, r7
        lsh     PIDE_ENCODER, r7
        or      r7, r0
        or      @PD_ERRORS, r0
        sti     r0, @PD_ERRORS

; The sway sensor in use sticks if so many samples have the same code; codes at the ends of its range do not count.
pid_watch_sway:
        ldi     @TASK + TB_TICK, r2
        subi    @PD_SAMPLED, r2
        cmpi    @K_PD_SAMPLE, r2
        retslt
        addi    @PD_SAMPLED, r2
        sti     r2, @PD_SAMPLED
        ldi     @PD_ANGLES + 1, r0
        and     0FFFh, r0
        lsh     12, r0
        ldi     @PD_ANGLES, r1
        and     0FFFh, r1
        or      r1, r0
        ldi     @SV_SWAY_SENSOR, r1
        lsh     24, r1
        or      r1, r0
        ldi     @PD_SEEN, r3
        sti     r0, @PD_SEEN
        xor     r0, r3                          ; the bits that have changed
        lsh3    -24, r3, r1
        ldinz   -1, r3                          ; another sensor
        ldi     @PD_SAME, r2
        ldi     0, r6
        ldi     1, rc
        rptb    pid_watch_axis                  ; the second time the halves of R2 and R6 have changed places
        ldi     r2, r4
        and     0FFFFh, r4
        addi    1, r4
        tstb    0FFFh, r3
        ldinz   0, r4
        ldi     r0, r1
        and     0FFFh, r1
        cmpi    7FFh, r1
        ldieq   0, r4
        cmpi    800h, r1
        ldieq   0, r4
        lsh     -16, r2
        lsh3    16, r4, r1
        or      r1, r2
        lsh     -1, r6
        ldi     0, r1
        cmpi    @K_PD_SAME, r4
        ldige   2, r1
        or      r1, r6
        lsh     -12, r0
pid_watch_axis:
        lsh     -12, r3
        sti     r2, @PD_SAME
        lsh     PIDE_SWAY, r6
        or      @PD_ERRORS, r6
        sti     r6, @PD_ERRORS
        rets
pid_watch_turns:
        ldi     1, r1
        ldi     ir1, r4
        addi    8, r4
        lsh     r4, r1
        or      r1, r2
        br      pid_watch_next

; Number of the joint of the lowest bit of STILL; bit 4 is joint 0.
pid_watch_first:
        .word   0, 4, 3, 4, 2, 4, 3, 4, 1, 4, 3, 4, 2, 4, 3, 4
        .word   0, 4, 3, 4, 2, 4, 3, 4, 1, 4, 3, 4, 2, 4, 3, 4

; Five bits of R2 (now) and R3 (last run) from R5 on; refreshes since when at *AR0++; limit R6; bits beyond it: R7.
pid_watch_five:
        ldi     @TASK + TB_TICK, r4
        ldi     4, ar1
pid_watch_one:
        tstb    r5, r2
        beq     pid_watch_over
        tstb    r5, r3
        bne     pid_watch_long
        sti     r4, *ar0
        br      pid_watch_over
pid_watch_long:
        subi3   *ar0, r4, r0
        cmpi    r6, r0
        blt     pid_watch_over
        or      r5, r7
pid_watch_over:
        addi    1, ar0
        lsh     1, r5
        dbu     ar1, pid_watch_one
        rets
