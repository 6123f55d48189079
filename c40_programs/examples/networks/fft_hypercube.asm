; FFT of 1024 complex points on 1, 2, 4, 8 or 16 chips: `emulator exec fft_hypercube.asm --topology hypercube:8`.
;
; Chip k has L = 1024 / chips points in `real` and `imaginary`, from k L on. Radix 2, decimation in frequency. In the
; first stages the two points of a butterfly are on neighbouring chips. These exchange their parts: one computes the
; sums, the other the differences times the twiddle factors. Later stages are local. Place j then has X(reversed j).
;
; To see: a link carries one direction at a time. If both sides sent at once, the token would change after each word,
; and a word each way would cost 22 cycles. So one side sends its whole part, then the other: 5 cycles a word.

                .include "../examples.inc"
                .include "ports.inc"

N               .set    1024

                .bss    variables,0
                .bss    chip,1
                .bss    points,1                ; L
                .bss    half,1                  ; distance between the two points of a butterfly
                .bss    stride,1                ; step in the sine table
real            .usect  "points",N
imaginary       .usect  "points",N
other_real      .usect  "points",N
other_imag      .usect  "points",N

                .data
sine:           .include "../sine_1024.inc"

                .text
start:          set_up
                sti     r0,@chip
                ldi     N,r4
                ldi     -1,ar6                  ; dimensions - 1
                ldi     1,r5
                sti     r5,@stride
count:          cmpi    1,r1
                beq     counted
                lsh     -1,r1
                lsh     -1,r4
                addi    1,ar6
                bu      count
counted:        sti     r4,@points
                ldi     N/2,r5
                sti     r5,@half

; Stages between chips: dimension ar6, from the highest down.
across:         cmpi    0,ar6
                blt     own_stages
                ldi     @chip,r0                ; which port: docs/networks.md, hypercube
                ldi     ar6,r2
parity:         ldi     r0,r3
                and     1,r3
                addi    r3,r2
                lsh     -1,r0
                bnz     parity
                ldi     ar6,r3
                lsh     -1,r3
                mpyi    port_step,r3
                and     1,r2                    ; 0: this chip begins with the token
                ldi     r2,r5
                mpyi    3*port_step,r5
                addi    r5,r3
                address port_control,ar0
                addi    r3,ar0
                ldi     ar0,ar2
                addi    output,ar2
                ldi     ar0,ar3
                addi    input,ar3
                cmpi    0,r2
                bne     read_first
                call    send
                call    receive
                bu      exchanged
read_first:     call    receive
                call    send
exchanged:      address real,ar0
                address other_real,ar1
                address imaginary,ar2
                address other_imag,ar3
                ldi     @points,rc
                subi    1,rc
                ldi     @chip,r2
                ldi     ar6,r5
                negi    r5,r5
                lsh     r5,r2                   ; bit ar6 of the chip's number
                tstb    1,r2
                bne     differences
                rptb    summed
                addf3   *ar1++,*ar0,r2
                addf3   *ar3++,*ar2,r3
summed:         stf     r2,*ar0++
        ||      stf     r3,*ar2++
                bu      next_dimension
differences:    ldi     @chip,r2                ; first twiddle: place modulo half, times the stride
                mpyi    @points,r2
                ldi     @half,r3
                subi    1,r3
                and     r3,r2
                mpyi    @stride,r2
                address sine,ar4
                addi    r2,ar4
                ldi     ar4,ar5
                addi    N/4,ar5
                ldi     @stride,ir0
                rptb    twiddled
                ldf     *ar4++(ir0),r7          ; s
                ldf     *ar5++(ir0),r6          ; c
                subf3   *ar0,*ar1++,r0          ; difference t
                subf3   *ar2,*ar3++,r1
                mpyf3   r0,r6,r2                ; t (c - i s)
                mpyf3   r1,r7,r3
                addf3   r2,r3,r2
                mpyf3   r1,r6,r3
                mpyf3   r0,r7,r0
                subf3   r0,r3,r3
twiddled:       stf     r2,*ar0++
        ||      stf     r3,*ar2++
next_dimension: ldi     @stride,r0
                addi    r0,r0
                sti     r0,@stride
                ldi     @half,r0
                lsh     -1,r0
                sti     r0,@half
                subi    1,ar6
                bu      across

own_stages:
stage:          address real,ar4
                address imaginary,ar5
                address sine,ar6
                ldi     @half,ir1
                ldi     ir1,ir0
                addi    ir0,ir0                 ; butterflies with the same twiddle factor are 2 half apart
                ldi     @stride,r10
                ldi     @points,r9              ; repetitions: L / (2 half)
                ldi     @half,r8
groups:         lsh     -1,r9
                lsh     -1,r8
                bnz     groups
                subi    1,r9
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
done:           b       done

; Sends both parts through the port whose output FIFO register is at ar2.
send:           address real,ar1
                call    send_part
                address imaginary,ar1
send_part:      ldi     @points,r4
                subi    2,r4
                ldi     *ar1++,r5
                rpts    r4
                ldi     *ar1++,r5
        ||      sti     r5,*ar2
                sti     r5,*ar2
                rets

; Reads both parts of the other chip through the input FIFO register at ar3.
receive:        address other_real,ar1
                call    receive_part
                address other_imag,ar1
receive_part:   ldi     @points,r4
                subi    2,r4
                ldi     *ar3,r5
                rpts    r4
                ldi     *ar3,r5
        ||      sti     r5,*ar1++
                sti     r5,*ar1
                rets
