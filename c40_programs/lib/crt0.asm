; Start-up of a C program (docs/from-c.md): stack, .bss, initial values, exit(main(0, 0)). For both calling conventions.
;
; ROM model: clears .bss and copies the initial values from the records of .cinit: {words, address, data...}, up to 0
; words. RAM model: the program's loader has set the values, and memory begins at 0. The linker then sets `cinit` to -1,
; as it does without .cinit. GCC has no .cinit, so CLEAR_BSS tells that .bss of its programs is to be cleared
; nevertheless.

                .include "c_runtime.inc"
                .global _c_int00, c_int00, _start, __stack
                .ref    _main, _exit, cinit, .bss, end

                .if     !defined(STACK_WORDS)
STACK_WORDS     .set    400h
                .endif
__stack         .usect  ".stack",STACK_WORDS
                .bss    c_page,1                ; DP's page in the small model, where .bss lies in one page

                .text
_c_int00:
c_int00:
_start:
                address __stack,ar0
                ldi     ar0,sp                  ; PUSH counts up first
                ldi     0,st                    ; no interrupts, no saturation (OVM), no repeat
                address cinit,ar0
                .if     !defined(CLEAR_BSS)
                cmpi    -1,ar0
                beq     call_main
                .endif

                address .bss,ar1
                address end,ar2
                subi3   ar1,ar2,r0              ; words of .bss
                bz      initialise              ; c_page is one word of .bss, but a map may place it elsewhere
                subi3   1,r0,rc
                ldi     0,r0
                rptb    cleared
cleared:        sti     r0,*ar1++

initialise:     cmpi    -1,ar0
                beq     call_main
next_record:    ldi     *ar0++,r1               ; its words
                bz      call_main
                lda     *ar0++,ar1
                subi3   1,r1,rc
                rptb    copied
                ldi     *ar0++,r0
copied:         sti     r0,*ar1++
                b       next_record

call_main:      ldp     @c_page
                lda     sp,ar3                  ; the first frame
                ldi     0,r0
                push    r0                      ; argv, argc: on the stack
                push    r0
                lda     0,ar2                   ; and in registers
                ldi     0,r2
                call    _main
                subi    2,sp
                push    r0
                lda     r0,ar2
                call    _exit
                b       $
