; The grab path: a straight way against the grown boxes. grab_path.asm has the registers and places.

; ---- R0 = 1 when the straight way from point R6 to point R7 enters a box by more than GP_TOUCH, else 0; R6, R7 kept
; ---- A box is the set where five functions are positive, each linear along the way: the share t0..t1 with all
; positive.
grab_path_blocked:
        call    alive
        ldhi    hi16(SCRATCH), ar3
        or      lo16(GP_POINT), ar3
        ldi     ar3, ar4
        ldi     r6, r0
        lsh     2, r0
        addi    r0, ar3
        ldi     r7, r0
        lsh     2, r0
        addi    r0, ar4
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_BOXES), ar1
        ldi     @GP_BOX_COUNT, ar2
        br      grab_path_blocked_next
grab_path_blocked_box:
        call    grab_path_clip
        cmpf    r8, r9
        bgt     grab_path_is_blocked
        addi    8, ar1
grab_path_blocked_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     grab_path_blocked_box
        ldi     0, r0
        rets
grab_path_is_blocked:
        ldi     1, r0
        rets

; ---- r8 = t0, r9 = t1: the share of the way from *ar3 to *ar4 inside the box *ar1, none when t1 <= t0; GP_NEAR,
; GP_FAR. Changes r0..r5. ----
grab_path_clip:
        call    grab_path_clip_plan
        cmpf    r8, r9
        retsle
        ldf     *+ar1(4), r3
        subf    *+ar3(2), r3
        ldf     *+ar1(4), r4
        subf    *+ar4(2), r4
        stf     r3, @GP_NEAR + 4
        stf     r4, @GP_FAR + 4
        call    grab_path_half
        rets

grab_path_clip_plan:                            ; the same without the top
        ldf     0.0, r8
        ldf     1.0, r9
        ldf     *ar3, r3
        subf    *ar1, r3
        ldf     *ar4, r4
        subf    *ar1, r4
        stf     r3, @GP_NEAR
        stf     r4, @GP_FAR
        call    grab_path_half
        cmpf    r8, r9
        retsle
        ldf     *+ar1(1), r3
        subf    *ar3, r3
        ldf     *+ar1(1), r4
        subf    *ar4, r4
        stf     r3, @GP_NEAR + 1
        stf     r4, @GP_FAR + 1
        call    grab_path_half
        cmpf    r8, r9
        retsle
        ldf     *+ar3(1), r3
        subf    *+ar1(2), r3
        ldf     *+ar4(1), r4
        subf    *+ar1(2), r4
        stf     r3, @GP_NEAR + 2
        stf     r4, @GP_FAR + 2
        call    grab_path_half
        cmpf    r8, r9
        retsle
        ldf     *+ar1(3), r3
        subf    *+ar3(1), r3
        ldf     *+ar1(3), r4
        subf    *+ar4(1), r4
        stf     r3, @GP_NEAR + 3
        stf     r4, @GP_FAR + 3
        call    grab_path_half
        rets

; R3 at t = 0, R4 at t = 1: cut t0..t1 (R8, R9) to where the function exceeds GP_TOUCH. Changes R0..R5.
grab_path_half:
        subf    @K_GP_TOUCH, r3
        subf    @K_GP_TOUCH, r4
        cmpf    0.0, r3
        bgt     grab_path_half_inside
        cmpf    0.0, r4
        bgt     grab_path_half_enters
        ldf     -1.0, r9                        ; nowhere
        rets
grab_path_half_enters:
        subf3   r4, r3, r0
        call    m_reciprocal
        mpyf    r3, r0
        cmpf    r8, r0
        ldfgt   r0, r8
        rets
grab_path_half_inside:
        cmpf    0.0, r4
        bgt     grab_path_half_done
        subf3   r4, r3, r0
        call    m_reciprocal
        mpyf    r3, r0
        cmpf    r9, r0
        ldflt   r0, r9
grab_path_half_done:
        rets
