; The console's address, unless the memory map gives another one.
                .global __console
__console       .set    0A0000000h
