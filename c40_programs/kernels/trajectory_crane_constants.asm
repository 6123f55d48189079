; Limits of the crane's motion by segment length: T >= c h / v, T^2 >= c h, T^4 >= c h (docs/kernels.md); v: CR_SPEED.
K_TJ_XY1            .set $ - LIFT               ; S'max
                    .float 2.4609375
K_TJ_XY2            .set $ - LIFT               ; S''max / 0.4 m/s2
                    .float 9.372 / 0.4
K_TJ_XY4            .set $ - LIFT               ; S''''max / 0.0813 m/s4 (0.3 m/s2 at the tip, by l/g = 3.7 s2)
                    .float 623.0 / 0.0813
K_TJ_Z1             .set $ - LIFT               ; S'max
                    .float 2.4609375
K_TJ_Z2             .set $ - LIFT               ; 0.12 m/s2
                    .float 9.372 / 0.12
K_TJ_YAW1           .set $ - LIFT               ; S'max
                    .float 2.4609375
K_TJ_YAW2           .set $ - LIFT               ; 0.03 rad/s2
                    .float 9.372 / 0.03
; The same for quintics: peaks 1.875 and 5.774; no limit on the fourth derivative.
K_TJ_SHAPED         .set $ - LIFT
                    .float 1.875, 5.7735 / 0.4, 0.0, 1.875, 5.7735 / 0.12, 1.875, 5.7735 / 0.03
K_TJ_SEVENTEENTH    .set $ - LIFT
                    .float 1.0 / 17.0
