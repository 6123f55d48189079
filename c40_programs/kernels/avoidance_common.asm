; What the three builds of obstacle avoidance share (docs/kernels.md, "Obstacle avoidance"): what the range sensor sees, as points along and
; across the lane ahead; and the decision, from the shift and the speed that a method wants to those that it gets.
;
; Frames: the vehicle's (x ahead, y left, origin in its middle) and the lane's (along: arc length of the leg, lateral: left of it).

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
AV_LATERAL      .set SCRATCH + 104      ; f m, and left of it
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
AV_CLOSE        .set SCRATCH + 120      ; f m, from the front to what stands in the way or close beside it
AV_PATH_COUNT   .set SCRATCH + 121      ; i pieces of the leg in AV_PATH
AV_TOTAL        .set SCRATCH + 122      ; f m, length of the leg
AV_PATH         .set SCRATCH + 128      ; pieces of 8 words: x0, y0, cos, sin of heading0, curvature, length, arc length at its start, 1/curvature
AV_COUNT        .set SCRATCH + 123      ; i AG_PRODUCED: the time, in points
AV_RATE         .set SCRATCH + 124      ; f 1/s, of the time since the look that is compared with; 0: there is none
AV_NEAR_FOUND   .set SCRATCH + 125      ; i points in AV_NEAR
AV_PIECE        .set SCRATCH + 126      ; i result of avoid_project: address of the piece
AV_WAIT         .set SCRATCH + 127      ; i AG_AVOID_WAIT
AV_PLACE        .set SCRATCH + 204      ; f m, AG_AVOID_PLACE
AV_FLANK        .set SCRATCH + 206      ; f m, AG_AVOID_BESIDE
AV_SEEN         .set SCRATCH + 205      ; f m, from the front to what blocks the way near it, straight on
AV_MINIMA       .set SCRATCH + 208      ; per sector: mm to the nearest echo less 1 (FFFFFFFFh: none), its ray
AV_POINTS       .set SCRATCH + 352      ; per echo AV_POINT_WORDS: range, x, y, along from the vehicle's middle, lateral, sector, swing
AV_POINT_WORDS  .set 7
AV_SECTORS_MOST .set 72
AV_NEAR         .set AV_MINIMA          ; i x16 addresses of points, once the minima have become points: the nearest of each four sectors
AV_NOW          .set AV_MINIMA              ; when the decision is made, this look: i AV_COUNT + 1, f x2 m along the leg of what blocks and of what is close, f x2 AV_BINS: lateral place nearest to the lane, left, right
AV_THEN         .set AV_NOW + AV_LOOK_WORDS  ; an earlier one
AV_BINS         .set 32                 ; of 1.5 m along the leg, modulo 48 m
AV_BLOCK        .set 1
AV_BESIDE       .set 2
AV_SIDES        .set 3
AV_LOOK_WORDS   .set AV_SIDES + 2 * AV_BINS
AV_BANK         .set 370h               ; four earlier looks are kept behind what a split task keeps: in each of its halves two, AV_BANK_WORDS apart
AV_BANK_WORDS   .set 48h
AV_RANGE        .set 0
AV_PX           .set 1
AV_PY           .set 2
AV_PALONG       .set 3
AV_PLATERAL     .set 4
AV_PSECTOR      .set 5                  ; i
AV_PSWING       .set 6                  ; f m by which the vehicle's ends swing out of a bend there, to the left if positive

        .if AG_WORDS != 100h | SV_WORDS != 800h
        .error "avoid_bank takes the place of an AGV's looks from that of its area by a shift"
        .endif

; R0 = number of sectors, 1 .. 72. Pose, lane and points; R0 <- 0 when there is no sensor.
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

; ---- PATH: the pieces of the leg from 15 m behind the vehicle to 45 m ahead, and a straight beyond the leg's end; S, LATERAL, LEFT ----
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
avoid_path_lost:                                ; more than K_AV_ACROSS beside its lane: taken to be on it
        ldf     0.0, r0
        stf     r0, @AV_LATERAL
avoid_path_left:
        ldf     @AV_TOTAL, r0
        subf    @AV_S, r0
        stf     r0, @AV_LEFT
        rets

