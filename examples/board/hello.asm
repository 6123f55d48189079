; Says hello on the board's serial line. It runs in SRAM at 80000000h; an EPROM holds it until the boot loader copies it.
        .text
start:  ldhi    0c000h,ar0              ; the serial line: +0 a character, +1 bit 1 when one can be sent
        ldhi    hi16(text),ar1
        or      lo16(text),ar1
next:   ldi     *ar1++,r0
        bz      done
wait:   tstb    2,*+ar0(1)
        bz      wait
        sti     r0,*ar0
        b       next
done:   b       done
text:   .word   "Hello from an EPROM",10,0
