; For scripts/host_costs: DMA channel 0 waits for words at communication port 0 while the processor counts.
dma_control     .set    1000A0h                 ; of channel 0
destination     .set    4
destination_index .set  5
auxiliary_counter .set  7
; Split mode, the auxiliary half started and synchronised by ICRDY, both halves to stop at 0.
receives        .set    03800000h + 4000h + 14h + 0C0000h + 0C0h

                .text
start:          ldhi    hi16(dma_control), ar0
                or      lo16(dma_control), ar0
                ldhi    0030h, r2
                sti     r2, *+ar0(destination)
                ldi     1, r2
                sti     r2, *+ar0(destination_index)
                ldi     100h, r2
                sti     r2, *+ar0(auxiliary_counter)
                ldhi    hi16(receives), r4
                or      lo16(receives), r4
                sti     r4, *ar0
                ldi     5, die                  ; ICRDY and OCRDY for channel 0
count:          ldi     100, ar1
again:          addi    1, r0
                xor     3, r0
                db      ar1, again
                addi    1, r7
                b       count
