"""An edited normal map, and the report of how it was made."""

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
        As given, as plain values.
    layers : tuple of mapping
        What became of each layer: name, mode, strength, where it lies in px, its share of the canvas.
    curl_before : float or None
        Mean |curl| of what it started from, in slope per px: see `nmaptool.core.vectors.mean_abs_curl`.
    curl_after : float
        The same of the result.
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
    """An edited normal map, and how it came about.

    Attributes
    ----------
    normal_map : NormalMap
    placed : (H, W) float32 in [0, 1]
        Where layers lie above the lowest one: the mask for a relief whose background keeps its height.
    report : ComposeReport
    """

    normal_map: NormalMap
    placed: Float32
    report: ComposeReport

    def _line(self) -> str:
        return f"by {self.report.command}: {self.normal_map._line()}, mean curl {self.report.curl_after:.3g}"
