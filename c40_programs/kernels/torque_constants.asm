; The crane and its drives as torque compensation knows them (plant-and-bus.md 1.4, the plant's defaults).
K_TQ_JIB_MOMENT     .set $ - LIFT               ; m_j c_j, kg m
                    .float 308000.0
K_TQ_A0_MASS        .set $ - LIFT               ; m_j a0, kg m
                    .float 55000.0
K_TQ_CW_MOMENT      .set $ - LIFT               ; m_cw r_cw, kg m
                    .float 420000.0
K_TQ_JIB_PIVOT      .set $ - LIFT               ; I_j + m_j c_j^2, kg m2
                    .float 6192000.0
K_TQ_SLEW_FIXED     .set $ - LIFT               ; J_s + m_cw r_cw^2, kg m2
                    .float 6940000.0
K_TQ_JIB_INERTIA    .set $ - LIFT               ; I_j
                    .float 1880000.0
K_TQ_JIB_CENTRE     .set $ - LIFT               ; c_j, m
                    .float 14.0
K_TQ_JIB_MASS       .set $ - LIFT               ; m_j, kg
                    .float 22000.0
K_TQ_GANTRY         .set $ - LIFT               ; m_g + m_j + m_cw, kg
                    .float 262000.0
K_TQ_YAW_BASE       .set $ - LIFT               ; I_k = base + per_kg m_p: I_spreader - 10 t per_kg
                    .float 125000.0 - 10000.0 * 385000.0 / 30480.0
K_TQ_YAW_PER_KG     .set $ - LIFT               ; m2
                    .float 385000.0 / 30480.0
; Per joint: rotor J_m n^2, Coulomb, 1/v_0, viscous, 1/(n eta). Rated force F = n t, rated joint speed v = 157 / n;
; Coulomb 0.03 F, v_0 = 0.01 v, viscous 0.015 F / v.
K_TQ_DRIVES         .set $ - LIFT
                    .float 0.4 * 314.0 * 314.0, 0.03 * 314.0 * 382.0, 314.0 / 1.57, 0.015 * 382.0 * 314.0 * 314.0 / 157.0, 1.0 / (314.0 * 0.88)
                    .float 4.8 * 1250.0 * 1250.0, 0.03 * 1250.0 * 1911.0, 1250.0 / 1.57, 0.015 * 1911.0 * 1250.0 * 1250.0 / 157.0, 1.0 / (1250.0 * 0.88)
                    .float 20.0 * 3140.0 * 3140.0, 0.03 * 3140.0 * 7643.0, 3140.0 / 1.57, 0.015 * 7643.0 * 3140.0 * 3140.0 / 157.0, 1.0 / (3140.0 * 0.85)
                    .float 16.0 / 0.00955 / 0.00955, 0.03 * 3185.0 / 0.00955, 1.0 / 0.00955 / 1.57, 0.015 * 3185.0 / 0.00955 / 0.00955 / 157.0, 0.00955 / 0.88
                    .float 0.06 * 1500.0 * 1500.0, 0.03 * 1500.0 * 70.0, 1500.0 / 1.57, 0.015 * 70.0 * 1500.0 * 1500.0 / 157.0, 1.0 / (1500.0 * 0.88)
