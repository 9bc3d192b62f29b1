"""Options for comparing two ways of rebuilding a mesh."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import LimitError
from nmaptool.options.bake import VIEWS, Renderer, Up
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Choice, SignedText, parse_size

_MOST_PIXELS = 16_000_000


@dataclass(frozen=True)
class CompareOptions(Options, group="Camera"):
    """How the comparison is rendered.

    Parameters
    ----------
    view:
        Camera position: "front", "back", "left", "right", "top", "bottom" or "iso".
    up:
        Axis of the mesh that points up. With "y", the front is seen from +z; with "z", from -y.
    size:
        Size of each picture in the figure, columns x rows in pixels.
    renderer:
        "auto" tries OpenGL through EGL, then OSMesa, then a window; "egl", "osmesa" or "window" uses only that one.
        "numpy" renders without OpenGL and is slower.
    """

    view: str = option("front", Choice("left", tuple(VIEWS)))
    up: Up = option("y", choice_of(Up))
    size: str = option("640x640", SignedText("640x640"))
    renderer: Renderer = option("auto", choice_of(Renderer))

    def __post_init__(self) -> None:
        super().__post_init__()
        cols, rows = parse_size("size", self.size)
        if cols * rows > _MOST_PIXELS:
            raise LimitError(f"`size={self.size!r}`: has more than {_MOST_PIXELS} pixels; make it smaller")
