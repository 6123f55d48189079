; For scripts/host_costs: what a C compiler makes of a search for the 352 ways to place nine queens.
QUEENS          .set    9
                .include "../../programs/period/c_compiled.asm"
