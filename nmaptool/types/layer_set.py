"""The layers of one view: original, base and detail normal maps on one grid, and their report."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, read_only
from nmaptool.core.errors import InputError
from nmaptool.types.mesh_findings import MeshFindings
from nmaptool.types.mixture import Mixture
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame
from nmaptool.types.report import Report
from nmaptool.types.shown import Pictured


@dataclass(frozen=True, eq=False, repr=False)
class LayerReport(Report):
    """How the layers were made.

    Attributes
    ----------
    options : mapping
        The options given, as plain values.
    mixture : Mixture
    detail_share : float
        Share of the surface (by area) or of the motif that is detail.
    detail_angle_deg : float
        Mean angle between original and base over the covered pixels.
    view : str
        Name of the view; empty for layers of a map.
    pitch_from : str
        Source of the pixel size: ``given``, ``file`` or ``assumed``; empty if it is not known.
    findings : MeshFindings or None
        What was dropped from the mesh; None for layers of a map.
    faces : int
        Faces that were filtered and rendered; 0 for layers of a map.
    mean_edge : float
        Mean edge length in units of the mesh, the unit of sigma_s; 0 for layers of a map.
    sigma_s_px : float
        sigma_s in pixels; 0 for a learned filter.
    model : str
        Digest of the learned filter; empty for other filters.
    renderer : str
        Platform that rendered the mesh.
    camera : mapping
        ``rotation`` (mesh to eye space), ``center`` (of the picture, in eye space), ``unit_per_px``, ``distance`` (from
        the eye of a perspective camera to the picture plane, None if orthographic), all in units of the mesh.
    curl : mapping of str to float
        Mean |curl| of original, base and detail, in slope per px.
    seconds : mapping of str to float
        Time by stage.
    warnings : tuple of str
    """

    options: Mapping[str, Any]
    mixture: Mixture
    detail_share: float
    detail_angle_deg: float
    view: str = ""
    pitch_from: str = ""
    findings: MeshFindings | None = None
    faces: int = 0
    mean_edge: float = 0.0
    sigma_s_px: float = 0.0
    model: str = ""
    renderer: str = ""
    camera: Mapping[str, Any] = field(default_factory=dict)
    curl: Mapping[str, float] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        out = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        out["mixture"] = self.mixture.to_dict()
        out["findings"] = None if self.findings is None else dataclasses.asdict(self.findings)
        out |= {key: dict(out[key]) for key in ("options", "camera", "curl", "seconds")}
        return out


@dataclass(frozen=True, eq=False, repr=False)
class LayerSet(Pictured):
    """The original, base and detail normal maps of one view, with depth and face numbers if they were rendered.

    Parameters
    ----------
    original, base, detail : NormalMap
        All on the same grid, with the same coverage.
    report : LayerReport
    depth_mm : (H, W) float32, optional
        Distance from the camera along its axis; 0 where nothing is seen. It is measured from the eye of a perspective
        camera, or from the nearest point of the mesh for an orthographic one.
    faces : (H, W) int32, optional
        Index of the face seen at each pixel, from 0, in the order of the given mesh; -1 where none is seen.

    Raises
    ------
    InputError
        If the layers differ in size or pitch.
    """

    original: NormalMap
    base: NormalMap
    detail: NormalMap
    report: LayerReport
    depth_mm: Float32 | None = None
    faces: NDArray[np.int32] | None = None

    def __post_init__(self) -> None:
        for layer in (self.base, self.detail):
            if layer.frame != self.original.frame:
                raise InputError(f"{layer.name} is {layer.frame}, but the original is {self.original.frame}")
        for name in ("depth_mm", "faces"):
            array = getattr(self, name)
            if array is not None:
                if array.shape != self.original.frame.shape:
                    raise InputError(f"{name} is {array.shape}, expected {self.original.frame.shape}")
                object.__setattr__(self, name, read_only(array))

    @property
    def frame(self) -> Frame:
        """Size and pitch."""
        return self.original.frame

    @property
    def coverage(self) -> Float32:
        """(H, W) float32 in [0, 1]: where the layers are defined."""
        return self.original.coverage

    def _line(self) -> str:
        parts = [name for name in ("depth_mm", "faces") if getattr(self, name) is not None]
        more = f", with {' and '.join(parts)}" if parts else ""
        name = self.original.name.removesuffix(": original")
        return f"{name}: {self.frame.with_pitch}, {self.report.detail_share:.0%} detail{more}"
