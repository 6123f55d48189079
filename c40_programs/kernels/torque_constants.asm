; Constants of torque compensation; what it knows of the crane stands in plant_constants.asm.
K_TQ_LOAD_FILTER    .set $ - LIFT               ; s, of the load cell's reading
                    .float 0.02
