; The heartbeat of a long kernel (docs/kernels.md, Heartbeat): increments TB_ALIVE of its block to show progress. Called
; between rows, sectors or candidates. Keeps all registers and ST; the executive's copy of the block holds the counter.
alive:
        push    ar0
        push    ar1
        ldi     @TASK + TB_ALIVE, ar1
        ldi     @EXEC_BLOCK, ar0
        addi    1, ar1
        sti     ar1, @TASK + TB_ALIVE
        sti     ar1, *+ar0(TB_ALIVE)
        pop     ar1
        pop     ar0
        rets
