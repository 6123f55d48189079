; A survey of the obstacles around a vehicle, from the 180 rays of its range sensor: the nearest echo in each of 36
; sectors of five rays, and how far ahead the vehicle's way is free. The work is the same for every ray.
;
; Area of each task: its parameters, then its results.
SU_SENSOR       .set 0                  ; i offset of the range sensor on bus B
SU_PATIENCE     .set 1                  ; i looks at the other half's word before the first does it, too
SU_TICK         .set 8                  ; i the release (TB_TICK) that the results are of: written last
SU_FREE         .set 9                  ; i mm from the vehicle's centre to the first echo in its way, or RANGE_MOST
SU_SCAN         .set 10                 ; i number of the scan
SU_SECTOR       .set 16                 ; + k, k = 0..35, i mm to the nearest echo of rays 5 k to 5 k + 4, or RANGE_MOST
SU_SECTORS      .set 36
SU_HALF         .set 18
SU_RAYS         .set 5

SU_TABLE        .set SCRATCH            ; 36 words: as at SU_SECTOR
SU_NEAREST      .set SCRATCH + 36       ; f mm
SU_MOUNT        .set SCRATCH + 37       ; f mm
SU_SEEN         .set SCRATCH + 38       ; i number of the scan
SU_LEFT         .set SCRATCH + 39       ; i looks that are left

survey_units:   .float  1.0e-6          ; rad per microradian
                .float  1800.0          ; mm to either side: half a vehicle's width, and half a metre

; Before the first call of survey.
survey_begin:
        ldi     RANGE_MOST, r0
        float   r0, r0
        stf     r0, @SU_NEAREST
        rets

; R10 sectors from sector R9 on: into SU_TABLE, SU_NEAREST, SU_SEEN.
survey:
        ldhi    hi16(survey_units), ar0
        or      lo16(survey_units), ar0
        ldhi    hi16(WINDOW_B), ar5
        addi    *+ar6(SU_SENSOR), ar5
        ldi     *+ar5(RANGE_FIRST), r4
        ldi     *+ar5(RANGE_STEP), r11
        float   *+ar5(RANGE_MOUNT), r0
        ldi     *+ar5(RANGE_SCAN), r1
        stf     r0, @SU_MOUNT
        sti     r1, @SU_SEEN
        ldi     r9, r0
        mpyi    SU_RAYS, r0             ; the first ray
        ldi     ar5, ar4
        addi    RANGE_RAY, ar4
        addi    r0, ar4                 ; its place
        mpyi    r11, r0
        addi    r0, r4                  ; its direction, microradians
        ldhi    hi16(SU_TABLE), ar3
        or      lo16(SU_TABLE), ar3
        addi    r9, ar3
        ldi     r10, ar2
        subi    1, ar2
survey_sector:
        call    alive
        ldi     RANGE_MOST, r5
        ldi     SU_RAYS - 1, ar1
survey_ray:
        ldi     *ar4++, r6
        ldieq   RANGE_MOST, r6          ; no valid echo
        cmpi    r5, r6
        ldilt   r6, r5
        float   r4, r0
        mpyf    *ar0, r0
        call    m_sincos
        float   r6, r7
        mpyf    r7, r1
        addf    @SU_MOUNT, r1           ; ahead of the vehicle's centre, mm
        mpyf    r7, r0                  ; to its left
        absf    r0, r0
        cmpi    RANGE_MOST, r6
        bge     survey_next             ; nothing there
        cmpf    *+ar0(1), r0
        bgt     survey_next             ; beside its way
        cmpf    0.0, r1
        blt     survey_next             ; behind it
        cmpf    @SU_NEAREST, r1
        bge     survey_next
        stf     r1, @SU_NEAREST
survey_next:
        addi    r11, r4
        db      ar1, survey_ray
        sti     r5, *ar3++
        db      ar2, survey_sector
        rets

; Results into this task's area, R10 sectors from sector R9 on, the release last. R0 <- R8, R1 <- 0: what it returns.
survey_end:
        ldhi    hi16(SU_TABLE), ar0
        or      lo16(SU_TABLE), ar0
        addi    r9, ar0
        ldi     ar6, ar1
        addi    SU_SECTOR, ar1
        addi    r9, ar1
        ldi     r10, rc
        subi    1, rc
        call    copy_words
        fix     @SU_NEAREST, r0
        ldi     @SU_SEEN, r1
        ldi     @TASK + TB_TICK, r2
        sti     r0, *+ar6(SU_FREE)
        sti     r1, *+ar6(SU_SCAN)
        sti     r2, *+ar6(SU_TICK)
        ldi     r8, r0
        ldi     0, r1
        rets

; All of it on one DSP.
kernel_survey_whole:
        call    survey_begin
        ldi     0, r9
        ldi     SU_SECTORS, r10
        call    survey
        ldi     0, r8
        br      survey_end
