"""Measurements of a normal map, and the problems found in it."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.types.normal_map import Decoding
from nmaptool.types.report import Report
from nmaptool.types.shown import counted


@dataclass(frozen=True)
class Finding:
    """A problem or doubt, and its remedy."""

    code: str
    message: str
    remedy: str


@dataclass(frozen=True, repr=False)
class Inspection(Report):
    """Everything `inspect_map` measures; shares are of the foreground unless stated otherwise.

    Attributes
    ----------
    name, cols, rows, bits, channels, layer, pitch_mm
        The file.
    decoding : Decoding
        Convention, zero code and background, each with its source; ``curl_ratio`` is the mean |curl| with green down
        over that with green up.
    foreground_share, coverage_mean : float
        Share of the picture that is foreground, and mean coverage of the picture.
    unit_length_error : float
        Mean of ||v| - 1| of the stored vectors.
    off_length_share : float
        Share of vectors with an error above 0.1.
    away_share : float
        Share of vectors with nz <= 0.
    neutral_bias_px : float or None
        Height by which a flat map would tilt over its longer side if the file's own flat code were read with the middle
        code as zero; None if no flat code stands out.
    mean_abs_curl : float
        Mean |curl|, in slope per px.
    outline_sign : float or None
        Mean of n . outward over the outline: near +1 for a raised motif, negative for an inverted one.
    better_swizzle : str or None
        Channel order with clearly less curl; None if there is none.
    premultiplied, eight_bit_data, lossy, is_float : bool
    has_blocks : bool
        Whether the 8 x 8 blocks of lossy compression show, whatever the format.
    coarse : bool
        Whether the file stores its values coarser than ``bits`` says, such as by a palette.
    color_chunks : tuple of str
    findings : tuple of Finding
    """

    name: str
    cols: int
    rows: int
    bits: int
    channels: tuple[str, ...]
    layer: str | None
    pitch_mm: float | None
    decoding: Decoding
    foreground_share: float
    coverage_mean: float
    unit_length_error: float
    off_length_share: float
    away_share: float
    neutral_bias_px: float | None
    mean_abs_curl: float
    outline_sign: float | None
    better_swizzle: str | None
    premultiplied: bool
    eight_bit_data: bool
    lossy: bool
    has_blocks: bool
    coarse: bool
    is_float: bool
    color_chunks: tuple[str, ...]
    findings: tuple[Finding, ...] = ()

    def _line(self) -> str:
        codes = f" ({', '.join(finding.code for finding in self.findings)})" if self.findings else ""
        found = counted(len(self.findings), "finding")
        return f"{self.name}: {self.cols} x {self.rows} px, {self.bits} bits, {found}{codes}"
