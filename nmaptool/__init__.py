"""Meshes and normal maps in, carved bas-reliefs in exact millimetres out.

    import nmaptool as nm

    layers = nm.bake(nm.read_mesh("head.ply"))
    relief = nm.relief(layers.original, layers.detail, options=nm.ReliefOptions(height=nm.length("3mm")))
    nm.write_relief(relief, "head.stl", preview="head.png")

``__init__.pyi`` lists the public names. They load when they are first used: importing the package alone loads no heavy
library.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
