; FFT of 1024 complex points, radix 2, decimation in frequency: real parts at `real`, imaginary parts at `imaginary`.
; The transform replaces both, in natural order: X(k) = sum x(n) exp(-2 pi i n k/1024).
;
; To see: ten stages whose butterflies are a block repeat with two parallel stores; a sine table of three quarters of a
; period, where the cosine is a quarter of a period later; bit-reversed addressing for the final order.

                .include "examples.inc"

N               .set    1024

                .bss    variables,0
                .bss    half,1                  ; distance between the two points of a butterfly
                .bss    stride,1                ; step in the sine table
real            .usect  "points",N,N            ; bit-reversed addressing needs arrays aligned to their length
imaginary       .usect  "points",N,N
sorted_real     .usect  "points",N
sorted_imag     .usect  "points",N

                .data
sine:           .include "sine_1024.inc"

                .text
start:          set_up
                ldi     N/2,r0
                sti     r0,@half
                ldi     1,r0
                sti     r0,@stride

stage:          address real,ar4
                address imaginary,ar5
                address sine,ar6
                ldi     @half,ir1
                ldi     ir1,ir0
                addi    ir0,ir0                 ; butterflies with the same twiddle factor are 2 half apart
                ldi     @stride,r10
                ldi     @stride,r9
                subi    1,r9                    ; repetitions - 1
                ldi     @half,ar7
                subi    1,ar7
twiddle:        ldf     *ar6,r7                 ; s
                ldi     ar6,ar0
                addi    N/4,ar0
                ldf     *ar0,r6                 ; c
                ldi     ar4,ar0                 ; real: upper point, lower point
                ldi     ar4,ar1
                addi    ir1,ar1
                ldi     ar5,ar2                 ; imaginary
                ldi     ar5,ar3
                addi    ir1,ar3
                ldi     r9,rc
                rptb    butterfly
                subf3   *ar1,*ar0,r0            ; difference t
                subf3   *ar3,*ar2,r1
                addf3   *ar1,*ar0,r2            ; sum
                addf3   *ar3,*ar2,r3
                stf     r2,*ar0++(ir0)
        ||      stf     r3,*ar2++(ir0)
                mpyf3   r0,r6,r2                ; t (c - i s)
                mpyf3   r1,r7,r3
                addf3   r2,r3,r2
                mpyf3   r1,r6,r3
                mpyf3   r0,r7,r0
                subf3   r0,r3,r3
butterfly:      stf     r2,*ar1++(ir0)
        ||      stf     r3,*ar3++(ir0)
                addi    1,ar4
                addi    1,ar5
                addi    r10,ar6
                db      ar7,twiddle
                ldi     @stride,r0
                addi    r0,r0
                sti     r0,@stride
                ldi     @half,r0
                lsh     -1,r0
                sti     r0,@half
                bnz     stage

; Point k of the transform is at the place that the ten bits of k give in reverse order.
                address real,ar0
                address imaginary,ar1
                address sorted_real,ar2
                address sorted_imag,ar3
                ldi     N/2,ir0
                ldi     N-1,rc
                rptb    unscrambled
                ldf     *ar0++(ir0)b,r0
                ldf     *ar1++(ir0)b,r1
unscrambled:    stf     r0,*ar2++
        ||      stf     r1,*ar3++
                address real,ar0
                address imaginary,ar1
                address sorted_real,ar2
                address sorted_imag,ar3
                ldi     N-1,rc
                rptb    moved
                ldf     *ar2++,r0
        ||      ldf     *ar3++,r1
moved:          stf     r0,*ar0++
        ||      stf     r1,*ar1++
done:           b       done
