; Routines after the structures of TI's published programs. Each is called with its arguments in registers;
; scripts/published_counts runs them and makes a table of docs/validation.md.

                .text

; FIR of N taps. AR0 coefficients, AR1 samples (circular, BK = N), RC = N-2. R2 := sum.
fir:            mpyf3   *ar0++(1),*ar1++(1)%,r0
                ldf     0.0,r2
                rpts    rc
                mpyf3   *ar0++(1),*ar1++(1)%,r0
        ||      addf3   r0,r2,r2
                addf    r0,r2
                rets

; N biquads, direct form II, one sample. AR0 coefficients a2, b2, a1, b1, b0 of each; AR1 delays: word k N + i is delay
; k of biquad i, circular with BK = 3N; IR0 = N, IR1 = N+1, RC = N-1, R2 = x. R0 := y; AR1 := where the next sample
; begins.
biquads:        ldf     0.0,r1
                rptb    biquad_end
                mpyf3   *ar0++(1),*ar1,r0               ; a2 d(n-2)
        ||      addf3   r1,r2,r2                        ; the biquad before: its last term
                mpyf3   *ar0++(1),*ar1++(ir0)%,r1       ; b2 d(n-2)
        ||      addf3   r0,r2,r2
                mpyf3   *ar0++(1),*ar1,r0               ; a1 d(n-1)
                mpyf3   *ar0++(1),*ar1++(ir0)%,r0       ; b1 d(n-1)
        ||      addf3   r0,r2,r2                        ; d(n)
                mpyf3   *ar0++(1),r2,r2                 ; b0 d(n)
        ||      stf     r2,*ar1++(ir1)%
biquad_end:     addf    r0,r2
                addf3   r1,r2,r0
                rets

; LMS filter of N taps. AR0 weights, AR1 samples (circular, BK = N), RC = N-2, R5 = desired, R6 = 2 mu, IR0 = N, IR1 =
; N-2. R2 := y.
lms:            mpyf3   *ar0++(1),*ar1++(1)%,r0
                ldf     0.0,r2
                rpts    rc
                mpyf3   *ar0++(1),*ar1++(1)%,r0
        ||      addf3   r0,r2,r2
                addf    r0,r2
                subf3   r2,r5,r7                        ; error
                mpyf    r6,r7
                mpyf3   *ar1++(1)%,r7,r1
                subi    ir0,ar0                         ; back to the first weight
                ldi     ir1,rc
                ldf     r2,r4                           ; y
                rptb    lms_end
                mpyf3   *ar1++(1)%,r7,r1
        ||      addf3   *ar0,r1,r2
lms_end:        stf     r2,*ar0++(1)
                addf3   *ar0,r1,r2
                stf     r2,*ar0
                ldf     r4,r2
                rets

; K x N matrix times vector. AR0 matrix by rows, AR1 vector (circular, BK = N), AR2 = K-1, AR3 product, R4 = N-2.
matrix_vector:  mpyf3   *ar0++(1),*ar1++(1)%,r0
                ldf     0.0,r2
                rpts    r4
                mpyf3   *ar0++(1),*ar1++(1)%,r0
        ||      addf3   r0,r2,r2
                dbd     ar2,matrix_vector
                addf    r0,r2
                stf     r2,*ar3++
                nop
                rets

; R2 := 1 / R0: the seed and two steps of Newton's method.
inverse:        rcpf    r0,r2
                mpyf3   r0,r2,r3
                subrf   2.0,r3
                mpyf    r3,r2
                mpyf3   r0,r2,r3
                subrf   2.0,r3
                mpyf    r3,r2
                rets

; R2 := square root of R0 > 0.
square_root:    rsqrf   r0,r2
                ldf     r0,r4
                mpyf    0.5,r4
                mpyf3   r2,r2,r3
                mpyf    r4,r3
                subrf   1.5,r3
                mpyf    r3,r2
                mpyf3   r2,r2,r3
                mpyf    r4,r3
                subrf   1.5,r3
                mpyf    r3,r2
                mpyf    r0,r2
                rets

