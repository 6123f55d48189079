; ---- the decision: AG_AVOID_LIMIT, AG_AVOID_SHIFT, AG_AVOID_HOLD from SHIFT and SPEED; R0, R1 as a kernel returns them
; ----
avoid_decide:
        call    avoid_beside
        call    avoid_side
        call    avoid_block
        call    avoid_keep
        call    avoid_motion
        br      avoid_speed

; FLANK <- how far along the leg something is beside the vehicle. There a shift has no room: towards the thing for the
; flank, away from it for the vehicle's ends, which swing out. Covers things that are about to leave the view.
avoid_beside:
        call    alive
        float   *+ar6(AG_AVOID_BESIDE), r5
        mpyf    @K_MILLI, r5
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldi     @AV_FOUND, ar2
        br      avoid_beside_next
avoid_beside_point:
        ldf     *+ar1(AV_PX), r0
        subf    @AV_MOUNT, r0
        cmpf    @K_AV_SOON, r0
        bge     avoid_beside_after
        ldf     *+ar1(AV_PALONG), r0
        subf    @AV_MOUNT, r0
        cmpf    @K_AV_BESIDE, r0                ; not a bend away
        bge     avoid_beside_after
        ldf     *+ar1(AV_PLATERAL), r0
        call    avoid_gap
        cmpf    @K_AV_BESIDE, r0
        bge     avoid_beside_after
        ldf     *+ar1(AV_PALONG), r0
        addf    @AV_S, r0
        addf    @K_AV_REAR, r0
        cmpf    r5, r0
        ldfgt   r0, r5
avoid_beside_after:
        addi    AV_POINT_WORDS, ar1
avoid_beside_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     avoid_beside_point
        stf     r5, @AV_FLANK
        rets

; SHIFT <- the shift wanted, or the present one while it must be held; HOLD. A thing is not passed if it is so near to
; the leg's end that the vehicle could not return to the lane before the end.
avoid_side:
        call    alive
        ldf     @AV_SHIFT, r6
        ldf     @K_AV_SHIFT_MOST, r1
        cmpf    r1, r6
        ldfgt   r1, r6
        negf    r1, r1
        cmpf    r1, r6
        ldflt   r1, r6
        ldf     @AV_HOLD, r7                    ; hold: until the rear has passed the things in the lane
        ldf     @K_AV_NO_LIMIT, r8              ; the nearest thing that can be passed
        ldf     r8, r9                          ; the nearest thing that cannot be passed
        call    avoid_home
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldi     @AV_FOUND, ar2
        br      avoid_hold_next
avoid_hold_point:
        ldf     *+ar1(AV_PLATERAL), r0
        call    avoid_gap
        cmpf    @K_AV_HALF, r0
        bge     avoid_hold_after
        ldf     *+ar1(AV_PALONG), r0
        cmpf    r3, r0
        bgt     avoid_hold_late
        cmpf    @K_AV_HOLD_WITHIN, r0
        bge     avoid_hold_after
        cmpf    r8, r0
        ldflt   r0, r8
        addf    @AV_S, r0
        addf    @K_AV_REAR, r0
        cmpf    r7, r0
        ldfgt   r0, r7
        br      avoid_hold_after
avoid_hold_late:
        cmpf    r9, r0
        ldflt   r0, r9
avoid_hold_after:
        addi    AV_POINT_WORDS, ar1
avoid_hold_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     avoid_hold_point
        ldf     @AV_HOLD, r10
        stf     r7, @AV_HOLD
        cmpf    @K_AV_NO_LIMIT, r8
        calllt  avoid_feasible
        cmpf    @AV_S, r10
        ble     avoid_hold_over                 ; the things that it already passes do not limit it
        absf    @AV_SHIFT_OLD, r0
        absf    r6, r1
        cmpf    r0, r1
        ldflt   @AV_SHIFT_OLD, r6
        ldf     @AV_SHIFT_OLD, r0               ; nor does the side change
        mpyf    r6, r0
        cmpf    0.0, r0
        ldflt   @AV_SHIFT_OLD, r6
        br      avoid_side_home
