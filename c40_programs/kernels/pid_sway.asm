; PID's shift of the suspension against sway and wind (docs/kernels.md, Wind).
;
; Per axis, radial and tangential, in the slewing frame: theta the rope's angle from its reference, y the load's offset
; from its path, v the rate of y, w the acceleration by the wind, l the rope's length, x the suspension's shift:
;   e = x + l theta - y      y' = v + 3 o e      v' = w - g theta + 3 o^2 e      w' = o^3 e      x = -gain / g v - l / g
;   w
; The first equation measures y; the others are an observer with three poles at o. x brakes the load's swing, and holds
; the suspension so far upwind that the load hangs where it should.
; While the load stands on something, or a drive is off, the rope gives no information: y and v decay, and w stays.
; While the path moves and no wind is known, e would contain the errors of the path's model. Then w stays as well, y is
; the measured value, and v, the integral of the angle, leaks: v' = w - g theta - o / 4 v

pid_sway:
        call    pid_filters
        ldhi    hi16(PD_SWAY_FROM), ar0         ; FROM <- interpolated
        or      lo16(PD_SWAY_FROM), ar0
        ldi     ar0, ar1
        addi    4, ar1
        ldf     @PD_PHASE, r2
        ldi     3, rc
        rptb    pid_sway_between
        subf3   *ar0, *ar1++, r0
        mpyf    r2, r0
        addf    *ar0, r0
pid_sway_between:
        stf     r0, *ar0++
        ldi     @PD_STATUS, ir0                 ; IR0: a corner rests on something,
        and     SPREADER_CORNERS, ir0
        ldf     @SV_LOAD, r1                    ; or the rope is slack
        ldf     @K_TQ_SPREADER, r2
        mpyf    @K_PD_SLACK, r2
        cmpf    r2, r1
        ldilt   1, ir0
        ldi     @SV_STOPPED, r0
        beq     pid_sway_at_rate
        ldi     @SV_DRIVES, r0
        xor     1Fh, r0
        or      r0, ir0
        ldf     @SV_PATH_RATE, r0               ; the reference sway goes with the acceleration: with the square of the
                                                ; path's rate
        mpyf    r0, r0
        ldf     @PD_SWAY_FROM, r1
        mpyf    r0, r1
        stf     r1, @PD_SWAY_FROM
        mpyf    @PD_SWAY_FROM + 1, r0
        stf     r0, @PD_SWAY_FROM + 1
pid_sway_at_rate:
        absf    @PD_WIND, r0                    ; its sign: the path moves, and no wind is known; what is not yet known
                                                ; drives v
        absf    @PD_WIND + 1, r1
        addf    r1, r0
        absf    @PD_SPEED, r1
        absf    @PD_SPEED + 1, r2
        addf    r2, r1
        mpyf    @K_PD_SHOWS, r1
        addf    r1, r0
        subf    @K_PD_WINDY, r0
        ldi     @PD_MOVING, r1
        lsh     31, r1
        and     r0, r1
        or      r1, ir0
        ldf     @K_PC_SMOOTH, r7                ; R7 = h / (T + h)
        ldf     @K_PC_STEP, r8                  ; R8 = h
        ldf     @K_PC_OBSERVE, r9               ; R9 = 3 o h
        ldf     @K_PC_OBSERVE + 1, r10          ; R10 = 3 o^2 h
        ldf     @K_PC_OBSERVE + 2, r11          ; R11 = o^3 h
        ldf     @K_PC_BRAKE, r4                 ; R4 = gain / g
        ldf     @PD_Y + 3, r5
        mpyf    @K_ONE_OVER_G, r5               ; R5 = l / g
        subi    PD_SWAY_TO - PD_ANGLES, ar0     ; AR0 (PD_ANGLES) and AR1 (PD_SWAY_FROM) now point to the ends of FROM,
                                                ; TO
        subi    8, ar1
        ldhi    hi16(PD_SWAY), ar2
        or      lo16(PD_SWAY), ar2
        ldi     0, ar3                          ; the signs of these: AR3 some swing is out of tolerance, AR5 the load
                                                ; is not over its
        ldi     0, ar5                          ; place, AR4 the wind displaces it
        ldi     0, ar4
        ldi     1, rc
        rptb    pid_sway_axis_end
        ldf     *+ar2(PD_WIND - PD_SWAY), r2    ; R2 = w
        mpyf3   r2, r5, r3
        ldf     *+ar2(PD_SPEED - PD_SWAY), r1   ; R1 = v
        mpyf3   r1, r4, r0
        addf    r0, r3                          ; R3 = -x
        mpyf    @K_ONE_OVER_G, r2               ; place where the rope hangs in this wind
        ldi     *ar0++, r0
        lsh     20, r0                          ; signed 12 bits
        ash     -20, r0
        float   r0, r0
        mpyf    @K_PD_SWAY_UNIT, r0
        subf    *ar1++, r0
        subf    r2, r0
        ldf     @K_PC_SWAY_LIMIT, r6
        cmpf    r6, r0
        ldfgt   r6, r0
        negf    r6, r6
        cmpf    r6, r0
        ldflt   r6, r0
        addf    r2, r0
        subf    *ar2, r0
        mpyf    r7, r0
        addf    *ar2, r0
        rnd     r0, r0
        stf     r0, *ar2                        ; R0 = theta
        subf3   r2, r0, r6
        absf    r6, r6                          ; the swing; in gusts part of it never settles
        absf    r2, r2
        mpyf    @K_PD_GUSTS, r2
        subrf   r2, r6
        addf    @K_PD_SWAY_TOLERANCE, r6
        or      r6, ar3

        mpyf    @K_GRAVITY, r0
        ldi     ir0, r2
        bned    pid_sway_stands
        ldf     *+ar2(PD_WIND - PD_SWAY), r2
        ldf     *-ar2(PD_SWAY - PD_BESIDE), r6  ; R6 = y
        subf    r0, r2                          ; w - g theta
        mpyf    r5, r0
        subf    r3, r0
        subf3   r6, r0, r3                      ; R3 = e
        mpyf3   r8, r1, r0
        addf    r0, r6
        mpyf3   r9, r3, r0
        addf    r0, r6
        mpyf    r8, r2
        addf    r2, r1
        mpyf3   r10, r3, r0
        addf    r0, r1
        mpyf    r11, r3
        ldf     *+ar2(PD_WIND - PD_SWAY), r2
        addf    r3, r2
        ldf     @K_PD_WIND_MOST, r0
        cmpf    r0, r2
        ldfgt   r0, r2
        negf    r0, r0
        cmpf    r0, r2
        ldflt   r0, r2
