; A servo that a timer drives:
; `emulator exec servo.asm servo.asm --link 0.0:1.3 --events events.txt --dump 0:positions:8`.
;
; Chip 0 is the controller. Its timer 0 interrupts every 1000 cycles (50 us at 40 MHz). The interrupt routine reads the
; position, computes a torque (proportional to the error, less damping times the difference of two positions), sends the
; torque, and stores the position in `positions`. The main program only executes IDLE. Chip 1 is the moved body: it
; sends its position, takes a torque and integrates: v := v + u, x := x + v. It starts at 0; the target is 1.
;
; To see: words appear on the link at exact multiples of the timer's period, whatever the program does in between: IDLE
; takes the interrupt. A real plant would not wait for its controller; this one does.

                .include "../examples.inc"
                .include "../networks/ports.inc"

samples         .set    64
period_ticks    .set    500                     ; of 2 cycles
timer_control   .set    100020h
period          .set    8
vectors         .set    2ff800h
tint0           .set    2                       ; in the vector table
tint0_enabled   .set    1                       ; in IIE

                .bss    variables,0
                .bss    positions,samples

                .text
start:          set_up
                cmpi    0,r0
                bne     plant

                address port_control,ar0
                address vectors,ar1
                ldpe    ar1,ivtp
                address tick,r0
                sti     r0,*+ar1(tint0)
                address positions,ar2
                ldi     samples,r8
                ldf     0.0,r6                  ; the position before
                address timer_control,ar1
                ldi     period_ticks,r0
                sti     r0,*+ar1(period)
                ldi     2c0h,r0                 ; internal clock, pulses, go
                sti     r0,*ar1
                ldi     tint0_enabled,iie
wait:           idle                            ; sets GIE, too
                cmpi    0,r8
                bne     wait
                ldi     0,iie
                ldi     0,r0
                sti     r0,*ar1                 ; hold the timer
done:           b       done

tick:           ldf     *+ar0(input),r0         ; position
                ldf     1.0,r1
                subf    r0,r1                   ; error
                mpyf    0.0625,r1
                subf3   r6,r0,r2                ; speed
                mpyf    0.5,r2
                subf    r2,r1
                rnd     r1
                stf     r1,*+ar0(output)
                stf     r0,*ar2++
                ldf     r0,r6
                subi    1,r8
                reti

plant:          address port_control + 3 * port_step,ar0
                ldf     0.0,r0                  ; x
                ldf     0.0,r1                  ; v
                ldi     samples-1,ar7
moved:          rnd     r0
                stf     r0,*+ar0(output)
                ldf     *+ar0(input),r2
                addf    r2,r1
                addf    r1,r0
                db      ar7,moved
                b       done
