*----------------------------------------------------------------------------
* A vector library as transputer-like systems on the C40 had it: arguments in registers, called by LAJ, the way back by
* BUD R11, loops set up by RPTBD with work in its slots. Over x and y of `count` (at least 2) floats:
*   dot    sum x y              saxpy   y := a x + y, at `result`
*   top    the largest x, `where` its index, the first if there are several
*   poly   x polynomial with coefficients y at `a`, from the highest power on (Horner), by a trap: LATU 7
*   below  index of the first x below 0 (one must be), by an annulling loop
*----------------------------------------------------------------------------
        .global START
        .sect   "traps"
        .space  7
        .word   VPOLY
        .bss    count,1
        .bss    a,1
        .bss    dot,1
        .bss    top,1
        .bss    where,1
        .bss    poly,1
        .bss    below,1
        .bss    x,300
        .bss    y,300
        .bss    result,300
        .bss    stack,32
at      .macro  symbol,register
        LDHI    hi16(symbol),register
        OR      lo16(symbol),register
        .endm
        .text
START:  at      stack,SP
        at      2FFC00h,AR0
        LDPE    AR0,TVTP
        LDPK    @count
        at      x,AR0
        at      y,AR1
        LAJ     VDOT
        LDI     @count,RC
        LDF     0.0,R2
        NOP
        STF     R0,@dot
        at      x,AR0
        at      y,AR1
        at      result,AR2
        LAJ     VSAXPY
        LDI     @count,RC
        LDF     @a,R7
        NOP
        at      x,AR0
        LAJ     VTOP
        LDI     @count,RC
        LDI     AR0,AR1
        LDF     *AR0,R0
        STF     R0,@top
        STI     R1,@where
        at      y,AR0
        LATU    7
        LDI     @count,RC
        LDF     @a,R7
        LDF     *AR0++(1),R0
        STF     R0,@poly
        at      x,AR0
        LAJ     VBELOW
        LDI     0,R1
        LDF     *AR0,R2
        LDF     0.0,R7
        STI     R1,@below
DONE:   B       DONE

VDOT:   MPYF3   *AR0++(1),*AR1++(1),R0
        SUBI    2,RC
        RPTS    RC
        MPYF3   *AR0++(1),*AR1++(1),R0
||      ADDF3   R0,R2,R2
        BUD     R11
        ADDF3   R0,R2,R0
        NOP
        NOP

VSAXPY: SUBI    2,RC
        RPTBD   SAX
        MPYF3   *AR0++(1),R7,R0         ; the first product, ahead of the loop
        NOP
        NOP
        ADDF3   R0,*AR1++(1),R2
SAX:    MPYF3   *AR0++(1),R7,R0
||      STF     R2,*AR2++(1)
        BUD     R11
        ADDF3   R0,*AR1,R2
        STF     R2,*AR2
        NOP

VTOP:   LDI     AR0,R1
        SUBI    1,RC
        RPTB    COMPARED
        CMPF    *AR0,R0                 ; so far - this
        LDFLT   *AR0,R0
        LDILT   AR0,R1
COMPARED: NOP   *AR0++(1)
        BUD     R11
        SUBI    AR1,R1
        NOP
        NOP

VPOLY:  SUBI    2,RC
        RPTB    HORNER
        MPYF    R7,R0
HORNER: ADDF    *AR0++(1),R0
        BU      R11

VBELOW: CMPF    R7,R2
        BGEAF   VBELOW                  ; its slots only when it goes back
        ADDI    1,R1
        LDF     *+AR0(1),R2
        NOP     *++AR0(1)               ; third slot: annulled, it does not step
        BU      R11
        .end
