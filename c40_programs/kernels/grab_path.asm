; Process 2: the grab path, and the planner that homing shares (docs/kernels_job.md). In this file: the routes, the grown
; boxes, the plan. grab_path_boxes.asm: tests of a way against the boxes. grab_path_band.asm: the elastic band.
; grab_path_list.asm: the list of points.
;
; Route 1 leads from the crane's last commanded pose to CR_CLEARANCE above the target. Route 2 leads from there, with
; the container, to CR_CLEARANCE above the deck of the highest AGV in the loading spot, present or not (process 4 aligns
; the load). Route 3 leads home. A no-go box grows by half the load's extent and a margin, and upwards. No way leads below it.
;
; 1. The end over the bay gets a column: a point straight above it, raised in steps while the way from the column to the
;    other end is blocked.
; 2. If the way stays blocked, each box that blocks the straight way gets the face with the cheapest exit: the face with
;    the least depth behind it along the way; the upper face if an end is in the box. An elastic band of 5 via points is
;    pulled tight around those faces: it minimises the sum of |p_(i+1) - p_i|^2 outside the boxes by projected
;    Gauss-Seidel. Each of the GP_SWEEPS sweeps sets p_i := (p_(i-1) + p_(i+1))/2. Then, for the two steps beside p_i
;    and each box, the middle of the part inside is moved out, and p_i with it. The last GP_PUSHES sweeps only move
;    points out.
; 3. Via points are left out if the straight way without them is free.
; 4. If a step of the band is still blocked (the boxes leave no way between them), the route goes straight up, over
;    everything between the ends, and straight down.

GP_BOXES            .set SCRATCH                ; grown boxes, 8 words each: xmin, xmax, ymin, ymax, top, face (i, -1:
                                                ; any); up to BOXES_MAX + 1
GP_BOX_COUNT        .set SCRATCH + 72           ; i
GP_POINT            .set SCRATCH + 80           ; p_0 .. p_6: x, y, z, yaw
GP_START            .set SCRATCH + 108          ; x, y, z, yaw
GP_END              .set SCRATCH + 112
GP_OUT              .set SCRATCH + 116          ; up to 8 points
GP_OUT_COUNT        .set SCRATCH + 148          ; i
GP_HANG             .set SCRATCH + 149          ; m below the spreader's underside
GP_LIFT             .set SCRATCH + 150          ; m, height of the column
GP_LIFT_LEAST       .set SCRATCH + 151          ; m
GP_COLUMN           .set SCRATCH + 152          ; i, 0: over the start, 4: over the end
GP_SWEEP            .set SCRATCH + 153          ; i
GP_INDEX            .set SCRATCH + 154          ; i
GP_NEAR             .set SCRATCH + 164          ; depths behind the five faces at the beginning of a way,
GP_FAR              .set SCRATCH + 169          ; and at its end
GP_FROM             .set SCRATCH + 160          ; i
GP_TO               .set SCRATCH + 161          ; i
GP_FIRST_COUNT      .set SCRATCH + 162          ; i
GP_RISES            .set 8                      ; most times that the column is raised
GP_SWEEPS           .set 40
GP_PUSHES           .set 12
GP_INNER            .set 5                      ; via points of the band
GP_LAST             .set GP_INNER + 1
GP_FACE             .set 5                      ; in a grown box
GP_FACES            .set 5
GP_OVER             .set 4                      ; the face upwards

grab_path_first .macro                          ; ---- route 1: the empty spreader
        ldf     0.0, r0
        stf     r0, @GP_HANG
        call    grab_path_present
        ldf     *+ar6(CR_TARGET), r0
        stf     r0, @GP_END
        ldf     *+ar6(CR_TARGET + 1), r0
        stf     r0, @GP_END + 1
        ldf     *+ar6(CR_TARGET + 2), r0
        addf    *+ar6(CR_CLEARANCE), r0
        stf     r0, @GP_END + 2
        ldf     *+ar6(CR_TARGET + 3), r0
        stf     r0, @GP_END + 3
        call    grab_path_grow
        ldi     4, r0
        sti     r0, @GP_COLUMN
        ldf     0.0, r0
        stf     r0, @GP_LIFT_LEAST
        call    grab_path_plan
        ldi     1, r6
        call    grab_path_store
        ldi     @GP_OUT_COUNT, r0
        sti     r0, @GP_FIRST_COUNT
        .endm

