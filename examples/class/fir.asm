; A filter of 8 taps over 32 samples: `emulator exec fir.asm --until done --dump result:32 --profile`.
; The input is a step. The taps are 1/8 each, so the output climbs to 1 in eight samples and stays there.
;
; To see: a multiplication and an addition in one instruction (the two halves joined by ||), one instruction repeated
; (RPTS), a delayed branch (DBD) with work in two of its three slots, and two circular buffers. RPTS inside RPTB would
; be wrong: both use RS, RE and RC. `emulator exec --check` names such a mistake.

TAPS    .set    8
SAMPLES .set    32

        .bss    result,SAMPLES
        .data
a_state:  .word state
a_taps:   .word taps
a_result: .word result

        .sect   "ring"
        .align  2*TAPS          ; a circular buffer of BK words begins on a power of two above BK
state:  .space  TAPS
        .align  2*TAPS
taps:   .float  0.125,0.125,0.125,0.125,0.125,0.125,0.125,0.125

        .text
start:  ldp     a_state
        lda     @a_state,ar0
        lda     @a_taps,ar1
        lda     @a_result,ar2
        ldi     TAPS,bk
        ldf     0.0,r2
        rpts    TAPS-1
        stf     r2,*ar0++%              ; nothing has come before the step
        ldi     SAMPLES-1,ar4
next:   ldf     1.0,r3                  ; the step
        stf     r3,*ar0++%              ; over the oldest sample
        mpyf3   *ar0++%,*ar1++%,r0
        ldf     0.0,r2
        rpts    TAPS-2
        mpyf3   *ar0++%,*ar1++%,r0
||      addf3   r0,r2,r2
        dbd     ar4,next
        addf    r0,r2
        stf     r2,*ar2++
        nop
done:   b       done
