; What torque compensation and PID share: the path's clock, the set-point between two joint points, and the hoist ramp.

SV_HEAD         .set SCRATCH + 0        ; words 0 .. 0Dh of the area
SV_POINT_PERIOD .set SV_HEAD + CR_POINT_PERIOD
SV_SERVO_PERIOD .set SV_HEAD + CR_SERVO_PERIOD
SV_POINT_TICKS  .set SV_HEAD + CR_POINT_TICKS
SV_SERVO_TICKS  .set SV_HEAD + CR_SERVO_TICKS
SV_SPREADER     .set SV_HEAD + CR_SPREADER
SV_LOAD         .set SV_HEAD + CR_LOAD
SV_RAMP_START   .set SV_HEAD + CR_RAMP_START
SV_RAMP_TICKS   .set SV_HEAD + CR_RAMP_TICKS
SV_RAMP_BASE    .set SV_HEAD + CR_RAMP_BASE
SV_RAMP_DELTA   .set SV_HEAD + CR_RAMP_DELTA
SV_STOPPED      .set SV_HEAD + CR_STOPPED
SV_SWAY_SENSOR  .set SV_HEAD + CR_SWAY_SENSOR
SV_FROM         .set SCRATCH + 16       ; the joint points before and after the set-point
SV_TO           .set SCRATCH + 32
SV_RATE         .set SCRATCH + 48       ; refreshes per second

SV_PATH_TICK    .set SCRATCH + 49       ; i what the path's clock shows at TB_TICK, whole refreshes
SV_PATH_PART    .set SCRATCH + 53       ; f and the fraction of a refresh
SV_PATH_RATE    .set SCRATCH + 54       ; f its rate, and the rate's change per refresh: where SV_STOPPED is not 0, as
SV_PATH_CHANGE  .set SCRATCH + 55
SV_DRIVES       .set SCRATCH + 110      ; i PATH_DRIVES

; HEAD <- the area's first words.
servo_head:
        ldi     ar6, ar0
        ldhi    hi16(SV_HEAD), ar1
        or      lo16(SV_HEAD), ar1
        ldi     CR_SWAY_SENSOR, rc
        br      copy_words

; The path's clock at TB_TICK. It shows the refresh number until the crane first stops on its path. Its rate changes
; from PATH_FROM to PATH_TO linearly, in PATH_TICKS refreshes from PATH_BEGIN. After servo_head. Clobbers R0 to R6, AR0.
servo_path:
        ldi     @TASK + TB_TICK, r0
        ldi     @SV_STOPPED, r1
        bnz     servo_path_slowed
        sti     r0, @SV_PATH_TICK
        ldf     0.0, r1
        stf     r1, @SV_PATH_PART
        rets
servo_path_slowed:
        ldi     ar6, ar0
        addi    CR_PATH, ar0
        ldi     *+ar0(PATH_DRIVES), r1
        sti     r1, @SV_DRIVES
        subi    *ar0, r0
        cmpi    0, r0
        ldilt   0, r0                           ; refreshes since the rate began to change
        ldi     *+ar0(PATH_TICKS), r1
        ldf     *+ar0(PATH_FROM), r2
        ldf     *+ar0(PATH_CHANGE), r3
        ldi     0, r4                           ; refreshes since the change ended
        cmpi    r1, r0
        blt     servo_path_changes
        subi3   r1, r0, r4
        ldi     r1, r0
servo_path_changes:
        float   r0, r0
        mpyf    r0, r3                          ; change of the rate so far
        ldf     r3, r5
        mpyf    0.5, r5
        addf    r2, r5
        mpyf    r0, r5                          ; mean rate times the time
        addf    r2, r3
        ldf     *+ar0(PATH_CHANGE), r6
        float   r4, r4
        mpyf3   *+ar0(PATH_TO), r4, r2
        addf    r2, r5
        cmpf    0.0, r4
        ble     servo_path_rate
        ldf     *+ar0(PATH_TO), r3
        ldf     0.0, r6
servo_path_rate:
        stf     r3, @SV_PATH_RATE
        stf     r6, @SV_PATH_CHANGE
        addf    *+ar0(PATH_PART), r5
        fix     r5, r0                          ; floor
        float   r0, r1
        subf    r1, r5
        stf     r5, @SV_PATH_PART
        addi    *+ar0(PATH_BASE), r0
        sti     r0, @SV_PATH_TICK
        rets

; R0 = points consumed, c: the set-point moves from joint point c - 2 to c - 1. Point -1 is the pose at the start; PID
; stores it in the ring. With c = 0 the set-point rests there. R0 <- ring index of the first point, R1 <- of the second.
servo_slots:
        ldi     r0, r1
        subi    1, r1
        and     3, r1
        subi    2, r0
        cmpi    -2, r0
        ldieq   3, r0
        and     3, r0
        rets

; R0 = refresh at which the segment began. R0 <- phase, 0 .. 1. After servo_path.
servo_phase:
        subri   @SV_PATH_TICK, r0
        float   r0, r3
        addf    @SV_PATH_PART, r3
        float   @SV_POINT_TICKS, r0
        call    m_reciprocal
        mpyf    r3, r0
        cmpf    0.0, r0
        ldflt   0.0, r0
        cmpf    1.0, r0
        ldfgt   1.0, r0
        rets

; The hoist ramp, by the path's clock: R0 <- m, R1 <- m/s, R2 <- m/s2, R4 <- 0 none commanded, 1 not ended, 2 ended;
; RATE <- refreshes per second. Clobbers R3, R5, R6.
servo_ramp:
        ldf     @SV_SERVO_PERIOD, r0
        call    m_reciprocal
        float   @SV_SERVO_TICKS, r1
        mpyf    r1, r0
        stf     r0, @SV_RATE
        ldi     0, r4
        ldi     @SV_RAMP_TICKS, r1
        beq     servo_ramp_none
        ldi     @SV_PATH_TICK, r6
        subi    @SV_RAMP_START, r6
        ldi     1, r4
        cmpi    r1, r6
        ldige   2, r4
        ldige   r1, r6
        float   r1, r0
        call    m_reciprocal
        ldf     r0, r5
        float   r6, r6
        addf    @SV_PATH_PART, r6
        cmpf    0.0, r6
        ldflt   0.0, r6
        mpyf    r6, r0                  ; u
        mpyf    @SV_RATE, r5            ; 1 / duration
        call    m_quintic
        mpyf    @SV_RAMP_DELTA, r0
        addf    @SV_RAMP_BASE, r0
        mpyf    r5, r1
        mpyf    @SV_RAMP_DELTA, r1
        mpyf    r5, r2
        mpyf    r5, r2
        mpyf    @SV_RAMP_DELTA, r2
        rets
servo_ramp_none:
        ldf     0.0, r0
        ldf     0.0, r1
        ldf     0.0, r2
        rets
