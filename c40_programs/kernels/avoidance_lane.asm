; Obstacle avoidance: the pieces of the lane, and a world point in the lane's frame.

; ---- PATH: the pieces of the leg from 15 m behind the vehicle to 45 m ahead, and a straight beyond the leg's end; S,
; LATERAL, LEFT ----
avoid_path:
        ldf     0.0, r8                         ; where trajectory planning is
        ldi     *+ar6(AG_PRODUCED), r0
        bz      avoid_path_s
        subi    1, r0
        and     1, r0
        lsh     3, r0
        addi3   r0, ar6, ar0
        ldf     *+ar0(TA_STATE), r8
avoid_path_s:
        stf     r8, @AV_S
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        ldhi    hi16(AV_PATH), ar2
        or      lo16(AV_PATH), ar2
        ldi     @TA_COUNT, ar4
        subi    1, ar4
        ldi     0, r11                          ; pieces
        ldf     0.0, r10                        ; start of the segment
avoid_path_segment:
        ldf     r10, r0
        subf    r8, r0
        cmpf    @K_AV_AHEAD, r0
        bgt     avoid_path_next
        addf    *+ar1(TA_SEGMENT_LENGTH), r0
        cmpf    @K_AV_BEHIND, r0
        blt     avoid_path_next
        ldf     *+ar1(TA_SEGMENT_X), r0
        ldf     *+ar1(TA_SEGMENT_Y), r1
        ldf     *+ar1(TA_SEGMENT_HEADING), r6
        ldf     *+ar1(TA_SEGMENT_CURVE), r7
        ldf     *+ar1(TA_SEGMENT_LENGTH), r9
        call    avoid_piece
avoid_path_next:
        addf    *+ar1(TA_SEGMENT_LENGTH), r10
        addi    8, ar1
        dbu     ar4, avoid_path_segment
        stf     r10, @AV_TOTAL
        subi    8, ar1
        ldf     *+ar1(TA_SEGMENT_LENGTH), r6
        call    trajectory_agv_pose             ; R0, R1, R6: the end
        ldf     0.0, r7
        ldf     @K_AV_BEYOND, r9
        call    avoid_piece
        sti     r11, @AV_PATH_COUNT

        ldf     @AV_X, r10
        ldf     @AV_Y, r11
        call    avoid_project
        cmpi    0, r0
        beq     avoid_path_lost
        ldf     @AV_ALONG, r0
        stf     r0, @AV_S
        ldf     @AV_ACROSS, r0
        stf     r0, @AV_LATERAL
        br      avoid_path_left
avoid_path_lost:                                ; more than K_AV_ACROSS beside its lane: treated as on the lane
        ldf     0.0, r0
        stf     r0, @AV_LATERAL
avoid_path_left:
        ldf     @AV_TOTAL, r0
        subf    @AV_S, r0
        stf     r0, @AV_LEFT
        rets

; *AR2++ <- the piece that starts at R0, R1, heading R6, curvature R7, length R9, arc length R10; R11 += 1. Keeps R8 ..
; R10.
avoid_piece:
        stf     r0, *ar2
        stf     r1, *+ar2(1)
        ldf     r6, r0
        call    m_sincos
        stf     r1, *+ar2(2)
        stf     r0, *+ar2(3)
        stf     r7, *+ar2(4)
        stf     r9, *+ar2(5)
        stf     r10, *+ar2(6)
        ldf     r7, r0
        bz      avoid_piece_straight
        call    m_reciprocal
avoid_piece_straight:
        stf     r0, *+ar2(7)
        addi    8, ar2
        addi    1, r11
        rets

; ---- ALONG, ACROSS of the world point R10, R11: its foot on the nearest piece; R0 <- 1, or 0 if no piece is within
; K_AV_ACROSS ---- On an arc, with u, v in the frame of its start: lateral = (1 - |(k u, 1 - k v)|) / k, along = atan2(k
; u, 1 - k v) / k. Keeps R10, R11, AR3, AR5.
avoid_project:
        ldhi    hi16(AV_PATH), ar2
        or      lo16(AV_PATH), ar2
        ldi     @AV_PATH_COUNT, ar4
        subi    1, ar4
        ldf     @K_AV_ACROSS, r9                ; least |lateral| so far
        ldi     0, ir0
avoid_project_piece:
        ldf     r10, r6
        subf    *ar2, r6
        ldf     r11, r7
        subf    *+ar2(1), r7
        mpyf3   *+ar2(2), r6, r4
        mpyf3   *+ar2(3), r7, r5
        addf    r5, r4                          ; u
        mpyf3   *+ar2(2), r7, r5
        mpyf3   *+ar2(3), r6, r3
        subf    r3, r5                          ; v
        ldf     r5, r8
        ldf     r4, r0
        ldf     *+ar2(4), r3
        bz      avoid_project_foot
        mpyf3   r3, r4, r6                      ; k u
        mpyf    r3, r5
        ldf     1.0, r7
        subf    r5, r7                          ; 1 - k v
        mpyf3   r6, r6, r0
        mpyf3   r7, r7, r1
        addf    r1, r0
        call    m_sqrt
        ldf     1.0, r8
        subf    r0, r8
        mpyf    *+ar2(7), r8                    ; lateral
        absf    r8, r0
        cmpf    r9, r0
        bge     avoid_project_next
        ldf     r6, r0
        ldf     r7, r1
        call    m_atan2
        mpyf    *+ar2(7), r0
avoid_project_foot:
        absf    r8, r7
        cmpf    r9, r7
        bge     avoid_project_next
        cmpf    @K_AV_OVERLAP_LOW, r0
        blt     avoid_project_next
        ldf     *+ar2(5), r1
        addf    0.5, r1
        cmpf    r1, r0
        bgt     avoid_project_next
        addf    *+ar2(6), r0
        stf     r0, @AV_ALONG
        stf     r8, @AV_ACROSS
        sti     ar2, @AV_PIECE
        ldf     r7, r9
        ldi     1, ir0
avoid_project_next:
        addi    8, ar2
        dbu     ar4, avoid_project_piece
        ldi     ir0, r0
        rets
