"""How a mesh is read and drawn.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import LimitError, UsageError
from nmaptool.core.units import Length, length
from nmaptool.options.checks import parse_size, require_absolute, require_choices, require_number

Up = Literal["y", "z"]
Shading = Literal["flat", "smooth"]
Renderer = Literal["auto", "egl", "osmesa", "window", "numpy"]
Geometry = Literal["original", "updated"]
DetailEncoding = Literal["rotation", "slope", "difference"]

# azimuth and elevation in degrees
VIEWS = {
    "front": (0.0, 0.0),
    "back": (180.0, 0.0),
    "left": (-90.0, 0.0),
    "right": (90.0, 0.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
    "iso": (45.0, 35.264389682754654),
}
# degrees; from farther away, depths cannot be told apart
_NARROWEST = 0.01


@dataclass(frozen=True)
class MeshReadOptions:
    """How a mesh file is read.

    Parameters
    ----------
    unit:
        What one unit of the file is: "mm", "cm", "m" or "in". Default: metres for glTF, else mm.
    max_faces:
        Refuse larger meshes, where the file tells before any memory is taken.
    """

    unit: Literal["mm", "cm", "m", "in"] | None = None
    max_faces: int = 20_000_000

    def __post_init__(self) -> None:
        if self.unit is not None:
            require_choices(("unit", self.unit, ("mm", "cm", "m", "in")))
        if self.max_faces < 1:
            raise UsageError(f"--max-faces {self.max_faces}: must be at least 1")


@dataclass(frozen=True)
class BakeOptions:
    """How a mesh is drawn.

    Parameters
    ----------
    view:
        Where the camera stands: "front", "back", "left", "right", "top", "bottom" or "iso"; several, such as
        "front,left", give a set of maps each.
    azimuth:
        Degrees that the camera walks around the mesh, counter-clockwise seen from above, instead of the view's.
    elevation:
        Degrees that the camera climbs, instead of the view's.
    roll:
        Degrees that the picture turns counter-clockwise.
    up:
        Which axis of the mesh points up. "y": the front is seen from +z; "z": from -y.
    size:
        Columns x rows of the maps.
    margin:
        Free border around the mesh, in px or in % of the longer side.
    width:
        Width of the whole picture, such as 100mm, whatever the mesh's own units say.
    pitch:
        Size of a pixel, such as 0.1mm, instead of framing the whole mesh.
    target:
        Point of the mesh, such as 0,12.5,3, that falls on the picture's centre, instead of framing the mesh.
    fov:
        Degrees that a perspective camera sees across the longer side; 0 is orthographic.
    shading:
        "flat": each face has its own normal; "smooth": normals are interpolated between vertices.
    crease:
        Degrees between two faces from which smooth shading leaves the edge between them sharp.
    supersample:
        1, 2 or 4 samples across a pixel; normals and coverage are averaged.
    renderer:
        "auto": OpenGL through EGL, else OSMesa, else a window of the platform; or one of them; "numpy" draws without
        OpenGL, slower.
    geometry:
        What is drawn: "original", the mesh as it is; "updated", the mesh rebuilt to its base normals, which moves its
        outlines (the paper's Fig. 10); the camera is the same.
    detail_encoding:
        What the detail map holds: "rotation" (undone by blending with mode rnm), "slope" (by mode pd), or
        "difference".
    max_megapixels:
        Refuse larger pictures, all views together, before any memory is taken; 36 take some 5 GB.
    """

    view: str = "front"
    azimuth: float | None = None
    elevation: float | None = None
    roll: float = 0.0
    up: Up = "y"
    size: str = "1000x900"
    margin: Length = Length(4.0, "%")
    width: Length | None = None
    pitch: Length | None = None
    target: str | None = None
    fov: float = 0.0
    shading: Shading = "flat"
    crease: float = 60.0
    supersample: Literal[1, 2, 4] = 2
    renderer: Renderer = "auto"
    geometry: Geometry = "original"
    detail_encoding: DetailEncoding = "rotation"
    max_megapixels: float = 100.0

    def __post_init__(self) -> None:
        require_choices(
            ("up", self.up, ("y", "z")),
            ("shading", self.shading, ("flat", "smooth")),
            ("supersample", str(self.supersample), ("1", "2", "4")),
            ("renderer", self.renderer, ("auto", "egl", "osmesa", "window", "numpy")),
            ("geometry", self.geometry, ("original", "updated")),
            ("detail-encoding", self.detail_encoding, ("rotation", "slope", "difference")),
        )
        for name in ("margin", "width", "pitch"):  # text is as good as a Length
            value = getattr(self, name)
            if isinstance(value, str):
                object.__setattr__(self, name, length(value))
        _ = self.views, self.target_point
        self._check_directions()
        for name in ("azimuth", "elevation", "roll"):
            if getattr(self, name) is not None:
                require_number(name, getattr(self, name), -360, 360, "30")
        require_number("crease", self.crease, 0, 180, "60")
        require_number("fov", self.fov, 0, 150, "35")
        if 0 < self.fov < _NARROWEST:
            raise UsageError(f"--fov {self.fov:g}: must be 0 (orthographic) or at least {_NARROWEST:g}, such as 35")
        self._check_lengths()
        self._check_size()

    @property
    def directions(self) -> tuple[tuple[float, float], ...]:
        """Azimuth and elevation of each view, in degrees."""
        own = (VIEWS[name] for name in self.views)
        return tuple(
            (a if self.azimuth is None else self.azimuth, e if self.elevation is None else self.elevation)
            for a, e in own
        )

    def _check_directions(self) -> None:
        if len(set(self.directions)) < len(self.views):
            raise UsageError(
                f"--view {self.view}: --azimuth and --elevation take the place of a view's own angles, and two of "
                "these views become the same; give one view"
            )

    def _check_lengths(self) -> None:
        if self.margin.is_absolute:
            raise UsageError(f"--margin {self.margin}: give it in px or %, such as 4%")
        require_absolute(width=self.width, pitch=self.pitch)
        if self.width is not None and self.pitch is not None:
            raise UsageError("--width and --pitch both say how large a pixel is; give one of them")

    def _check_size(self) -> None:
        if not self.max_megapixels > 0:
            raise UsageError(f"--max-megapixels {self.max_megapixels:g}: must be greater than zero")
        # a sample costs a tenth of a pixel's layers
        pixels = self.rows * self.cols * max(len(self.views), self.supersample**2 / 10) / 1e6
        if pixels > self.max_megapixels:
            raise LimitError(
                f"--size {self.size}: comes to {pixels:.3g} megapixels of layers ({len(self.views)} of the views, "
                f"{self.supersample} samples across a pixel), more than the limit of {self.max_megapixels:g}; make it "
                "smaller or raise --max-megapixels"
            )

    @property
    def rows(self) -> int:
        """Pixels down."""
        return parse_size("size", self.size)[1]

    @property
    def cols(self) -> int:
        """Pixels across."""
        return parse_size("size", self.size)[0]

    @property
    def views(self) -> tuple[str, ...]:
        """The views' names, in order."""
        names = tuple(name.strip().lower() for name in self.view.split(","))
        for name in names:
            if name not in VIEWS:
                raise UsageError(f"--view {name!r}: use one of {', '.join(VIEWS)}, or several, such as front,left")
        if len(set(names)) < len(names):
            raise UsageError(f"--view {self.view}: names a view twice")
        return names

    @property
    def target_point(self) -> tuple[float, float, float]:
        """``target`` as numbers; the origin where there is none."""
        if self.target is None:
            return (0.0, 0.0, 0.0)
        try:
            x, y, z = (float(part) for part in self.target.split(","))
        except ValueError:
            raise UsageError(f"--target {self.target!r}: expected three numbers, such as 0,12.5,3") from None
        for part in (x, y, z):
            require_number("target", part, -1e9, 1e9, "0,12.5,3")
        return (x, y, z)
