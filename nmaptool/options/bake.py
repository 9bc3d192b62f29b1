"""Options for reading and rendering a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import LimitError, UsageError
from nmaptool.core.units import Length
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Count, Number, Positive, SignedText, Text, parse_size, require_number
from nmaptool.options.length_kinds import LengthText

Unit = Literal["mm", "cm", "m", "in"]
Up = Literal["y", "z"]
Samples = Literal[1, 2, 4]
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
# degrees; a camera farther away cannot resolve depths
_NARROWEST = 0.01


@dataclass(frozen=True)
class MeshReadOptions(Options, group="Reading"):
    """How a mesh file is read.

    Parameters
    ----------
    unit:
        Unit of the mesh file: "mm", "cm", "m" or "in". Default: metres for glTF, otherwise mm.
    max_faces:
        Refuse larger meshes. If the file states its size, it is refused before any memory is used.
    """

    unit: Unit | None = option(None, choice_of(Unit))
    max_faces: int = option(20_000_000, Count())


@dataclass(frozen=True)
class BakeOptions(Options, group="Camera"):
    """How a mesh is rendered.

    Parameters
    ----------
    view:
        Camera position: "front", "back", "left", "right", "top", "bottom" or "iso". Give several, such as "front,left",
        to get one set of maps for each.
    azimuth:
        Azimuth of the camera in degrees, counter-clockwise around the mesh seen from above. Overrides the azimuth of
        --view.
    elevation:
        Elevation of the camera in degrees; 90 looks straight down. Overrides the elevation of --view.
    roll:
        Rotate the picture counter-clockwise by this many degrees.
    up:
        Axis of the mesh that points up. With "y", the front is seen from +z; with "z", from -y.
    size:
        Size of the maps, columns x rows in pixels.
    margin:
        Empty border around the mesh, in px or in % of the longer side.
    width:
        Width of the whole picture, such as 100mm. Overrides the units of the mesh.
    pitch:
        Size of one pixel, such as 0.1mm. Default: the size at which the whole mesh fits into the picture.
    target:
        Point of the mesh to put at the centre of the picture, such as 0,12.5,3. Default: the whole mesh is framed.
    fov:
        Field of view of a perspective camera, in degrees across the longer side. 0 is orthographic.
    shading:
        "flat": each face has its own normal. "smooth": normals are interpolated between vertices.
    crease:
        With smooth shading, keep an edge sharp if its faces differ by more than this many degrees. Smaller values keep
        more edges sharp.
    supersample:
        Samples across a pixel: 1, 2 or 4. Normals and coverage are averaged; more samples give smoother edges.
    renderer:
        "auto" tries OpenGL through EGL, then OSMesa, then a window; "egl", "osmesa" or "window" uses only that one.
        "numpy" renders without OpenGL and is slower.
    geometry:
        "original" renders the mesh unchanged. "updated" renders the mesh rebuilt to match its base normals, which moves
        its silhouette (Fig. 10 of the paper). The camera is the same for both.
    detail_encoding:
        What the detail map stores: "rotation" (blend it back with mode rnm), "slope" (with mode pd), or "difference".
    max_megapixels:
        Refuse larger pictures, counting all views together, before any memory is used. 36 megapixels need about 5 GB.
    """

    view: str = option("front", Text("front,left"))
    azimuth: float | None = option(None, Number("30", -360, 360))
    elevation: float | None = option(None, Number("30", -360, 360))
    roll: float = option(0.0, Number("30", -360, 360))
    up: Up = option("y", choice_of(Up))
    size: str = option("1000x900", SignedText("1000x900"))
    margin: Length = option(Length(4.0, "%"), LengthText("4%"))
    width: Length | None = option(None, LengthText("100mm", absolute=True))
    pitch: Length | None = option(None, LengthText("0.1mm", absolute=True))
    target: str | None = option(None, SignedText("0,12.5,3"))
    fov: float = option(0.0, Number("35", 0, 150))
    shading: Shading = option("flat", choice_of(Shading))
    crease: float = option(60.0, Number("60", 0, 180))
    supersample: Samples = option(2, choice_of(Samples))
    renderer: Renderer = option("auto", choice_of(Renderer))
    geometry: Geometry = option("original", choice_of(Geometry))
    detail_encoding: DetailEncoding = option("rotation", choice_of(DetailEncoding))
    max_megapixels: float = option(100.0, Positive())

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.views, self.target_point
        self._check_directions()
        if 0 < self.fov < _NARROWEST:
            raise UsageError(f"`fov={self.fov:g}`: must be 0 (orthographic) or at least {_NARROWEST:g}, such as 35")
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
                f"`view={self.view!r}`: `azimuth` and `elevation` override the angles of the views, which makes two of "
                "them the same; give one view"
            )

    def _check_lengths(self) -> None:
        if self.margin.is_absolute:
            raise UsageError(f"`margin='{self.margin}'`: give it in px or %, such as 4%")
        if self.width is not None and self.pitch is not None:
            raise UsageError("`width` and `pitch` both set the size of a pixel; give one of them")

    def _check_size(self) -> None:
        # a sample takes a tenth of the memory of a pixel's layers
        pixels = self.rows * self.cols * max(len(self.views), self.supersample**2 / 10) / 1e6
        if pixels > self.max_megapixels:
            raise LimitError(
                f"`size={self.size!r}`: needs {pixels:.3g} megapixels of layers (views: {len(self.views)}, samples "
                f"across a pixel: {self.supersample}), more than the limit of {self.max_megapixels:g}; make it smaller "
                "or raise `max_megapixels`"
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
        """The names of the views, in order."""
        names = tuple(name.strip().lower() for name in self.view.split(","))
        for name in names:
            if name not in VIEWS:
                raise UsageError(f"`view={name!r}`: use one of {', '.join(VIEWS)}, or several, such as front,left")
        if len(set(names)) < len(names):
            raise UsageError(f"`view={self.view!r}`: names a view twice")
        return names

    @property
    def target_point(self) -> tuple[float, float, float]:
        """``target`` as numbers; the origin if it is not given."""
        if self.target is None:
            return (0.0, 0.0, 0.0)
        try:
            x, y, z = (float(part) for part in self.target.split(","))
        except ValueError:
            raise UsageError(f"`target={self.target!r}`: expected three numbers, such as 0,12.5,3") from None
        for part in (x, y, z):
            require_number("target", part, -1e9, 1e9, "0,12.5,3")
        return (x, y, z)
