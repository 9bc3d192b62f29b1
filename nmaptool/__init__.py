"""Meshes and normal maps in, carved bas-reliefs in exact millimetres out.

    import nmaptool as nm

    layers = nm.bake(nm.read_mesh("head.ply"))
    relief = nm.relief(layers.original, layers.detail, options=nm.ReliefOptions(height=nm.length("3mm")))
    nm.write_relief(relief, "head.stl", preview="head.png")

``__init__.pyi`` lists the public names. They load when they are first used: importing the package alone loads no heavy
library.
"""

import lazy_loader

from nmaptool.types.shown import set_painter as _set_painter

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _paint(value: object) -> bytes:
    """What a notebook shows of a value: `nmaptool.types` does not know `nmaptool.figures` (decision 0019)."""
    from nmaptool.figures.notebook import png_of  # loads NumPy and OpenCV

    return png_of(value)


_set_painter(_paint)
