; Adds up words from the FIFO until a 0, and leaves the sum in the dual-port RAM: its last word rings the other chip.
start:  ldhi 0c000h,ar0
        ldhi 0d000h,ar1
        ldi 0,r3
        ldi ar0,ar2
        addi 100h,ar2
wait:   ldi *+ar2(1),r0
        tstb 1,r0
        bz wait
        ldi *ar2,r1
        bz over
        addi r1,r3
        b wait
over:   ldi 3ffh,ir0
        sti r3,*+ar1(ir0)
done:   b done