; *AR2++ <- the piece that starts at R0, R1, heading R6, curvature R7, length R9, arc length R10; R11 += 1. Keeps R8 .. R10.
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

; ---- ALONG, ACROSS of the world point R10, R11: its foot on the nearest piece; R0 <- 1, or 0 if none is within K_AV_ACROSS ----
; On an arc, with u, v in the frame of its start: lateral = (1 - |(k u, 1 - k v)|) / k, along = atan2(k u, 1 - k v) / k. Keeps R10, R11, AR3, AR5.
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

; ---- POINTS, FOUND: the minima that stand within K_AV_ACROSS of the lane ahead ----
avoid_points:
        ldhi    hi16(AV_MINIMA), ar3
        or      lo16(AV_MINIMA), ar3
        ldhi    hi16(AV_POINTS), ar5
        or      lo16(AV_POINTS), ar5
        ldi     0, ar1                          ; sector
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
        cmpi    @AV_SECTORS, ar1
        blt     avoid_point
        rets

; R0 <- swing at the point just projected: half the vehicle's length squared / 2 times the curvature, to the outer side; before and behind a bend so much
; less as the square of the distance from it. Clobbers R1 .. R4, AR0.
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

; ---- NEAR, NEAR_FOUND: of each four sectors the nearest point within K_AV_STANDS of the lane, for methods that look at 16. Clobbers R0 .. R5 ----
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

; ---- the decision: AG_AVOID_LIMIT, AG_AVOID_SHIFT, AG_AVOID_HOLD from SHIFT and SPEED; R0, R1 as a kernel returns them ----
avoid_decide:
        call    avoid_beside
        call    avoid_side
        call    avoid_block
        call    avoid_keep
        call    avoid_motion
        br      avoid_speed

; FLANK <- how far along the leg something is beside the vehicle, where a shift has no room: to that side for the flank, to the other for the ends, which swing
; out. What is about to go out of view.
avoid_beside:
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

; SHIFT <- the shift wanted, or the present one while it must be held; HOLD. What stands so near to the leg's end that the vehicle would not be back
; in the lane behind it is not passed.
avoid_side:
        ldf     @AV_SHIFT, r6
        ldf     @K_AV_SHIFT_MOST, r1
        cmpf    r1, r6
        ldfgt   r1, r6
        negf    r1, r1
        cmpf    r1, r6
        ldflt   r1, r6
        ldf     @AV_HOLD, r7                    ; hold: until the rear is past what stands in the lane
        ldf     @K_AV_NO_LIMIT, r8              ; the nearest that can be passed
        ldf     r8, r9                          ; the nearest that cannot
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
        ble     avoid_hold_over                 ; it is not bound by what it passes already
        absf    @AV_SHIFT_OLD, r0
        absf    r6, r1
        cmpf    r0, r1
        ldflt   @AV_SHIFT_OLD, r6
        ldf     @AV_SHIFT_OLD, r0               ; nor is the side changed
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

; R6 <- the shift that passes the group of things that begins R8 ahead: R6, or as much more as it needs; to the other side, if this one is shut and that one is
; not; none if both are. R6 = 0 stays. Clobbers R0 .. R5, R11, AR1, AR2.
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
        addf    @K_AV_NEEDS, r1                 ; the vehicle's place when it passes this on its left
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
avoid_feasible_beside:                          ; it stands beside the lane: between it and the group must be room
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

; R3 <- how far ahead the last thing may stand that can be passed beside the lane, so that the vehicle is back in it for the leg's end.
avoid_home:
        ldf     @AV_LEFT, r3
        subf    @K_AV_HOME_STRAIGHT, r3
        subf    @K_AV_REAR, r3
        rets

; R1 <- lateral place of the way R8 ahead: shift + (now - shift) (1 - t)^2 (1 + 2 t), t = (R8 - 4 m) / 15 m: the front is there when the middle has gone
; 7.4 m less. Clobbers R0, R2.
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

; R0 <- how far the point AR1, R0 m to the left of the way, is from what the vehicle's middle sweeps: |R0|, less the swing on its side. Clobbers R1, R2.
avoid_gap:
        mpyf3   *+ar1(AV_PSWING), r0, r1
        absf    r0, r0
        cmpf    0.0, r1
        retsle
        absf    *+ar1(AV_PSWING), r2
        subf    r2, r0
        rets

