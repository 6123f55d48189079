;******************************************************************
;* What a C compiler makes of a small program: frames through AR3, arguments on the stack from the right, results in R0,
;* initialised variables from .cinit records, a switch by table, calls through pointers, and leaf functions called by LAJ.
;*
;*   int queens(int row, int cols, int left, int right);   solutions of the QUEENS-queens problem
;*   int ack(int m, int n);                                Ackermann's function
;*   int switched(int op, int a, int b);                   + - * & | by op, else -1
;*   void map(int (*f)(int), int *array, int count);
;* main() leaves _solutions, _ackermann, _cases (8 words: op 0..7 on _left and _right), _array (each squared plus 1).
;******************************************************************
FP      .set    AR3
        .if     !defined(QUEENS)
QUEENS  .set    6
        .endif
        .global _c_int00, _main, _queens, _ack, _switched, _map

        .bss    _solutions,1
        .bss    _ackermann,1
        .bss    _cases,8
        .bss    _left,1
        .bss    _right,1
        .bss    _array,5
        .bss    _full,1
        .bss    _stack,600

        .sect   ".cinit"
cinit_start:
        .word   2,_left
        .word   -37,11
        .word   5,_array
        .word   3,-4,0,100,-1000
        .word   1,_full
        .word   (1<<QUEENS)-1
        .word   0

        .text
cinit_at: .word cinit_start
stack_at: .word _stack
_c_int00:
        LDP     stack_at
        LDI     @stack_at,SP
        LDI     SP,FP
        LDI     @cinit_at,AR0
        LDI     *AR0++(1),R1            ; words of the first record
        BZ      CALLMAIN
RECORD: LDI     *AR0++(1),AR1
        LDI     *AR0++(1),R0
        SUBI    1,R1
        RPTS    R1
        STI     R0,*AR1++(1)
||      LDI     *AR0++(1),R0
        LDI     R0,R1                   ; the last one read is the next record's length
        BNZ     RECORD
CALLMAIN:
        LDP     _solutions
        CALL    _main
_exit:  BU      _exit

_main:  PUSH    FP
        LDI     SP,FP
        ADDI    1,SP                    ; int i
        PUSH    R4
        PUSH    R5
        LDI     0,R0
        PUSH    R0
        PUSH    R0
        PUSH    R0
        PUSH    R0
        CALL    _queens
        SUBI    4,SP
        STI     R0,@_solutions
        LDI     3,R1
        PUSH    R1
        LDI     2,R2
        PUSH    R2
        CALL    _ack
        SUBI    2,SP
        STI     R0,@_ackermann
        LDI     0,R0
        STI     R0,*+FP(1)
L1:     LDI     @_right,R0
        PUSH    R0
        LDI     @_left,R1
        PUSH    R1
        LDI     *+FP(1),R2
        PUSH    R2
        CALL    _switched
        SUBI    3,SP
        LDI     *+FP(1),IR0
        LDHI    hi16(_cases),AR2
        OR      lo16(_cases),AR2
        STI     R0,*+AR2(IR0)
        LDI     1,R1
        ADDI    *+FP(1),R1
        STI     R1,*+FP(1)
        CMPI    8,R1
        BLT     L1
        LDI     5,R0
        PUSH    R0
        LDHI    hi16(_array),R1
        OR      lo16(_array),R1
        PUSH    R1
        LDHI    hi16(_square1),R2
        OR      lo16(_square1),R2
        PUSH    R2
        CALL    _map
        SUBI    3,SP
        POP     R5
        POP     R4
        LDI     *-FP(1),R1
        BUD     R1
        LDI     *FP,FP
        NOP
        SUBI    3,SP                    ; local, old FP, return address

* int queens(row, cols, left, right): one local, free
_queens:
        PUSH    FP
        LDI     SP,FP
        ADDI    1,SP
        PUSH    R4
        PUSH    R5
        LDI     *-FP(3),R0              ; cols == full: one more
        CMPI    @_full,R0
        LDIEQ   1,R0
        BEQ     EPI_Q
        LDI     0,R4                    ; count
        OR      *-FP(4),R0
        OR      *-FP(5),R0
        LDI     @_full,R1
        ANDN    R0,R1
        STI     R1,*+FP(1)
        BZ      NONE
