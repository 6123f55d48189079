; Sub-process 5 as a synthetic load that keeps a DSP busy for TB_ARGUMENT cycles (preset "saturated"), so that misses can be shown at any
; length. It computes, and its result is thrown away: the repulsion k (1/d - 1/d0)/d^2 of a sample of distances.
;
; Cycles from the kernel's first instruction to the end of its return: 16 per turn of the loop and AVOIDANCE_OVERHEAD, so that any argument
; from 40 on is met within 8 cycles.

AVOIDANCE_OVERHEAD  .set 24

kernel_avoidance:
        ldi     @TASK + TB_ARGUMENT, r0
        subi    AVOIDANCE_OVERHEAD - 8, r0
        lsh     -4, r0                          ; turns of 16 cycles
        ldi     r0, rc
        subi    1, rc
        cmpi    1, r0
        blt     avoidance_done
        ldf     0.25, r4                        ; 1/d0
        ldf     2.0, r5                         ; d
        ldf     0.0, r6                         ; sum
        ldf     4.0, r7
        rptb    avoidance_turn
        rcpf    r5, r0                          ; 1/d: the seed and two steps of Newton
        mpyf3   r5, r0, r1
        subrf   2.0, r1
        mpyf    r1, r0
        mpyf3   r5, r0, r1
        subrf   2.0, r1
        mpyf    r1, r0
        subf3   r4, r0, r1                      ; 1/d - 1/d0
        mpyf3   r0, r0, r2
        mpyf    r2, r1
        addf    r1, r6
        mpyf    0.5, r6                         ; the sum forgets, so that it stays small
        addf    0.0625, r5                      ; the next distance, 2 to 4 m
        ldf     2.0, r3
        cmpf    r7, r5
avoidance_turn:
        ldfgt   r3, r5
avoidance_done:
        ldi     0, r0
        ldi     0, r1
        rets