avoid_hold_over:
        cmpf    r8, r9
        ldflt   0.0, r6
avoid_side_home:
        ldf     @AV_FLANK, r0                   ; a shift does not grow while something is beside the vehicle
        cmpf    @AV_S, r0
        ble     avoid_side_end
        ldf     @AV_SHIFT_OLD, r0
        ldf     r0, r1
        cmpf    0.0, r0
        ldflt   0.0, r0
        cmpf    r0, r6
        ldfgt   r0, r6
        cmpf    0.0, r1
        ldfgt   0.0, r1
        cmpf    r1, r6
        ldflt   r1, r6
avoid_side_end:
        ldf     @AV_LEFT, r0                    ; the end of the leg is in the lane
        cmpf    @K_AV_HOME_STRAIGHT, r0
        ldflt   0.0, r6
        rnd     r6, r6
        stf     r6, @AV_SHIFT
        rets

; R6 <- the shift that passes the group of things that begins R8 ahead: R6, or a larger one if needed; to the other side
; if only that one is free; none if both are blocked. R6 = 0 stays. Clobbers R0 .. R5, R11, AR1, AR2.
avoid_feasible:
        cmpf    0.0, r6
        retseq
        ldf     @K_AV_SHIFT_MOST, r4            ; farthest to the left
        negf    r4, r5                          ; and right
        ldf     @K_AV_NO_LIMIT, r11             ; needed to pass on the right
        negf    r11, r3                         ; on the left
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldi     @AV_FOUND, ar2
        br      avoid_feasible_next
avoid_feasible_point:
        ldf     *+ar1(AV_PALONG), r0
        subf    r8, r0
        cmpf    @K_AV_GROUP, r0
        bge     avoid_feasible_after
        ldf     *+ar1(AV_PLATERAL), r0
        call    avoid_gap
        ldf     *+ar1(AV_PSWING), r1
        cmpf    0.0, r1
        ldfgt   0.0, r1
        subrf   *+ar1(AV_PLATERAL), r1
        addf    @K_AV_NEEDS, r1                 ; the vehicle's lateral place when it passes this thing on its left
        ldf     *+ar1(AV_PSWING), r2
        cmpf    0.0, r2
        ldflt   0.0, r2
        subrf   *+ar1(AV_PLATERAL), r2
        subf    @K_AV_NEEDS, r2                 ; on its right
        cmpf    @K_AV_HALF, r0
        bge     avoid_feasible_beside
        cmpf    r3, r1
        ldfgt   r1, r3
        cmpf    r11, r2
        ldflt   r2, r11
        br      avoid_feasible_after
avoid_feasible_beside:                          ; it stands beside the lane: there must be room between it and the group
        cmpf    r4, r2
        ldfgt   r4, r2
        cmpf    r5, r1
        ldflt   r5, r1
        ldf     *+ar1(AV_PLATERAL), r0
        ldfgt   r2, r4
        ldflt   r1, r5
avoid_feasible_after:
        addi    AV_POINT_WORDS, ar1
avoid_feasible_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     avoid_feasible_point
        cmpf    0.0, r6
        blt     avoid_feasible_right
        cmpf    r4, r3
        bgt     avoid_feasible_only_right
        cmpf    r3, r6
        ldflt   r3, r6
        cmpf    r4, r6
        ldfgt   r4, r6
        rets
avoid_feasible_only_right:
        ldf     r11, r6
        cmpf    r5, r11
        ldflt   0.0, r6
        rets
avoid_feasible_right:
        cmpf    r5, r11
        blt     avoid_feasible_only_left
        cmpf    r11, r6
        ldfgt   r11, r6
        cmpf    r5, r6
        ldflt   r5, r6
        rets
avoid_feasible_only_left:
        ldf     r3, r6
        cmpf    r4, r3
        ldfgt   0.0, r6
        rets

; R3 <- largest distance ahead of a thing that can be passed, so that the vehicle is back in the lane at the leg's end.
avoid_home:
        ldf     @AV_LEFT, r3
        subf    @K_AV_HOME_STRAIGHT, r3
        subf    @K_AV_REAR, r3
        rets

