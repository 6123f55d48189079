; What the kernels know of crane, drives and vehicles. The emulator writes the plant's own parameters here when it loads
; the image (emulator/cmrc/programs/plant_constants.cpp); the assembled words are 0.

; ---- geometry
K_A0                .set $ - LIFT               ; m, a_0: luff pivot from the slew axis
                    .space 1
K_JIB               .set $ - LIFT               ; m, L
                    .space 1
K_PIVOT             .set $ - LIFT               ; m, h_p
                    .space 1
K_JIB_SQUARED       .set $ - LIFT               ; m2, L^2; of a gantry 0, so that its rope's length is h_p - z
                    .space 1
K_ONE_OVER_JIB      .set $ - LIFT               ; 1/m
                    .space 1
K_IK_COS_LOW        .set $ - LIFT               ; cosine of the steepest luff angle
                    .space 1
K_IK_COS_HIGH       .set $ - LIFT               ; cosine of the flattest
                    .space 1
; ---- masses and inertias of the slewing crane
K_TQ_JIB_MOMENT     .set $ - LIFT               ; m_j c_j, kg m
                    .space 1
K_TQ_A0_MASS        .set $ - LIFT               ; m_j a_0, kg m
                    .space 1
K_TQ_CW_MOMENT      .set $ - LIFT               ; m_cw r_cw, kg m
                    .space 1
K_TQ_JIB_PIVOT      .set $ - LIFT               ; I_j + m_j c_j^2, kg m2
                    .space 1
K_TQ_SLEW_FIXED     .set $ - LIFT               ; J_s + m_cw r_cw^2, kg m2
                    .space 1
K_TQ_JIB_INERTIA    .set $ - LIFT               ; I_j, kg m2
                    .space 1
K_TQ_JIB_CENTRE     .set $ - LIFT               ; c_j, m
                    .space 1
K_TQ_JIB_MASS       .set $ - LIFT               ; m_j, kg
                    .space 1
K_TQ_GANTRY         .set $ - LIFT               ; m_g + m_j + m_cw, kg
                    .space 1
; ---- either machine's
K_TQ_SPREADER       .set $ - LIFT               ; mass of the spreader, kg
                    .space 1
K_TQ_YAW_BASE       .set $ - LIFT               ; its yaw inertia, kg m2
                    .space 1
K_TQ_YAW_PER_KG     .set $ - LIFT               ; m2: increase by a container, per kg
                    .space 1
K_TQ_DRIVES         .set $ - LIFT               ; per channel: rotor J_m n^2, Coulomb F_c, 1 / v_0, viscous b, 1 / (n
                                                ; eta)
                    .space 25
K_PD_UNIT           .set $ - LIFT               ; per channel: joint unit per encoder count
                    .space 5
K_PD_LIFT           .set $ - LIFT               ; m: times cos phi, by which the jib's tip rises per rad of luff; of a
                                                ; gantry 0
                    .space 1
K_PD_TURN           .set $ - LIFT               ; 1 if the tangential motion also turns the load; of a gantry 0
                    .space 1
K_PD_SWAY_UNIT      .set $ - LIFT               ; rad per code of the sway sensor
                    .space 1
; ---- container
K_GP_HALF_LENGTH    .set $ - LIFT               ; m, half of a container's length, which is the spreader's too
                    .space 1
K_GP_HALF_WIDTH     .set $ - LIFT               ; m
                    .space 1
K_ID_LENGTH         .set $ - LIFT               ; m
                    .space 1
K_ID_HALF_WIDTH     .set $ - LIFT               ; m
                    .space 1
; ---- vehicles
K_TA_ACCELERATE     .set $ - LIFT               ; m/s2: 0.9 of the drive's ramp, for its loop to catch up
                    .space 1
K_TA_BRAKE          .set $ - LIFT               ; m/s2: 0.8 of it
                    .space 1
K_TA_BRAKE_TWICE    .set $ - LIFT
                    .space 1
K_IA_HALF_BASE      .set $ - LIFT               ; m, half the wheelbase
                    .space 1
K_IA_STEER_LIMIT    .set $ - LIFT               ; rad
                    .space 1
K_IA_DRIFT_EMPTY    .set $ - LIFT               ; s2/m: mass / (2 C), empty
                    .space 1
K_IA_DRIFT_LOADED   .set $ - LIFT               ; with a container
                    .space 1
K_AV_HALF           .set $ - LIFT               ; m, half the vehicle's width and 0.4
                    .space 1
K_AV_CLOSE          .set $ - LIFT               ; m, half its width and 0.9: nearer than this beside the way is passed
                                                ; slowly
                    .space 1
K_AV_NEEDS          .set $ - LIFT               ; m from the lane's middle to what is passed: K_AV_HALF and what the
                                                ; vehicle may be off its way, 0.15
                    .space 1
K_AV_WAY            .set $ - LIFT               ; m, width of the way: twice K_AV_HALF
                    .space 1
K_AV_HALF_LENGTH    .set $ - LIFT               ; m, of the vehicle
                    .space 1
K_AV_SWING          .set $ - LIFT               ; m2, less half its square: times a curvature, how far the ends swing
                                                ; out
                    .space 1
K_AV_REAR           .set $ - LIFT               ; m: the rear has passed a place when the middle is this far past it:
                                                ; half the length and 1.6
                    .space 1
K_AV_PASSED         .set $ - LIFT               ; m, the vehicle's length and 1.2
                    .space 1
K_AV_B              .set $ - LIFT               ; m/s2, B: 0.9 of the drive's braking deceleration
                    .space 1
K_AV_TWICE_OVER_B   .set $ - LIFT               ; 2 / B
                    .space 1
K_AV_ONE_OVER_B     .set $ - LIFT               ; 1 / B
                    .space 1
K_DW_HALF_OVER_B    .set $ - LIFT               ; 1 / (2 B)
                    .space 1
K_DW_RADIUS2        .set $ - LIFT               ; m2, K_AV_HALF squared
                    .space 1
