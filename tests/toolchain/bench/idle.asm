; For scripts/host_costs: the quiet end of a link.
                .text
start:          idle
                b       start
