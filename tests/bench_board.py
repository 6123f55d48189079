"""A board of RAM and of a window for devices."""

HEAD = """
name = "bench"

[[region]]
name = "RAM"
base = 0x300000
words = 0x10000
bus = "local"

[[region]]
name = "devices"
kind = "window"
base = 0xA0000000
words = 0x10000
bus = "global"
"""
