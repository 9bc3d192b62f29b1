"""What the own check of a format finds in a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Facts:
    """What the own check of a format finds in a file before OpenImageIO reads it.

    Attributes
    ----------
    color_chunks : tuple of str
    lossy : bool
    nodata : float or None
    notes : tuple of str
    coarse : bool
        As in `nmaptool.RasterImage`.
    attributes : mapping
        Further metadata, as in `nmaptool.RasterImage`.
    channels : tuple of str
        Names of all channels if OpenImageIO gives them wrong ones.
    spare_alpha : bool
        The file does not say that its last channel is alpha: it counts as alpha only if it varies.
    white_is_zero : bool
        The file stores the negative of unsigned integers.
    refusal : str
        Why its numbers are not read, with the remedy; empty if they are.
    pages : int
        The number of pages if its parts are pages of a document, of which the first is read, not layers.
    names : tuple of str
        The names of these pages, those of smaller versions too.
    parts : tuple of Facts
        The facts of each page, if they differ.
    """

    color_chunks: tuple[str, ...] = ()
    lossy: bool = False
    nodata: float | None = None
    notes: tuple[str, ...] = ()
    coarse: bool = False
    attributes: Mapping[str, str] = field(default_factory=dict)
    channels: tuple[str, ...] = ()
    spare_alpha: bool = False
    white_is_zero: bool = False
    refusal: str = ""
    pages: int = 0
    names: tuple[str, ...] = ()
    parts: tuple[Facts, ...] = ()

    def of_part(self, number: int) -> Facts:
        """What the check found about a part."""
        return self.parts[number] if number < len(self.parts) else self
