; Shared by the three builds of obstacle avoidance (docs/kernels_job.md, "Obstacle avoidance"). Here: the range sensor's
; echoes, the nearest of each sector. avoidance_lane.asm: the lane, and points in its frame. avoidance_points.asm: the
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
AV_SECTORS_MOST .set 72
AV_MINIMA       .set SCRATCH + 208      ; per sector: mm to the nearest echo less 1 (FFFFFFFFh: none), its ray
AV_POINTS       .set AV_MINIMA + 2 * AV_SECTORS_MOST
                                        ; per echo AV_POINT_WORDS: range, x, y, along from the vehicle's middle,
                                        ; lateral, sector, swing
AV_POINT_WORDS  .set 7
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
