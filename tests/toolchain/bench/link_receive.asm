; For scripts/host_costs: adds up the words that come in at communication port 3.
                .text
start:          ldhi    0010h, ar0
                or      0070h, ar0
                ldi     0, r0
again:          ldi     *+ar0(1), r1
                addi    r1, r0
                b       again
