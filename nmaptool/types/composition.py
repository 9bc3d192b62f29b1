"""An edited normal map and its report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nmaptool.core.arrays import Float32
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.report import Report
from nmaptool.types.shown import Pictured


@dataclass(frozen=True, eq=False, repr=False)
class ComposeReport(Report):
    """How a normal map was edited.

    Attributes
    ----------
    command : str
        ``blend``, ``paste``, ``transform``, ``convert``, ``stack``.
    options : mapping
        The options given, as plain values.
    layers : tuple of mapping
        For each layer: name, mode, strength, position in px, share of the canvas.
    curl_before : float or None
        Mean |curl| of the input, in slope per px: see `nmaptool.core.vectors.mean_abs_curl`.
    curl_after : float
        Mean |curl| of the result.
    seconds : mapping of str to float
        Time by stage.
    warnings : tuple of str
    """

    command: str
    options: Mapping[str, Any]
    curl_before: float | None
    curl_after: float
    layers: tuple[Mapping[str, Any], ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class Composition(Pictured):
    """An edited normal map and the report of the edit.

    Attributes
    ----------
    normal_map : NormalMap
    placed : (H, W) float32 in [0, 1]
        Coverage of the layers above the lowest one: the mask for a relief whose background keeps its height.
    report : ComposeReport
    walls : (H, W) float32 in [0, 1] or None
        Coverage of the layers with ``edge="wall"``: the wall mask for a relief. None where there are no layers.
    """

    normal_map: NormalMap
    placed: Float32
    report: ComposeReport
    walls: Float32 | None = None

    def _line(self) -> str:
        return f"by {self.report.command}: {self.normal_map._line()}, mean curl {self.report.curl_after:.3g}"
