"""What a plate is made from, besides maps, and what was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nmaptool.core.arrays import Float64
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.types.contours import Contours
from nmaptool.types.font import Font
from nmaptool.types.report import Report
from nmaptool.types.shown import OneLine, counted


@dataclass(frozen=True, eq=False, repr=False)
class PlateDesign(OneLine):
    """A plate with its frame and lettering; `nmaptool.read_design` reads the files that the options name.

    Parameters
    ----------
    plate : PlateOptions
        With a shape.
    frame : FrameOptions
    texts : tuple of TextOptions
    machine : MachineOptions
    fonts : mapping of str to Font
        The fonts that the texts name.
    outline : Contours, optional
        The shape of an SVG file, in any size.
    profile : (n, 2) float64, optional
        The profile of an SVG file: x from the edge of the plate (0) to the inner side (1), height from 0 to 1.
    """

    plate: PlateOptions
    frame: FrameOptions = field(default_factory=FrameOptions)
    texts: tuple[TextOptions, ...] = ()
    machine: MachineOptions = field(default_factory=MachineOptions)
    fonts: Mapping[str, Font] = field(default_factory=dict)
    outline: Contours | None = None
    profile: Float64 | None = None

    def _line(self) -> str:
        frame = f", frame {self.frame.frame} {self.frame.frame_profile}" if self.frame.frame is not None else ""
        texts = f", {counted(len(self.texts), 'text')}" if self.texts else ""
        return f"{self.plate.shape}{frame}{texts}"


@dataclass(frozen=True, eq=False, repr=False)
class PlateReport(Report):
    """How a plate was made.

    Attributes
    ----------
    shape : str
    width_mm, height_mm : float
        Size of the plate without a loop.
    area_mm2 : float
        Inside its outline, without the holes.
    outline_tolerance_mm : float
        The greatest distance between the outline and the true curve.
    pitch_mm : float
        Size of a pixel.
    resampled : float
        Pixels for each pixel of the map along a side; 1 if it was not resampled.
    picture_width_mm : float
        Width of the picture of the motif on the plate.
    motif_width_mm, motif_height_mm : float
        Size of the motif.
    fill : str
        "inside" or "cover".
    margin_mm : float
    frame : mapping
        Width, height and profile of the frame; empty without one.
    texts : tuple of mapping
        Text, path, size, height, length and thinnest stroke of each text, in mm.
    holes : tuple of mapping
        Diameter and middle of each hole in mm, and the rim's width.
    top_mm, lowest_mm : float
        The highest and the lowest point, from the surface of the plate.
    finer_share : float or None
        Share of the plate whose detail is finer than the machine can make; None if that is not known.
    warnings : tuple of str
    """

    shape: str
    width_mm: float
    height_mm: float
    area_mm2: float
    outline_tolerance_mm: float
    pitch_mm: float
    resampled: float
    picture_width_mm: float
    motif_width_mm: float
    motif_height_mm: float
    fill: str
    margin_mm: float
    frame: Mapping[str, Any]
    texts: tuple[Mapping[str, Any], ...]
    holes: tuple[Mapping[str, Any], ...]
    top_mm: float
    lowest_mm: float
    finer_share: float | None = None
    warnings: tuple[str, ...] = ()
