; Constants: copied by _start to CONSTANTS on chip, so @K_NAME is the copy's address (README.md).

LIFT                .set constants - CONSTANTS

constants:
; ---- library
K_TWO_OVER_PI       .set $ - LIFT
                    .float 0.636619772367581
K_HALF_PI           .set $ - LIFT               ; X and X_LOW: two singles whose sum is exact to 2^-48
                    .float 1.5707963705062866
K_HALF_PI_LOW       .set $ - LIFT
                    .float -4.371138828673793e-08
K_QUARTER_PI        .set $ - LIFT
                    .float 0.7853981852531433
K_QUARTER_PI_LOW    .set $ - LIFT
                    .float -2.1855694143368964e-08
K_PI                .set $ - LIFT
                    .float 3.1415927410125732
K_PI_LOW            .set $ - LIFT
                    .float -8.742277657347586e-08
K_2PI               .set $ - LIFT
                    .float 6.2831854820251465
K_2PI_LOW           .set $ - LIFT
                    .float -1.7484555314695172e-07
K_ONE_OVER_2PI      .set $ - LIFT
                    .float 0.15915494309189535
K_SIN3              .set $ - LIFT               ; -1/3!, 1/5!, -1/7!, 1/9!
                    .float -0.16666666666666666
K_SIN5              .set $ - LIFT
                    .float 0.008333333333333333
K_SIN7              .set $ - LIFT
                    .float -1.984126984126984e-4
K_SIN9              .set $ - LIFT
                    .float 2.7557319223985893e-6
K_COS4              .set $ - LIFT               ; 1/4!, -1/6!, 1/8!, -1/10!
                    .float 0.041666666666666664
K_COS6              .set $ - LIFT
                    .float -0.001388888888888889
K_COS8              .set $ - LIFT
                    .float 2.48015873015873e-5
K_COS10             .set $ - LIFT
                    .float -2.755731922398589e-7
K_TAN_PI_8          .set $ - LIFT
                    .float 0.41421356237309503
K_ATAN0             .set $ - LIFT
                    .float -0.33333333
K_ATAN1             .set $ - LIFT
                    .float 0.19999925
K_ATAN2             .set $ - LIFT
                    .float -0.14282548
K_ATAN3             .set $ - LIFT
                    .float 0.11050837
K_ATAN4             .set $ - LIFT
                    .float -0.08508252
K_ATAN5             .set $ - LIFT
                    .float 0.04806254
K_TWO_LOG2E         .set $ - LIFT
                    .float 2.8853900817779268
K_EXP1              .set $ - LIFT
                    .float -0.693147175
K_EXP2              .set $ - LIFT
                    .float 0.240226097
K_EXP3              .set $ - LIFT
                    .float -0.0554992775
K_EXP4              .set $ - LIFT
                    .float 0.00959716896
K_EXP5              .set $ - LIFT
                    .float -0.00129178940
K_EXP6              .set $ - LIFT
                    .float 1.14980842e-4
K_315               .set $ - LIFT
                    .float 315
K_420               .set $ - LIFT
                    .float 420
K_540               .set $ - LIFT
                    .float 540
K_630               .set $ - LIFT
                    .float 630
K_2520              .set $ - LIFT
                    .float 2520
K_15120             .set $ - LIFT
                    .float 15120

; ---- read by several kernels
K_GRAVITY           .set $ - LIFT               ; m/s2, and its reciprocal: filled in like plant_constants.asm
                    .space 1
K_ONE_OVER_G        .set $ - LIFT
                    .space 1
K_MILLI             .set $ - LIFT
                    .float 1.0e-3
K_MICRO             .set $ - LIFT
                    .float 1.0e-6

        .include "kernels/plant_constants.asm"
        .include "kernels/trajectory_crane_constants.asm"
        .include "kernels/torque_constants.asm"
        .include "kernels/torque_newton_euler_constants.asm"
        .include "kernels/pid_constants.asm"
        .include "kernels/agv_all_constants.asm"
constants_end:
