; Shared by the three builds of obstacle avoidance (docs/kernels_job.md, "Obstacle avoidance"). Here: the range sensor's
; echoes as points on the lane. avoidance_decide.asm: shift and speed allowed. avoidance_motion.asm: moving things.
;
; Frames: the vehicle's (x ahead, y left, origin in its middle) and the lane's (along: arc length of the leg, lateral:
; left of it).

        .if AGV_RANGE_WORDS != 8 * AGV_UNIT_WORDS
        .error "avoid_look takes the sensor's place from the unit's by a shift"
        .endif

AV_X            .set SCRATCH + 96       ; f pose and speed as measured, m, rad, m/s
AV_Y            .set SCRATCH + 97
AV_HEADING      .set SCRATCH + 98
AV_SPEED_NOW    .set SCRATCH + 99
AV_COS          .set SCRATCH + 100      ; f of the heading
AV_SIN          .set SCRATCH + 101
AV_MOUNT        .set SCRATCH + 102      ; f m, sensor ahead of the vehicle's middle
AV_S            .set SCRATCH + 103      ; f m, the vehicle's place along the leg
AV_LATERAL      .set SCRATCH + 104      ; f m left of the leg
AV_LEFT         .set SCRATCH + 105      ; f m, to the end of the leg
AV_SHIFT_OLD    .set SCRATCH + 106      ; f m, AG_AVOID_SHIFT before
AV_HOLD         .set SCRATCH + 107      ; f m, AG_AVOID_HOLD
AV_SECTORS      .set SCRATCH + 108      ; i
AV_FIRST        .set SCRATCH + 109      ; f rad, direction of ray 0; AV_STEP follows: between two rays
AV_STEP         .set SCRATCH + 110
AV_RAYS         .set SCRATCH + 111      ; i
AV_FOUND        .set SCRATCH + 112      ; i points
AV_SHIFT        .set SCRATCH + 113      ; f m, what the method wants: lateral shift, speed limit
AV_SPEED        .set SCRATCH + 114
AV_FREE         .set SCRATCH + 115      ; f m, from the front to what blocks the way
AV_ALONG        .set SCRATCH + 116      ; f result of avoid_project, AV_ACROSS too
AV_ACROSS       .set SCRATCH + 117
AV_TARGET       .set SCRATCH + 118      ; f x2 a point of the lane ahead in the vehicle's frame
AV_CLOSE        .set SCRATCH + 120      ; f m, from the front to what blocks the way or stands close beside it
AV_PATH_COUNT   .set SCRATCH + 121      ; i pieces of the leg in AV_PATH
AV_TOTAL        .set SCRATCH + 122      ; f m, length of the leg
AV_PATH         .set SCRATCH + 128      ; pieces of 8 words: x0, y0, cos, sin of heading0, curvature, length, arc length
                                        ; at its start, 1/curvature
AV_COUNT        .set SCRATCH + 123      ; i AG_PRODUCED: the time, in points
AV_RATE         .set SCRATCH + 124      ; f 1/s, of the time since the look that is compared with; 0: there is none
AV_NEAR_FOUND   .set SCRATCH + 125      ; i points in AV_NEAR
AV_PIECE        .set SCRATCH + 126      ; i result of avoid_project: address of the piece
AV_WAIT         .set SCRATCH + 127      ; i AG_AVOID_WAIT
AV_PLACE        .set SCRATCH + 204      ; f m, AG_AVOID_PLACE
AV_FLANK        .set SCRATCH + 206      ; f m, AG_AVOID_BESIDE
AV_SEEN         .set SCRATCH + 205      ; f m, from the front to what blocks the way near the front, straight ahead
AV_MINIMA       .set SCRATCH + 208      ; per sector: mm to the nearest echo less 1 (FFFFFFFFh: none), its ray
AV_POINTS       .set SCRATCH + 352      ; per echo AV_POINT_WORDS: range, x, y, along from the vehicle's middle,
                                        ; lateral, sector, swing
AV_POINT_WORDS  .set 7
AV_SECTORS_MOST .set 72
AV_NEAR         .set AV_MINIMA          ; i x16 addresses of points, once the minima have become points: the nearest of
                                        ; each four sectors
AV_NOW          .set AV_MINIMA              ; when the decision is made, this look: i AV_COUNT + 1, f x2 m along the leg
                                            ; of the blocking and the close thing, f x2 AV_BINS: lateral place nearest
                                            ; to the lane, left, right
