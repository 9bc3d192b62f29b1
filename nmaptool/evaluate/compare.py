"""gSfG and Poisson reconstruction on the same targets (paper, Fig. 13)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress, Stages, part
from nmaptool.core.vectors import angles_deg
from nmaptool.evaluate.sweep import CURVES, POISSON_ONCE, as_shown, sweep, verdicts_of
from nmaptool.filters.learned.model import FilterModel
from nmaptool.filters.prepared import PreparedMesh, prepare_mesh
from nmaptool.meshes.distances import hausdorff
from nmaptool.options import BakeOptions, CompareOptions, FilterOptions, ReconstructOptions
from nmaptool.options.bake import VIEWS
from nmaptool.reconstruction.reconstruct import reconstruct
from nmaptool.reconstruction.smooth import target_normals
from nmaptool.render.camera import Camera, frame_camera
from nmaptool.render.face_buffer import draw_face_buffer
from nmaptool.render.numpy_raster import Draw
from nmaptool.render.rendering import rendering
from nmaptool.types.comparison import Comparison, Contender, CurvePoint, RenderedView
from nmaptool.types.mesh import Mesh
from nmaptool.types.reconstruction import Reconstruction

_BINS = 60
_LIGHT = np.array([-0.45, 0.5, 0.74])


def compare(
    mesh: Mesh,
    options: CompareOptions | None = None,
    filter: FilterOptions | None = None,
    reconstruct_options: ReconstructOptions | None = None,
    *,
    model: FilterModel | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Rebuild a mesh to its base normals by gSfG and by Poisson's equation, and compare both (paper, Fig. 13).

    Each scheme trades normal deviation for vertex deviation. Both are run over a range of their closeness parameter, so
    vertex deviations can be compared at equal normal deviations.

    Parameters
    ----------
    mesh : Mesh
        Need not be clean: unusable faces are dropped.
    options : CompareOptions, optional
        View and renderer of the figure.
    filter : FilterOptions, optional
        Filter that gives the target normals.
    reconstruct_options : ReconstructOptions, optional
        Options of the gSfG run that the figure shows.
    model : FilterModel, optional
        Model for the filter ``learned``. Default: the one that comes with the package.
    progress : callable, optional
        Called with the stage and the share done, 0 to 1; most of it is "sweeping".

    Returns
    -------
    Comparison
        Deviations in mm and degrees of every run, and a verdict.

    Raises
    ------
    UsageError
        If ``reconstruct_options.scheme`` is Poisson.
    InputError
        If no face of the mesh is usable.
    RendererError
        If no OpenGL context is available.

    Examples
    --------
    >>> import trimesh
    >>> sphere = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=1))
    >>> comparison = nm.compare(sphere, nm.CompareOptions(size="64x64", renderer="numpy"))
    >>> list(comparison.contenders), comparison.faces
    (['gsfg', 'poisson'], 80)
    """
    options = options or CompareOptions()
    ours = reconstruct_options or ReconstructOptions()
    if ours.scheme == "poisson":
        raise UsageError("`scheme='poisson'`: Poisson is always compared; choose the gSfG scheme to compare it with")
    stages = Stages(progress)
    with stages.stage("whole"):
        comparison = _compared(prepare_mesh(mesh, filter, model), options, ours, stages)
    return dataclasses.replace(comparison, seconds=stages.seconds(digits=2))


def _compared(prepared: PreparedMesh, options: CompareOptions, ours: ReconstructOptions, stages: Stages) -> Comparison:
    """Return the comparison, without its timing."""
    camera = frame_camera(prepared.mesh, _bake_options(options), *VIEWS[options.view])
    with rendering(options.renderer) as (draw, _):
        split = prepared.decompose(part(stages.progress, 0.0, 0.1))
        bench = _Bench(prepared.mesh, target_normals(split, 0.0))
        found = {"gsfg": bench.run(ours)}
        curves = {}
        for number, name in enumerate(CURVES):
            curves[name] = sweep(name, bench.point, ours, _part(stages, number))
        stages.tell("measuring", 0.9)
        found["poisson"] = bench.run(_matched(curves[POISSON_ONCE], bench.point_of(found["gsfg"], ours), ours))
        contenders = {name: bench.contender(each) for name, each in found.items()}
        rendered_views = {name: _rendered_view(each, camera, draw) for name, each in contenders.items()}
    edges = bench.edges(list(found.values()))
    contenders = {
        name: dataclasses.replace(each, histogram=bench.histogram(found[name], edges))
        for name, each in contenders.items()
    }
    return Comparison(
        name=prepared.mesh.name,
        faces=len(prepared.mesh.faces),
        vertices=len(prepared.mesh.vertices),
        diagonal_mm=bench.diagonal_mm,
        filter=prepared.filter,
        normal_before_deg=found["gsfg"].report.normal_deviation_before_deg,
        edges_deg=edges,
        contenders=contenders,
        curves=curves,
        verdicts=(as_shown(contenders["gsfg"], contenders["poisson"]), *verdicts_of(curves)),
        rendered_views=rendered_views,
    )