pid_sway_known:
        rnd     r6, r6
        stf     r6, *-ar2(PD_SWAY - PD_BESIDE)
        rnd     r1, r1
        stf     r1, *+ar2(PD_SPEED - PD_SWAY)
        rnd     r2, r2
        stf     r2, *+ar2(PD_WIND - PD_SWAY)
        mpyf3   r2, r5, r3
        mpyf3   r1, r4, r0
        addf    r0, r3
        rnd     r3, r3
        stf     r3, *+ar2(PD_SHIFT - PD_SWAY)
        absf    r6, r6
        subrf   @K_PD_PLACE, r6
        or      r6, ar5
        absf    r1, r1
        subrf   @K_PD_PLACE_SPEED, r1
        or      r1, ar5
        absf    r2, r2
        subrf   @K_PD_WINDY, r2
        or      r2, ar4
pid_sway_axis_end:
        nop     *ar2++

        lsh3    -31, ar3, r0
        mpyi    PD_OUT_SWAY, r0
        sti     r0, @PD_OUT
        lsh3    -31, ar5, r0
        xor     1, r0
        lsh     23, r0                          ; PID_STEADY
        or      @PD_RESULT, r0
        lsh3    -31, ar4, r1
        lsh     24, r1                          ; PID_WINDY
        or      r1, r0
        sti     r0, @PD_RESULT

        ldf     @PD_Y + 2, r0                   ; R9, COSINE <- cos phi of the measured luff angle, to 8e-6 up to 80
                                                ; degrees: enough
        mpyf    r0, r0                          ; for a gain. A gantry does not need it
        ldf     @K_COS8, r9
        mpyf    r0, r9
        addf    @K_COS6, r9
        mpyf    r0, r9
        addf    @K_COS4, r9
        mpyf    r0, r9
        subf    0.5, r9
        mpyf    r0, r9
        addf    1.0, r9
        stf     r9, @PD_COSINE
        negf    @PD_SHIFT, r0
        mpyf    @PD_SWAY_FROM + 2, r0           ; by which the luff moves. What that lifts the jib's tip the hoist pays
                                                ; out
        mpyf3   r0, r9, r1
        mpyf    @K_PD_LIFT, r1
        addf    @PD_R + 3, r1
        rnd     r1, r1
        stf     r1, @PD_R + 3
        addf    @PD_R + 2, r0
        rnd     r0, r0
        stf     r0, @PD_R + 2
        negf    @PD_SHIFT + 1, r0
        mpyf    @PD_SWAY_FROM + 3, r0           ; rate of slewing: the rotator turns the load back
        ldf     r0, r1
        mpyf    @K_PD_TURN, r1
        subrf   @PD_R + 4, r1
        rnd     r1, r1
        stf     r1, @PD_R + 4
        addf    @PD_R + 1, r0
        rnd     r0, r0
        stf     r0, @PD_R + 1
        rets

pid_sway_stands:                                ; R0 = g theta, R2 = w - g theta, R3 = -x
        lsh3    1, ir0, r6
        bzd     pid_sway_moves
        mpyf    r5, r0
        subf3   r3, r0, r6
        mpyf    r8, r2
        ldf     *-ar2(PD_SWAY - PD_BESIDE), r6  ; y and v fade within a second
        ldf     *+ar2(PD_WIND - PD_SWAY), r2
        mpyf3   r8, r6, r0
        subf    r0, r6
        brd     pid_sway_known
        mpyf3   r8, r1, r0
        subf    r0, r1
        nop

pid_sway_moves:                                 ; y is the measured value
        mpyf3   r9, r1, r0
        mpyf    @K_PD_LEAK, r0
        brd     pid_sway_known
        subf    r0, r2
        addf    r2, r1
        ldf     *+ar2(PD_WIND - PD_SWAY), r2
