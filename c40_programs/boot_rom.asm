; The boot loader in the on-chip ROM (c40-hardware.md 9), written from the description of TI's loader: its streams, how
; the pins choose the source, and the state of the chip afterwards. It uses no memory and no stack.
;
;   AR0  peripheral registers          R4  entry of the program (the first block)
;   AR1  next word of a memory source  R5  1 once R4 is known
;   AR2  destination of the next word  AR6 words left in this block, minus one
;   AR3  CPCR of the port              AR5 the routine that fetches a word of the stream into R0
        .text
        .word boot              ; the reset vector

boot:   ldhi 10h,ar0
; The pins IIOF3, 2, 1 are bits 14, 10, 6 of IIF; as a number:
pins:   ldi iif,r0
        lsh3 -6,r0,r1
        and 1,r1
        lsh3 -9,r0,r2
        and 2,r2
        or r2,r1
        lsh3 -12,r0,r2
        and 4,r2
        or r2,r1
        bz pins                 ; 000 is reserved
        cmpi 7,r1
        bz ports

; From memory. The first word, or its low bits, is the width.
        ldhi 0,ar4
        or sources,ar4
        addi r1,ar4
        ldi *ar4,ar1
        ldi *ar1,r0
        and 0ffh,r0
        ldi byte,ar5
        cmpi 8,r0
        bz width
        ldi half,ar5
        cmpi 10h,r0
        bz width
        ldi word,ar5
width:  laju ar5                ; the full word with the width
        nop
        nop
        nop
        b load

; From the first port that has a word; the pins may change while the loader waits.
ports:  ldhi 10h,ar3
        or 40h,ar3
        ldi 5,rc
port:   ldi *ar3,r0
        and 1e00h,r0            ; INPUT LEVEL
        bnz found
        addi 10h,ar3
        subi 1,rc
        cmpi 0,rc               ; arithmetic sets flags for R0 to R11 only
        bnn port
        b pins
found:  ldi link,ar5

load:   laju ar5
        ldi 0,r5
        nop
        nop
        sti r0,*ar0             ; GMICR
        laju ar5
        nop
        nop
        nop
        sti r0,*+ar0(4)         ; LMICR

block:  laju ar5
        nop
        nop
        nop
        ldi r0,r6
        bz trailer
        laju ar5
        nop
        nop
        nop
        ldi r0,ar2
        cmpi 0,r5
        bnz copy
        ldi r0,r4
        ldi 1,r5
; The routine that fetches a word jumps to `stored`, and `stored` jumps back: 8 cycles a word from a port (9.6: 8 to 10).
copy:   subi 1,r6
        ldi r6,ar6
        ldi stored,r11
        bu ar5
stored: dbud ar6,ar5
        sti r0,*ar2++
        nop
        nop
        b block

trailer:
        laju ar5
        nop
        nop
        nop
        ldpe r0,ivtp
        laju ar5
        nop
        nop
        nop
        ldpe r0,tvtp
        laju ar5
        nop
        nop
        nop
        ldi r0,ar4
        nop
        nop
        iack *ar4
        bu r4

; One word of the stream into R0.
link:   bud r11
        ldi *+ar3(1),r0         ; waits while the FIFO is empty
        nop
        nop
word:   bud r11
        ldi *ar1++,r0
        nop
        nop
half:   ldi *ar1++,r0
        and 0ffffh,r0
        bud r11
        ldi *ar1++,r2
        lsh 16,r2
        or r2,r0
byte:   ldi *ar1++,r0
        and 0ffh,r0
        ldi *ar1++,r2
        and 0ffh,r2
        lsh 8,r2
        or r2,r0
        ldi *ar1++,r2
        and 0ffh,r2
        lsh 16,r2
        or r2,r0
        bud r11
        ldi *ar1++,r2
        lsh 24,r2
        or r2,r0

; By the pins IIOF3, 2, 1; 000 and 111 do not select memory.
sources:
        .word 0, 0c0000000h, 0a0000000h, 80000000h, 60000000h, 40000000h, 00300000h, 0
