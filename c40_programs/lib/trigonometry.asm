; Sine and cosine, arc tangent, hyperbolic tangent, wrapping of angles.

; R0 <- sin R0, R1 <- cos R0. x = k pi/2 + y with |y| <= pi/4. Taylor series of degree 9 (sine) and 10 (cosine).
; Errors: truncation (pi/4)^11/11! = 1.8e-9 and (pi/4)^12/12! = 1.1e-10; coefficients rounded to 24 bits, 5e-9.
m_sincos:
        ldf     @K_TWO_OVER_PI, r1
        mpyf    r0, r1
        addf    0.5, r1
        fix     r1, r2                  ; k
        float   r2, r1
        ldf     @K_HALF_PI, r3          ; pi/2 in two parts
        mpyf    r1, r3
        subf    r3, r0
        ldf     @K_HALF_PI_LOW, r3
        mpyf    r1, r3
        subf    r3, r0                  ; y
        mpyf3   r0, r0, r1              ; y^2
        ldf     @K_SIN9, r3
        mpyf    r1, r3
        addf    @K_SIN7, r3
        mpyf    r1, r3
        addf    @K_SIN5, r3
        mpyf    r1, r3
        addf    @K_SIN3, r3
        mpyf    r1, r3
        mpyf    r0, r3
        addf    r3, r0                  ; sin y
        ldf     @K_COS10, r3
        mpyf    r1, r3
        addf    @K_COS8, r3
        mpyf    r1, r3
        addf    @K_COS6, r3
        mpyf    r1, r3
        addf    @K_COS4, r3
        mpyf    r1, r3
        subf    0.5, r3
        mpyf    r3, r1
        addf    1.0, r1                 ; cos y
        tstb    1, r2
        beq     m_sincos_even
        ldf     r0, r3                  ; sin (y + pi/2) = cos y, cos (y + pi/2) = -sin y
        ldf     r1, r0
        negf    r3, r1
m_sincos_even:
        tstb    2, r2
        retseq
        negf    r0, r0
        negf    r1, r1
        rets

; R0 <- atan R0
m_atan:
        ldf     1.0, r1

; R0 <- atan2(y = R0, x = R1): arc tangent of the smaller of |x| and |y| divided by the larger, then the octant.
m_atan2:
        ldf     r0, r4
        ldf     r1, r5
        absf    r0, r0
        absf    r1, r1
        cmpf    r1, r0
        bgt     m_atan2_steep
        cmpf    0.0, r1
        beq     m_atan2_origin
        ldf     r0, r3
        ldf     r1, r0
        call    m_reciprocal
        mpyf    r3, r0
        call    m_atan_unit
        br      m_atan2_left
m_atan2_steep:
        ldf     r1, r3
        call    m_reciprocal
        mpyf    r3, r0
        call    m_atan_unit
        subrf   @K_HALF_PI, r0
        addf    @K_HALF_PI_LOW, r0
m_atan2_left:
        cmpf    0.0, r5
        bge     m_atan2_below
        subrf   @K_PI, r0
        addf    @K_PI_LOW, r0
m_atan2_below:
        cmpf    0.0, r4
        retsge
        negf    r0, r0
        rets
m_atan2_origin:
        ldf     0.0, r0
        rets

; R0 <- atan R0 for 0 <= R0 <= 1. Above tan(pi/8): atan t = pi/4 + atan((t - 1)/(t + 1)). Below: atan t = t + t z P(z)
; with z = t^2. P is fitted on 0 to tan^2(pi/8); the error with rounded coefficients is 1e-9. Changes R1, R2, R3.
m_atan_unit:
        ldf     0.0, r3
        cmpf    @K_TAN_PI_8, r0
        ble     m_atan_small
        ldf     r0, r3
        subf    1.0, r3
        addf    1.0, r0
        call    m_reciprocal
        mpyf    r3, r0
        ldf     @K_QUARTER_PI, r3
        addf    @K_QUARTER_PI_LOW, r3
m_atan_small:
        mpyf3   r0, r0, r1
        ldf     @K_ATAN5, r2
        mpyf    r1, r2
        addf    @K_ATAN4, r2
        mpyf    r1, r2
        addf    @K_ATAN3, r2
        mpyf    r1, r2
        addf    @K_ATAN2, r2
        mpyf    r1, r2
        addf    @K_ATAN1, r2
        mpyf    r1, r2
        addf    @K_ATAN0, r2
        mpyf    r1, r2
        mpyf    r0, r2
        addf    r2, r0
        addf    r3, r0
        rets

; R0 <- R0 - 2 pi floor(R0 / 2 pi + 1/2)
m_wrap:
        ldf     @K_ONE_OVER_2PI, r1
        mpyf    r0, r1
        addf    0.5, r1
        fix     r1, r1
        float   r1, r1
        ldf     @K_2PI, r2
        mpyf    r1, r2
        subf    r2, r0
        ldf     @K_2PI_LOW, r2
        mpyf    r1, r2
        subf    r2, r0
        rets

; R0 <- tanh R0 = +-(1 - e)/(1 + e) with e = exp(-2 |x|) = 2^-n 2^-f and n + f = 2 |x| log2(e). 2^-f is a polynomial of
; degree 6 (error 6e-9).
m_tanh:
        ldf     r0, r4                  ; its sign
        absf    r0, r0
        cmpf    9.0, r0
        bgt     m_tanh_one              ; 1 - tanh 9 = 3e-8
        ldf     @K_TWO_LOG2E, r1
        mpyf    r0, r1
        fix     r1, r2                  ; n
        float   r2, r0
        subf    r0, r1                  ; f
        ldf     @K_EXP6, r0
        mpyf    r1, r0
        addf    @K_EXP5, r0
        mpyf    r1, r0
        addf    @K_EXP4, r0
        mpyf    r1, r0
        addf    @K_EXP3, r0
        mpyf    r1, r0
        addf    @K_EXP2, r0
        mpyf    r1, r0
        addf    @K_EXP1, r0
        mpyf    r1, r0
        addf    1.0, r0                 ; 2^-f
        negi    r2, r2                  ; a float word of exponent -n and mantissa 1 is 2^-n
        lsh     24, r2
        sti     r2, @MATH
        mpyf    @MATH, r0               ; e
        ldf     1.0, r3
        subf    r0, r3
        addf    1.0, r0
        call    m_reciprocal
        mpyf    r3, r0
        br      m_tanh_sign
m_tanh_one:
        ldf     1.0, r0
m_tanh_sign:
        cmpf    0.0, r4
        retsge
        negf    r0, r0
        rets
