; A chain of DMA lists: `emulator exec dma_chain.asm --events events.txt --dump transposed:16`.
;
; Transposes a matrix of 16 x 16 words without the processor. List k of a chain has the registers of a transfer from row
; k, word by word (source index 1), to column k (destination index 16). After each transfer the channel reads the next
; list by itself (TRANSFER MODE 10); the last one stops (01) and interrupts (TCC). The processor writes the lists and
; starts the channel with a count of 0, so that it begins with the first list. Then the processor sleeps.
;
; To see: 16 lists of 7 words at 2 cycles and 16 x 16 words at 2 cycles: 16 * (14 + 32) = 736 cycles, and one to start,
; as --events prints. Lists and matrices are in different on-chip RAM blocks; each block serves two accesses a cycle.

                .include "../examples.inc"

n               .set    16
dma_control     .set    1000a0h                 ; channel 0
counter         .set    3
link            .set    6
vectors         .set    2ffa00h
dmaint0         .set    25h                     ; in the vector table
dmaint0_enabled .set    2000000h                ; in IIE
goes_on         .set    0c00008h                ; START 11, TRANSFER MODE 10
stops           .set    0c40004h                ; START 11, TRANSFER MODE 01, TCC

                .bss    variables,0
matrix          .set    2ffc00h
transposed      .set    2ffd00h
lists           .set    2ff800h

                .text
start:          set_up
                address matrix,ar1              ; word i is i
                ldi     0,r0
                ldi     n*n-1,rc
                rptb    filled
                sti     r0,*ar1++
filled:         addi    1,r0

                address lists,ar1
                address matrix,r0               ; row
                address transposed,r1           ; column
                ldi     1,r2
                ldi     n,r3
                ldi     n-1,ar3
next:           address goes_on,r4
                cmpi    0,ar3
                bne     write
                address stops,r4                ; the last list
write:          sti     r4,*ar1++               ; control
                sti     r0,*ar1++               ; source
                sti     r2,*ar1++               ; source index
                sti     r3,*ar1++               ; counter
                sti     r1,*ar1++               ; destination
                sti     r3,*ar1++               ; destination index
                addi    1,ar1,r5
                sti     r5,*ar1++               ; link: the next list
                addi    n,r0
                addi    1,r1
                db      ar3,next

                address vectors,ar1
                ldpe    ar1,ivtp
                address ended,r0
                sti     r0,*+ar1(dmaint0)
                address dmaint0_enabled,r0
                ldi     r0,iie
                address dma_control,ar0
                ldi     0,r0
                sti     r0,*+ar0(counter)
                address lists,r0
                sti     r0,*+ar0(link)
                address goes_on,r0
                sti     r0,*ar0
                idle                            ; sets GIE, too
done:           b       done

ended:          reti
