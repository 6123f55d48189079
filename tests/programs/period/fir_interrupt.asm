*----------------------------------------------------------------------------
* FIR filter of 11 taps in the service routine of timer 0, as sources for the C3x have it: address constants in a
* table, variables through DP, the samples in a circular buffer, the coefficients from the oldest tap on. Beside
* it a foreground program iterates the logistic map x := 3.9 x (1 - x) in the very registers that the routine
* uses: a single bit of 40 that is not saved and restored shows after some fifty iterations.
*   input     the next sample, before the interrupt
*   outputs   one word per interrupt, `served` counts them
*   chaos     x after ROUNDS x 25 iterations, as PUSH and PUSHF leave it (two words)
*----------------------------------------------------------------------------
        .version 40
        .global BEGIN, SAMPLE
TAPS    .set    11
ROUNDS  .set    40

        .sect   "vectors"
        .word   BEGIN, 0, SAMPLE, 0, 0, 0, 0    ; reset, NMI, TINT0, IIOF0-3

        .bss    input,1
        .bss    newest,1                        ; where the next sample goes
        .bss    outptr,1
        .bss    served,1
        .bss    rounds,1
        .bss    chaos,2
        .bss    outputs,512
        .bss    stack,64
delay   .usect  "delay",TAPS,16

        .data
coeffs  .float  0.0125, -0.04, 0.0875, 0.125, -0.25, 0.5, 0.3125, -0.1, 0.04, 0.02, -0.01
STACKAD .word   stack
DELAYAD .word   delay
COEFAD  .word   coeffs
OUTAD   .word   outputs
VECAD   .word   BEGIN_VECTORS
BEGIN_VECTORS .set 2FFA00h

        .text
BEGIN:  LDP     STACKAD
        LDI     @STACKAD,SP
        LDI     @DELAYAD,AR0
        LDI     @OUTAD,AR1
        LDI     @VECAD,AR2
        LDPE    AR2,IVTP
        LDP     newest
        STI     AR0,@newest
        STI     AR1,@outptr
        LDI     ROUNDS,R0
        STI     R0,@rounds
        LDF     0.0,R0
        STF     R0,@served                      ; 0.0 is 80000000h,
        LDI     0,R0
        STI     R0,@served                      ; so the integer again
        RPTS    TAPS-1
        STF     R0,*AR0++(1)                    ; R0 holds the float 0.0 no more: only its exponent says so
        LDI     1,IIE                           ; TINT0
        OR      2000h,ST                        ; GIE

        LDF     0.25,R0
        LDF     1.0,R3
        LDHI    hi16(factor),AR6
        OR      lo16(factor),AR6
        LDF     *AR6,R4
again:  LDI     24,RC
        RPTB    iterate
        SUBF3   R0,R3,R2                        ; 1 - x
        MPYF    R4,R0
iterate: MPYF   R2,R0
        LDI     @rounds,R5
        SUBI    1,R5
        STI     R5,@rounds
        BNZ     again
        LDI     SP,AR0                          ; both halves of x
        PUSH    R0
        PUSHF   R0
        LDI     *+AR0(1),R5
        LDI     *+AR0(2),R6
        SUBI    2,SP
        STI     R5,@chaos
        STI     R6,@chaos+1
STOP:   B       STOP
factor  .float  3.9

SAMPLE: PUSH    ST
        PUSH    DP
        PUSH    R0
        PUSHF   R0
        PUSH    R2
        PUSHF   R2
        PUSH    AR0
        PUSH    AR1
        PUSH    BK
        PUSH    RS
        PUSH    RE
        PUSH    RC
        LDP     COEFAD
        LDI     @COEFAD,AR0
        LDP     input
        LDI     TAPS,BK
        LDI     @newest,AR1
        LDF     @input,R0
        STF     R0,*AR1++(1)%                   ; over the oldest
        STI     AR1,@newest
        MPYF3   *AR0++(1),*AR1++(1)%,R0
        LDF     0.0,R2
        RPTS    TAPS-2
        MPYF3   *AR0++(1),*AR1++(1)%,R0
||      ADDF3   R0,R2,R2
        ADDF    R0,R2
        LDI     @outptr,AR1
        STF     R2,*AR1++(1)
        STI     AR1,@outptr
        LDI     @served,R0
        ADDI    1,R0
        STI     R0,@served
        POP     RC
        POP     RE
        POP     RS
        POP     BK
        POP     AR1
        POP     AR0
        POPF    R2
        POP     R2
        POPF    R0
        POP     R0
        POP     DP
        POP     ST
        RETI
        .end
