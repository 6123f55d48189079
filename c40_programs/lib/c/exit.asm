; void exit(int status), void abort(void), and what GCC's main() calls first (docs/from-c.md). R0 keeps the status: at
; `c_exit` the program ends.

                .include "c_runtime.inc"
                .global _exit, _abort, ___main, c_exit

                .text
_abort:         ldi     -1,r0
                b       c_exit
_exit:          whole_argument r0
c_exit:         b       $

___main:        rets                            ; constructors: C has none
