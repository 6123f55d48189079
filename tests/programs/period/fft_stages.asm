*----------------------------------------------------------------------------
* Complex radix-2 FFT, decimation in time, in place, as application notes have it: N and M = log2 N from outside (64 and 6
* unless said), the table of sines from outside (5/4 of a period), real and imaginary parts side by side, first the points exchanged into
* bit-reversed order by *ARn++(IR0)B, then M stages. X(k) = sum x(n) exp(-2 pi i n k/N).
*   INP    2 N words, real and imaginary part in turn; replaced
*   SINE   N + N/4 words
*----------------------------------------------------------------------------
        .if     !defined(N)
N       .set    64
M       .set    6
        .endif
        .global FFT, SINE
INP     .usect  "points",2*N,2*N
SINE    .usect  "table",N+N/4
        .bss    HALF,1
        .bss    STRIDE,1
        .text
INPAD   .word   INP
SINAD   .word   SINE

FFT:    LDP     INPAD
        LDI     @INPAD,AR0
        LDI     @INPAD,AR1
        LDI     N,IR0                   ; half of the 2 N words
        LDI     N-1,RC
        RPTB    BITRV
        CMPI    AR1,AR0
        BGE     CONT                    ; exchanged already, or the same
        LDF     *AR0,R0
||      LDF     *AR1,R1
        STF     R0,*AR1
||      STF     R1,*AR0
        LDF     *+AR0(1),R0
||      LDF     *+AR1(1),R1
        STF     R0,*+AR1(1)
||      STF     R1,*+AR0(1)
CONT:   NOP     *AR0++(2)
BITRV:  NOP     *AR1++(IR0)B

        LDI     1,R8                    ; points between the two of a butterfly
        LDI     N/2,R9                  ; step in the table = butterflies of a factor
        LDI     M-1,AR7
STAGE:  LDP     INPAD
        LDI     @INPAD,AR4
        LDI     @SINAD,AR5
        LDI     R9,IR1
        LDI     R8,IR0
        LSH     2,IR0
        SUBI    1,IR0                   ; from the imaginary part to the next butterfly
        LDI     R8,AR6
        SUBI    1,AR6
FACTOR: LDI     AR5,AR2
        ADDI    N/4,AR2
        LDF     *AR2,R6                 ; cosine
        LDI     AR4,AR0
        ADDI3   R8,R8,R0
        ADDI3   AR0,R0,AR1
        SUBI3   1,R9,RC
        RPTBD   BFLY
        LDF     *AR5++(IR1),R7          ; sine
        NOP
        NOP     *AR4++(2)
        MPYF3   *AR1,R6,R0              ; t = b (c - i s)
        MPYF3   *+AR1(1),R7,R1
        ADDF3   R0,R1,R2
        MPYF3   *+AR1(1),R6,R0
        MPYF3   *AR1,R7,R1
        SUBF3   R1,R0,R3
        ADDF3   R2,*AR0,R4
        SUBF3   R2,*AR0,R5
||      STF     R4,*AR0++(1)
        STF     R5,*AR1++(1)
        ADDF3   R3,*AR0,R4
        SUBF3   R3,*AR0,R5
BFLY:   STF     R4,*AR0++(IR0)
||      STF     R5,*AR1++(IR0)
        DB      AR6,FACTOR
        DBD     AR7,STAGE
        LSH     1,R8
        LSH     -1,R9
        NOP
DONE:   B       DONE
        .end
