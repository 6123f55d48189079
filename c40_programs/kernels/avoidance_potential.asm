; Sub-process 5 as a potential field: each of the 16 nearest echoes (one per 11 degrees) repels by k (1/d - 1/d0)/d^2,
; limited, turned by 60 degrees to the passing side, so that an obstacle straight ahead makes no minimum. The sum
; of the forces across the vehicle, over the spring to the lane, is the shift; the sum along the vehicle slows it.

PF_SECTORS      .set 64

kernel_avoidance_potential:
        ldi     PF_SECTORS, r0
        call    avoid_look
        cmpi    0, r0
        beq     avoid_nothing
        call    avoid_nearest
        ldf     0.0, r10                        ; sum across, left positive
        ldf     0.0, r11                        ; sum along
        ldhi    hi16(AV_NEAR), ar3
        or      lo16(AV_NEAR), ar3
        ldi     @AV_NEAR_FOUND, ar2
        br      potential_next
potential_point:
        ldi     *ar3++, ar1
        ldf     *+ar1(AV_RANGE), r0
        cmpf    0.5, r0
        ldflt   0.5, r0
        call    m_reciprocal                    ; q = 1/d
        ldf     r0, r3
        subf    @K_PF_REACH, r3
        cmpf    0.0, r3
        ble     potential_after                 ; beyond d0
        mpyf    r0, r3
        mpyf    r0, r3                          ; F
        cmpf    @K_PF_MOST, r3
        ldfgt   @K_PF_MOST, r3
        ldf     *+ar1(AV_PX), r4
        subf    @AV_MOUNT, r4
        mpyf    r0, r4                          ; cos of the echo's direction
        ldf     *+ar1(AV_PY), r5
        mpyf    r0, r5                          ; sin
        ldf     @AV_SHIFT_OLD, r6               ; passing side: half the present shift decides, so that the side is kept
        mpyf    0.5, r6
        subrf   *+ar1(AV_PLATERAL), r6
        ldf     @K_PF_SIN, r7
        cmpf    0.0, r6
        bge     potential_left
        negf    r7, r7
potential_left:                                 ; -(cos, sin) turned: along = -c60 cos + s60 sin, across = -s60 cos -
                                                ; c60 sin
        mpyf3   r7, r4, r6
        ldf     r5, r1
        mpyf    @K_PF_COS, r1
        addf    r1, r6
        mpyf    r3, r6
        subf    r6, r10
        mpyf    r7, r5
        mpyf    @K_PF_COS, r4
        subf    r5, r4
        mpyf    r3, r4
        addf    r4, r11                         ; against the motion
potential_after:
potential_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     potential_point
        mpyf    @K_PF_SHIFT, r10
        stf     r10, @AV_SHIFT
        cmpf    0.0, r11
        ble     avoid_decide
        ldf     r11, r0
        mpyf    @K_PF_SLOW, r0
        addf    1.0, r0
        call    m_reciprocal
        mpyf    @K_PF_FASTEST, r0
        stf     r0, @AV_SPEED
        br      avoid_decide
