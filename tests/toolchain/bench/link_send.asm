; For scripts/host_costs: sends words at communication port 0 forever.
                .text
start:          ldhi    0010h, ar0
                or      0040h, ar0
                ldi     0, r0
again:          addi    1, r0
                sti     r0, *+ar0(2)
                b       again
