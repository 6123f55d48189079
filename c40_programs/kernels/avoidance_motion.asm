; ---- moving things: compares lateral places beside the lane with those about 0.4 s before (16 to 48 points). A thing
; that enters the way before the rear has passed blocks it; one that comes along it shortens it by its own path. ----
avoid_motion:
        call    alive
        ldi     @AV_COUNT, r0
        lsh     -4, r0
        subi    2, r0
        call    avoid_bank
        ldhi    hi16(AV_THEN), ar1
        or      lo16(AV_THEN), ar1
        ldi     AV_LOOK_WORDS - 1, rc
        call    copy_words
        ldf     0.0, r0
        stf     r0, @AV_RATE
        ldi     @AV_COUNT, r0
        addi    1, r0
        sti     r0, @AV_NOW
        ldi     @AV_THEN, r1
        bz      avoid_motion_new                ; nothing has been kept there
        subi    r1, r0
        cmpi    16, r0
        blt     avoid_motion_new
        cmpi    48, r0
        bge     avoid_motion_new
        float   r0, r0
        float   *+ar6(AG_PERIOD_US), r1
        mpyf    @K_MICRO, r1
        mpyf    r1, r0
        call    m_reciprocal
        stf     r0, @AV_RATE
avoid_motion_new:
        ldf     @AV_FREE, r6
        ldf     @AV_CLOSE, r7
        ldf     r6, r0
        ldi     AV_BLOCK, ir0
        call    avoid_closing
        cmpf    @K_AV_MOVES, r1
        ble     avoid_motion_close
        call    avoid_meet
        subf    r0, r6
        stf     r6, @AV_FREE
avoid_motion_close:
        ldf     r7, r0
        ldi     AV_BESIDE, ir0
        call    avoid_closing
        cmpf    @K_AV_COMES, r1
        ble     avoid_motion_clear
        ldf     r7, r0                          ; a thing comes along past the vehicle: let it pass
        addf    @K_AV_PASSES, r0
        ldf     r7, r2
        cmpf    @K_AV_SOON, r7
        calllt  avoid_remember
        call    avoid_meet
        subf    r0, r7
        cmpf    @AV_FREE, r7
        bge     avoid_motion_clear
        stf     r7, @AV_FREE
avoid_motion_clear:
        ldhi    hi16(AV_NOW), ar0
        or      lo16(AV_NOW), ar0
        addi    AV_SIDES, ar0
        ldf     @K_AV_NO_LIMIT, r0
        rpts    2 * AV_BINS - 1
        stf     r0, *ar0++
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldi     @AV_FOUND, ar2
        br      avoid_motion_next
avoid_motion_point:
        call    avoid_crossing
        addi    AV_POINT_WORDS, ar1
avoid_motion_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     avoid_motion_point
        ldi     @AV_COUNT, r0
        lsh     -4, r0
        call    avoid_bank
        ldi     ar0, ar1
        ldhi    hi16(AV_NOW), ar0
        or      lo16(AV_NOW), ar0
        ldi     AV_LOOK_WORDS - 1, rc
        br      copy_words

; NOW's word IR0 <- place along the leg of the thing R0 ahead of the front; R1 <- its speed towards the vehicle, against
; THEN's, m/s; 0: unknown. Clobbers AR0.
avoid_closing:
        ldhi    hi16(AV_NOW), ar0
        or      lo16(AV_NOW), ar0
        ldf     0.0, r1
        cmpf    @K_AV_NO_LIMIT, r0
        bge     avoid_closing_keep
        addf    @AV_MOUNT, r0
        addf    @AV_S, r0
        rnd     r0, r0
        addi    AV_LOOK_WORDS, ar0              ; AV_THEN
        ldf     *+ar0(ir0), r1
        subi    AV_LOOK_WORDS, ar0
        cmpf    @K_AV_NO_LIMIT, r1
        ldfge   r0, r1                          ; nothing was there
        subf    r0, r1
        mpyf    @AV_RATE, r1
        cmpf    @K_AV_MOVES_MOST, r1
        ldfgt   0.0, r1                         ; not the same thing as before
avoid_closing_keep:
        stf     r0, *+ar0(ir0)
        rets

; R0 <- how far a thing at R1 m/s moves while the vehicle stops. Keeps R1.
avoid_meet:
        ldf     @AV_SPEED_NOW, r0
        mpyf    @K_AV_ONE_OVER_B, r0
        addf    @K_AV_T, r0
        mpyf    r1, r0
        rets

; WAIT, PLACE <- a thing at R1 m/s that needs R0 m to leave the way, R2 ahead along the lane and soon beside the front,
; out of view. A nearer thing that is already remembered is kept. Keeps R1, R6 .. R11.
avoid_remember:
        addf    @AV_MOUNT, r2
        addf    @AV_S, r2
        rnd     r2, r2
        ldi     @AV_COUNT, r3
        cmpi    @AV_WAIT, r3
        bge     avoid_remember_new
        cmpf    @AV_PLACE, r2
        retsgt
avoid_remember_new:
        stf     r2, @AV_PLACE
        ldf     r1, r4
        ldf     r0, r5
        ldf     r1, r0
        call    m_reciprocal
        mpyf    r0, r5
        float   *+ar6(AG_PERIOD_US), r0
        mpyf    @K_MICRO, r0
        call    m_reciprocal
        mpyf    r0, r5
        ldf     r4, r1
        fix     r5, r0
        addi    @AV_COUNT, r0
        sti     r0, @AV_WAIT
        rets