L2:     LDI     *+FP(1),R5
        NEGI    R5,R0
        AND     R0,R5                   ; lowest free column
        ANDN    R5,R1
        STI     R1,*+FP(1)
        LDI     *-FP(5),R0
        OR      R5,R0
        LSH     1,R0
        PUSH    R0
        LDI     *-FP(4),R0
        OR      R5,R0
        LSH     -1,R0
        PUSH    R0
        LDI     *-FP(3),R0
        OR      R5,R0
        PUSH    R0
        LDI     *-FP(2),R0
        ADDI    1,R0
        PUSH    R0
        CALL    _queens
        SUBI    4,SP
        ADDI    R0,R4
        LDI     *+FP(1),R1
        BNZ     L2
NONE:   LDI     R4,R0
EPI_Q:  LDI     *-FP(1),R1
        POP     R5
        POP     R4
        BUD     R1
        LDI     *FP,FP
        SUBI    3,SP
        NOP

_ack:   PUSH    FP
        LDI     SP,FP
        LDI     *-FP(2),R0              ; m
        BNZ     L3
        LDI     *-FP(3),R0
        ADDI    1,R0
        B       EPI_A
L3:     LDI     *-FP(3),R1              ; n
        BNZD    L4
        SUBI    1,R0
        LDI     1,R2
        NOP
        PUSH    R2
        PUSH    R0
        CALL    _ack
        SUBI    2,SP
        B       EPI_A
L4:     SUBI    1,R1
        PUSH    R1
        ADDI    1,R0
        PUSH    R0
        CALL    _ack
        SUBI    2,SP
        PUSH    R0
        LDI     *-FP(2),R0
        SUBI    1,R0
        PUSH    R0
        CALL    _ack
        SUBI    2,SP
EPI_A:  LDI     *-FP(1),R1
        BUD     R1
        LDI     *FP,FP
        NOP
        SUBI    2,SP

_switched:
        PUSH    FP
        LDI     SP,FP
        LDI     *-FP(2),R0
        CMPI    4,R0
        BHI     DEFAULT
        LDHI    hi16(SWTAB),AR0
        OR      lo16(SWTAB),AR0
        LDI     R0,IR0
        LDI     *+AR0(IR0),R1
        BUD     R1
        LDI     *-FP(3),R0
        LDI     *-FP(4),R2
        NOP
SWTAB:  .word   CASE0,CASE1,CASE2,CASE3,CASE4
CASE0:  ADDI    R2,R0
        B       EPI_S
CASE1:  SUBI    R2,R0
        B       EPI_S
CASE2:  MPYI    R2,R0
        B       EPI_S
CASE3:  AND     R2,R0
        B       EPI_S
CASE4:  OR      R2,R0
        B       EPI_S
DEFAULT: LDI    -1,R0
EPI_S:  LDI     *-FP(1),R1
        BUD     R1
        LDI     *FP,FP
        NOP
        SUBI    2,SP

_map:   PUSH    FP
        LDI     SP,FP
        PUSH    R4
        PUSH    AR4
        LDI     *-FP(3),AR4
        LDI     *-FP(4),R4
L5:     SUBI    1,R4
        BLT     EPI_M
        LDI     *AR4,R0
        PUSH    R0
        LDI     *-FP(2),R1
        CALLU   R1
        SUBI    1,SP
        STI     R0,*AR4++(1)
        B       L5
EPI_M:  POP     AR4
        POP     R4
        LDI     *-FP(1),R1
        BUD     R1
        LDI     *FP,FP
        NOP
        SUBI    2,SP

* int square1(int x): the product by a leaf with its argument in R2, called by LAJ in the frame of another
_square1:
        PUSH    FP
        LDI     SP,FP
        LAJ     square
        NOP
        LDI     *-FP(2),R2
        NOP
        ADDI    1,R0
        LDI     *-FP(1),R1
        BUD     R1
        LDI     *FP,FP
        NOP
        SUBI    2,SP
square: BUD     R11
        MPYI3   R2,R2,R0
        NOP
        NOP
        .end
