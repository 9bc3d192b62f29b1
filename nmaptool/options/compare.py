"""How two ways of rebuilding a mesh are compared.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import LimitError, UsageError
from nmaptool.options.bake import VIEWS, Renderer, Up
from nmaptool.options.checks import parse_size, require_choices

_MOST_PIXELS = 16_000_000


@dataclass(frozen=True)
class CompareOptions:
    """How the comparison is drawn.

    Parameters
    ----------
    view:
        Where the camera stands: "front", "back", "left", "right", "top", "bottom" or "iso".
    up:
        Which axis of the mesh points up. "y": the front is seen from +z; "z": from -y.
    size:
        Columns x rows of each picture in the figure.
    renderer:
        "auto": OpenGL through EGL, else OSMesa, else a window of the platform; or one of them; "numpy" draws without
        OpenGL, slower.
    """

    view: str = "front"
    up: Up = "y"
    size: str = "640x640"
    renderer: Renderer = "auto"

    def __post_init__(self) -> None:
        if self.view not in VIEWS:
            raise UsageError(f"--view {self.view!r}: use one of {', '.join(VIEWS)}")
        require_choices(
            ("up", self.up, ("y", "z")), ("renderer", self.renderer, ("auto", "egl", "osmesa", "window", "numpy"))
        )
        cols, rows = parse_size("size", self.size)
        if cols * rows > _MOST_PIXELS:
            raise LimitError(
                f"--size {self.size}: more than the {_MOST_PIXELS} pixels a figure may have; make it smaller"
            )