AV_THEN         .set AV_NOW + AV_LOOK_WORDS  ; an earlier one
AV_BINS         .set 32                 ; of 1.5 m along the leg, modulo 48 m
AV_BLOCK        .set 1
AV_BESIDE       .set 2
AV_SIDES        .set 3
AV_LOOK_WORDS   .set AV_SIDES + 2 * AV_BINS
AV_BANK         .set 370h               ; four earlier looks, behind the words of a split task: two per half,
                                        ; AV_BANK_WORDS apart
AV_BANK_WORDS   .set 48h
AV_RANGE        .set 0
AV_PX           .set 1
AV_PY           .set 2
AV_PALONG       .set 3
AV_PLATERAL     .set 4
AV_PSECTOR      .set 5                  ; i
AV_PSWING       .set 6                  ; f m by which the vehicle's ends swing out of a bend, positive left

        .if AG_WORDS != 100h | SV_WORDS != 800h
        .error "avoid_bank takes the place of an AGV's looks from that of its area by a shift"
        .endif

; R0 = number of sectors, 1 .. 72. Makes pose, lane and points; R0 <- 0 when there is no sensor.
avoid_look:
        sti     r0, @AV_SECTORS
        ldhi    hi16(WINDOW_B), ar5
        addi    *+ar6(AG_UNIT), ar5
        float   *+ar5(AGV_X), r0
        mpyf    @K_MILLI, r0
        stf     r0, @AV_X
        float   *+ar5(AGV_Y), r0
        mpyf    @K_MILLI, r0
        stf     r0, @AV_Y
        float   *+ar5(AGV_HEADING), r0
        mpyf    @K_MICRO, r0
        stf     r0, @AV_HEADING
        call    m_sincos
        stf     r0, @AV_SIN
        stf     r1, @AV_COS
        float   *+ar5(AGV_SPEED), r0
        mpyf    @K_MILLI, r0
        stf     r0, @AV_SPEED_NOW
        float   *+ar6(AG_AVOID_SHIFT), r0
        mpyf    @K_MILLI, r0
        stf     r0, @AV_SHIFT_OLD
        float   *+ar6(AG_AVOID_HOLD), r0
        mpyf    @K_MILLI, r0
        stf     r0, @AV_HOLD
        ldi     *+ar6(AG_AVOID_WAIT), r0
        sti     r0, @AV_WAIT
        float   *+ar6(AG_AVOID_PLACE), r0
        mpyf    @K_MILLI, r0
        stf     r0, @AV_PLACE
        ldi     *+ar6(AG_PRODUCED), r0
        sti     r0, @AV_COUNT
        ldf     @K_AV_NO_LIMIT, r0
        stf     r0, @AV_SPEED
        ldf     0.0, r0
        stf     r0, @AV_SHIFT
        ldi     0, r0
        sti     r0, @AV_FOUND

        ldi     *+ar6(AG_LEG), r6
        call    trajectory_agv_load
        ldi     @TA_COUNT, r0
        callz   avoid_no_leg
        call    avoid_path

        ldi     *+ar6(AG_UNIT), r0              ; the sensor of this unit
        subi    AGV_UNIT, r0
        lsh     3, r0
        addi    AGV_RANGE, r0
        ldhi    hi16(WINDOW_B), ar5
        addi    r0, ar5
        ldi     *+ar5(RANGE_COUNT), r0
        cmpi    RANGE_RAYS, r0
        ldigt   RANGE_RAYS, r0
        sti     r0, @AV_RAYS
        cmpi    0, r0
        ble     avoid_blind
        float   *+ar5(RANGE_FIRST), r0
        mpyf    @K_MICRO, r0
        stf     r0, @AV_FIRST
        float   *+ar5(RANGE_STEP), r0
        mpyf    @K_MICRO, r0
        stf     r0, @AV_STEP
        float   *+ar5(RANGE_MOUNT), r0
        mpyf    @K_MILLI, r0
        stf     r0, @AV_MOUNT
        call    avoid_minima
        call    avoid_points
        ldi     1, r0
        rets

; No leg: the lane is straight ahead.
avoid_no_leg:
        ldf     @AV_X, r0
        stf     r0, @TA_SEGMENTS + TA_SEGMENT_X
        ldf     @AV_Y, r0
        stf     r0, @TA_SEGMENTS + TA_SEGMENT_Y
        ldf     @AV_HEADING, r0
        stf     r0, @TA_SEGMENTS + TA_SEGMENT_HEADING
        ldf     0.0, r0
        stf     r0, @TA_SEGMENTS + TA_SEGMENT_LENGTH
        stf     r0, @TA_SEGMENTS + TA_SEGMENT_CURVE
        ldi     1, r0
        sti     r0, @TA_COUNT
        rets
