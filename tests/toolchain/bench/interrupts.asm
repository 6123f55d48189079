; For scripts/host_costs: a filter of 16 taps in the routine of a timer's interrupt, every 200 cycles, beside a main program
; that counts; the instruction cache is on.

timer_control   .set    100020h
period          .set    8
vectors         .set    2ff800h
tint0           .set    2                       ; in the vector table

address         .macro  symbol,register
                ldhi    hi16(symbol),register
                or      lo16(symbol),register
                .endm

                .bss    stack,64
taps            .usect  "onchip",16,16
delays          .usect  "onchip",16,16

                .text
start:          address stack,ar0
                ldi     ar0,sp
                or      800h,st                 ; the cache
                address vectors,ar1
                ldpe    ar1,ivtp
                address tick,r0
                sti     r0,*+ar1(tint0)
                address taps,ar0
                ldf     0.3,r0
                rpts    31
                stf     r0,*ar0++
                address delays,ar5
                ldi     16,bk
                address timer_control,ar1
                ldi     100,r0                  ; of 2 cycles
                sti     r0,*+ar1(period)
                ldi     2c0h,r0                 ; internal clock, pulses, go
                sti     r0,*ar1
                ldi     1,iie
                or      2000h,st                ; interrupts
                ldi     0,r8
count:          addi    1,r8
                tstb    7,r8
                bnz     count
                xor     r8,r9
                br      count

tick:           push    st
                float   r8,r1
                mpyf    0.001,r1
                stf     r1,*ar5++(1)%
                address taps,ar4
                mpyf3   *ar4++,*ar5++(1)%,r0
                ldf     0.0,r2
                rpts    14
                mpyf3   *ar4++,*ar5++(1)%,r0
        ||      addf3   r0,r2,r2
                addf    r0,r2
                pop     st
                reti
