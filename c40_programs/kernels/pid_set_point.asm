; PID's set-point (docs/kernels.md): the point of the path, the cubic between two joint points.

; Consume the joint points that are due: a segment's point is due N_t after the one before, however late this tick is.
; The segment begins now only if the buffer was dry at the last tick, or for point 0. R10 <- 1 if a due one was missing.
pid_advance:
        ldi     0, r10
        ldi     @PD_CONSUMED, r0
        ldi     @SV_PATH_TICK, r1
        ldi     @SV_POINT_TICKS, r2
        cmpi    0, r0
        bne     pid_advance_more
        cmpi    @PD_PRODUCED, r0
        retseq
        br      pid_advance_now
pid_advance_more:
        ldi     r1, r3
        subi    @PD_SEGMENT, r3                 ; refreshes since the segment began
        cmpi    r2, r3
        blt     pid_advance_done
        cmpi    @PD_PRODUCED, r0
        bge     pid_advance_dry
        ldi     @PD_LAW, r3
        tstb    PD_DRY, r3
        bne     pid_advance_now
        addi    1, r0
        sti     r0, @PD_CONSUMED
        ldi     @PD_SEGMENT, r3
        addi    r2, r3
        sti     r3, @PD_SEGMENT
        br      pid_advance_more
pid_advance_now:
        addi    1, r0
        sti     r0, @PD_CONSUMED
        sti     r1, @PD_SEGMENT
        ldi     @PD_RESULT, r3
        ldhi    hi16(PID_BEGAN), r4
        or      r4, r3
        sti     r3, @PD_RESULT
pid_advance_done:
        ldi     @PD_LAW, r3
        andn    PD_DRY, r3
        sti     r3, @PD_LAW
        rets
pid_advance_dry:
        ldi     1, r10
        ldi     @PD_LAW, r3
        or      PD_DRY, r3
        sti     r3, @PD_LAW
        rets

; R <- the set-point: cubic with the points' positions and rates. MOVING, PID_STARVED. SWAY_FROM, SWAY_TO, PHASE.
pid_reference:
        ldi     @PD_CONSUMED, r0
        call    servo_slots
        ldi     r0, r8
        ldi     r1, r9
        lsh3    4, r8, ar0
        addi    ar6, ar0
        addi    CR_RING, ar0
        ldhi    hi16(SV_FROM), ar1
        or      lo16(SV_FROM), ar1
        ldi     9, rc
        call    copy_words
        lsh3    4, r9, ar0
        addi    ar6, ar0
        addi    CR_RING, ar0
        ldhi    hi16(SV_TO), ar1
        or      lo16(SV_TO), ar1
        ldi     9, rc
        call    copy_words
        lsh3    2, r8, ar0
        addi    ar6, ar0
        addi    CR_SWAY, ar0
        ldhi    hi16(PD_SWAY_FROM), ar1
        or      lo16(PD_SWAY_FROM), ar1
        ldi     3, rc
        call    copy_words
        lsh3    2, r9, ar0
        addi    ar6, ar0
        addi    CR_SWAY, ar0
        ldi     3, rc
        call    copy_words                      ; AR1 now points to PD_SWAY_TO
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
        mpyf    r3, r5                          ; R5: weight of the second point's position
        addf    1.0, r4
        mpyf    r2, r4                          ; R4: of the first point's
        ldf     @SV_POINT_PERIOD, r6
        mpyf    r0, r2
        mpyf    r6, r2                          ; R2: of the first point's rate
        mpyf    r1, r3
        mpyf    r6, r3
        negf    r3, r3                          ; R3: of the second point's
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
        ldf     0.0, r6                         ; fastest joint speed of the second point, of both
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
        ldhi    hi16(PID_STARVED), r1           ; the buffer ran dry in full motion
        or      @PD_RESULT, r1
        sti     r1, @PD_RESULT
pid_reference_rest:
        ldf     @PD_PHASE, r1                   ; the segment is over: only its end counts
        cmpf    1.0, r1
        ldfge   r6, r7
        cmpf    @K_PD_REST, r7
        ldigt   1, r0
        ldi     @PD_RAMP, r1
        cmpi    1, r1
        ldieq   1, r0
        sti     r0, @PD_MOVING
        rets
