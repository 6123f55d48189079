; Least mean squares: an adaptive filter of 16 taps learns an unknown system from its input and output. For each of
; `samples`
;     y = sum w(k) x(n-k),  e = d - y,  w(k) := w(k) + 2 mu e x(n-k)
; Input at `input`, the unknown system's output at `desired`; results: weights at `weights`, errors at `errors`.
;
; To see: a circular buffer for x (BK, *AR++%); the update of TI's application note, with the multiply of the next tap
; beside the add and the store of this one.

                .include "examples.inc"

TAPS            .set    16

                .bss    variables,0
                .bss    samples,1
                .bss    two_mu,1                ; float
                .bss    input,2048
                .bss    desired,2048
                .bss    errors,2048
weights         .usect  "onchip",TAPS,32
delays          .usect  "onchip",TAPS,32        ; a multiple of the next power of two above TAPS

                .text
start:          set_up
                address weights,ar0
                address delays,ar1
                ldf     0.0,r0
                rpts    TAPS-1
                stf     r0,*ar0++
        ||      stf     r0,*ar1++
                ldi     TAPS,bk
                address delays,ar1
                address input,ar2
                address desired,ar3
                address errors,ar4
                ldi     @samples,ar5
                subi    1,ar5
next_sample:    ldf     *ar2++,r0
                stf     r0,*ar1++(1)%           ; newest over oldest; AR1: the oldest now
                address weights,ar0             ; weights from the oldest tap on
                mpyf3   *ar0++(1),*ar1++(1)%,r0
                ldf     0.0,r2
                rpts    TAPS-2
                mpyf3   *ar0++(1),*ar1++(1)%,r0
        ||      addf3   r0,r2,r2
                addf    r0,r2                   ; y
                ldf     *ar3++,r3
                subf    r2,r3                   ; e
                stf     r3,*ar4++
                mpyf    @two_mu,r3
                rnd     r3,r7                   ; 2 mu e
                address weights,ar0
                ldi     TAPS-1,rc
                rptb    updated
                mpyf3   *ar1++(1)%,r7,r1
                addf3   *ar0,r1,r2
                rnd     r2
updated:        stf     r2,*ar0++
                db      ar5,next_sample
done:           b       done
