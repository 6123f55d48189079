; A worm: one chip with a program boots a whole grid of chips without programs, and these boot one another:
; `emulator exec --network worm.toml --dump 0:count:1`.
;
; A chip that leaves reset with the boot ROM waits for a stream on any port (c40-hardware.md 9.3). Chip 0 sends this
; program as a stream to its east and south neighbours. A booted chip gets its place and the grid's size and continues:
; the first row boots east and south, the others south. When all chips that it booted have answered with their counts,
; a chip answers with their sum and itself through the port that booted it. So chip 0 learns the number of chips.
;
; To see: the boot protocol; code that sends itself; AR3, where the loader leaves the control register of its port.
; Chip 0 starts at `start`, the others at `booted`, the first word of the block.

                .include "ports.inc"

east            .set    port_control
south           .set    port_control + port_step

address         .macro  symbol,register         ; register := address of symbol
                ldhi    hi16(symbol),register
                or      lo16(symbol),register
                .endm

                .bss    variables,0
                .bss    count,1                 ; number of chips from this one on
                .bss    column,1
                .bss    row,1
                .bss    columns,1
                .bss    rows,1
                .bss    parent,1                ; CPCR of the port that booted this chip; 0: none
                .bss    stack,16

                .text
booted:         ldi     *+ar3(input),r4         ; column, row, columns, rows
                ldi     *+ar3(input),r5
                ldi     *+ar3(input),r6
                ldi     *+ar3(input),r7
                ldi     ar3,r8
                bu      begin

start:          ldi     0,r4                    ; chip 0: R2, R3 have the shape of the grid
                ldi     0,r5
                ldi     r2,r6
                ldi     r3,r7
                ldi     0,r8
begin:          ldpk    @variables
                address stack,ar0
                ldi     ar0,sp
                sti     r4,@column
                sti     r5,@row
                sti     r6,@columns
                sti     r7,@rows
                sti     r8,@parent
                ldi     1,r0
                sti     r0,@count

; Send to both neighbours before waiting for either: they work at the same time.
                call    has_east
                beq     no_east
                address east,ar0
                ldi     @column,r4
                addi    1,r4
                ldi     @row,r5
                call    infect
no_east:        call    has_south
                beq     no_south
                address south,ar0
                ldi     @column,r4
                ldi     @row,r5
                addi    1,r5
                call    infect
no_south:       call    has_east
                beq     none_east
                address east,ar0
                call    collect
none_east:      call    has_south
                beq     none_south
                address south,ar0
                call    collect
none_south:     ldi     @parent,ar3
                cmpi    0,ar3
                beq     done
                ldi     @count,r0
                sti     r0,*+ar3(output)
done:           b       done

; R0 not 0: this chip has to boot its neighbour in the east, or in the south.
has_east:       ldi     0,r0
                ldi     @row,r1
                bne     decided
                ldi     @columns,r0
                subi    1,r0
                subi    @column,r0
decided:        cmpi    0,r0
                rets
has_south:      ldi     @rows,r0
                subi    1,r0
                subi    @row,r0
                cmpi    0,r0
                rets

; The neighbour's answer through the port whose CPCR is at AR0.
collect:        ldi     *+ar0(input),r0
                addi    @count,r0
                sti     r0,@count
                rets

; The boot stream to the port with its CPCR at AR0: GMICR, LMICR, one block, 0, IVTP, TVTP, IACK address, parameters.
infect:         address 100000h,ar1
                ldi     *ar1,r0                 ; GMICR, LMICR as here
                sti     r0,*+ar0(output)
                ldi     *+ar1(4),r0
                sti     r0,*+ar0(output)
                address end - booted,rc
                ldi     rc,r0
                sti     r0,*+ar0(output)
                subi    1,rc
                address booted,ar1
                ldi     ar1,r0
                sti     r0,*+ar0(output)
                rptb    sent
                ldi     *ar1++,r0
sent:           sti     r0,*+ar0(output)
                ldi     0,r0
                sti     r0,*+ar0(output)        ; no further block
                sti     r0,*+ar0(output)        ; IVTP
                sti     r0,*+ar0(output)        ; TVTP
                address booted,ar1
                ldi     ar1,r0
                sti     r0,*+ar0(output)
                sti     r4,*+ar0(output)
                sti     r5,*+ar0(output)
                ldi     @columns,r0
                sti     r0,*+ar0(output)
                ldi     @rows,r0
                sti     r0,*+ar0(output)
                rets
end:
