; Ping-pong between two chips, by their DMA coprocessors:
; `emulator exec bandwidth_dma.asm bandwidth_dma.asm --link 0.0:1.3 --dump 0:cycles:9`.
;
; As in bandwidth.asm chip 0 sends messages of 1, 2, 4, ... 256 words, chip 1 returns them, and `cycles` has the cycles
; of each round trip. But no processor touches a word. The channel with the port's number runs in split mode: its
; primary half moves words from memory to the output FIFO on OCRDY, its auxiliary half from the input FIFO to memory on
; ICRDY. The processor starts a half, sleeps in IDLE, and is woken by the channel's interrupt.
;
; To see: a message costs more than with LDI || STI (registers to write, an interrupt to take). A word costs the same:
; the link decides. And the processor could compute meanwhile.

                .include "../examples.inc"
                .include "ports.inc"

sizes           .set    9
timer_control   .set    100020h
counter         .set    4
period          .set    8
dma_control     .set    1000a0h                 ; of channel 0; that of channel n is 10h * n higher
source          .set    1                       ; registers of a channel, from its control register on
source_index    .set    2
words_out       .set    3
destination     .set    4
destination_index .set  5
words_in        .set    7
vectors         .set    2ff800h
dmaint0         .set    25h                     ; in the vector table, and bit 25 of IIE
; Control words: split mode, transfer mode 01 (stop at 0), TCC (interrupt at the end) of both halves, port's events.
common          .set    4000h + 14h + 0c0000h + 0c0h
halted          .set    02800000h               ; START = AUX START = 10
sends           .set    02c00000h               ; START = 11, AUX START = 10
receives        .set    03800000h               ; START = 10, AUX START = 11

                .bss    variables,0
                .bss    chip,1
                .bss    port,1
                .bss    cycles,sizes
message         .usect  "message",256

                .text
start:          set_up
                sti     r0,@chip
                ldi     0,r1                    ; the port, and the channel
                cmpi    0,r0
                ldinz   3,r1
                sti     r1,@port
                ldi     r1,r2
                lsh     4,r2
                address dma_control,ar0
                addi    r2,ar0
                lsh     10,r2                   ; 3 << 4 << 11 = COM PORT 3 << 15, so the port's number fits both fields
                lsh     1,r2
                address common,r10
                or      r2,r10
                address message,r2
                sti     r2,*+ar0(source)
                sti     r2,*+ar0(destination)
                ldi     1,r2
                sti     r2,*+ar0(source_index)
                sti     r2,*+ar0(destination_index)

                address vectors,ar1             ; DMAINT of the channel
                ldpe    ar1,ivtp
                addi    dmaint0,ar1
                addi    r1,ar1
                address woken,r2
                sti     r2,*ar1
                ldi     1,r2
                ldi     r1,r3
                addi    25,r3
                lsh     r3,r2
                ldi     r2,iie
                ldi     5,r2                    ; DIE: ICRDY and OCRDY for channel 0 (bits 1-0, 3-2)
                cmpi    0,r1
                beq     selected
                address 24000h,r2               ; for channel 3 (bits 16-14, 19-17)
selected:       ldi     r2,r11

                address timer_control,ar5
                ldi     -1,r2
                sti     r2,*+ar5(period)
                ldi     2c0h,r2                 ; internal clock, go
                sti     r2,*ar5
                address cycles,ar6
                ldi     1,r9                    ; words
                ldi     sizes-1,ar7
                address halted,r4
                or      r10,r4
                sti     r4,*ar0                 ; end the reset: the channel sees events from now on
                ldi     r11,die
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

send:           address message,r2
                sti     r2,*+ar0(source)
                sti     r9,*+ar0(words_out)
                address sends,r4
                bu      work
receive:        address message,r2
                sti     r2,*+ar0(destination)
                sti     r9,*+ar0(words_in)
                address receives,r4
work:           or      r10,r4
                andn    2000h,st                ; GIE off: the interrupt may not come before IDLE, which sets GIE
                sti     r4,*ar0
                idle
                rets

woken:          reti
