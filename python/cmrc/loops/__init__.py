"""The crane's servo loops: their margins by the linear model, and as runs show them (docs/control.md)."""