; R0 <- how far the point AR1 is ahead of the front, along the lane or straight on, whichever is more: outside in a bend the lane's metres are longer.
avoid_ahead:
        ldf     *+ar1(AV_PALONG), r0
        cmpf    *+ar1(AV_PX), r0
        ldflt   *+ar1(AV_PX), r0
        subf    @AV_MOUNT, r0
        rets

; FREE, CLOSE: what blocks the way from the present lateral place to SHIFT, and back into the lane before the leg's end, and what stands close beside it. SEEN: on the
; inner side of a bend it goes out of view before it is as near as that along the lane; the vehicle must stand before.
avoid_block:
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

; R1 <- what stopping takes from the present speed: v T + v^2 / (2 B).
avoid_stopping:
        ldf     @AV_SPEED_NOW, r0
        ldf     r0, r1
        mpyf    @K_DW_HALF_OVER_B, r1
        addf    @K_AV_T, r1
        mpyf    r0, r1
        rets

; Where the way to another shift is blocked too near to stop, and that of the present one 0.5 m less, the present one is kept.
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

; ---- what moves: the lateral places of what stands beside the lane are compared with those of some 0.4 s ago (16 to 48 points). What comes nearer
; so fast that it would be in the way before the rear has passed blocks it now; what comes along the way shortens it by its way while the vehicle stops. ----
avoid_motion:
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
        ldf     r7, r0                          ; what comes along past the vehicle: let it pass
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

; NOW's word IR0 <- the place along the leg of what is R0 ahead of the front; R1 <- the speed at which it comes along, against THEN's, m/s; 0: unknown.
; Clobbers AR0.
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
        ldfgt   0.0, r1                         ; another thing than before
avoid_closing_keep:
        stf     r0, *+ar0(ir0)
        rets

; R0 <- how far what comes along at R1 m/s gets while the vehicle stops. Keeps R1.
avoid_meet:
        ldf     @AV_SPEED_NOW, r0
        mpyf    @K_AV_ONE_OVER_B, r0
        addf    @K_AV_T, r0
        mpyf    r1, r0
        rets

; WAIT, PLACE <- what comes at R1 m/s and needs R0 m to be out of the way, R2 ahead along the lane and soon beside the front, where it is not seen. Something
; nearer that is remembered already is kept. Keeps R1, R6 .. R11.
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

; The point AR1 into NOW; FREE is shortened if it would come into the way. Keeps AR1, AR2.
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
        subf    @K_AV_HALF, r0                  ; how far it is from the way
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
        ldf     r8, r0                          ; as far, and to the other side of the way
        addf    @K_AV_WAY, r0
        ldf     r7, r2
        br      avoid_remember

; R1 <- the speed at which the place R9 (bin R3, side R4) has come nearer since the look of three slots ago (0.6 to 1.3 s), longer than what the rim of a post that
; is driven past can feign; 0: unknown. Clobbers R0, R2, R5, R10, AR0, IR0.
avoid_older:
        ldi     @AV_COUNT, r0
        lsh     -4, r0
        subi    3, r0
        call    avoid_bank
        ldf     0.0, r1
        ldi     @AV_COUNT, r5
        addi    1, r5
        ldi     *ar0, r0
        retseq                                  ; nothing has been kept there
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

; R2 <- the place nearest to the lane that the look at AR0 has of bin R3 and its neighbours, on the side whose bins begin at R4. Clobbers IR0.
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

; AR0 <- where this AGV's look of slot R0 is kept. Clobbers R0, R1.
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
        ldflt   0.0, r0                         ; do not creep the last centimetres
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

; Nothing can be seen: as without avoidance.
avoid_nothing:
        ldi     0, r0
        sti     r0, *+ar6(AG_AVOID_WAIT)
        sti     r0, *+ar6(AG_AVOID_HOLD)
        sti     r0, *+ar6(AG_AVOID_SHIFT)
        sti     r0, *+ar6(AG_AVOID_LIMIT)
        ldi     0, r1
        rets
