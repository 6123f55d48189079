; Kernels of processes 1, 2, 7, 8 and of the AGVs, included here as they land. A kind without a kernel answers FFFFFFFFh, as an unknown kind does.
kernel_trajectory_agv:
kernel_inverse_agv:
kernel_identify:
kernel_grab_path:
kernel_home_crane:
kernel_home_agv:
kernel_avoidance:
        ldi     -1, r0
        ldi     0, r1
        rets
