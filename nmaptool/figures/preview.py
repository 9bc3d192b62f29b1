"""Pictures and films of reliefs in a material."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from nmaptool.core.arrays import Float32, Srgb
from nmaptool.core.errors import UsageError
from nmaptool.figures.labelled import labelled_sheet
from nmaptool.options.materials import MATERIALS
from nmaptool.options.preview import Light, PreviewOptions, parse_background, parse_section
from nmaptool.shading.field import Field, field_of, picture_shape
from nmaptool.shading.tone import displayed
from nmaptool.types.height import Height
from nmaptool.types.mesh import Mesh
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.relief import Relief

Previewed: TypeAlias = Height | Relief | NormalMap | Mesh
_SMALL_PX = 640
_LARGEST_ISO_PX = 1400
_NAMES = {Height: "Height", Relief: "Relief", NormalMap: "NormalMap", Mesh: "Mesh"}


@dataclass(frozen=True, eq=False)
class _Piece:
    """What a preview shows: heights, a soft outline, the thickness below the lowest point, a mesh that is no relief."""

    height: Height
    coverage: Float32 | None
    base_mm: float | None
    mesh: Mesh | None = None

    def field(self, size_px: int | None) -> Field:
        return field_of(self.height, size_px, self.coverage, self.base_mm)


def preview(relief: Previewed | Mapping[str, Previewed], options: PreviewOptions | None = None) -> Srgb:
    """Draw a relief in a material under lamps, with cast shadows and the shade of its recesses.

    Parameters
    ----------
    relief : Height, Relief, NormalMap, Mesh, or a mapping of names to them
        A normal map is integrated with the default options of `nmaptool.relief`; a mesh is seen along -z. Several
        become a contact sheet with their names.
    options : PreviewOptions, optional

    Returns
    -------
    (h, w, 3) uint8
        sRGB, for display.

    Raises
    ------
    UsageError
        If the value is something else, a section lies outside the relief, or the options ask for a film.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 4)), np.ones((2, 3), bool), nm.Frame(2, 3, pitch_mm=0.5))
    >>> nm.preview(height).shape
    (600, 900, 3)
    """
    options = options or PreviewOptions()
    if options.is_film:
        name = "turntable" if options.turntable else "light_sweep"
        raise UsageError(f"`{name}`: makes a film; write it with write_preview, or leave it out")
    if isinstance(relief, Mapping):
        tile = dataclasses.replace(options, size=options.size or _SMALL_PX)
        return labelled_sheet({name: _still(piece_of(each, tile), tile) for name, each in relief.items()})
    return _still(piece_of(relief, options), options)


def film(relief: Previewed, options: PreviewOptions) -> Iterator[Srgb]:
    """Draw the pictures of a film one by one, see `PreviewOptions`.

    Parameters
    ----------
    relief : Height, Relief, NormalMap or Mesh
    options : PreviewOptions
        With ``turntable`` or ``light_sweep``.

    Yields
    ------
    (h, w, 3) uint8
        All of one size.
    """
    piece = piece_of(relief, options)
    size = options.size or _SMALL_PX
    field = piece.field(size)
    for number in range(options.frames):
        turn = 360.0 * number / options.frames
        if options.turntable:
            # the piece turns, while the camera and the lamps stay where they are
            lights = [_turned(light, -turn) for light in options.lights]
            yield _perspective(piece, field, options, lights, size, -turn, is_steady=True)
        else:
            first, *rest = options.lights
            lights = [_turned(first, -turn), *rest]
            if options.view == "iso":
                yield _perspective(piece, field, options, lights, size, 0.0)
            else:
                yield _from_above(field, options, lights)


def piece_of(relief: Previewed, options: PreviewOptions) -> Any:
    """What a preview of a value shows.

    Raises
    ------
    UsageError
        If it has no preview.
    InputError
        If it cannot be integrated or seen.
    """
    base_mm = None if options.thickness is None else options.thickness.to_mm(1.0, 1)
    if isinstance(relief, NormalMap):
        from nmaptool.reliefs.relief import relief as solved

        relief = solved(relief)
    if isinstance(relief, Relief):
        return _Piece(relief.height, relief.coverage, base_mm)
    if isinstance(relief, Height):
        return _Piece(relief, None, base_mm)
    if isinstance(relief, Mesh):
        from nmaptool.meshes.clean import clean_mesh
        from nmaptool.shading.mesh_front import lattice_of, mesh_front

        size = {} if options.size is None else {"longer_px": options.size}
        mesh = _standing(clean_mesh(relief)[0], options.up)
        height, thick_mm = mesh_front(mesh, **size)
        is_relief = lattice_of(mesh.vertices_mm) is not None
        return _Piece(height, None, thick_mm if base_mm is None else base_mm, None if is_relief else mesh)
    raise UsageError(
        f"the relief must be a {', '.join(list(_NAMES.values())[:-1])} or Mesh, found "
        f"{type(relief).__name__}; read one with read_previewed"
    )


def _standing(mesh: Mesh, up: str) -> Mesh:
    """The mesh with z up."""
    if up == "z":
        return mesh
    x, y, z = mesh.vertices.T
    return dataclasses.replace(mesh, vertices=np.column_stack([x, -z, y]))


def _still(piece: _Piece, options: PreviewOptions) -> Srgb:
    if options.section is not None:
        from nmaptool.figures.section import section_figure
        from nmaptool.shading.section import section

        low, _ = piece.height.range_mm
        back_mm = piece.field(16).back_mm if piece.base_mm is None else low - piece.base_mm
        return section_figure(section(piece.height, *parse_section(options.section)), back_mm, options.size)
    if options.view == "iso":
        size = options.size or min(_LARGEST_ISO_PX, max(picture_shape(*piece.height.frame.shape)))
        field = piece.field(size)
        return _perspective(piece, field, options, options.lights, size, 0.0)
    field = piece.field(options.size)
    return _from_above(field, options, options.lights)


def _backdrop(options: PreviewOptions) -> Float32:
    chosen = parse_background(options.background)
    return np.array(MATERIALS[options.material].backdrop if chosen is None else chosen, np.float32)


def _from_above(field: Field, options: PreviewOptions, lights: Any) -> Srgb:
    from nmaptool.shading.top import top_view

    return displayed(top_view(field, MATERIALS[options.material], lights, _backdrop(options)))


def _perspective(
    piece: _Piece,
    field: Field,
    options: PreviewOptions,
    lights: Any,
    size: int,
    turn: float,
    *,
    is_steady: bool = False,
) -> Srgb:
    from nmaptool.shading.viewpoint import AZIMUTH_DEG

    scene = MATERIALS[options.material], lights, _backdrop(options), size, AZIMUTH_DEG + turn
    if piece.mesh is not None:
        from nmaptool.shading.mesh_view import mesh_view

        return mesh_view(piece.mesh, *scene, is_steady=is_steady)
    from nmaptool.shading.iso import iso_view

    return iso_view(field, *scene, is_steady=is_steady)


def _turned(light: Light, degrees: float) -> Light:
    return dataclasses.replace(light, azimuth_deg=light.azimuth_deg + degrees)
