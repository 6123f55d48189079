; Constants of grab_path.asm and home_crane.asm (m).

K_GP_MARGIN         .set $ - LIFT
                    .float 0.5                  ; distance kept from every box
K_GP_TOUCH          .set $ - LIFT
                    .float 0.05                 ; a straight way may enter the margin by this much
K_GP_RISE           .set $ - LIFT
                    .float 0.5                  ; step by which the column over an end is raised
K_GP_SIXTH          .set $ - LIFT
                    .float 1.6666666666667e-1
K_GP_HUGE           .set $ - LIFT
                    .float 1.0e9
