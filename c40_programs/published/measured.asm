; Our versions of routines that publications time but do not show (docs/validation.md). scripts/validation runs them.

                .text

; Switch to the next process of a ring; the process that yields calls it. AR7: block of the running process: {next, SP}.
; Saves what a nano-kernel's process keeps: return address and frame pointer.
switch_reduced: push    ar3
                sti     sp,*+ar7(1)
                lda     *ar7,ar7
                ldi     *+ar7(1),sp
                pop     ar3
                rets

; The same, saving all that a C function must preserve: R4, R5, R8, R6 and R7 as floats, AR3 to AR6, DP.
switch_c:       push    r4
                push    r5
                push    r8
                pushf   r6
                pushf   r7
                push    ar3
                push    ar4
                push    ar5
                push    ar6
                push    dp
                sti     sp,*+ar7(1)
                lda     *ar7,ar7
                ldi     *+ar7(1),sp
                pop     dp
                pop     ar6
                pop     ar5
                pop     ar4
                pop     ar3
                popf    r7
                popf    r6
                pop     r8
                pop     r5
                pop     r4
                rets

; Two processes that yield to each other forever, by either switch.
process_a:      call    switch_reduced
back_a:         b       process_a
process_b:      call    switch_reduced
back_b:         b       process_b
process_c:      call    switch_c
back_c:         b       process_c
process_d:      call    switch_c
back_d:         b       process_d

; A row of an image convolved with 3 x 3 coefficients, floats. AR0, AR1, AR2: three rows, of RC + 3 pixels; AR3: RC + 1
; results; AR4: nine coefficients, circular, BK = 9.
convolve_row:   rptb    convolved
                mpyf3   *ar0++(1),*ar4++(1)%,r2
                mpyf3   *ar0++(1),*ar4++(1)%,r0
                mpyf3   *ar0--(1),*ar4++(1)%,r0
        ||      addf3   r0,r2,r2
                mpyf3   *ar1++(1),*ar4++(1)%,r0
        ||      addf3   r0,r2,r2
                mpyf3   *ar1++(1),*ar4++(1)%,r0
        ||      addf3   r0,r2,r2
                mpyf3   *ar1--(1),*ar4++(1)%,r0
        ||      addf3   r0,r2,r2
                mpyf3   *ar2++(1),*ar4++(1)%,r0
        ||      addf3   r0,r2,r2
                mpyf3   *ar2++(1),*ar4++(1)%,r0
        ||      addf3   r0,r2,r2
                mpyf3   *ar2--(1),*ar4++(1)%,r0
        ||      addf3   r0,r2,r2
                addf3   r0,r2,r2
convolved:      stf     r2,*ar3++(1)
                rets
