; The grab path: the points that are needed, the route over everything, the list in the crane's area.

; ---- from p_0 on, each time to the farthest point with a free straight way; R0 = 1 when even the next point has none,
; else 0 ----
grab_path_shorten:
        ldi     0, r0
        sti     r0, @GP_FROM
grab_path_shorten_from:
        ldi     GP_LAST, r7
grab_path_shorten_to:
        ldi     @GP_FROM, r6
        cmpi    r6, r7
        ble     grab_path_shorten_stuck
        sti     r7, @GP_TO
        call    grab_path_blocked
        ldi     @GP_TO, r7
        cmpi    0, r0
        bz      grab_path_shorten_take
        subi    1, r7
        br      grab_path_shorten_to
grab_path_shorten_take:
        sti     r7, @GP_FROM
        ldi     r7, r6
        call    grab_path_emit
        ldi     @GP_FROM, r7
        cmpi    GP_LAST, r7
        blt     grab_path_shorten_from
        ldi     0, r0
        rets
grab_path_shorten_stuck:
        ldi     1, r0
        rets

; ---- the new list: straight up from p_0, above all that the plan of the way crosses, down to the end ----
grab_path_over:
        call    alive
        ldhi    hi16(SCRATCH), ar3
        or      lo16(GP_POINT), ar3
        ldi     ar3, ar4
        addi    4 * GP_LAST, ar4
        ldf     *+ar3(2), r10
        ldf     *+ar4(2), r0
        cmpf    r10, r0
        ldfgt   r0, r10                         ; the higher end
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_BOXES), ar1
        ldi     @GP_BOX_COUNT, ar2
        br      grab_path_over_next
grab_path_over_box:
        call    grab_path_clip_plan
        cmpf    r8, r9
        ble     grab_path_over_aside
        ldf     *+ar1(4), r0
        cmpf    r10, r0
        ldfgt   r0, r10
grab_path_over_aside:
        addi    8, ar1
grab_path_over_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     grab_path_over_box
        stf     r10, *+ar3(2)
        stf     r10, *+ar4(2)
        ldi     0, r0
        sti     r0, @GP_OUT_COUNT
        cmpf    @GP_START + 2, r10
        ble     grab_path_over_start            ; the start is already as high
        ldi     0, r6
        call    grab_path_emit
grab_path_over_start:
        ldi     GP_LAST, r6
        call    grab_path_emit
        cmpf    @GP_END + 2, r10
        retsle
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_END), ar0
        br      grab_path_emit_at

; ---- the list to route R6: points, then their number ----
grab_path_store:
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_OUT), ar0
        ldi     ar6, ar1
        addi    CR_ROUTE - 32, ar1
        ldi     r6, r1
        lsh     5, r1
        addi    r1, ar1
        ldi     @GP_OUT_COUNT, r1
        lsh     2, r1
        subi    1, r1
        ldi     r1, rc
        call    copy_words
        addi3   r6, ar6, ar0
        ldi     @GP_OUT_COUNT, r1
        sti     r1, *+ar0(CR_ROUTE_COUNT)
        rets
