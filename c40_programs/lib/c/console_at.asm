; Where the console is, unless the memory map says it.
                .global __console
__console       .set    0A0000000h
