"""What converting a normal map to another kind of file did."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nmaptool.types.composition import ComposeReport


@dataclass(frozen=True, eq=False, repr=False)
class ConvertReport(ComposeReport):
    """What a conversion did, beside what every edit reports; ``curl_after`` is that of the codes as written.

    Attributes
    ----------
    source, target : mapping
        What the file was and what it is now: bits, green, zero code, components, background.
    vectors : int
        Pixels where the map is defined.
    off_length : int
        Vectors that were off unit length by more than rounding: no unit vector has their codes. They are normalised.
    off_length_largest : float
        By how much at most.
    rim_pixels : int
        Anti-aliased pixels that took the normals just inside them; their coverage is in alpha.
    flattened : int
        Pixels of a flat background that were noise and are flat now.
    """

    source: Mapping[str, Any] = field(default_factory=dict)
    target: Mapping[str, Any] = field(default_factory=dict)
    vectors: int = 0
    off_length: int = 0
    off_length_largest: float = 0.0
    rim_pixels: int = 0
    flattened: int = 0
