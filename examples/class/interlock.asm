; Where cycles go besides instructions: `emulator exec interlock.asm --until done --pipeline 0:24`.
        .text
start:  ldhi    002fh,sp        ; on-chip RAM for the stack
        or      0fc00h,sp
        ldhi    002fh,ar0
        or      0f800h,ar0      ; an address is written ...
        ldf     *ar0,r0         ; ... and used at once: 2 cycles of waiting
        mpyf    r0,r0,r1
        call    twice           ; the pipeline refills: 3 cycles
done:   b       done
twice:  addf    r1,r1
        rets
