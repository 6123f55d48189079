; Constants of the kernels in agv_all.asm.

        .include "trajectory_agv_constants.asm"
        .include "inverse_agv_constants.asm"
        .include "identify_constants.asm"
        .include "grab_path_constants.asm"
        .include "avoidance_constants.asm"
