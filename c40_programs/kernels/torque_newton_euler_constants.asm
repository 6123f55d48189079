; The links of the crane for torque_newton_euler.asm (plant-and-bus.md 1.4): b, c, k, joint, slides, sign, p, s, mass, inertia, has.
; The load's mass and the yaw inertia are filled in from the payload.
K_NE_TABLE          .set $ - LIFT
                    .word 1, 2, 0, 0, 1                 ; gantry
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 180000.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 1, 0                 ; slewing platform with the counterweight
                    .float 1.0, 0.0, 0.0, 0.0, -7.0, 0.0, 0.0, 60000.0, 0.0, 0.0, 4000000.0
                    .word 6
                    .word 2, 0, 1, 2, 0                 ; jib
                    .float -1.0, 2.5, 0.0, 22.0, 14.0, 0.0, 0.0, 22000.0, 0.0, 1880000.0, 1880000.0
                    .word 7
                    .word 2, 0, 1, 2, 0                 ; turns back at the tip
                    .float 1.0, 32.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 3, 1                 ; load
                    .float -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 4, 0                 ; yaw
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 4
