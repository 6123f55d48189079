"""A figure that a notebook shows as a picture, whether pyplot is in use or not. Needs matplotlib."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

DPI = 72


class ShownFigure(Figure):
    """A figure of its own, which no pyplot has to know."""

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png", dpi=DPI)
        return out.getvalue()
