"""The report of converting a normal map file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nmaptool.types.composition import ComposeReport


@dataclass(frozen=True, eq=False, repr=False)
class ConvertReport(ComposeReport):
    """The report of a conversion; ``curl_after`` is measured on the codes as written.

    Attributes
    ----------
    source, target : mapping
        Properties of the input and the output file: bits, green, zero code, components, background.
    vectors : int
        Pixels where the map is defined.
    off_length : int
        Vectors whose length differs from 1 by more than rounding, so that no unit vector has their codes. They are
        normalised.
    off_length_largest : float
        The largest such difference.
    rim_pixels : int
        Anti-aliased pixels that were given the normals just inside them; their coverage is in alpha.
    flattened : int
        Pixels of a flat background whose noise was removed.
    """

    source: Mapping[str, Any] = field(default_factory=dict)
    target: Mapping[str, Any] = field(default_factory=dict)
    vectors: int = 0
    off_length: int = 0
    off_length_largest: float = 0.0
    rim_pixels: int = 0
    flattened: int = 0