; Enters the point AR1 in NOW; shortens FREE if the point will come into the way. Keeps AR1, AR2.
avoid_crossing:
        ldf     *+ar1(AV_PALONG), r8
        ldf     r8, r0
        addf    @AV_S, r0
        mpyf    @K_AV_ONE_OVER_BIN, r0
        fix     r0, r3                          ; bin
        ldf     *+ar1(AV_PLATERAL), r9
        ldi     AV_SIDES, r4                    ; where its bins begin
        cmpf    @AV_LATERAL, r9
        bge     avoid_crossing_left
        negf    r9, r9
        addi    AV_BINS, r4
avoid_crossing_left:
        ldhi    hi16(AV_NOW), ar0
        or      lo16(AV_NOW), ar0
        ldi     r3, ir0
        and     AV_BINS - 1, ir0
        addi    r4, ir0
        rnd     r9, r1
        cmpf    *+ar0(ir0), r1
        bge     avoid_crossing_then
        stf     r1, *+ar0(ir0)
avoid_crossing_then:
        ldf     @AV_RATE, r0
        cmpf    0.0, r0
        retseq
        ldf     r0, r7
        call    avoid_ahead
        ldf     r0, r1
        ldf     r7, r0                          ; rate
        ldf     r1, r7                          ; ahead of the front
        addi    AV_LOOK_WORDS, ar0              ; AV_THEN
        call    avoid_before
        cmpf    @K_AV_NO_LIMIT, r2
        retsge
        subf    r9, r2
        mpyf    r0, r2                          ; how fast it comes
        cmpf    @K_AV_MOVES, r2
        retsle
        cmpf    @K_AV_MOVES_MOST, r2
        ldfgt   @K_AV_MOVES_MOST, r2
        ldf     r2, r11
        call    avoid_way
        ldf     *+ar1(AV_PLATERAL), r0
        subf    r1, r0
        call    avoid_gap
        subf    @K_AV_HALF, r0                  ; its distance from the way
        ldf     r0, r8
        ldf     @AV_SPEED_NOW, r1
        cmpf    1.0, r1
        ldflt   1.0, r1
        mpyf    r0, r1
        ldf     r7, r0
        addf    @K_AV_PASSED, r0
        mpyf    r11, r0                         ; gap / speed there < (ahead + length) / speed here
        cmpf    r0, r1
        retsge
        cmpf    @AV_FREE, r7
        bge     avoid_crossing_soon
        stf     r7, @AV_FREE
avoid_crossing_soon:
        ldf     *+ar1(AV_PX), r0
        subf    @AV_MOUNT, r0
        cmpf    @K_AV_SOON, r0
        retsge
        call    avoid_older
        cmpf    @K_AV_CROSSES, r1
        retsle
        ldf     r8, r0                          ; as far, plus the distance to the other side of the way
        addf    @K_AV_WAY, r0
        ldf     r7, r2
        br      avoid_remember

; R1 <- speed at which the place R9 (bin R3, side R4) has come nearer since the look three slots before (0.6 to 1.3 s).
; A shorter time would let the rim of a post beside the driving vehicle look like motion. 0: unknown. Clobbers R0, R2,
; R5, R10, AR0, IR0.
avoid_older:
        ldi     @AV_COUNT, r0
        lsh     -4, r0
        subi    3, r0
        call    avoid_bank
        ldf     0.0, r1
        ldi     @AV_COUNT, r5
        addi    1, r5
        ldi     *ar0, r0
        retseq                                  ; no look has been kept there
        subi    r0, r5
        cmpi    32, r5
        retslt
        cmpi    64, r5
        retsge
        call    avoid_before
        cmpf    @K_AV_NO_LIMIT, r2
        retsge
        subf    r9, r2
        ldf     r2, r10
        float   r5, r0
        float   *+ar6(AG_PERIOD_US), r1
        mpyf    @K_MICRO, r1
        mpyf    r1, r0
        call    m_reciprocal
        mpyf3   r0, r10, r1
        rets

; R2 <- place nearest to the lane in the look at AR0, in bin R3 and its neighbours, on the side whose bins begin at R4.
; Clobbers IR0.
avoid_before:
        ldf     @K_AV_NO_LIMIT, r2
        subi    1, r3
        call    avoid_before_bin
        call    avoid_before_bin
        call    avoid_before_bin
        subi    2, r3
        rets
avoid_before_bin:
        ldi     r3, ir0
        and     AV_BINS - 1, ir0
        addi    r4, ir0
        cmpf    *+ar0(ir0), r2
        ldfgt   *+ar0(ir0), r2
        addi    1, r3
        rets

; AR0 <- address of this AGV's look in slot R0. Clobbers R0, R1.
avoid_bank:
        ldi     r0, r1
        and     1, r1
        lsh     10, r1                          ; half
        and     2, r0
        bz      avoid_bank_first
        addi    AV_BANK_WORDS, r1
avoid_bank_first:
        ldhi    hi16(WINDOW_A + AG_BASE - AG_WORDS), ar0
        or      lo16(WINDOW_A + AG_BASE - AG_WORDS), ar0
        ldi     ar6, r0
        subi    ar0, r0
        lsh     3, r0
        addi    r0, r1
        ldhi    hi16(WINDOW_A + SV_BASE + AV_BANK), ar0
        or      lo16(WINDOW_A + SV_BASE + AV_BANK), ar0
        addi    r1, ar0
        rets
