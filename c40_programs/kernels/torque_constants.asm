; Constants of torque compensation; what it knows of the crane stands in plant_constants.asm.
K_TQ_LOAD_FILTER    .set $ - LIFT               ; s, of the load cell's reading
                    .float 0.02
K_TQ_WIND_LIMIT     .set $ - LIFT               ; mm/s: above it no lift begins. dock.wind_limit_m_s puts its own here
                    .word 20000
