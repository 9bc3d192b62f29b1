"""Choose the renderer: OpenGL or NumPy."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from nmaptool.render import numpy_raster
from nmaptool.render.numpy_raster import Draw


@contextlib.contextmanager
def rendering(renderer: str) -> Iterator[tuple[Draw, str]]:
    """Yield a draw function and its name, see `nmaptool.render.gl.drawing`; ``numpy`` does not even import OpenGL."""
    if renderer == "numpy":
        yield numpy_raster.visible_faces, renderer
        return
    from nmaptool.render import gl

    with gl.drawing(renderer) as drawn:
        yield drawn
