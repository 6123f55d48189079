; Blends from 0 to 1: motions are made of them.

; S of degree 9 with four vanishing derivatives at both ends, at u = R0, 0 <= u <= 1:
; S = u^5 (126 - 420 u + 540 u^2 - 315 u^3 + 70 u^4), computed as 1 - S(1 - u) above 1/2, so that the sum stays below 16
;   S' = 630 w^4, S'' = 2520 w^3 d, S''' = 2520 w^2 (3 d^2 - 2 w), S'''' = 15120 w d (d^2 - 3 w);
;   w = u (1 - u), d = 1 - 2 u
; R0 <- S, R1 <- S', R2 <- S'', R3 <- S''', R4 <- S''''. Clobbers R5, R6, R7.
m_blend9:
        ldf     1.0, r1
        subf    r0, r1                  ; v = 1 - u
        mpyf3   r0, r1, r5              ; w
        subf3   r0, r1, r6              ; d = v - u
        cmpf    0.5, r0
        ldfgt   r1, r0                  ; the smaller of u and v
        ldf     70.0, r1
        mpyf    r0, r1
        subf    @K_315, r1
        mpyf    r0, r1
        addf    @K_540, r1
        mpyf    r0, r1
        subf    @K_420, r1
        mpyf    r0, r1
        addf    126.0, r1
        mpyf3   r0, r0, r2
        mpyf    r2, r2
        mpyf    r2, r0                  ; u^5
        mpyf    r1, r0
        cmpf    0.0, r6
        bge     m_blend9_lower
        subrf   1.0, r0
m_blend9_lower:                         ; S
        mpyf3   r5, r5, r2              ; w^2
        mpyf3   r2, r5, r3              ; w^3
        ldf     @K_630, r1
        mpyf    r2, r1
        mpyf    r2, r1                  ; S'
        mpyf3   r6, r6, r4              ; d^2
        ldf     @K_2520, r7
        mpyf    r7, r3
        mpyf    r6, r3                  ; S''
        mpyf    r2, r7                  ; 2520 w^2
        ldf     3.0, r2
        mpyf    r4, r2
        subf    r5, r2
        subf    r5, r2
        mpyf    r2, r7                  ; S'''
        ldf     r3, r2
        ldf     r7, r3
        ldf     3.0, r7
        mpyf    r5, r7
        subf    r7, r4                  ; d^2 - 3 w
        mpyf    r5, r4
        mpyf    r6, r4
        mpyf    @K_15120, r4            ; S''''
        rets

; The quintic at u = R0, 0 <= u <= 1: R0 <- S = u^3 (10 - 15 u + 6 u^2), R1 <- S' = 30 w^2, R2 <- S'' = 60 w (1 - 2 u).
; Clobbers R3.
m_quintic:
        ldf     1.0, r1
        subf    r0, r1                  ; v
        subf3   r0, r1, r2              ; 1 - 2 u
        mpyf    r0, r1                  ; w
        mpyf    r1, r2
        mpyf    60.0, r2                ; S''
        mpyf    r1, r1
        mpyf    30.0, r1                ; S'
        ldf     6.0, r3
        mpyf    r0, r3
        subf    15.0, r3
        mpyf    r0, r3
        addf    10.0, r3
        mpyf    r0, r3
        mpyf    r0, r3
        mpyf    r3, r0                  ; S
        rets
