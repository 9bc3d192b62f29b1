"""The closed bodies of a solid, together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nmaptool.solids.piece import Piece
from nmaptool.solids.raised import RaisedPiece
from nmaptool.types.solid import Solid


def closed_solid(pieces: Sequence[Piece | RaisedPiece], facts: dict[str, Any]) -> Solid:
    """A solid of closed bodies."""
    bounds = np.array([piece.bounds_mm for piece in pieces])
    name = "relief" if len(pieces) == 1 else "relief {}"
    return Solid(
        tuple(piece.body(name.format(number)) for number, piece in enumerate(pieces, start=1)),
        True,
        np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)]),
        sum(piece.volume_mm3 for piece in pieces),
        {**facts, "pieces": len(pieces)},
    )
