; Per joint (s, psi, phi, l, kappa): u_max, N m, and codes per N m, which are the plant's (plant_constants.asm);
; tolerance of PID_SETTLED.
K_PD_JOINTS         .set $ - LIFT
                    .float 0.0, 0.0, 0.02
                    .float 0.0, 0.0, 1.5e-3
                    .float 0.0, 0.0, 1.5e-3
                    .float 0.0, 0.0, 0.03
                    .float 0.0, 0.0, 5.0e-3
K_PD_SWAY_TOLERANCE .set $ - LIFT               ; rad
                    .float 1.6e-3
K_PD_GUSTS          .set $ - LIFT               ; ... and more by this, per rad at which the wind makes the rope hang
                    .float 0.25
K_PD_SLACK          .set $ - LIFT               ; the rope is slack below this share of the spreader's weight
                    .float 0.8
K_PD_LONGEST        .set $ - LIFT               ; s, longest step of the wind's observer
                    .float 0.02
K_PD_THIRD          .set $ - LIFT
                    .float 0.3333333333
K_PD_LEAK           .set $ - LIFT               ; o / 4 of K_PC_OBSERVE's 3 o
                    .float 0.0833333333
K_PD_SHOWS          .set $ - LIFT               ; 1/s: share of a speed beside the path that the wind may explain
                    .float 0.125
K_PD_WIND_MOST      .set $ - LIFT               ; m/s2, largest value that counts as wind: the rope hangs 0.08 rad off
                    .float 0.785
K_PD_WINDY          .set $ - LIFT               ; m/s2: with 36 m of rope the wind displaces the load by 0.1 m
                    .float 0.03
K_PD_PLACE          .set $ - LIFT               ; m and m/s: a load within these is over its place; guides catch 0.15 m
                    .float 0.1
K_PD_PLACE_SPEED    .set $ - LIFT
                    .float 0.15
K_PD_SETTLE         .set $ - LIFT               ; s of being within all tolerances
                    .float 1.5
K_PD_REST           .set $ - LIFT               ; joint speed that counts as rest, rad/s or m/s
                    .float 1.0e-4
; Errors. K_PD_FOLLOW to K_PD_SAME are defaults at f_s = 8 kHz; the configuration (errors.*) replaces them.
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
K_PD_SAME           .set $ - LIFT               ; number of equal samples
                    .word 64
K_PD_BACK           .set $ - LIFT               ; rad/s: rate at which a joint returns to its path
                    .float 0.7
K_PD_BACK_ENDS      .set $ - LIFT               ; m or rad: it is there
                    .float 1.0e-5
; What this chip has read of CR_CONTROL_BLOCK, and results computed from it (pid_law.asm). Generation -1: nothing read.
K_PC_GENERATION     .set $ - LIFT
                    .word -1
K_PC_JOINTS         .set KEPT
K_PC_SWAY_GAIN      .set K_PC_JOINTS + PC_SWAY + 0
K_PC_SWAY_WIND      .set K_PC_JOINTS + PC_SWAY + 1
K_PC_SWAY_FILTER    .set K_PC_JOINTS + PC_SWAY + 2
K_PC_SWAY_LIMIT     .set K_PC_JOINTS + PC_SWAY + 3
K_PC_FILTER         .set K_PC_JOINTS + CR_CONTROL_WORDS + 0     ; f x5: T_d / (T_d + N h) for h = PERIOD
K_PC_SMOOTH         .set K_PC_JOINTS + CR_CONTROL_WORDS + 5     ; f h / (T + h) of the measured sway
K_PC_STEP           .set K_PC_JOINTS + CR_CONTROL_WORDS + 6     ; f h of the wind's observer: after a gap its step is
                                                                ; bounded
K_PC_OBSERVE        .set K_PC_JOINTS + CR_CONTROL_WORDS + 7     ; f x3: 3 o h, 3 o^2 h, o^3 h
K_PC_BRAKE          .set K_PC_JOINTS + CR_CONTROL_WORDS + 10    ; f gain / g
K_PC_PERIOD         .set K_PC_JOINTS + CR_CONTROL_WORDS + 11
