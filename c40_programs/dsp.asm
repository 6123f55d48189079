; The image of a CMRC DSP: executive, library, kernels (README.md).

        .include "include/task_block.inc"
        .include "include/devices.inc"
        .include "include/areas.inc"
        .include "include/onchip.inc"

        .text

; Interrupt vectors: IVTP points here, so this must start on a 512-word boundary (the image starts at 300000h).
vectors:
        .word   0
        .word   isr_wake                ; 01h NMI
        .word   0                       ; 02h TINT0
        .word   isr_wake, isr_wake, isr_wake, isr_wake          ; 03h IIOF0, the doorbell, to 06h IIOF3
        .space  57

; Written by the loader before the DSP starts.
dsp_slot:       .word 0                 ; number of this DSP
idle_policy:    .word 0                 ; what the DSP does when no block waits: IDLE_DOORBELL, IDLE_PAUSE, IDLE_SPIN
pause_count:    .word 400               ; IDLE_PAUSE: NOPs between two looks at the list, less one

        .include "constants.asm"
        .include "executive.asm"
        .include "lib/arithmetic.asm"
        .include "lib/trigonometry.asm"
        .include "lib/blend.asm"
        .include "lib/copy.asm"
        .include "lib/alive.asm"
        .include "kernels/trajectory_crane.asm"
        .include "kernels/trajectory_crane_shaper.asm"
        .include "kernels/inverse_crane.asm"
        .include "kernels/crane_servo.asm"
        .include "kernels/torque.asm"
        .include "kernels/torque_newton_euler.asm"
        .include "kernels/pid.asm"
        .include "kernels/pid_set_point.asm"
        .include "kernels/pid_sway.asm"
        .include "kernels/pid_law.asm"
        .include "kernels/pid_watch.asm"
        .include "kernels/error.asm"
        .include "kernels/agv_all.asm"  ; trajectory_agv, inverse_agv, identify, grab_path, home, avoidance
        .include "kernels/slices.asm"   ; long tasks in several blocks
        .include "kernels/user.asm"     ; empty: the place for a user's own tasks
        .include "kernels/gantry.asm"   ; the crane's tasks on a ship-to-shore gantry
        .include "kernels/gantry_constants.asm"
        .ifdef  OWN_BLOCKS              ; last, so that the other addresses do not depend on OWN_BLOCKS
        .include "claim_own.asm"
        .endif

        .end