avoid_blind:
        ldi     0, r0
        rets

; ---- MINIMA: the nearest valid echo of each sector; ray boundaries are k * rays / sectors, floored ----
avoid_minima:
        call    alive
        float   @AV_SECTORS, r0
        call    m_reciprocal
        float   @AV_RAYS, r1
        mpyf    r1, r0
        mpyf    @K_AV_FRACTION, r0
        addf    0.5, r0
        fix     r0, r6                          ; rays per sector, 16 bits behind the point
        addi    RANGE_RAY, ar5
        ldhi    hi16(AV_MINIMA), ar1
        or      lo16(AV_MINIMA), ar1
        ldi     @AV_SECTORS, ar2
        subi    1, ar2
        ldi     0, r5                           ; ray at which the sector begins, 16 bits behind the point
        ldi     0, r4                           ; the same, whole
avoid_sector:
        addi    r6, r5
        ldi     r5, r7
        lsh     -16, r7                         ; where the next one begins
        ldi     -1, r1                          ; nothing yet
        ldi     0, r2
        ldi     r7, rc
        subi    r4, rc
        subi    1, rc
        cmpi    0, rc
        blt     avoid_sector_done               ; more sectors than rays: an empty one
        rptb    avoid_ray
        ldi     *ar5++, r0
        subi    1, r0                           ; no valid echo (0) becomes the farthest
        cmpi    r1, r0
        ldilo   rc, r2
avoid_ray:
        ldilo   r0, r1
        ldi     r7, r0
        subi    1, r0
        subi    r2, r0                          ; RC counts down to the last ray
        ldi     r0, r2
        ldi     RANGE_MOST - 1, r0
        cmpi    r0, r1
        ldihs   -1, r1                          ; nothing within reach
avoid_sector_done:
        sti     r1, *ar1++
        sti     r2, *ar1++
        ldi     r7, r4
        dbu     ar2, avoid_sector
        rets

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

; ---- POINTS, FOUND: the minima within K_AV_ACROSS of the lane ahead ----
avoid_points:
        ldhi    hi16(AV_MINIMA), ar3
        or      lo16(AV_MINIMA), ar3
        ldhi    hi16(AV_POINTS), ar5
        or      lo16(AV_POINTS), ar5
        ldi     0, ar1                          ; sector
avoid_points_some:
        call    alive
        ldi     ar1, ir1
        addi    8, ir1
        cmpi    @AV_SECTORS, ir1
        ldigt   @AV_SECTORS, ir1
avoid_point:
        ldi     *ar3, r0
        cmpi    -1, r0
        beq     avoid_point_next
        addi    1, r0
        float   r0, r6
        mpyf    @K_MILLI, r6
        stf     r6, *+ar5(AV_RANGE)
        float   *+ar3(1), r0
        mpyf    @AV_STEP, r0
        addf    @AV_FIRST, r0
        call    m_sincos
        mpyf    r6, r1
        addf    @AV_MOUNT, r1                   ; x
        mpyf    r6, r0                          ; y
        stf     r1, *+ar5(AV_PX)
        stf     r0, *+ar5(AV_PY)
        ldf     r1, r10
        mpyf    @AV_COS, r10
        ldf     r0, r2
        mpyf    @AV_SIN, r2
        subf    r2, r10
        addf    @AV_X, r10
        ldf     r1, r11
        mpyf    @AV_SIN, r11
        mpyf    @AV_COS, r0
        addf    r0, r11
        addf    @AV_Y, r11
        call    avoid_project
        cmpi    0, r0
        beq     avoid_point_next
        ldf     @AV_ALONG, r0
        subf    @AV_S, r0
        stf     r0, *+ar5(AV_PALONG)
        ldf     @AV_ACROSS, r0
        stf     r0, *+ar5(AV_PLATERAL)
        sti     ar1, *+ar5(AV_PSECTOR)
        call    avoid_swing
        stf     r0, *+ar5(AV_PSWING)
        addi    AV_POINT_WORDS, ar5
        ldi     @AV_FOUND, r0
        addi    1, r0
        sti     r0, @AV_FOUND
avoid_point_next:
        addi    2, ar3
        addi    1, ar1
        cmpi    ir1, ar1
        blt     avoid_point
        cmpi    @AV_SECTORS, ar1
        blt     avoid_points_some
        rets

