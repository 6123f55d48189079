; A ship-to-shore gantry (plant-and-bus.md 1.4, the plant's gantry_crane). What only its own kernels read:
gantry_masses:                                  ; kg: all that travels but the load; the trolley
                    .float 925000.0, 25000.0
gantry_limits:                                  ; m: travel, trolley, hoist
                    .float -200.0, 200.0, -33.0, 38.5, 3.0, 49.0
gantry_travel:                                  ; T >= c h / v, T^2 >= c h along the quay: 0.1 m/s2; the same for quintics
                    .float 2.4609375, 9.372 / 0.1, 1.875, 5.7735 / 0.1

; What the constants of the slewing crane's programs become: place on chip, number of words, words; a place of 0 ends the list.
gantry_constants:
                    .word K_PIVOT, 1
                    .float 34.0
                    .word K_JIB_SQUARED, 1      ; no jib: the rope's length is h_p - z
                    .float 0.0
                    .word K_TQ_DRIVES, 25       ; as in torque_constants.asm
                    .float 0.0, 0.0, 0.0, 0.0, 0.0
                    .float 1.2 * 209.0 * 209.0, 0.03 * 209.0 * 1146.0, 209.0 / 1.57, 0.015 * 1146.0 * 209.0 * 209.0 / 157.0, 1.0 / (209.0 * 0.88)
                    .float 2.0 * 62.8 * 62.8, 0.03 * 62.8 * 1019.0, 62.8 / 1.57, 0.015 * 1019.0 * 62.8 * 62.8 / 157.0, 1.0 / (62.8 * 0.88)
                    .float 16.0 / 0.00955 / 0.00955, 0.03 * 3185.0 / 0.00955, 1.0 / 0.00955 / 1.57, 0.015 * 3185.0 / 0.00955 / 0.00955 / 157.0, 0.00955 / 0.88
                    .float 0.06 * 1500.0 * 1500.0, 0.03 * 1500.0 * 70.0, 1500.0 / 1.57, 0.015 * 70.0 * 1500.0 * 1500.0 / 157.0, 1.0 / (1500.0 * 0.88)
                    .word K_NE_TABLE, 6 * NE_ROW        ; as in torque_newton_euler_constants.asm: travel, trolley, two empty links, load, yaw
                    .word 1, 2, 0, 1, 1
                    .float 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 900000.0, 0.0, 0.0, 0.0
                    .word 1
                    .word 2, 0, 1, 2, 1
                    .float 1.0, 0.0, 0.0, 34.0, 0.0, 0.0, 0.0, 25000.0, 0.0, 0.0, 0.0
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
                    .word K_PD_UNIT, 5          ; as in pid_constants.asm
                    .float 0.0, 6.283185307179586 / 16384.0 / 209.0, 6.283185307179586 / 16384.0 / 62.8
                    .float 6.283185307179586 / 16384.0 * 0.00955, 6.283185307179586 / 16384.0 / 1500.0
                    .word K_PD_JOINTS, 15
                    .float 1.0, 0.0, 1.0
                    .float 1719.0, 2047.0 / 1719.0, 0.02
                    .float 1528.5, 2047.0 / 1528.5, 0.02
                    .float 4777.5, 2047.0 / 4777.5, 0.03
                    .float 105.0, 2047.0 / 105.0, 5.0e-3
                    .word 0
