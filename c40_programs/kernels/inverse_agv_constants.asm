; Constants of inverse_agv.asm (m, s, rad).

K_IA_LATERAL        .set $ - LIFT
                    .float 0.32                 ; times k_th^2
K_IA_HEADING        .set $ - LIFT
                    .float 0.5                  ; 1/m
K_IA_ALONG          .set $ - LIFT
                    .float 1.2                  ; 1/s
K_IA_AT_SPOT        .set $ - LIFT
                    .float 0.01                 ; m from the end of the leg within which the vehicle stops
K_IA_FASTEST        .set $ - LIFT
                    .float 6.5                  ; m/s
K_IA_SLOWEST        .set $ - LIFT
                    .float -0.2                 ; m/s, speed back after an overshoot
K_IA_KILO           .set $ - LIFT
                    .float 1000.0               ; mm per m
K_IA_MEGA           .set $ - LIFT
                    .float 1.0e6                ; microradians per rad