; R0 <- swing at the projected point: half the vehicle's length squared / 2 times the curvature, to the outer side;
; before and behind a bend less, by the square of the distance from the bend. Clobbers R1 .. R4, AR0.
avoid_swing:
        ldi     @AV_PIECE, ar0
        ldf     *+ar0(4), r0
        bz      avoid_swing_straight
        mpyf    @K_AV_SWING, r0
        rets
avoid_swing_straight:
        ldf     @AV_ALONG, r1
        subf    *+ar0(6), r1                    ; behind the piece before
        ldf     *+ar0(5), r2
        subf    r1, r2                          ; before the next
        ldf     0.0, r0
        ldhi    hi16(AV_PATH), ar4
        or      lo16(AV_PATH), ar4
        ldi     ar0, r3
        subi    ar4, r3
        bz      avoid_swing_next                ; the first piece
        subi    8, ar0
        ldf     *+ar0(4), r4
        call    avoid_swing_end
        addi    8, ar0
        ldi     ar0, r3
        subi    ar4, r3
avoid_swing_next:
        lsh     -3, r3
        addi    1, r3
        cmpi    @AV_PATH_COUNT, r3
        retsge                                  ; the last
        addi    8, ar0
        ldf     *+ar0(4), r4
        ldf     r2, r1
; R0 += the swing R1 metres from a bend of curvature R4.
avoid_swing_end:
        subrf   @K_AV_HALF_LENGTH, r1
        retslt
        cmpf    @K_AV_HALF_LENGTH, r1
        ldfgt   @K_AV_HALF_LENGTH, r1
        mpyf    r1, r1
        mpyf    -0.5, r1
        mpyf    r4, r1
        addf    r1, r0
        rets

; ---- TARGET: the lane's point R8 metres ahead of the vehicle's middle, in the vehicle's frame ----
avoid_target:
        addf    @AV_S, r8
        ldf     0.0, r9                         ; beyond the leg's end
        ldf     @AV_TOTAL, r0
        cmpf    r0, r8
        ble     avoid_target_within
        ldf     r8, r9
        subf    r0, r9
        ldf     r0, r8
avoid_target_within:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(TA_SEGMENTS), ar1
        ldi     @TA_COUNT, ar2
        ldf     0.0, r10
        call    trajectory_agv_find             ; TA_POINT
        ldf     @TA_POINT + 2, r0
        call    m_sincos
        mpyf    r9, r1
        addf    @TA_POINT, r1
        subf    @AV_X, r1
        mpyf    r9, r0
        addf    @TA_POINT + 1, r0
        subf    @AV_Y, r0
        ldf     r1, r2
        mpyf    @AV_COS, r2
        ldf     r0, r3
        mpyf    @AV_SIN, r3
        addf    r3, r2
        stf     r2, @AV_TARGET
        mpyf    @AV_COS, r0
        mpyf    @AV_SIN, r1
        subf    r1, r0
        stf     r0, @AV_TARGET + 1
        rets

; ---- NEAR, NEAR_FOUND: of each four sectors the nearest point within K_AV_STANDS of the lane, for methods that look at
; 16. Clobbers R0 .. R5 ----
avoid_nearest:
        ldhi    hi16(AV_POINTS), ar1
        or      lo16(AV_POINTS), ar1
        ldhi    hi16(AV_NEAR), ar0
        or      lo16(AV_NEAR), ar0
        subi    1, ar0
        ldi     -1, r4                          ; the four sectors of the last one
        ldi     0, r5
        ldi     @AV_FOUND, ar2
        br      avoid_nearest_next
avoid_nearest_point:
        absf    *+ar1(AV_PLATERAL), r0
        cmpf    @K_AV_STANDS, r0
        bge     avoid_nearest_after
        ldi     *+ar1(AV_PSECTOR), r3
        lsh     -2, r3
        ldf     *+ar1(AV_RANGE), r0
        cmpi    r4, r3
        beq     avoid_nearest_same
        ldi     r3, r4
        addi    1, r5
        addi    1, ar0
        br      avoid_nearest_take
avoid_nearest_same:
        cmpf    r2, r0
        bge     avoid_nearest_after
avoid_nearest_take:
        ldf     r0, r2
        sti     ar1, *ar0
avoid_nearest_after:
        addi    AV_POINT_WORDS, ar1
avoid_nearest_next:
        subi    1, ar2
        cmpi    0, ar2
        bge     avoid_nearest_point
        sti     r5, @AV_NEAR_FOUND
        rets
