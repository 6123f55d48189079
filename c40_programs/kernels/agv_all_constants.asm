; Constants of the kernels in agv_all.asm.

        .include "kernels/trajectory_agv_constants.asm"
        .include "kernels/inverse_agv_constants.asm"
        .include "kernels/identify_constants.asm"
        .include "kernels/grab_path_constants.asm"
