; Constants of identify.asm (m).

K_ID_TOLERANCE      .set $ - LIFT
                    .float 16.0                 ; 1 / (0.25 m)^2
K_ID_ENOUGH         .set $ - LIFT
                    .float 0.93                 ; share of the template that a match needs
K_ID_QUANTUM        .set $ - LIFT
                    .float 0.004                ; m: the scanner floors to 8 mm
K_ID_FAR            .set $ - LIFT
                    .float 1.0e9
