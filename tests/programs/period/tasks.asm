*----------------------------------------------------------------------------
* An executive that divides the chip between three tasks: timer 0 takes it away, trap 0 gives it up, trap 1 ends a task.
* Whatever a task may have in registers is saved on its own stack: 40 bits of R0-R11, the repeat registers, ST last.
*   primes   task A: primes below 500, by a sieve           crc      task B: CRC-32 of `message` (32 words), bit by bit
*   chaos    task C: the logistic map in 40 bits, with circular pointers; PUSH's and PUSHF's word
*   ended    tasks that have ended; switches counts
*----------------------------------------------------------------------------
        .global START, STOP
FRAME   .set    41                      ; words of a saved task
LIMIT   .set    500

        .sect   "vectors"
        .word   START,0,SWITCH
        .sect   "traps"
        .word   SWITCH,FINISH

TCB     .struct
sp      .int
next    .int
SIZE    .endstruct

        .bss    current,1
        .bss    ended,1
        .bss    switches,1
        .bss    primes,1
        .bss    crc,1
        .bss    chaos,2
        .bss    message,32
        .bss    sieve,LIMIT
        .bss    idle_tcb,TCB
        .bss    a_tcb,TCB
        .bss    b_tcb,TCB
        .bss    c_tcb,TCB
        .bss    idle_stack,100
        .bss    a_stack,100
        .bss    b_stack,100
        .bss    c_stack,100
ring    .usect  "ring",3,4

address .macro  symbol,register
        LDHI    hi16(symbol),register
        OR      lo16(symbol),register
        .endm

save    .macro
        PUSH    ST
        .asg    0,n
        .loop   12
        PUSH    R:n:
        PUSHF   R:n:
        .eval   n+1,n
        .endloop
        .asg    0,n
        .loop   8
        PUSH    AR:n:
        .eval   n+1,n
        .endloop
        PUSH    DP
        PUSH    IR0
        PUSH    IR1
        PUSH    BK
        PUSH    RS
        PUSH    RE
        PUSH    RC
        .endm

restore .macro
        POP     RC
        POP     RE
        POP     RS
        POP     BK
        POP     IR1
        POP     IR0
        POP     DP
        .asg    7,n
        .loop   8
        POP     AR:n:
        .eval   n-1,n
        .endloop
        .asg    11,n
        .loop   12
        POPF    R:n:
        POP     R:n:
        .eval   n-1,n
        .endloop
        POP     ST
        .endm

create  .macro  tcb,stack,entry,following
        address stack,AR0
        address entry,R0
        STI     R0,*++AR0(1)            ; where RETI goes
        LDI     4000h,R0                ; PGIE
        STI     R0,*++AR0(1)
        LDI     0,R0
        RPTS    FRAME-1-2
        STI     R0,*++AR0(1)
        address tcb,AR1
        STI     AR0,*+AR1(TCB.sp)
        address following,R0
        STI     R0,*+AR1(TCB.next)
        .endm

        .text
START:  address idle_stack,SP
        LDPK    @current
        address 2FFA00h,AR0
        LDPE    AR0,IVTP
        address 2FFC00h,AR0
        LDPE    AR0,TVTP
        create  a_tcb,a_stack,TASKA,b_tcb
        create  b_tcb,b_stack,TASKB,c_tcb
        create  c_tcb,c_stack,TASKC,idle_tcb
        address idle_tcb,AR0
        STI     AR0,@current
        address a_tcb,R0
        STI     R0,*+AR0(TCB.next)
        LDI     0,R0
        STI     R0,@ended
        STI     R0,@switches
        LDI     1,IIE
        OR      2000h,ST
IDLING: TRAPU   0
        LDI     @ended,R0
        CMPI    3,R0
        BNE     IDLING
        ANDN    2000h,ST
        NOP
STOP:   B       STOP

SWITCH: save
        LDPK    @current
        LDI     @switches,R0
        ADDI    1,R0
        STI     R0,@switches
        LDI     @current,AR0
        STI     SP,*+AR0(TCB.sp)
        LDI     *+AR0(TCB.next),AR0
        STI     AR0,@current
        LDI     *+AR0(TCB.sp),SP
        restore
        RETI

FINISH: LDPK    @current                ; the task does not come back: nothing of it to save but that it has ended
        LDI     @ended,R0
        ADDI    1,R0
        STI     R0,@ended
        RETI

TASKA:  LDPK    @primes
        address sieve,AR0
        LDI     1,R0
        RPTS    LIMIT-1
        STI     R0,*AR0++(1)
        address sieve,AR0
        LDI     2,R1                    ; the next number
next_n: LDI     R1,IR0
        LDI     *+AR0(IR0),R2
        BZ      struck
        ADDI3   R1,R1,R3
        LDI     0,R4
strike: CMPI    LIMIT,R3
        BGE     struck
        LDI     R3,IR1
        STI     R4,*+AR0(IR1)
        BUD     strike
        ADDI    R1,R3
        NOP
        NOP
struck: ADDI    1,R1
        CMPI    LIMIT,R1
        BLT     next_n
        LDI     0,R5
        LDI     *AR0++(2),R2            ; not 0 and 1
        LDI     LIMIT-3,RC
        RPTB    counted
        LDI     *AR0++(1),R2
counted: ADDI   R2,R5
        STI     R5,@primes
        TRAPU   1
rest_a: TRAPU   0
        B       rest_a

TASKB:  LDPK    @crc
        address message,AR2
        address 0EDB88320h,R7
        LDI     -1,R0
        LDI     31,AR4
word_b: XOR     *AR2++(1),R0
        LDI     31,RC
        RPTB    bit
        TSTB    1,R0
        LDIZ    0,R1
        LDINZ   R7,R1
        LSH     -1,R0
bit:    XOR     R1,R0
        DB      AR4,word_b
        NOT     R0,R0
        STI     R0,@crc
        TRAPU   1
rest_b: TRAPU   0
        B       rest_b

TASKC:  LDPK    @chaos
        LDI     3,BK                    ; 3.9, 1.0, 1.0 in turn
        address ring,AR1
        LDF     1.0,R1
        STF     R1,*+AR1(1)
        STF     R1,*+AR1(2)
        LDF     @factor,R1
        STF     R1,*AR1
        LDF     0.25,R0
        LDI     19,AR5
more_c: LDI     49,RC
        RPTBD   mapped
        LDF     *AR1++(1)%,R8
        LDF     *AR1++(1)%,R9
        NOP
        SUBF3   R0,R9,R11               ; 1 - x
        MPYF3   R8,R0,R0
        LDF     *AR1++(1)%,R9           ; 1.0
        LDF     *AR1++(1)%,R8           ; 3.9
        MPYF3   R0,R11,R0
mapped: LDF     *AR1++(1)%,R9           ; 1.0
        DBD     AR5,more_c
        address ring,AR1
        NOP
        LDI     SP,AR0
        PUSH    R0
        PUSHF   R0
        LDI     *+AR0(1),R1
        STI     R1,@chaos
        LDI     *+AR0(2),R1
        STI     R1,@chaos+1
        SUBI    2,SP
        TRAPU   1
rest_c: TRAPU   0
        B       rest_c
        .bss    factor,1
        .end
