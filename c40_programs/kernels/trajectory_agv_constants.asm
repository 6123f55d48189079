; Constants of trajectory_agv.asm (m, s, rad).

K_TA_ARRIVED        .set $ - LIFT
                    .float 0.001                ; m of arc left that count as the end of the leg
K_TA_HUGE           .set $ - LIFT
                    .float 1.0e9
K_TA_MICRO          .set $ - LIFT
                    .float 1.0e6                ; us per s
K_TA_SWEEP_FROM     .set $ - LIFT
                    .float -0.125               ; s: steering lead - sweep / 2
K_TA_SWEEP_TO       .set $ - LIFT
                    .float 0.925                ; s: steering lead + sweep / 2
K_TA_SWEEP_LEAST    .set $ - LIFT
                    .float 0.1                  ; m, on either side
K_TA_AT_SPOT        .set $ - LIFT
                    .float 0.01                 ; m along the leg within which the AGV has arrived: there inverse
                                                ; kinematics stops it

; sin u / u = 1 - u^2/3! + u^4/5! - ..., to u^14: error below 2.6e-7 for |u| <= pi, 1e-9 for |u| <= pi/2
K_TA_SINC1          .set $ - LIFT
                    .float -1.6666666666667e-1
K_TA_SINC2          .set $ - LIFT
                    .float 8.3333333333333e-3
K_TA_SINC3          .set $ - LIFT
                    .float -1.9841269841270e-4
K_TA_SINC4          .set $ - LIFT
                    .float 2.7557319223986e-6
K_TA_SINC5          .set $ - LIFT
                    .float -2.5052108385442e-8
K_TA_SINC6          .set $ - LIFT
                    .float 1.6059043836822e-10
K_TA_SINC7          .set $ - LIFT
                    .float -7.6471637318198e-13

K_TA_SHIFT_RATE     .set $ - LIFT
                    .float 0.3                  ; 1/m
K_TA_SHIFT_LEAD     .set $ - LIFT
                    .float 0.35                 ; s
K_TA_SHIFT_MOST     .set $ - LIFT
                    .float 0.04                 ; 1/m
