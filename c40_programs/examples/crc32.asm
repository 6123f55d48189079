; CRC-32 (Ethernet, zlib; polynomial EDB88320h, reflected) of `length` bytes at `message`, four bytes to a word, the
; first in bits 7-0. Bit by bit, then by a table of 256 words that the program makes: crc_by_bits, crc_by_table.
;
; To see: LSH leaves the bit that it shifts out in the carry, and LDIC turns the carry into a mask without a branch;
; LBU0-LBU3 unpack bytes; a macro parameter that is part of a mnemonic; IR0 as a table index.

                .include "examples.inc"

                .bss    variables,0
                .bss    length,1
                .bss    crc_by_bits,1
                .bss    crc_by_table,1
                .bss    message,512
                .bss    table,256

                .text
start:          set_up
                ldhi    0EDB8h,r3
                or      8320h,r3                ; R3: the polynomial
                address table,ar1
                ldi     ar1,ar0
                ldi     0,r0
                ldi     255,ar5
make_entry:     ldi     r0,r1
                call    eight_bits
                dbd     ar5,make_entry
                sti     r1,*ar0++
                addi    1,r0
                nop

                address by_bits,ar7
                call    whole_message
                sti     r1,@crc_by_bits
                address by_table,ar7
                call    whole_message
                sti     r1,@crc_by_table
done:           b       done

; Adds the byte R0 to the checksum R1, bit by bit. Uses R2, RC.
by_bits:        xor     r0,r1
eight_bits:     ldi     7,rc
                rptb    one_bit
                lsh     -1,r1
                ldi     0,r2
                ldic    r3,r2                   ; LDI does not change the carry
one_bit:        xor     r2,r1
                rets

; The same by the table at AR1. Uses IR0.
by_table:       xor     r1,r0
                and     0FFh,r0
                ldi     r0,ir0
                lsh     -8,r1
                xor     *+ar1(ir0),r1
                rets

take            .macro  n                       ; byte n of the word at AR0
                lbu:n:  *ar0,r0
                callu   ar7
                .endm

; R1: the checksum of the message; the routine at AR7 adds each byte.
whole_message:  address message,ar0
                ldi     -1,r1
                ldi     @length,r4
                lsh     -2,r4
                bz      last_word
next_word:      take    0
                take    1
                take    2
                take    3
                addi    1,ar0
                subi    1,r4
                bnz     next_word
last_word:      ldi     @length,r4
                and     3,r4
                bz      all_taken
                take    0
                cmpi    1,r4
                beq     all_taken
                take    1
                cmpi    2,r4
                beq     all_taken
                take    2
all_taken:      not     r1
                rets
