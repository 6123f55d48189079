; int putchar(int c), int puts(const char *s) on a console device (docs/cli.md, Board files), one character a word. The
; device's address is __console: the memory map's [symbols], or console_at.asm.

                .include "c_runtime.inc"
                .global _putchar, _puts
                .ref    __console

                .text
_putchar:       whole_argument r0
put:            address __console,ar1           ; +0 the character, +1 the status: bit 1: ready for a character
wait:           ldi     *+ar1(1),r1
                tstb    2,r1
                bz      wait
                sti     r0,*ar1
                and     0ffh,r0                 ; as an unsigned char
                rets

_puts:          whole_argument r0
                lda     r0,ar2
next:           ldi     *ar2++,r0
                bz      last
                call    put
                b       next
last:           ldi     10,r0
                b       put                     ; gives 10: not negative, so no error