; R1 <- lateral place of the way R8 ahead: shift + (now - shift) (1 - t)^2 (1 + 2 t), t = (R8 - 4 m) / 15 m: the front
; is there when the middle has gone 7.4 m less. Clobbers R0, R2.
avoid_way:
        ldf     r8, r0
        subf    @K_AV_FRONT, r0
        cmpf    0.0, r0
        ldflt   0.0, r0
        mpyf    @K_AV_BLEND, r0                 ; t
        cmpf    1.0, r0
        ldfgt   1.0, r0
        ldf     1.0, r1
        subf    r0, r1
        mpyf    r1, r1
        addf3   r0, r0, r2
        addf    1.0, r2
        mpyf    r2, r1
        ldf     @AV_LATERAL, r2
        subf    @AV_SHIFT, r2
        mpyf    r2, r1
        addf    @AV_SHIFT, r1
        rets

; R0 <- distance of point AR1, R0 m left of the way, from the middle's path: |R0|, less the swing. Clobbers R1, R2.
avoid_gap:
        mpyf3   *+ar1(AV_PSWING), r0, r1
        absf    r0, r0
        cmpf    0.0, r1
        retsle
        absf    *+ar1(AV_PSWING), r2
        subf    r2, r0
        rets

; R0 <- distance of point AR1 ahead of the front, along the lane or straight ahead: the larger one (bends outside).
avoid_ahead:
        ldf     *+ar1(AV_PALONG), r0
        cmpf    *+ar1(AV_PX), r0
        ldflt   *+ar1(AV_PX), r0
        subf    @AV_MOUNT, r0
        rets

; FREE, CLOSE: what blocks the way from the present lateral place to SHIFT, and back to the lane before the leg's end,
; and what stands close beside it. SEEN: on the inner side of a bend a thing leaves the view before it is as near as
; that along the lane; the vehicle must stop earlier.
avoid_block:
        call    alive
        ldf     @K_AV_NO_LIMIT, r7              ; free distance
        ldf     r7, r5
        ldf     r7, r9
        call    avoid_home
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldi     @AV_FOUND, ar2
        br      avoid_block_next
avoid_block_point:
        ldf     *+ar1(AV_PALONG), r8
        call    avoid_way
        ldf     *+ar1(AV_PLATERAL), r0
        subf    r1, r0
        call    avoid_gap
        cmpf    r3, r8
        ble     avoid_block_gap
        ldf     r0, r4
        ldf     *+ar1(AV_PLATERAL), r0
        call    avoid_gap
        cmpf    r4, r0
        ldfgt   r4, r0
avoid_block_gap:
        ldf     r0, r1
        call    avoid_ahead
        cmpf    @K_AV_CLOSE, r1
        bge     avoid_block_after
        cmpf    r5, r0
        ldflt   r0, r5
        cmpf    @K_AV_HALF, r1
        bge     avoid_block_after
        cmpf    r7, r0
        ldflt   r0, r7
        cmpf    @K_AV_NEAR, r0
        bge     avoid_block_after
        ldf     *+ar1(AV_PX), r0
        subf    @AV_MOUNT, r0
        cmpf    r9, r0
        ldflt   r0, r9
avoid_block_after:
        addi    AV_POINT_WORDS, ar1
avoid_block_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     avoid_block_point
        stf     r7, @AV_FREE
        stf     r5, @AV_CLOSE
        stf     r9, @AV_SEEN
        rets

; R1 <- stopping distance from the present speed: v T + v^2 / (2 B).
avoid_stopping:
        ldf     @AV_SPEED_NOW, r0
        ldf     r0, r1
        mpyf    @K_DW_HALF_OVER_B, r1
        addf    @K_AV_T, r1
        mpyf    r0, r1
        rets

; If the way to another shift is blocked too near to stop, and the present shift's is free 0.5 m farther: keep that one.
avoid_keep:
        ldf     @AV_SHIFT, r6
        cmpf    @AV_SHIFT_OLD, r6
        retseq
        call    avoid_stopping
        addf    @K_AV_STAND, r1
        ldf     @AV_FREE, r10
        cmpf    r1, r10
        retsge
        ldf     @AV_SHIFT_OLD, r0
        stf     r0, @AV_SHIFT
        call    avoid_block
        ldf     r10, r0
        addf    0.5, r0
        cmpf    r0, r7
        retsgt
        stf     r6, @AV_SHIFT
        br      avoid_block

