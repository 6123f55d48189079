; What torque compensation and PID share: the set-point between two joint points, and the hoist ramp.

SV_HEAD         .set SCRATCH + 0        ; words 0 .. 0Bh of the area
SV_POINT_PERIOD .set SV_HEAD + CR_POINT_PERIOD
SV_SERVO_PERIOD .set SV_HEAD + CR_SERVO_PERIOD
SV_POINT_TICKS  .set SV_HEAD + CR_POINT_TICKS
SV_SERVO_TICKS  .set SV_HEAD + CR_SERVO_TICKS
SV_SPREADER     .set SV_HEAD + CR_SPREADER
SV_PAYLOAD      .set SV_HEAD + CR_PAYLOAD
SV_RAMP_START   .set SV_HEAD + CR_RAMP_START
SV_RAMP_TICKS   .set SV_HEAD + CR_RAMP_TICKS
SV_RAMP_BASE    .set SV_HEAD + CR_RAMP_BASE
SV_RAMP_DELTA   .set SV_HEAD + CR_RAMP_DELTA
SV_FROM         .set SCRATCH + 16       ; the joint points before and after the set-point
SV_TO           .set SCRATCH + 32
SV_RATE         .set SCRATCH + 48       ; refreshes per second

; HEAD <- the area's first words.
servo_head:
        ldi     ar6, ar0
        ldhi    hi16(SV_HEAD), ar1
        or      lo16(SV_HEAD), ar1
        ldi     CR_RAMP_DELTA, rc
        br      copy_words

; R0 = points consumed, c: the set-point moves from joint point c - 2 to c - 1. Point -1 is the pose at the start, which PID
; leaves in its place in the ring; with c = 0 it stands there. R0 <- ring index of the former, R1 <- of the latter.
servo_slots:
        ldi     r0, r1
        subi    1, r1
        and     3, r1
        subi    2, r0
        cmpi    -2, r0
        ldieq   3, r0
        and     3, r0
        rets

; R0 = refresh at which the segment began. R0 <- phase, 0 .. 1.
servo_phase:
        subri   @TASK + TB_TICK, r0
        float   r0, r3
        float   @SV_POINT_TICKS, r0
        call    m_reciprocal
        mpyf    r3, r0
        cmpf    0.0, r0
        ldflt   0.0, r0
        cmpf    1.0, r0
        ldfgt   1.0, r0
        rets

; The hoist ramp at TB_TICK: R0 <- m, R1 <- m/s, R2 <- m/s2, R4 <- 0 none commanded, 1 not ended, 2 ended; RATE <- refreshes per
; second. Clobbers R3, R5, R6.
servo_ramp:
        ldf     @SV_SERVO_PERIOD, r0
        call    m_reciprocal
        float   @SV_SERVO_TICKS, r1
        mpyf    r1, r0
        stf     r0, @SV_RATE
        ldi     0, r4
        ldi     @SV_RAMP_TICKS, r1
        beq     servo_ramp_none
        ldi     @TASK + TB_TICK, r6
        subi    @SV_RAMP_START, r6
        cmpi    0, r6
        ldilt   0, r6
        ldi     1, r4
        cmpi    r1, r6
        ldige   2, r4
        ldige   r1, r6
        float   r1, r0
        call    m_reciprocal
        ldf     r0, r5
        float   r6, r6
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