kernel_grab_path:
        grab_path_first
grab_path_second:                               ; ---- route 2: the container hangs below
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_END), ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_START), ar1
        ldi     3, rc
        call    copy_words
        ldf     *+ar6(CR_BOX_HEIGHT), r0
        stf     r0, @GP_HANG
        call    grab_path_spot
        call    grab_path_grow
        ldi     0, r0
        sti     r0, @GP_COLUMN
        call    grab_path_clear
        call    grab_path_plan
        ldi     2, r6
        call    grab_path_store
        ldi     @GP_OUT_COUNT, r0
        addi    @GP_FIRST_COUNT, r0
        ldhi    8, r1                           ; MAY_PROCESS << 3
        rets

; ---- GP_START: the crane's last commanded pose; home before the first command ----
grab_path_present:
        ldi     ar6, ar0
        addi    CR_HOME, ar0
        ldi     *+ar6(CR_PRODUCED), r0
        bz      grab_path_present_at
        subi    1, r0
        and     1, r0
        lsh     4, r0
        addi3   r0, ar6, ar0
        addi    CR_POINT, ar0
grab_path_present_at:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_START), ar1
        ldi     3, rc
        call    copy_words
        rets

; ---- GP_END: above the loading spot, where the hanging container clears the deck of the highest AGV ----
grab_path_spot:
        ldi     ar6, ar0
        addi    CR_SPOT, ar0
        ldf     *ar0, r0
        stf     r0, @GP_END
        ldf     *+ar0(1), r0
        stf     r0, @GP_END + 1
        ldf     *+ar0(2), r0
        ldf     @GP_START + 3, r1
        call    trajectory_crane_half_turn
        rnd     r0
        stf     r0, @GP_END + 3
        ldf     *+ar6(CR_AGV_DECK), r0
        addf    *+ar6(CR_BOX_HEIGHT), r0
        addf    *+ar6(CR_CLEARANCE), r0
        rnd     r0
        stf     r0, @GP_END + 2
        rets

; ---- GP_LIFT_LEAST: from the start to where the hanging load clears everything in the bay ----
grab_path_clear:
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_BOXES), ar0
        ldf     0.0, r0
        ldi     @GP_BOX_COUNT, r1               ; the bay is the last box
        bz      grab_path_clear_done
        subi    1, r1
        lsh     3, r1
        addi    r1, ar0
        ldf     *+ar0(4), r0
        subf    @GP_START + 2, r0
        ldf     0.0, r1
        cmpf    r1, r0
        ldflt   r1, r0
grab_path_clear_done:
        stf     r0, @GP_LIFT_LEAST
        rets

; ---- the no-go boxes and the bay, grown for a load of GP_HANG at the yaw of GP_END ----
; A box at yaw c, s has half extents (6.096 |c| + 1.219 |s|, 6.096 |s| + 1.219 |c|).
grab_path_grow:
        ldf     @GP_END + 3, r0
        call    m_sincos
        absf    r0
        absf    r1
        ldf     @K_GP_HALF_LENGTH, r2
        ldf     @K_GP_HALF_WIDTH, r3
        mpyf3   r2, r1, r6
        mpyf3   r3, r0, r4
        addf    r4, r6
        addf    @K_GP_MARGIN, r6                ; along x
        mpyf3   r2, r0, r7
        mpyf3   r3, r1, r4
        addf    r4, r7
        addf    @K_GP_MARGIN, r7                ; along y
        ldf     @GP_HANG, r8
        addf    @K_GP_MARGIN, r8                ; upwards
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_BOXES), ar1
        ldi     0, r9
        ldi     ar6, ar0
        addi    CR_BOX, ar0
        ldi     *-ar0(CR_BOX - CR_BOX_COUNT), r10
        ldi     BOXES_MAX, r0
        cmpi    r0, r10
        ldigt   r0, r10
        cmpi    0, r10
        ble     grab_path_bay
