"""Emulator of TMS320C40 multiprocessors that reproduces the CMRC robot controller."""