; R0 := R0 / R1, rounded towards zero. Both are smaller than 2^31 in size, R1 is not 0. One SUBC gives one bit of the
; quotient.
divide:         xor3    r1,r0,r3                        ; sign
                absi    r0
                absi    r1
                cmpi    r1,r0
                blt     divide_none
                float   r0,r2                           ; the exponent of a float is the position of the leading 1
                pushf   r2
                pop     r2
                lsh     -24,r2
                float   r1,r4
                pushf   r4
                pop     r4
                lsh     -24,r4
                subi    r4,r2                           ; number of bits of the quotient, less one
                lsh     r2,r1
                rpts    r2
                subc    r1,r0
                subri   31,r2                           ; the quotient is in the low bits, the remainder above
                lsh     r2,r0
                negi    r2
                lsh     r2,r0
                negi    r0,r2
                cmpi    0,r3
                ldilt   r2,r0
                rets
divide_none:    ldi     0,r0
                rets

; N complex points (real, imaginary, real ...), decimation in frequency, radix 2, then in natural order to another
; place.
; AR5 points, AR6 table of sines (N points of one and a quarter period), AR3 result, R8 = N; AR5 and AR3 on multiples of
; 2N.
fft_radix2:     ldi     r8,r9                           ; words between the two points of a butterfly
                ldi     1,r10                           ; butterflies of one twiddle factor
                ldi     r8,ir1
                lsh     -2,ir1
fft_stage:      ldi     r9,ir0
                addi    r9,ir0
                ldi     ar5,ar0
                addi3   r9,ar5,ar2
                subi3   1,r10,rc
                rptb    fft_trivial                     ; W = 1
                addf3   *ar2,*ar0,r0
                subf3   *ar2,*ar0,r1
                addf3   *+ar2(1),*+ar0(1),r2
                subf3   *+ar2(1),*+ar0(1),r3
                stf     r2,*+ar0(1)
        ||      stf     r3,*+ar2(1)
fft_trivial:    stf     r0,*ar0++(ir0)
        ||      stf     r1,*ar2++(ir0)
                ldi     r9,r0
                lsh     -1,r0
                subi    2,r0
                blt     fft_sort
                ldi     r0,ar7                          ; number of groups, less two
                ldi     ar5,ar1
                ldi     ar6,ar4
fft_group:      addi    2,ar1
                addi    r10,ar4
                subi3   1,r10,rc
                ldi     ar1,ar0
                addi3   r9,ar1,ar2
                ldf     *ar4,r6                         ; sine
                rptb    fft_butterfly
                subf3   *ar2,*ar0,r2
                subf3   *+ar2(1),*+ar0(1),r1
                mpyf3   r2,r6,r0
        ||      addf3   *+ar2(1),*+ar0(1),r3
                mpyf3   r1,*+ar4(ir1),r3
        ||      stf     r3,*+ar0(1)
                subf3   r0,r3,r4
                mpyf3   r1,r6,r0
        ||      addf3   *ar2,*ar0,r3
                mpyf3   r2,*+ar4(ir1),r3
        ||      stf     r3,*ar0++(ir0)
                addf3   r0,r3,r5
fft_butterfly:  stf     r4,*+ar2(1)
        ||      stf     r5,*ar2++(ir0)
                db      ar7,fft_group
                lsh     -1,r9
                lsh     1,r10
                b       fft_stage
fft_sort:       ldi     ar5,ar0
                ldi     r8,ir0                          ; stride of the bit-reversed address
                ldi     2,ir1
                subi3   1,r8,rc
                rptb    fft_sorted
                ldf     *+ar0(1),r0
        ||      ldf     *ar0++(ir0)b,r1
fft_sorted:     stf     r0,*+ar3(1)
        ||      stf     r1,*ar3++(ir1)
                rets

