; Process 7: route 3, from the last commanded pose to CR_HOME, spreader empty (docs/kernels_job.md), by grab_path.asm.
; The column stands over the start, so that the spreader leaves things below it straight up when it must.

kernel_home_crane:
        ldf     0.0, r0
        stf     r0, @GP_HANG
        stf     r0, @GP_LIFT_LEAST
        ldi     0, r0
        sti     r0, @GP_COLUMN
        call    grab_path_present
        ldi     ar6, ar0
        addi    CR_HOME, ar0
        ldhi    hi16(SCRATCH), ar1
        or      lo16(GP_END), ar1
        ldi     3, rc
        call    copy_words
        call    grab_path_grow
        call    grab_path_plan
        ldi     3, r6
        call    grab_path_store
        ldi     @GP_OUT_COUNT, r0
        ldi     0, r1
        rets
