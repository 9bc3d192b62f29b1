"""Turn meshes and normal maps into bas-reliefs with exact heights in millimetres.

    import nmaptool as nm

    layers = nm.bake(nm.read_mesh("head.ply"))
    relief = nm.relief(layers.original, layers.detail, options=nm.ReliefOptions(height=nm.length("3mm")))
    nm.write_relief(relief, "head.stl", preview="head.png")

``__init__.pyi`` lists the public names. Each is loaded on first use: importing the package alone loads no heavy
library.
"""

import lazy_loader

from nmaptool.types.shown import set_painter as _set_painter

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _paint(value: object) -> bytes:
    """PNG of a value for notebooks; `nmaptool.types` must not import `nmaptool.figures` itself (decision 0019)."""
    from nmaptool.figures.notebook import png_of  # loads NumPy and OpenCV

    return png_of(value)


_set_painter(_paint)