; The same with radix 4; N is a power of 4. The two middle results of a butterfly change places. Then bit reversal sorts
; the results.
                .bss    fft_points,1
                .bss    fft_table,1
                .bss    fft_result,1
                .bss    fft_size,1
                .bss    fft_repeat,1                    ; number of butterflies with one twiddle factor, less one
                .bss    fft_step,1                      ; words from the sine of one twiddle factor to the next
                .bss    fft_eighth,1                    ; index of the sine of pi/4
                .bss    fft_last,1                      ; first point of the last twiddle factor's butterflies

fft_radix4:     ldpk    @fft_points
                sti     ar5,@fft_points
                sti     ar6,@fft_table
                sti     ar3,@fft_result
                sti     r8,@fft_size
                ldi     0,r0
                sti     r0,@fft_repeat
                ldi     1,r0
                sti     r0,@fft_step
                ldi     r8,r0
                lsh     -3,r0
                sti     r0,@fft_eighth
                ldi     r8,ir0
                lsh     1,ir0                           ; words between butterflies with one twiddle factor
                ldi     r8,ir1
                lsh     -2,ir1                          ; words from a sine to its cosine
fft4_stage:     ldi     ir0,bk
                lsh     -2,bk                           ; words between the points of a butterfly
                ldi     @fft_points,ar7
                addi3   bk,ar7,r0
                subi    2,r0
                sti     r0,@fft_last
                ldi     ar7,ar0
                addi3   bk,ar0,ar1
                addi3   bk,ar1,ar2
                addi3   bk,ar2,ar3
                ldi     0,r7                            ; index of the sine
                ldi     @fft_repeat,rc
                rptb    fft4_trivial                    ; W = 1
                addf3   *+ar2(1),*+ar0(1),r0
                addf3   *+ar3(1),*+ar1(1),r1
                subf3   *+ar2(1),*+ar0(1),r8            ; y0 - y2
                subf3   *+ar3(1),*+ar1(1),r9            ; y1 - y3
                addf3   r1,r0,r2
                subf3   r1,r0,r3
                addf3   *ar2,*ar0,r0
                addf3   *ar3,*ar1,r1
                subf3   *ar2,*ar0,r10                   ; x0 - x2
                subf3   *ar3,*ar1,r11                   ; x1 - x3
                addf3   r1,r0,r4
                subf3   r1,r0,r5
                stf     r2,*+ar0(1)
        ||      stf     r4,*ar0++(ir0)
                subf3   r11,r8,r2
                addf3   r9,r10,r4
                stf     r3,*+ar1(1)
        ||      stf     r5,*ar1++(ir0)
                addf3   r11,r8,r3
                subf3   r9,r10,r5
                stf     r2,*+ar2(1)
        ||      stf     r4,*ar2++(ir0)
fft4_trivial:   stf     r3,*+ar3(1)
        ||      stf     r5,*ar3++(ir0)
                cmpi    2,bk
                beq     fft4_sort                       ; the last stage has no other factor
