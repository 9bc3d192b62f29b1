"""A mesh to original, base and detail normal maps."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.progress import Progress, Stages, part
from nmaptool.core.units import Length
from nmaptool.core.vectors import mean_abs_curls, mean_angle_deg
from nmaptool.filters.learned.model import FilterModel
from nmaptool.filters.prepared import PreparedMesh, prepare_mesh
from nmaptool.filters.rolling import Decomposition
from nmaptool.maps.detail import encode_detail
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

# sizes in mm beyond which a mesh's units are hardly millimetres
_SMALLEST_MM, _LARGEST_MM = 5.0, 5000.0


def bake(
    mesh: Mesh,
    options: BakeOptions | None = None,
    filter: FilterOptions | None = None,
    *,
    model: FilterModel | None = None,
    progress: Progress | None = None,
) -> LayerSet:
    """Render the original, base and detail normal maps of a mesh (paper, Sec. 3 and 4.2.1).

    The face normals of the cleaned mesh are split as by `decompose_normals`; one drawing of the mesh then says which
    face each pixel sees, and every layer takes its normals from there.

    Parameters
    ----------
    mesh : Mesh
        Need not be clean: unusable faces are dropped and reported.
    options : BakeOptions, optional
        Size, camera, one view, renderer and detail encoding.
    filter : FilterOptions, optional
        What counts as detail.
    model : FilterModel, optional
        For the filter ``learned`` only. Default: the one that comes with the package.
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
        If options contradict each other or name several views; use `bake_views` for those.
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
        raise UsageError(f"`view={options.view!r}`: is several views; use bake_views, which gives a set for each")
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
        One for each view of ``options.view``, in that order.

    Raises
    ------
    UsageError, InputError, RendererError
        As `bake`, which refuses several views.

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
    # the renderer first: where nothing can be drawn, nobody waits for the filter
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
    """A drawing of a mesh, and what it came from."""

    prepared: PreparedMesh
    options: BakeOptions
    view: str
    face_buffer: FaceBuffer
    platform: str


def _sized(prepared: PreparedMesh, cameras: list[Camera], width: Length | None) -> PreparedMesh:
    """The mesh in the millimetres that the picture's width gives it, so that lengths in mm mean those."""
    if width is None:
        return prepared
    sizes = [width.to_mm(1.0, 1) / camera.cols / camera.unit_per_px for camera in cameras]
    sigma_s = prepared.filter.sigma_s
    if isinstance(sigma_s, Length) and sigma_s.is_absolute and not np.allclose(sizes, sizes[0], rtol=1e-6):
        raise UsageError(
            f"`sigma_s='{sigma_s}'`: these views have different scales at `width='{width}'`; give it in %, or one view"
        )
    sized = dataclasses.replace(prepared.mesh, mm_per_unit=sizes[0], unit_from="given")
    return dataclasses.replace(prepared, mesh=sized)


def _updated(mesh: Mesh, split: Decomposition) -> tuple[Mesh, Decomposition]:
    """The mesh rebuilt to its base normals, and the split whose base is the normals that resulted (paper, Fig. 10)."""
    rebuilt = reconstruct(mesh, split.base).mesh
    base = rebuilt.geometry.normals
    return rebuilt, dataclasses.replace(split, base=base, residual=split.normals - base)


def _fields(mesh: Mesh, split: Decomposition, options: BakeOptions) -> tuple[Float64, Float64]:
    """Original and base directions, one a face or one a corner."""
    if options.shading == "flat":
        return split.normals, split.base
    return corner_normals(mesh, split.normals, options.crease), corner_normals(mesh, split.base, options.crease)


def _layer_set(drawn: _Drawn, split: Decomposition, fields: tuple[Float64, Float64]) -> LayerSet:
    options, face_buffer, camera = drawn.options, drawn.face_buffer, drawn.face_buffer.camera
    prepared, mesh = drawn.prepared, drawn.prepared.mesh
    original, coverage = face_buffer.normal_layer(fields[0])
    if not coverage.any():
        raise InputError(
            f"{mesh.name}: nothing of it is seen in the {drawn.view} view; choose another `view`, `pitch` or `target`"
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
    f, options, mesh = drawn.prepared.findings, drawn.options, drawn.prepared.mesh
    counted = (
        (f.degenerate_faces, "faces have no area and were dropped"),
        (f.nonfinite_faces, "faces have a vertex that is NaN or infinite and were dropped"),
    )
    found = [f"{count} {words}" for count, words in counted if count]
    longest = float(np.ptp(mesh.vertices, axis=0).max())
    size_mm = longest * mesh.mm_per_unit
    if mesh.unit_from == "assumed" and options.pitch is None and not _SMALLEST_MM <= size_mm <= _LARGEST_MM:
        found.append(f"is {size_mm:.3g} mm large if its units are mm; say `width='100mm'`, or its `unit`")
    found += drawn.prepared.warnings
    if float((coverage > 0).mean()) < 0.001:
        found.append("less than a thousandth of the picture sees the mesh")
    return tuple(found)