@dataclass(frozen=True, eq=False)
class _Bench:
    """A clean mesh and the target normals for all schemes."""

    mesh: Mesh
    targets: Float64

    @property
    def diagonal_mm(self) -> float:
        return float(np.linalg.norm(np.ptp(self.mesh.vertices, axis=0))) * self.mesh.mm_per_unit

    def run(self, options: ReconstructOptions) -> Reconstruction:
        return reconstruct(self.mesh, self.targets, options)

    def point(self, options: ReconstructOptions) -> CurvePoint:
        return self.point_of(self.run(options), options)

    def point_of(self, found: Reconstruction, options: ReconstructOptions) -> CurvePoint:
        off = self._deviation_mm(found)
        closeness = None if options.scheme == "gsfg" else options.closeness
        rms = float(np.sqrt((off**2).mean()))
        return CurvePoint(closeness, options.steps, found.report.normal_deviation_deg, rms, found.report.folded_after)

    def contender(self, found: Reconstruction) -> Contender:
        """Return the figures of one scheme, without its histogram."""
        mesh, report = self._aligned(found), found.report
        off = self._deviation_mm(found)
        there, back = hausdorff(mesh.vertices, self.mesh)[0], hausdorff(self.mesh.vertices, mesh)[0]
        angles = self._angles(found)
        return Contender(
            options=report.options,
            mesh=mesh,
            deviation_mm=off,
            rms_mm=float(np.sqrt((off**2).mean())),
            mean_mm=float(off.mean()),
            max_mm=float(off.max()),
            hausdorff_mm=max(there, back) * mesh.mm_per_unit,
            to_original_mm=there * mesh.mm_per_unit,
            from_original_mm=back * mesh.mm_per_unit,
            normal_mean_deg=report.normal_deviation_deg,
            normal_median_deg=float(np.median(angles)),
            normal_p95_deg=report.normal_deviation_p95_deg,
            histogram=np.zeros(0),
            folded=report.folded_after,
            volume_share=report.volume_share,
            seconds=report.seconds,
        )

    def edges(self, found: list[Reconstruction]) -> Float64:
        """Return histogram bins up to the larger of the schemes' 98th percentiles."""
        end = max(float(np.percentile(self._angles(each), 98)) for each in found)
        return np.linspace(0, max(end, 1e-6), _BINS + 1)

    def histogram(self, found: Reconstruction, edges: Float64) -> Float64:
        areas = self.mesh.geometry.areas
        angles = self._angles(found).clip(edges[0], edges[-1])
        return np.asarray(np.histogram(angles, edges, weights=areas)[0] / areas.sum())

    def _aligned(self, found: Reconstruction) -> Mesh:
        shift = self.mesh.vertices.mean(axis=0) - found.vertices.mean(axis=0)
        return dataclasses.replace(found.mesh, vertices=found.vertices + shift)

    def _deviation_mm(self, found: Reconstruction) -> Float64:
        off = self._aligned(found).vertices - self.mesh.vertices
        return np.asarray(np.sqrt(np.einsum("ij,ij->i", off, off)) * self.mesh.mm_per_unit)

    def _angles(self, found: Reconstruction) -> Float64:
        return angles_deg(found.mesh.geometry.normals, self.targets)


def _part(stages: Stages, number: int) -> Callable[[float], None]:
    return lambda share: stages.tell("sweeping", 0.1 + 0.8 * (number + share) / len(CURVES))


def _matched(points: tuple[CurvePoint, ...], ours: CurvePoint, options: ReconstructOptions) -> ReconstructOptions:
    """Return options for Poisson in one solve, with the closeness whose deviations have ratios to ours closest to 1."""

    def off(point: CurvePoint) -> float:
        pairs = ((point.normal_deg, ours.normal_deg), (point.rms_mm, ours.rms_mm))
        return sum(math.log(max(theirs, 1e-12) / max(own, 1e-12)) ** 2 for theirs, own in pairs)

    nearest = min(points, key=off)
    assert nearest.closeness is not None
    return dataclasses.replace(options, scheme="poisson", steps=1, closeness=nearest.closeness)


def _bake_options(options: CompareOptions) -> BakeOptions:
    return BakeOptions(view=options.view, up=options.up, size=options.size, renderer=options.renderer)


def _rendered_view(contender: Contender, camera: Camera, draw: Draw) -> RenderedView:
    face_buffer = draw_face_buffer(contender.mesh, camera, draw, 2)
    face, off = face_buffer.sampled_faces, contender.deviation_mm
    by_face = off.take(contender.mesh.faces).mean(axis=1)
    light = _LIGHT / np.linalg.norm(_LIGHT)
    normals = np.where(face_buffer.normals[:, 2:] < 0, -face_buffer.normals, face_buffer.normals)
    shade = 0.25 + 0.75 * (normals @ light).clip(0, 1)
    seen = face >= 0
    deviation = np.where(seen, by_face[face], np.nan).astype(np.float32)
    return RenderedView(deviation, np.where(seen, shade[face], 0).astype(np.float32))