fft4_factor:    addi    @fft_step,r7
                ldi     r7,ar4
                addi    @fft_table,ar4
                addi3   r7,ar4,ar5
                addi3   r7,ar5,ar6
                addi    2,ar7
                ldi     ar7,ar0
                addi3   bk,ar0,ar1
                addi3   bk,ar1,ar2
                addi3   bk,ar2,ar3
                ldi     @fft_repeat,rc
                cmpi    @fft_eighth,r7
                beq     fft4_eighth
                rptb    fft4_general
                addf3   *+ar2(1),*+ar0(1),r0
                addf3   *+ar3(1),*+ar1(1),r1
                subf3   *+ar2(1),*+ar0(1),r8            ; y0 - y2
                subf3   *+ar3(1),*+ar1(1),r9            ; y1 - y3
                addf3   r1,r0,r2
                subf3   r1,r0,r3                        ; imaginary part of the second result, before its factor
                addf3   *ar2,*ar0,r0
                addf3   *ar3,*ar1,r1
                subf3   *ar2,*ar0,r10                   ; x0 - x2
                subf3   *ar3,*ar1,r11                   ; x1 - x3
                mpyf3   *+ar5(ir1),r3,r4
        ||      stf     r2,*+ar0(1)
                addf3   r1,r0,r2
                subf3   r1,r0,r5
                mpyf3   *ar5,r5,r6
        ||      stf     r2,*ar0++(ir0)
                subf3   r6,r4,r2
                mpyf3   *+ar5(ir1),r5,r4
        ||      stf     r2,*+ar1(1)
                mpyf3   *ar5,r3,r6
                addf3   r6,r4,r2
                addf3   r9,r10,r5                       ; the first result
                subf3   r11,r8,r3
                subf3   r9,r10,r0                       ; the third
                addf3   r11,r8,r1
                mpyf3   *+ar4(ir1),r3,r4
        ||      stf     r2,*ar1++(ir0)
                mpyf3   *ar4,r5,r6
                subf3   r6,r4,r2
                mpyf3   *+ar4(ir1),r5,r4
        ||      stf     r2,*+ar2(1)
                mpyf3   *ar4,r3,r6
                addf3   r6,r4,r2
                mpyf3   *+ar6(ir1),r1,r4
        ||      stf     r2,*ar2++(ir0)
                mpyf3   *ar6,r0,r6
                subf3   r6,r4,r2
                mpyf3   *+ar6(ir1),r0,r4
        ||      stf     r2,*+ar3(1)
                mpyf3   *ar6,r1,r6
                addf3   r6,r4,r2
fft4_general:   stf     r2,*ar3++(ir0)
                cmpi    @fft_last,ar7
                blt     fft4_factor
fft4_next:      ldi     @fft_repeat,r0                  ; four times as many butterflies of a quarter of the points
                lsh     2,r0
                addi    3,r0
                sti     r0,@fft_repeat
                ldi     @fft_step,r0
                lsh     2,r0
                sti     r0,@fft_step
                lsh     -2,ir0
                b       fft4_stage
fft4_eighth:    rptb    fft4_diagonal                   ; W = (1 - j) / sqrt(2): its square is -j, its cube -(1 + j) /
                                                        ; sqrt(2)
                addf3   *+ar2(1),*+ar0(1),r0
                addf3   *+ar3(1),*+ar1(1),r1
                subf3   *+ar2(1),*+ar0(1),r8            ; y0 - y2
                subf3   *+ar3(1),*+ar1(1),r9            ; y1 - y3
                addf3   r1,r0,r2
                subf3   r1,r0,r3                        ; real part of the second result
                addf3   *ar2,*ar0,r0
                addf3   *ar3,*ar1,r1
                subf3   *ar2,*ar0,r10                   ; x0 - x2
                subf3   *ar3,*ar1,r11                   ; x1 - x3
                addf3   r1,r0,r4
                subf3   r0,r1,r5                        ; imaginary part of the second result
                addf3   r9,r10,r0
                subf3   r11,r8,r1
                addf3   r1,r0,r6                        ; the first result
                mpyf3   *ar4,r6,r6
        ||      stf     r2,*+ar0(1)
                subf3   r0,r1,r2
                mpyf3   *ar4,r2,r2
        ||      stf     r4,*ar0++(ir0)
                subf3   r10,r9,r0                       ; the third, with the real part's sign changed
                addf3   r11,r8,r1
                addf3   r1,r0,r4
                mpyf3   *ar4,r4,r4
        ||      stf     r5,*+ar1(1)
                subf3   r1,r0,r5
                mpyf3   *ar4,r5,r5
        ||      stf     r3,*ar1++(ir0)
                stf     r2,*+ar2(1)
        ||      stf     r6,*ar2++(ir0)
fft4_diagonal:  stf     r5,*+ar3(1)
        ||      stf     r4,*ar3++(ir0)
                cmpi    @fft_last,ar7
                blt     fft4_factor
                b       fft4_next
fft4_sort:      ldi     @fft_points,ar5
                ldi     @fft_result,ar3
                ldi     @fft_size,r8
                b       fft_sort
