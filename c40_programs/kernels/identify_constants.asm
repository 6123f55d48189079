; Constants of identify.asm (m).

K_ID_TOLERANCE      .set $ - LIFT
                    .float 16.0                 ; 1 / (0.25 m)^2
K_ID_ENOUGH         .set $ - LIFT
                    .float 0.93                 ; share of the template that a match needs
K_ID_QUANTUM        .set $ - LIFT               ; m, half of what the scanner floors to: the plant's, as those of
                                                ; plant_constants.asm
                    .space 1
K_ID_FAR            .set $ - LIFT
                    .float 1.0e9
