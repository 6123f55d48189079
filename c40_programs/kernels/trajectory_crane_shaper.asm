; Sub-process 1, crane, second build (plant-and-bus.md 2.1): quintics, look-ahead for the joints' speeds, input shaper.
;
; The path is that of trajectory_crane.asm with quintics as blends. What is written is the path through a ZVD shaper,
;   X(t) = p(t)/4 + p(t - T/2)/2 + p(t - T)/4,    T = 2 pi sqrt(l/g), l the mean of the rope's lengths at the leg's two
;   ends,
; all four coordinates alike: the path in space is unchanged. When a leg begins, the joints' speeds are
; computed at 16 points of the path; if one passes its limit, all segments are stretched.

TJ_HALF         .set SCRATCH + 123      ; s, T/2
TJ_LOOK         .set SCRATCH + 124      ; i, points not yet tested
TJ_WORST        .set SCRATCH + 125      ; largest speed over limit
TJ_LOOK_POINTS  .set 16

kernel_trajectory_crane_shaper:
        ldi     1, r0
        br      trajectory_crane_build

shaper_point:
        call    shaper_half
        call    shaper_clear
        ldi     @TASK + TB_ARGUMENT, r0
        subi    @TJ_K0, r0
        addi    1, r0
        float   r0, r8
        mpyf    @TJ_PERIOD, r8                  ; t
        ldf     0.25, r11
        call    shaper_sum
        subf    @TJ_HALF, r8
        ldf     0.5, r11
        call    shaper_sum
        subf    @TJ_HALF, r8
        ldf     0.25, r11
        call    shaper_sum
        ldf     @TJ_SUM + 8, r0                 ; the load hangs as under a steady acceleration
        stf     r0, @TJ_SUM + 12
        ldf     @TJ_SUM + 9, r0
        stf     r0, @TJ_SUM + 13
        br      trajectory_crane_write

shaper_clear:
        ldhi    hi16(TJ_SUM), ar1
        or      lo16(TJ_SUM), ar1
        ldf     0.0, r0
        rpts    15
        stf     r0, *ar1++
        rets

; HALF <- pi sqrt(l/g)
shaper_half:
        ldhi    hi16(TJ_BEGIN), ar0
        or      lo16(TJ_BEGIN), ar0
        call    shaper_rope
        ldf     r0, r8
        addi    TJ_END - TJ_BEGIN, ar0
        call    shaper_rope
        addf    r8, r0
        mpyf    0.5, r0
        mpyf    @K_ONE_OVER_G, r0
        call    m_sqrt
        mpyf    @K_PI, r0
        stf     r0, @TJ_HALF
        rets
; R0 <- l = h_p + sqrt(L^2 - (r - a0)^2) - z at the pose *AR0
shaper_rope:
        ldf     *ar0, r0
        mpyf    r0, r0
        ldf     *+ar0(1), r1
        mpyf    r1, r1
        addf    r1, r0
        call    m_sqrt
        subf    @K_A0, r0
        mpyf    r0, r0
        subrf   @K_JIB_SQUARED, r0
        call    m_sqrt
        addf    @K_PIVOT, r0
        subf    *+ar0(2), r0
        rets

; SUM += R11 times the path and its two derivatives at t = R8. Keeps R8.
shaper_sum:
        ldhi    hi16(TJ_CHAIN), ar3
        or      lo16(TJ_CHAIN), ar3
        ldhi    hi16(TJ_DURATION), ar4
        or      lo16(TJ_DURATION), ar4
        ldi     ar3, ar0
        ldhi    hi16(TJ_SUM), ar1
        or      lo16(TJ_SUM), ar1
        ldi     3, rc
        rptb    shaper_start
        mpyf3   *ar0++, r11, r0
        addf    *ar1, r0
        rnd     r0, r0
shaper_start:
        stf     r0, *ar1++
        ldi     @TJ_SEGMENTS, ar2
        br      shaper_segment_next
shaper_segment:
        ldf     r8, r0
        subf    *+ar4(TJ_START - TJ_DURATION), r0
        retsle                                  ; this and the following segments have not begun
        cmpf    *ar4, r0
        blt     shaper_within
        ldf     1.0, r0
        ldf     0.0, r1
        ldf     0.0, r2
        br      shaper_add
shaper_within:
        ldf     r0, r7
        ldf     *ar4, r0
        call    m_reciprocal
        ldf     r0, r10
        mpyf    r7, r0
        call    m_quintic
        mpyf    r10, r1
        mpyf    r10, r2
        mpyf    r10, r2
