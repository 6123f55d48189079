; Constants of torque compensation; the crane's parameters are in plant_constants.asm.
K_TQ_LOAD_FILTER    .set $ - LIFT               ; s, of the load cell's reading
                    .float 0.02
K_TQ_WIND_LIMIT     .set $ - LIFT               ; mm/s: above it no lift begins. dock.wind_limit_m_s replaces it
                    .word 20000
