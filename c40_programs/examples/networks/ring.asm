; A token round a ring: `emulator exec ring.asm --topology ring:8 --dump 0:token:1`.
;
; Each chip reads the token from its port 3, adds one, and passes it on through port 0; chip 0 begins and counts the
; laps. So after `laps` laps chip 0 holds laps * chips.
;
; To see: blocking reads and writes. A read of an empty input FIFO holds the processor until the word is there; no
; polling.
;
; At the start: R0 the chip's number, R1 the number of chips (docs/networks.md).

                .include "../examples.inc"
                .include "ports.inc"

laps            .set    10

                .bss    variables,0
                .bss    token,1

                .text
start:          set_up
                address port_control,ar0
                address port_control + 3 * port_step,ar3
                ldi     laps-1,ar1
                ldi     0,r2                    ; the token
                cmpi    0,r0
                bne     pass
                sti     r2,*+ar0(output)
pass:           ldi     *+ar3(input),r2
                addi    1,r2
                cmpi    0,r0
                bne     send
                cmpi    0,ar1                   ; chip 0 keeps it after the last lap
                beq     finish
send:           sti     r2,*+ar0(output)
                db      ar1,pass
finish:         sti     r2,@token
done:           b       done
