; Ping-pong between two chips: `emulator exec bandwidth.asm bandwidth.asm --link 0.0:1.3 --dump 0:cycles:9`.
;
; Chip 0 sends a message of 1, 2, 4, ... 256 words and chip 1 returns it; timer 0 of chip 0 measures. `cycles` has the
; cycles of each round trip. A word takes 5 cycles on the link. Each message also has a fixed cost (latency, token
; changes, loops), so long messages come close to one word per 5 cycles.
;
; To see: LDI || STI under RPTS moves a block between memory and a port at a cycle a word, and the port holds it to its
; own rate; a timer as a stop-watch.

                .include "../examples.inc"
                .include "ports.inc"

sizes           .set    9
timer_control   .set    100020h
counter         .set    4
period          .set    8

                .bss    variables,0
                .bss    chip,1
                .bss    cycles,sizes
                .bss    message,256

                .text
start:          set_up
                sti     r0,@chip
                address port_control,ar0
                cmpi    0,r0
                beq     chosen
                addi    3 * port_step,ar0       ; the link ends at port 3 of chip 1
chosen:         ldi     ar0,ar2
                addi    output,ar2
                ldi     ar0,ar3
                addi    input,ar3
                address timer_control,ar5
                ldi     -1,r2
                sti     r2,*+ar5(period)
                ldi     2c0h,r2                 ; internal clock, go
                sti     r2,*ar5
                address cycles,ar6
                ldi     1,r9                    ; words
                ldi     sizes-1,ar7
next:           ldi     *+ar5(counter),r7
                ldi     @chip,r0
                bne     answer
                call    send
                call    receive
                bu      timed
answer:         call    receive
                call    send
timed:          ldi     *+ar5(counter),r6
                subi    r7,r6
                lsh     1,r6                    ; the timer counts every second cycle
                sti     r6,*ar6++
                lsh     1,r9
                db      ar7,next
done:           b       done

send:           address message,ar1
                ldi     *ar1++,r2
                ldi     r9,r8
                subi    2,r8
                blt     last_out
                rpts    r8
                ldi     *ar1++,r2
        ||      sti     r2,*ar2
last_out:       sti     r2,*ar2
                rets

receive:        address message,ar1
                ldi     *ar3,r2
                ldi     r9,r8
                subi    2,r8
                blt     last_in
                rpts    r8
                ldi     *ar3,r2
        ||      sti     r2,*ar1++
last_in:        sti     r2,*ar1
                rets
