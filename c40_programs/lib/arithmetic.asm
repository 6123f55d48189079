; Reciprocal and roots: an 8-bit seed, then Newton's iteration on the full 32-bit mantissa (c40-isa.md 7.10).

; R0 <- 1 / R0. x' = x (2 - v x) squares the seed's error: 2^-8, 2^-16, 2^-32; truncation adds 3 units of 2^-31.
m_reciprocal:
        rcpf    r0, r1
        mpyf3   r0, r1, r2
        subrf   2.0, r2
        mpyf    r2, r1
        mpyf3   r0, r1, r2
        subrf   2.0, r2
        mpyf3   r1, r2, r0
        rets

; R0 <- sqrt(R0), 0 if R0 <= 0.
m_sqrt:
        cmpf    0.0, r0
        ble     m_sqrt_zero
        ldf     r0, r3
        call    m_rsqrt
        mpyf    r3, r0
        rets
m_sqrt_zero:
        ldf     0.0, r0
        rets

; R0 <- 1 / sqrt(R0), R0 > 0. x' = x (1.5 - v/2 x x) makes of an error e the error 1.5 e^2: 2^-8.4, 2^-16.2, 2^-31.9.
m_rsqrt:
        rsqrf   r0, r1
        mpyf    0.5, r0
        mpyf3   r1, r1, r2
        mpyf    r0, r2
        subrf   1.5, r2
        mpyf    r2, r1
        mpyf3   r1, r1, r2
        mpyf    r0, r2
        subrf   1.5, r2
        mpyf3   r1, r2, r0
        rets
