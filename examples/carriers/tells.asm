; Sleeps until the other chip rings, and tells the sum to its host and on its LEDs.
start:  ldhi 0c000h,ar0
        ldhi 0d000h,ar1
        ldi 3ffh,ir0
        ldhi 2fh,ar3
        or 0fe00h,ar3
        ldpe ar3,ivtp
        ldhi 2fh,sp
        or 0ff00h,sp
        ldhi hi16(isr),r0
        or lo16(isr),r0
        sti r0,*+ar3(4)
        ldi 0b0h,iif
        idle
        sti r4,*ar0
        addi 200h,ar0
        sti r4,*ar0
done:   b done
isr:    ldi *+ar1(ir0),r4
        reti
