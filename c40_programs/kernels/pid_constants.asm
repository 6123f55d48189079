; Per joint (s, psi, phi, l, kappa). The gains place a double pole at w on an inertia M: K = M w^2 / (n eta) in motor N m per joint
; unit, T_d = 2 / w, T_i = 6 / w, T_t = sqrt(T_d T_i); N = 20 (docs/kernels.md).
; K, K N, T_d, K / T_i, 1 / T_t; u_max and codes per N m, the plant's (plant_constants.asm); tolerance of PID_SETTLED
K_PD_JOINTS         .set $ - LIFT
                    .float 3.5e5 * 9.0 / (314.0 * 0.88), 20.0 * 3.5e5 * 9.0 / (314.0 * 0.88), 2.0 / 3.0, 3.5e5 * 9.0 / (314.0 * 0.88) * 3.0 / 6.0
                    .float 3.0 / 3.4641016151377544, 0.0, 0.0, 0.02
                    .float 2.0e7 * 25.0 / (1250.0 * 0.88), 20.0 * 2.0e7 * 25.0 / (1250.0 * 0.88), 2.0 / 5.0, 2.0e7 * 25.0 / (1250.0 * 0.88) * 5.0 / 6.0
                    .float 5.0 / 3.4641016151377544, 0.0, 0.0, 1.5e-3
                    .float 2.1e8 * 25.0 / (3140.0 * 0.85), 20.0 * 2.1e8 * 25.0 / (3140.0 * 0.85), 2.0 / 5.0, 2.1e8 * 25.0 / (3140.0 * 0.85) * 5.0 / 6.0
                    .float 5.0 / 3.4641016151377544, 0.0, 0.0, 1.5e-3
                    .float 2.83e5 * 64.0 * 0.00955 / 0.88, 20.0 * 2.83e5 * 64.0 * 0.00955 / 0.88, 2.0 / 8.0, 2.83e5 * 64.0 * 0.00955 / 0.88 * 8.0 / 6.0
                    .float 8.0 / 3.4641016151377544, 0.0, 0.0, 0.03
                    .float 3.5e5 * 25.0 / (1500.0 * 0.88), 20.0 * 3.5e5 * 25.0 / (1500.0 * 0.88), 2.0 / 5.0, 3.5e5 * 25.0 / (1500.0 * 0.88) * 5.0 / 6.0
                    .float 5.0 / 3.4641016151377544, 0.0, 0.0, 5.0e-3
K_PD_SWAY_GAIN      .set $ - LIFT               ; m/s of suspension per rad of sway
                    .float 9.0
K_PD_SWAY_LEAK      .set $ - LIFT               ; 1/s
                    .float 0.125
K_PD_SWAY_FILTER    .set $ - LIFT               ; s
                    .float 0.15
K_PD_SWAY_LIMIT     .set $ - LIFT               ; rad
                    .float 0.03
K_PD_SWAY_TOLERANCE .set $ - LIFT               ; rad
                    .float 1.6e-3
K_PD_SETTLE         .set $ - LIFT               ; s within all tolerances
                    .float 1.5
K_PD_REST           .set $ - LIFT               ; joint speed that counts as rest, rad/s or m/s
                    .float 1.0e-4
; Errors. The words from K_PD_FOLLOW to K_PD_SAME are the configuration's (errors.*), which puts its own here; these are its defaults at f_s = 8 kHz.
K_PD_FOLLOW         .set $ - LIFT               ; m or rad, by channel
                    .float 0.1, 0.005, 0.005, 0.1, 0.02
K_PD_FOLLOW_TICKS   .set $ - LIFT               ; refreshes: 50 ms
                    .word 400
K_PD_ENCODER_TICKS  .set $ - LIFT               ; 20 ms
                    .word 160
K_PD_TURNS          .set $ - LIFT               ; DRIVE_SPEED: 2 % of rated speed
                    .word 200
K_PD_SAMPLE         .set $ - LIFT               ; a sample of the sway sensor, 10 ms
                    .word 80
K_PD_SAME           .set $ - LIFT               ; so many equal ones
                    .word 64
K_PD_BACK           .set $ - LIFT               ; rad/s: how fast a joint comes back to its path
                    .float 0.7
K_PD_BACK_ENDS      .set $ - LIFT               ; m or rad: it is there
                    .float 1.0e-5
