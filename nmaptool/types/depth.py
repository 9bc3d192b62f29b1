"""The result of depth_to_normals: a normal map, its jumps and a report."""

from __future__ import annotations

from dataclasses import dataclass, field

from nmaptool.core.arrays import Float32
from nmaptool.options import DepthOptions
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.report import Report
from nmaptool.types.shown import Pictured, counted


@dataclass(frozen=True, repr=False)
class DepthReport(Report):
    """What was found in a depth or height picture, and the source of each value.

    Attributes
    ----------
    options : DepthOptions
        The options given.
    kind : str
        ``depth`` or ``height`` if the file states it, otherwise ``grey``.
    bits : int
        Bits that the picture actually uses.
    values, values_from : str, str
        What a stored value grows with, ``height``, ``distance`` or ``disparity``, and the source of this: ``given``,
        ``file``, ``preset``, ``found`` (from the name of the layer, or Blender's value for nothing) or ``assumed``.
    absolute : bool
        Whether the value at the camera is known; disparities are then converted to distances, others are read as
        heights.
    preset, preset_from : str, str
        The program that wrote the picture and the source of this, ``given`` or ``found``; empty if it is unknown.
    unit, unit_from : str or None, str
        Length of a stored unit and its source: ``given``, ``preset`` or ``none``.
    lens : str
        Where the writer states the field of view; empty if it has none.
    lowest_value, highest_value : float, float
        Ends of the values in use; of distances in the unit of 1 / disparity if disparities were converted.
    used_share : float or None
        Share of the integer codes between these; None for floats.
    empty : mapping of str to int
        Values that mean "no depth", and the number of pixels of each.
    empty_pixels : int
        Pixels without a depth after the filling, including transparent ones.
    fill_px, filled_holes, filled_pixels : float, int, int
        Largest width of the holes that are filled (0 if none are), the number of holes and of their pixels.
    orientation : int
        EXIF orientation by which the picture was turned or mirrored; 1 if it was not.
    notes : tuple of str
        What is unusual about the file.
    scale_px, scale_from : float, str
        Height of white above black, or of the highest value in use above the lowest, and its source: ``given``,
        ``file``, ``unit``, ``fov`` (from the distances themselves), ``range`` (assumed, for the values in use) or
        ``assumed``.
    range_px : float
        Height of the highest pixel of the surface above the lowest.
    pitch_mm, pitch_from : float or None, str
        Size of a pixel and its source: ``given``, ``file``, ``depth`` (from the field of view at the median distance)
        or ``none``.
    distance_mm : float or None
        Median distance, if it is known in perspective.
    inverted, inverted_from : bool, str
        Whether dark or small values are near, and the source of this.
    fov, fov_from : float, str
        Degrees across the longer side; 0 is orthographic.
    step_px, noise_px : float
        Height of a step of the stored values (0 if there are no steps), and standard deviation of the noise beyond it
        (0 if none was found).
    tolerance_px : float
        How far the fitted surface may depart from the stored heights; 0 if nothing was fitted.
    jump_px : float or None
        Smallest height of a jump; None if jumps were not looked for.
    jumps, jump_share : int, float
        Pixels beside a jump: their number, and their share of the surface.
    mixed_pixels : int
        Pixels of smoothed outlines that were moved to the side they mostly belong to.
    background, background_share : str, float
        ``none``, ``empty`` (pixels without depth), ``flat``, ``cut`` or both, such as ``empty, flat``; and its share of
        the picture.
    curl : float
        Mean |curl| of the map in slope per px.
    seconds : mapping of str to float
        Time by stage.
    warnings : tuple of str
    """

    options: DepthOptions
    kind: str
    values: str
    values_from: str
    absolute: bool
    preset: str
    preset_from: str
    unit: str | None
    unit_from: str
    lens: str
    bits: int
    lowest_value: float
    highest_value: float
    used_share: float | None
    empty: dict[str, int]
    empty_pixels: int
    fill_px: float
    filled_holes: int
    filled_pixels: int
    orientation: int
    notes: tuple[str, ...]
    scale_px: float
    scale_from: str
    range_px: float
    pitch_mm: float | None
    pitch_from: str
    distance_mm: float | None
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
        Its coverage is 0 where there is no depth, and on the background unless that is kept as a plate.
    jumps : (H, W) float32
        Height in px of the largest jump beside each pixel, 0 elsewhere.
    report : DepthReport
    """

    normal_map: NormalMap
    jumps: Float32
    report: DepthReport

    def _line(self) -> str:
        return f"{self.normal_map._line()}, {counted(self.report.jumps, 'pixel')} beside a jump"
