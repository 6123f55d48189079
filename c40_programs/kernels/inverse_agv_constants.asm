; Constants of inverse_agv.asm (m, s, rad).

K_IA_LATERAL        .set $ - LIFT
                    .float 0.32                 ; times k_th^2
K_IA_HEADING        .set $ - LIFT
                    .float 0.5                  ; 1/m
K_IA_ALONG          .set $ - LIFT
                    .float 1.2                  ; 1/s
K_IA_HALF_BASE      .set $ - LIFT
                    .float 4.5                  ; m, half the wheelbase
K_IA_STEER_LIMIT    .set $ - LIFT
                    .float 0.52359877559830     ; 30 degrees
K_IA_DRIFT_EMPTY    .set $ - LIFT
                    .float 0.03125              ; s^2/m: mass / (2 C), 25 t and 4e5 N/rad per axle
K_IA_DRIFT_LOADED   .set $ - LIFT
                    .float 0.06875              ; 55 t
K_IA_AT_SPOT        .set $ - LIFT
                    .float 0.01                 ; m from the end of the leg where the vehicle is told to stand
K_IA_FASTEST        .set $ - LIFT
                    .float 6.5                  ; m/s
K_IA_SLOWEST        .set $ - LIFT
                    .float -0.2                 ; m/s, creeping back after an overshoot
K_IA_KILO           .set $ - LIFT
                    .float 1000.0               ; mm per m
K_IA_MEGA           .set $ - LIFT
                    .float 1.0e6                ; microradians per rad