; The speed from which braking by B after T ends K_AV_STAND short of it: v = B (sqrt(T^2 + 2 d / B) - T)
avoid_speed:
        ldf     @AV_FREE, r7
        cmpf    @AV_SEEN, r7
        ldfgt   @AV_SEEN, r7
        ldf     @AV_SPEED, r6
        ldi     @AV_WAIT, r0
        cmpi    @AV_COUNT, r0
        ble     avoid_speed_free
        ldf     @AV_PLACE, r0                   ; what is remembered
        subf    @AV_S, r0
        subf    @AV_MOUNT, r0
        cmpf    r7, r0
        ldflt   r0, r7
avoid_speed_free:
        cmpf    @K_AV_NO_LIMIT, r7
        bge     avoid_speed_close
        subf    @K_AV_STAND, r7
        ldf     0.0, r0
        cmpf    0.0, r7
        ble     avoid_speed_blocked
        ldf     r7, r0
        mpyf    @K_AV_TWICE_OVER_B, r0
        addf    @K_AV_T_SQUARED, r0
        call    m_sqrt
        subf    @K_AV_T, r0
        mpyf    @K_AV_B, r0
        cmpf    0.125, r0
        ldflt   0.0, r0                         ; no creeping over the last centimetres
avoid_speed_blocked:
        cmpf    r6, r0
        ldflt   r0, r6
avoid_speed_close:
        ldf     @AV_CLOSE, r0
        cmpf    @K_AV_CLOSE_AHEAD, r0
        bge     avoid_write
        cmpf    @K_AV_CLOSE_SPEED, r6
        ldfgt   @K_AV_CLOSE_SPEED, r6
avoid_write:
        ldf     @AV_SHIFT, r0
        subf    @AV_LATERAL, r0
        absf    r0, r0
        cmpf    @K_AV_SHIFTING, r0
        ble     avoid_write_hold
        cmpf    @K_AV_SHIFT_SPEED, r6
        ldfgt   @K_AV_SHIFT_SPEED, r6
avoid_write_hold:
        ldi     @AV_WAIT, r0
        sti     r0, *+ar6(AG_AVOID_WAIT)
        ldf     @AV_PLACE, r0
        call    avoid_millimetres
        sti     r0, *+ar6(AG_AVOID_PLACE)
        ldf     @AV_FLANK, r0
        call    avoid_millimetres
        sti     r0, *+ar6(AG_AVOID_BESIDE)
        ldf     @AV_HOLD, r0
        call    avoid_millimetres
        sti     r0, *+ar6(AG_AVOID_HOLD)
        ldf     @AV_SHIFT, r0
        call    avoid_millimetres
        sti     r0, *+ar6(AG_AVOID_SHIFT)
        ldi     0, r1
        ldi     0, r2
        cmpi    0, r0
        ldine   AVOID_SHIFTED, r2
        ldi     0, r0
        cmpf    @K_AV_NO_LIMIT, r6
        bge     avoid_unlimited
        ldf     r6, r0
        call    avoid_millimetres
        addi    1, r0
        or      AVOID_SLOWED, r2
avoid_unlimited:
        sti     r0, *+ar6(AG_AVOID_LIMIT)
        ldi     r2, r0
        ldi     0, r1
        rets

; R0 <- R0 in whole thousandths, to the nearest.
avoid_millimetres:
        mpyf    @K_IA_KILO, r0
        addf    0.5, r0
        fix     r0, r0
        rets

; No view: drive as without avoidance.
avoid_nothing:
        ldi     0, r0
        sti     r0, *+ar6(AG_AVOID_WAIT)
        sti     r0, *+ar6(AG_AVOID_HOLD)
        sti     r0, *+ar6(AG_AVOID_SHIFT)
        sti     r0, *+ar6(AG_AVOID_LIMIT)
        ldi     0, r1
        rets
