"""Render a mesh as original, base and detail normal maps."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.progress import Progress, Stages, part
from nmaptool.core.text import in_short
from nmaptool.core.units import Length
from nmaptool.core.vectors import mean_abs_curls, mean_angle_deg
from nmaptool.filters.learned.model import FilterModel
from nmaptool.filters.prepared import PreparedMesh, prepare_mesh
from nmaptool.filters.rolling import Decomposition
from nmaptool.maps.detail import encode_detail
from nmaptool.meshes.lying import lying
from nmaptool.options import BakeOptions, FilterOptions
from nmaptool.options.plain_values import filter_values, plain_values
from nmaptool.reconstruction.reconstruct import reconstruct
from nmaptool.render.camera import Camera, frame_camera
from nmaptool.render.corners import corner_normals
from nmaptool.render.face_buffer import FaceBuffer, draw_face_buffer
from nmaptool.render.rendering import rendering
from nmaptool.types.layer_set import LayerReport, LayerSet
from nmaptool.types.mesh import Mesh
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame
from nmaptool.types.shown import counted

# outside this range of sizes in mm, the units of a mesh are probably not millimetres
_SMALLEST_MM, _LARGEST_MM = 5.0, 5000.0
# a scene in metres may be a building
_LARGEST_STATED_MM = 50_000.0


def bake(
    mesh: Mesh,
    options: BakeOptions | None = None,
    filter: FilterOptions | None = None,
    *,
    model: FilterModel | None = None,
    progress: Progress | None = None,
) -> LayerSet:
    """Render the original, base and detail normal maps of a mesh (paper, Sec. 3 and 4.2.1).

    The face normals of the cleaned mesh are split as by `decompose_normals`. The mesh is drawn once to find the visible
    face of each pixel, and every layer looks up its normals by face.

    Parameters
    ----------
    mesh : Mesh
        Need not be clean: unusable faces are dropped and reported.
    options : BakeOptions, optional
        Size, camera, one view, renderer and detail encoding.
    filter : FilterOptions, optional
        What counts as detail.
    model : FilterModel, optional
        Model for the filter ``learned``. Default: the one that comes with the package.
    progress : callable, optional
        Called with the stage, "filtering" up to 0.7, then "drawing", and the share done, 0 to 1.

    Returns
    -------
    LayerSet
        Normal maps of shape (rows, cols), depth in mm and face numbers. All are rendered on the original geometry
        (paper, Fig. 10), or with ``geometry="updated"`` on a mesh rebuilt to the base normals, by the same camera.

    Raises
    ------
    UsageError
        If options contradict each other or name several views; for several views, use `bake_views`.
    InputError
        If no face of the mesh is usable, or none is visible.
    RendererError
        If no OpenGL context is available.

    Examples
    --------
    >>> import trimesh
    >>> sphere = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=2))
    >>> layers = nm.bake(sphere, nm.BakeOptions(size="64x48", renderer="numpy"))
    >>> layers.original.normals.shape, layers.depth_mm.dtype
    ((48, 64, 3), dtype('float32'))
    """
    options = options or BakeOptions()
    if len(options.views) > 1:
        raise UsageError(f"`view={options.view!r}`: bake renders one view; use bake_views to render several")
    return bake_views(mesh, options, filter, model=model, progress=progress)[0]


def bake_views(
    mesh: Mesh,
    options: BakeOptions | None = None,
    filter: FilterOptions | None = None,
    *,
    model: FilterModel | None = None,
    progress: Progress | None = None,
) -> tuple[LayerSet, ...]:
    """Render the layers of a mesh from several views, as `bake` does from one; the mesh is filtered once.

    Parameters
    ----------
    mesh : Mesh
        As for `bake`.
    options : BakeOptions, optional
        As for `bake`, with one or more views.
    filter, model, progress : optional
        As for `bake`.

    Returns
    -------
    tuple of LayerSet
        One set per view of ``options.view``, in that order.

    Raises
    ------
    UsageError, InputError, RendererError
        As for `bake`, except that several views are allowed.

    Examples
    --------
    >>> import trimesh
    >>> box = nm.Mesh.from_trimesh(trimesh.creation.box())
    >>> views = nm.bake_views(box, nm.BakeOptions(view="front,left", size="32x32", renderer="numpy"))
    >>> [layers.report.view for layers in views]
    ['front', 'left']
    """
    options = options or BakeOptions()
    stages = Stages(progress)
    with stages.stage("clean"):
        prepared = prepare_mesh(mesh, filter, model)
        cameras = [frame_camera(prepared.mesh, options, *direction) for direction in options.directions]
        prepared = _sized(prepared, cameras, options.width)
    made = []
    # open the renderer first: if it fails, the error comes before the slow filter
    with rendering(options.renderer) as renderer:
        draw, platform = renderer
        with stages.stage("filter"):
            split = prepared.decompose(part(progress, 0.1, 0.7))
            shown = prepared.mesh
            if options.geometry == "updated":
                shown, split = _updated(shown, split)
            fields = _fields(shown, split, options)
        for number, (view, camera) in enumerate(zip(options.views, cameras, strict=True)):
            stages.tell("drawing", 0.7 + 0.3 * number / len(cameras))
            with stages.stage("draw"):
                face_buffer = draw_face_buffer(shown, camera, draw, options.supersample)
            with stages.stage("layers"):
                drawn = _Drawn(prepared, options, view, face_buffer, platform)
                made.append(_layer_set(drawn, split, fields))
    seconds = stages.seconds()
    return tuple(dataclasses.replace(s, report=dataclasses.replace(s.report, seconds=seconds)) for s in made)


@dataclass(frozen=True, eq=False)
class _Drawn:
    """A drawing of a mesh and its inputs."""

    prepared: PreparedMesh
    options: BakeOptions
    view: str
    face_buffer: FaceBuffer
    platform: str


def _sized(prepared: PreparedMesh, cameras: list[Camera], width: Length | None) -> PreparedMesh:
    """Set the units of the mesh by the width of the picture, which lengths in mm then refer to."""
    if width is None:
        return prepared
    sizes = [width.to_mm(1.0, 1) / camera.cols / camera.unit_per_px for camera in cameras]
    sigma_s = prepared.filter.sigma_s
    if isinstance(sigma_s, Length) and sigma_s.is_absolute and not np.allclose(sizes, sizes[0], rtol=1e-6):
        raise UsageError(
            f"`sigma_s='{sigma_s}'`: the views differ in scale at `width='{width}'`; give it in %, or use one view"
        )
    sized = dataclasses.replace(prepared.mesh, mm_per_unit=sizes[0], unit_from="given")
    return dataclasses.replace(prepared, mesh=sized)


def _updated(mesh: Mesh, split: Decomposition) -> tuple[Mesh, Decomposition]:
    """Return the mesh rebuilt to its base normals, and the split with the new normals as base (paper, Fig. 10)."""
    rebuilt = reconstruct(mesh, split.base).mesh
    base = rebuilt.geometry.normals
    return rebuilt, dataclasses.replace(split, base=base, residual=split.normals - base)


def _fields(mesh: Mesh, split: Decomposition, options: BakeOptions) -> tuple[Float64, Float64]:
    """Return original and base normals, per face or per corner."""
    if options.shading == "flat":
        return split.normals, split.base
    return corner_normals(mesh, split.normals, options.crease), corner_normals(mesh, split.base, options.crease)


def _layer_set(drawn: _Drawn, split: Decomposition, fields: tuple[Float64, Float64]) -> LayerSet:
    options, face_buffer, camera = drawn.options, drawn.face_buffer, drawn.face_buffer.camera
    prepared, mesh = drawn.prepared, drawn.prepared.mesh
    original, coverage = face_buffer.normal_layer(fields[0])
    if not coverage.any():
        raise InputError(
            f"{mesh.name}: is not visible in the {drawn.view} view; choose another `view`, `pitch` or `target`"
        )
    base, _ = face_buffer.normal_layer(fields[1])
    seen = coverage > 0
    detail = encode_detail(original, base, options.detail_encoding)
    pitch_mm, pitch_from = camera.unit_per_px * mesh.mm_per_unit, mesh.unit_from
    if options.pitch is not None:
        pitch_from = "given"
    if options.width is not None:
        pitch_mm, pitch_from = options.width.to_mm(1.0, 1) / camera.cols, "given"
    frame = Frame(camera.rows, camera.cols, pitch_mm)
    pixel_faces = face_buffer.pixel_faces()
    report = LayerReport(
        options=plain_values(options) | filter_values(prepared.filter),
        mixture=split.mixture,
        detail_share=_share(split, mesh),
        detail_angle_deg=mean_angle_deg(original[seen], base[seen]),
        view=drawn.view,
        pitch_from=pitch_from,
        findings=prepared.findings,
        faces=len(mesh.faces),
        mean_edge=mesh.mean_edge,
        sigma_s_px=prepared.sigma_s / camera.unit_per_px,
        model=prepared.model.digest if prepared.model else "",
        renderer=drawn.platform,
        camera=_camera_metadata(camera),
        curl=mean_abs_curls({"original": original, "base": base, "detail": detail}, seen),
        warnings=_warnings(drawn, coverage),
    )
    maps = {
        name: NormalMap(normals, coverage, frame, name=f"{mesh.name}: {name}")
        for name, normals in (("original", original), ("base", base), ("detail", detail))
    }
    source = np.where(pixel_faces >= 0, prepared.source_faces[pixel_faces], -1).astype(np.int32)
    depth_mm = face_buffer.depth(pixel_faces) * np.float32(pitch_mm / camera.unit_per_px)
    return LayerSet(**maps, report=report, depth_mm=depth_mm, faces=source)


def _camera_metadata(camera: Camera) -> dict[str, Any]:
    return {
        "rotation": camera.rotation.tolist(),
        "center": camera.center.tolist(),
        "unit_per_px": camera.unit_per_px,
        "distance": camera.distance,
    }


def _share(split: Decomposition, mesh: Mesh) -> float:
    areas = mesh.geometry.areas
    return float(areas[split.is_detail].sum() / areas.sum())


def _warnings(drawn: _Drawn, coverage: Float32) -> tuple[str, ...]:
    found = mesh_warnings(drawn.prepared, drawn.options, drawn.view)
    if float((coverage > 0).mean()) < 0.001:
        found.append("the mesh covers less than 0.1% of the picture")
    return tuple(found)


def mesh_warnings(prepared: PreparedMesh, options: BakeOptions, view: str) -> list[str]:
    """Return what can be doubted about a mesh, its units and a view of it before it is drawn."""
    f, mesh = prepared.findings, prepared.mesh
    dropped = ((f.degenerate_faces, "without area"), (f.nonfinite_faces, "with a NaN or infinite vertex"))
    found = [f"dropped {counted(count, 'face')} {why}" for count, why in dropped if count]
    longest = float(np.ptp(mesh.vertices, axis=0).max())
    size_mm = longest * mesh.mm_per_unit
    if options.pitch is None:
        found += _size_doubts(mesh.unit_from, size_mm)
    if options.azimuth is None and options.elevation is None:
        found += lying(mesh, options.up, [view])
    return found + prepared.warnings


def _size_doubts(unit_from: str, size_mm: float) -> list[str]:
    """Doubts about the units of a mesh, at most one."""
    remedy = "set its `unit`, or `width='100mm'`"
    if unit_from == "assumed" and not _SMALLEST_MM <= size_mm <= _LARGEST_MM:
        return [f"the mesh is {in_short(size_mm)} mm large if its units are mm; {remedy}"]
    if unit_from == "file" and size_mm > _LARGEST_STATED_MM:
        return [f"the mesh is {in_short(size_mm / 1000)} m large by the units of its file; {remedy}"]
    return []
