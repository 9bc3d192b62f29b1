"""Commands on maps larger than memory, tile by tile.

    import nmaptool as nm

    nm.tiled.relief("facade.zarr", "heights.zarr", nm.ReliefOptions(height=nm.length("8mm")))

``__init__.pyi`` lists the public names; each is loaded on first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
