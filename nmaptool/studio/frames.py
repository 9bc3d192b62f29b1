"""Heights as bytes for the page: a JSON header, then numbers of 16 bits and a mask."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.grid import touching_vertices
from nmaptool.types.relief_parts import ReliefParts

_MOST = 65535


def frame_of(parts: ReliefParts, facts: Mapping[str, Any]) -> bytes:
    """Return the bytes of a message.

    The first four are the length of the header, little-endian; it is padded so that the numbers begin at a multiple of
    four. It names the fields in their order, each (rows, cols) of little-endian uint16 from ``low`` to ``high``; a mask
    follows, one bit for each vertex, the highest bit of a byte first: 1 where the surface is.

    Parameters
    ----------
    parts : ReliefParts
    facts : mapping
        More entries of the header.
    """
    fields = {"first": parts.first_px, "second": parts.second_px}
    if parts.base_px is not None:
        fields["base"] = parts.base_px
    surface = touching_vertices(parts.surface)
    described, packed = [], []
    for name, values in fields.items():
        low, high, numbers = _packed(values, surface)
        described.append({"name": name, "low": low, "high": high})
        packed.append(numbers.tobytes())
    rows, cols = parts.first_px.shape
    header = {
        "rows": rows,
        "cols": cols,
        "pitch_mm": parts.pitch_mm,
        "px_per_delta": parts.px_per_delta,
        "fields": described,
        **facts,
    }
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    return b"".join([struct.pack("<I", len(text)), text, *packed, np.packbits(surface).tobytes()])


def _packed(values: Float64, surface: NDArray[np.bool_]) -> tuple[float, float, NDArray[np.uint16]]:
    """Return the range of the values on the surface, and their place in it as numbers of 16 bits."""
    inside = values[surface]
    low, high = float(inside.min()), float(inside.max())
    span = high - low if high > low else 1.0
    numbers = np.clip(np.rint((values - low) * (_MOST / span)), 0, _MOST).astype("<u2")
    return low, high, numbers
