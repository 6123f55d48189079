; Sub-process 5 as a synthetic load that keeps a DSP busy for TB_ARGUMENT cycles (preset "saturated"), to show missed
; deadlines of any length. It computes the repulsion k (1/d - 1/d0)/d^2 of sample distances; the result is not used.
;
; Cycles from the kernel's first instruction to the end of its return: 16 per turn of the loop and AVOIDANCE_OVERHEAD.
; Any argument from 40 on is met within 8 cycles. A heartbeat of AVOIDANCE_BEAT cycles follows AVOIDANCE_TURNS turns.

AVOIDANCE_OVERHEAD  .set 32
AVOIDANCE_TURNS     .set 125
AVOIDANCE_BEAT      .set 3

kernel_avoidance:
        ldi     @TASK + TB_ARGUMENT, ar2
        subi    AVOIDANCE_OVERHEAD - 8, ar2
        ash     -4, ar2                         ; turns of 16 cycles; none of less than the overhead
        cmpi    1, ar2
        blt     avoidance_done
        ldf     0.25, r4                        ; 1/d0
        ldf     2.0, r5                         ; d
        ldf     0.0, r6                         ; sum
        ldf     4.0, r7
avoidance_some:
        ldi     ar2, r0
        cmpi    AVOIDANCE_TURNS + AVOIDANCE_BEAT, r0
        ldigt   AVOIDANCE_TURNS, r0
        subi3   1, r0, rc
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
        mpyf    0.5, r6                         ; the sum decays, so that it stays small
        addf    0.0625, r5                      ; the next distance, 2 to 4 m
        ldf     2.0, r3
        cmpf    r7, r5
avoidance_turn:
        ldfgt   r3, r5
        subi    AVOIDANCE_TURNS + AVOIDANCE_BEAT, ar2
        cmpi    0, ar2
        ble     avoidance_done
        call    alive
        .rept   13
        nop
        .endr
        br      avoidance_some
avoidance_done:
        ldi     0, r0
        ldi     0, r1
        rets
