"""What depth_to_normals gives back: a normal map, its jumps, and the account of what was decided."""

from __future__ import annotations

from dataclasses import dataclass, field

from nmaptool.core.arrays import Float32
from nmaptool.options import DepthOptions
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.report import Report
from nmaptool.types.shown import Pictured, counted


@dataclass(frozen=True, repr=False)
class DepthReport(Report):
    """What was read off a depth or height picture, and from what.

    Attributes
    ----------
    options : DepthOptions
        As given.
    kind : str
        ``depth`` or ``height`` where the file says so, else ``grey``.
    bits : int
        Bits that the picture really uses.
    scale_px, scale_from : float, str
        How far white stands above black, or the highest float above the lowest, and whether that was ``given``, in
        the ``file`` or ``assumed``.
    range_px : float
        How far the highest pixel of the surface stands above the lowest.
    pitch_mm : float or None
        Size of a pixel.
    inverted, inverted_from : bool, str
        Whether dark or small is near.
    fov, fov_from : float, str
        Degrees across the longer side; 0 is orthographic.
    step_px, noise_px : float
        Height of a step of the stored values (0: none), and deviation of the noise beyond it (0: none was found).
    tolerance_px : float
        How far the fitted surface may leave the stored heights; 0 where nothing was fitted.
    jump_px : float or None
        Least height of a jump; None where none was looked for.
    jumps, jump_share : int, float
        Pixels beside a jump, and as a share of the surface.
    mixed_pixels : int
        Pixels of smoothed outlines that were moved to the side they mostly belong to.
    background, background_share : str, float
        ``none``, ``empty`` (pixels without depth), ``flat``, ``cut`` or both, such as ``empty, flat``.
    curl : float
        Mean |curl| of the map in slope per px.
    seconds : mapping of str to float
        Time by stage.
    warnings : tuple of str
    """

    options: DepthOptions
    kind: str
    bits: int
    scale_px: float
    scale_from: str
    range_px: float
    pitch_mm: float | None
    inverted: bool
    inverted_from: str
    fov: float
    fov_from: str
    step_px: float
    noise_px: float
    tolerance_px: float
    jump_px: float | None
    jumps: int
    jump_share: float
    mixed_pixels: int
    background: str
    background_share: float
    curl: float
    seconds: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class DepthResult(Pictured):
    """A depth or height picture as a normal map.

    Attributes
    ----------
    normal_map : NormalMap
        Its coverage is 0 where there is no depth and on the background, unless that was to be kept as a plate.
    jumps : (H, W) float32
        Height in px of the largest jump beside each pixel, 0 elsewhere.
    report : DepthReport
    """

    normal_map: NormalMap
    jumps: Float32
    report: DepthReport

    def _line(self) -> str:
        return f"{self.normal_map._line()}, {counted(self.report.jumps, 'pixel')} beside a jump"
