"""How two ways of rebuilding a mesh are compared."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import LimitError
from nmaptool.options.bake import VIEWS, Renderer, Up
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Choice, SignedText, parse_size

_MOST_PIXELS = 16_000_000


@dataclass(frozen=True)
class CompareOptions(Options, group="Camera"):
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

    view: str = option("front", Choice("left", tuple(VIEWS)))
    up: Up = option("y", choice_of(Up))
    size: str = option("640x640", SignedText("640x640"))
    renderer: Renderer = option("auto", choice_of(Renderer))

    def __post_init__(self) -> None:
        super().__post_init__()
        cols, rows = parse_size("size", self.size)
        if cols * rows > _MOST_PIXELS:
            raise LimitError(
                f"`size={self.size!r}`: more than the {_MOST_PIXELS} pixels a figure may have; make it smaller"
            )
