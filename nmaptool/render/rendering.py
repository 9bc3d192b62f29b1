"""The renderer that was asked for: OpenGL, or NumPy where that is named."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from nmaptool.render import numpy_raster
from nmaptool.render.numpy_raster import Draw


@contextlib.contextmanager
def rendering(renderer: str) -> Iterator[tuple[Draw, str]]:
    """What draws, and its name: see `nmaptool.render.gl.drawing`; OpenGL is not even imported for ``numpy``."""
    if renderer == "numpy":
        yield numpy_raster.visible_faces, renderer
        return
    from nmaptool.render import gl

    with gl.drawing(renderer) as drawn:
        yield drawn
