; A ship-to-shore gantry: constants of its own kernels; masses and limits are the plant's (plant_constants.asm):
gantry_masses:                                  ; kg: all moving masses without the load; the trolley
                    .space 2
gantry_limits:                                  ; m: travel, trolley, hoist
                    .space 6
gantry_travel:                                  ; T >= c h / v, T^2 >= c h along the quay: 0.1 m/s2; the same for
                                                ; quintics
                    .float 2.4609375, 9.372 / 0.1, 1.875, 5.7735 / 0.1

; New values for the slewing crane's constants: place on chip, number of words, words; a place of 0 ends the list.
gantry_constants:
                    .word K_NE_TABLE, 6 * NE_ROW        ; as in torque_newton_euler_constants.asm: travel, trolley, two
                                                        ; empty links, load, yaw
                    .word 1, 2, 0, 1, 1
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 2, 0, 1, 2, 1
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 0, 1
                    .float 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 0
                    .word 0, 1, 2, 0, 1
                    .float 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 0
                    .word 0, 1, 2, 3, 1
                    .float -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 0, 1, 2, 4, 0
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                    .word 4
                    .word K_PD_JOINTS, 15       ; as in pid_constants.asm
                    .float 0.0, 0.0, 1.0
                    .float 0.0, 0.0, 0.02
                    .float 0.0, 0.0, 0.02
                    .float 0.0, 0.0, 0.03
                    .float 0.0, 0.0, 5.0e-3
                    .word 0
