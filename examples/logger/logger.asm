; Echoes what is typed in capitals up to a full stop, and counts a timer's interrupts on the LEDs. From an EPROM:
;   build/bin/emulator asm examples/logger/logger.asm -o logger.out --section .text=2FF800h --section .data=2FF900h
;   build/bin/emulator image logger.out --format intel-hex --width 8 --board examples/logger/logger.toml -o logger.hex
;   build/bin/emulator exec logger.out --board examples/logger/logger.toml --rom logger.hex@300000h --boot reset --console-input -
        .text
start:  ldp     @uart
        ldi     @uart,ar0
        ldi     @leds,ar1
        ldi     @tick,ar2
        ldi     @stack,sp
        ldi     @table,ar3
        ldpe    ar3,ivtp
        ldi     @isr_at,r0
        sti     r0,*+ar3(5)             ; IIOF2
        ldi     5,r0
        sti     r0,*+ar2(2)             ; reload
        sti     r0,*ar2
        ldi     3,r0
        sti     r0,*+ar2(4)             ; runs, interrupts
        ldi     900h,iif                ; IIOF2: interrupt, edge
        or      2000h,st
next:   ldi     *+ar0(2),r1
        tstb    1,r1
        bz      next
        ldi     *ar0,r1
        cmpi    2Eh,r1
        bz      over
        andn    20h,r1
        sti     r1,*ar0
        b       next
over:   andn    2000h,st
done:   b       done
isr:    push    st                      ; addi changes the flags that the program tests
        push    r0
        ldi     1,r0
        sti     r0,*+ar2(6)             ; clears
        addi    1,r5
        sti     r5,*ar1
        pop     r0
        pop     st
        reti
        .data
uart:   .word   0B0000001h
leds:   .word   0B0000010h
tick:   .word   0B0000020h
stack:  .word   2FFF00h
table:  .word   2FFE00h
isr_at: .word   isr