shaper_add:
        mpyf    r11, r0
        mpyf    r11, r1
        mpyf    r11, r2
        ldi     ar3, ar0
        ldhi    hi16(TJ_SUM), ar1
        or      lo16(TJ_SUM), ar1
        ldi     3, rc
        rptb    shaper_coordinate
        ldf     *+ar0(4), r5                    ; P_i - P_i-1
        subf    *ar0++, r5
        mpyf3   r5, r0, r6
        addf    *ar1, r6
        rnd     r6, r6
        stf     r6, *ar1
        mpyf3   r5, r1, r6
        addf    *+ar1(4), r6
        stf     r6, *+ar1(4)
        mpyf3   r5, r2, r6
        addf    *+ar1(8), r6
        stf     r6, *+ar1(8)
shaper_coordinate:
        nop     *ar1++
        addi    4, ar3
        addi    1, ar4
shaper_segment_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     shaper_segment
        rets

; At the beginning of a leg: stretches DURATION where a joint would be too fast, then TOTAL += T. R0 = SHAPED: a gantry
; has a way of its own.
shaper_ahead:
        cmpi    1, r0
        bne     trajectory_gantry_ahead
        ldf     1.0, r0
        stf     r0, @TJ_WORST
        ldi     TJ_LOOK_POINTS, r0
        sti     r0, @TJ_LOOK
shaper_look:
        call    shaper_clear
        float   @TJ_LOOK, r8
        mpyf    @K_TJ_SEVENTEENTH, r8
        mpyf    @TJ_TOTAL, r8
        ldf     1.0, r11
        call    shaper_sum
        call    shaper_speeds
        ldi     @TJ_LOOK, r0
        subi    1, r0
        sti     r0, @TJ_LOOK
        bgt     shaper_look

        ldf     @TJ_WORST, r1
        ldhi    hi16(TJ_DURATION), ar0
        or      lo16(TJ_DURATION), ar0
        ldi     7, rc
        rptb    shaper_stretch
        mpyf3   *ar0, r1, r0
        rnd     r0, r0
shaper_stretch:
        stf     r0, *ar0++
        call    trajectory_crane_starts
shaper_total:
        call    shaper_half
        addf    r0, r0
        addf    @TJ_TOTAL, r0
        stf     r0, @TJ_TOTAL
        rets

; WORST <- the largest of it and the joints' speeds over their limits at SUM: psid = (x yd - y xd)/r^2, rd = (x xd + y
; yd)/r, phid = -rd/(L sin phi), ld = L cos phi phid - zd
shaper_speeds:
        ldf     @TJ_SUM, r6
        mpyf    r6, r6
        ldf     @TJ_SUM + 1, r0
        mpyf    r0, r0
        addf    r6, r0
        ldf     r0, r3
        call    m_rsqrt
        ldf     r0, r8                          ; 1/r
        mpyf    r3, r0
        subf    @K_A0, r0
        ldf     r0, r9                          ; L cos phi
        mpyf    r0, r0
        subrf   @K_JIB_SQUARED, r0
        call    m_rsqrt                         ; 1 / (L sin phi)
        ldf     r0, r10
        ldf     @TJ_SUM, r0
        mpyf    @TJ_SUM + 5, r0
        ldf     @TJ_SUM + 1, r1
        mpyf    @TJ_SUM + 4, r1
        subf    r1, r0
        mpyf    r8, r0
        mpyf    r8, r0
        absf    r0, r0
        mpyf    @TJ_SPEED + 4, r0
        ldf     @TJ_SUM, r1
        mpyf    @TJ_SUM + 4, r1
        ldf     @TJ_SUM + 1, r2
        mpyf    @TJ_SUM + 5, r2
        addf    r2, r1
        mpyf    r8, r1
        mpyf    r10, r1                         ; -phid
        absf    r1, r2
        mpyf    @TJ_SPEED + 5, r2
        cmpf    r2, r0
        ldflt   r2, r0
        mpyf    r9, r1
        addf    @TJ_SUM + 6, r1                 ; -ld
        absf    r1, r1
        mpyf    @TJ_SPEED + 6, r1
        cmpf    r1, r0
        ldflt   r1, r0
        cmpf    @TJ_WORST, r0
        retsle
        stf     r0, @TJ_WORST
        rets