grab_path_grow_next:
        call    grab_path_grow_one
        addi    6, ar0
        subi    1, r10
        bnz     grab_path_grow_next
grab_path_bay:
        ldi     ar6, ar0
        addi    CR_BAY, ar0
        call    grab_path_grow_one
        sti     r9, @GP_BOX_COUNT
        rets

grab_path_grow_one:                                     ; *AR0 (6 words) to *AR1 (8 words), R9 counts
        ldf     *ar0, r0
        subf    r6, r0
        stf     r0, *ar1
        ldf     *+ar0(1), r0
        addf    r6, r0
        stf     r0, *+ar1(1)
        ldf     *+ar0(2), r0
        subf    r7, r0
        stf     r0, *+ar1(2)
        ldf     *+ar0(3), r0
        addf    r7, r0
        stf     r0, *+ar1(3)
        ldf     *+ar0(5), r0
        addf    r8, r0
        stf     r0, *+ar1(4)
        addi    8, ar1
        addi    1, r9
        rets

; ---- GP_OUT: the way from GP_START to GP_END ----
grab_path_plan:
        ldi     0, r0
        sti     r0, @GP_OUT_COUNT
        ldf     @GP_LIFT_LEAST, r0
        stf     r0, @GP_LIFT
        ldi     GP_RISES, r0
        sti     r0, @GP_SWEEP
grab_path_raise:
        call    grab_path_ends
        ldi     0, r6
        ldi     GP_LAST, r7
        call    grab_path_blocked
        cmpi    0, r0
        bz      grab_path_straight
        ldf     @GP_LIFT, r0
        addf    @K_GP_RISE, r0
        stf     r0, @GP_LIFT
        ldi     @GP_SWEEP, r0
        subi    1, r0
        sti     r0, @GP_SWEEP
        bnn     grab_path_raise

        ldf     @GP_LIFT_LEAST, r0              ; no column is high enough
        stf     r0, @GP_LIFT
        call    grab_path_ends
        call    grab_path_band
        call    grab_path_column_start
        call    grab_path_shorten
        cmpi    0, r0
        bnz     grab_path_over
        br      grab_path_column_end
grab_path_straight:
        call    grab_path_column_start
        ldi     GP_LAST, r6
        call    grab_path_emit
        br      grab_path_column_end

; the column's point itself: over the start it comes first; over the end it is the last point before the end
grab_path_column_start:
        ldi     @GP_COLUMN, r0
        bnz     grab_path_column_none
        ldf     @GP_LIFT, r0
        bz      grab_path_column_none
        ldi     0, r6
        call    grab_path_emit
grab_path_column_none:
        rets
grab_path_column_end:
        ldi     @GP_COLUMN, r0
        bz      grab_path_column_none
        ldf     @GP_LIFT, r0
        bz      grab_path_column_none
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_END), ar0
        br      grab_path_emit_at

; ---- p_0 and p_6, one of them raised by GP_LIFT ----
grab_path_ends:
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_START), ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_POINT), ar1
        ldi     3, rc
        call    copy_words
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_END), ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_POINT + 4 * GP_LAST), ar1
        ldi     3, rc
        call    copy_words
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_POINT), ar0
        ldi     @GP_COLUMN, r0
        bz      grab_path_ends_raise
        addi    4 * GP_LAST, ar0
grab_path_ends_raise:
        ldf     *+ar0(2), r0
        addf    @GP_LIFT, r0
        rnd     r0
        stf     r0, *+ar0(2)
        rets

; ---- point R6 to the list ----
grab_path_emit:
        ldhi    hi16(SCRATCH), ar0
        or      lo16(GP_POINT), ar0
        lsh     2, r6
        addi    r6, ar0
grab_path_emit_at:
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_OUT), ar1
        ldi     @GP_OUT_COUNT, r0
        lsh     2, r0
        addi    r0, ar1
        ldi     3, rc
        call    copy_words
        ldi     @GP_OUT_COUNT, r0
        addi    1, r0
        sti     r0, @GP_OUT_COUNT
        rets
