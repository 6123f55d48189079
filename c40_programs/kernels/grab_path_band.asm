; The grab path: the elastic band of via points around the boxes. grab_path.asm says how it works.

; ---- the band: p_1 .. p_5 ----
grab_path_band:
        call    grab_path_choose
        call    grab_path_lay
        ldi     GP_SWEEPS, r0
        sti     r0, @GP_SWEEP
grab_path_sweep:
        ldhi    hi16(SCRATCH), ar3
        or      lo16(GP_POINT + 4), ar3
        ldi     GP_INNER, r0
        sti     r0, @GP_INDEX
grab_path_relax:
        ldi     @GP_SWEEP, r0
        cmpi    GP_PUSHES, r0
        ble     grab_path_push
        ldi     ar3, ar0                        ; the mean of the neighbours
        ldi     2, rc
        rptb    grab_path_mean
        ldf     *-ar0(4), r0
        addf    *+ar0(4), r0
        mpyf    0.5, r0
grab_path_mean:
        stf     r0, *ar0++(1)
grab_path_push:
        ldi     ar3, ar4
        subi    4, ar4
        call    grab_path_step
        ldi     ar3, ar4
        addi    4, ar4
        call    grab_path_step
        addi    4, ar3
        ldi     @GP_INDEX, r0
        subi    1, r0
        sti     r0, @GP_INDEX
        bnz     grab_path_relax
        ldi     @GP_SWEEP, r0
        subi    1, r0
        sti     r0, @GP_SWEEP
        bnz     grab_path_sweep
        rets

; ---- the way from *ar3 to *ar4 is moved out of every box in turn, by moving *ar3 ----
grab_path_step:
        call    alive
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_BOXES), ar1
        ldi     @GP_BOX_COUNT, ar2
        br      grab_path_step_next
grab_path_step_box:
        call    grab_path_clip
        cmpf    r8, r9
        ble     grab_path_step_clear
        addf3   r8, r9, r11
        mpyf    0.5, r11                        ; the middle of the part inside
        ldi     *+ar1(GP_FACE), r6
        bnn     grab_path_step_known
        call    grab_path_nearest
grab_path_step_known:
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_NEAR), ar0
        addi    r6, ar0
        ldf     *+ar0(GP_FACES), r0             ; its depth behind the face
        subf    *ar0, r0
        mpyf    r11, r0
        addf    *ar0, r0
        ldi     r6, r1
        lsh     -1, r1
        addi3   r1, ar3, ar5                    ; coordinate 0, 0, 1, 1, 2
        cmpi    GP_OVER, r6
        beq     grab_path_step_up
        tstb    1, r6
        bnz     grab_path_step_up
        negf    r0
grab_path_step_up:
        addf    *ar5, r0
        rnd     r0
        stf     r0, *ar5
grab_path_step_clear:
        addi    8, ar1
grab_path_step_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     grab_path_step_box
        rets

; ---- r6 = the face with the least depth at the share r11 of the way. Changes r0, r4, r5, ar0. ----
grab_path_nearest:
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_NEAR), ar0
        ldf     @K_GP_HUGE, r4
        ldi     0, r5
grab_path_nearest_face:
        ldf     *+ar0(GP_FACES), r0
        subf    *ar0, r0
        mpyf    r11, r0
        addf    *ar0++(1), r0
        cmpf    r4, r0
        ldflt   r0, r4
        ldilt   r5, r6
        addi    1, r5
        cmpi    GP_FACES, r5
        blt     grab_path_nearest_face
        rets

; ---- for every box the face through which the straight way leaves it most cheaply, -1 when it does not enter ----
grab_path_choose:
        call    alive
        ldhi    hi16(SCRATCH), ar3
        or      lo16(GP_POINT), ar3
        ldi     ar3, ar4
        addi    4 * GP_LAST, ar4
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_BOXES), ar1
        ldi     @GP_BOX_COUNT, ar2
        br      grab_path_choose_next
grab_path_choose_box:
        call    grab_path_clip
        ldi     -1, r6
        cmpf    r8, r9
        ble     grab_path_choose_store
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_NEAR), ar0
        ldf     @K_GP_HUGE, r4
        ldi     0, r5
grab_path_choose_face:
        ldf     *+ar0(GP_FACES), r0
        subf    *ar0, r0
        mpyf3   r8, r0, r1
        addf    *ar0, r1                        ; depth at t0
        mpyf    r9, r0
        addf    *ar0++(1), r0                   ; and at t1
        cmpf    r1, r0
        ldflt   r1, r0                          ; the greater
        cmpf    r4, r0
        ldflt   r0, r4
        ldilt   r5, r6
        addi    1, r5
        cmpi    GP_FACES, r5
        blt     grab_path_choose_face
        cmpf    0.0, r8                         ; a box that holds one of the ends gets its upper face
        ldile   GP_OVER, r6
        cmpf    1.0, r9
        ldige   GP_OVER, r6
grab_path_choose_store:
        sti     r6, *+ar1(GP_FACE)
        addi    8, ar1
grab_path_choose_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     grab_path_choose_box
        rets

; ---- p_1 .. p_5 evenly from p_0 to p_6, raised onto every box whose face is its top ----
grab_path_lay:
        call    alive
        ldhi    hi16(SCRATCH), ar3
        or      lo16(GP_POINT), ar3
        ldi     ar3, ar4
        addi    4 * GP_LAST, ar4
        ldi     ar3, ar5
        ldi     1, r7
grab_path_lay_next:
        addi    4, ar5
        float   r7, r11
        mpyf    @K_GP_SIXTH, r11                ; share of the way
        ldi     ar3, ar0
        ldi     ar5, ar1
        subi3   ar3, ar4, ir0
        ldi     3, rc
        rptb    grab_path_lay_coordinate
        ldf     *+ar0(ir0), r0
        subf    *ar0, r0
        mpyf    r11, r0
        addf    *ar0++(1), r0
        rnd     r0
grab_path_lay_coordinate:
        stf     r0, *ar1++(1)
        ldf     *ar5, r8
        ldf     *+ar5(1), r9
        ldf     *+ar5(2), r10
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_BOXES), ar1
        ldi     @GP_BOX_COUNT, ar2
        br      grab_path_lay_box_next
grab_path_lay_box:
        ldi     *+ar1(GP_FACE), r0
        cmpi    GP_OVER, r0
        bne     grab_path_lay_aside
        cmpf    *ar1, r8
        ble     grab_path_lay_aside
        cmpf    *+ar1(1), r8
        bge     grab_path_lay_aside
        cmpf    *+ar1(2), r9
        ble     grab_path_lay_aside
        cmpf    *+ar1(3), r9
        bge     grab_path_lay_aside
        ldf     *+ar1(4), r0
        cmpf    r10, r0
        ldfgt   r0, r10
grab_path_lay_aside:
        addi    8, ar1
grab_path_lay_box_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     grab_path_lay_box
        stf     r10, *+ar5(2)
        addi    1, r7
        cmpi    GP_INNER, r7
        ble     grab_path_lay_next
        rets
