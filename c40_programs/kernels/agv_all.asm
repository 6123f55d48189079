; The kernels of the AGVs, and of the processes that find, plan and go home.

        .include "trajectory_agv.asm"
        .include "inverse_agv.asm"
        .include "identify.asm"
        .include "grab_path.asm"
        .include "home_crane.asm"
        .include "home_agv.asm"
        .include "avoidance.asm"
        .include "avoidance_common.asm"
        .include "avoidance_potential.asm"
        .include "avoidance_vfh.asm"
        .include "avoidance_dwa.asm"
