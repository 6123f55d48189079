; The links of the crane for torque_newton_euler.asm: b, c, k, joint, slides, sign, p, s, mass, inertia, has. Places,
; masses and inertias that are 0 here and are not 0 are the plant's (plant_constants.asm says where they come from); the
; load's mass and the yaw inertia are filled in from the load.
K_NE_TABLE          .set $ - LIFT
                    .word 1, 2, 0, 0, 1                 ; gantry: mass
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 1, 0                 ; slewing platform with the counterweight: s, mass, inertia
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 6
                    .word 2, 0, 1, 2, 0                 ; jib: p, s, mass, inertia
                    .float -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 7
                    .word 2, 0, 1, 2, 0                 ; turns back at the tip: p
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 3, 1                 ; load
                    .float -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 4, 0                 ; yaw
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 4
