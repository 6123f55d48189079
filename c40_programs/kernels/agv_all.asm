; The kernels of the AGVs, and of the processes that find, plan and go home.

        .include "kernels/trajectory_agv.asm"
        .include "kernels/inverse_agv.asm"
        .include "kernels/identify.asm"
        .include "kernels/grab_path.asm"
        .include "kernels/home_crane.asm"
        .include "kernels/home_agv.asm"
        .include "kernels/avoidance.asm"
