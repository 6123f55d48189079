; Constants of the kernels in agv_all.asm.
