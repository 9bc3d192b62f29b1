"""What was written, read back: size, volume, and whether it is closed."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import OutputError
from nmaptool.core.progress import Progress
from nmaptool.io.solids.triangles import triangles_of
from nmaptool.types.solid import Solid

Hashes = NDArray[np.uint64]
_SIZE_MM = 1e-4
_VOLUME_SHARE = 1e-3
# up to this many triangles every edge is counted
_COUNTED_FACES = 1_000_000
_MIX = tuple(np.uint64(number) for number in (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9))
_SECOND = np.uint64(0xD6E8FEB86659FD93)


def check_written(solid: Solid, path: Path, progress: Progress | None = None) -> None:
    """Read a file back and compare it with the solid.

    Checked are the number of triangles, the size to 1e-4 mm, that no triangle lost its area to rounding; for a closed
    solid also that its volume is that of the heights to 0.1 %, and that every edge is used once in each direction.

    Raises
    ------
    OutputError
        If something differs.
    """
    found = _Measured()
    for corners in triangles_of(path):
        found.add(corners, solid.bounds_mm.mean(axis=0), solid.is_closed)
        if progress is not None:
            progress("checking", min(1.0, found.faces / max(1, solid.face_count)))
    if found.faces != solid.face_count:
        raise _failed(path, f"it holds {found.faces} triangles instead of {solid.face_count}")
    tolerance = max(_SIZE_MM, 4 * float(np.spacing(np.float32(np.abs(solid.bounds_mm).max()))))
    off = float(np.abs(found.bounds_mm - solid.bounds_mm).max())
    if not off <= tolerance:
        raise _failed(path, f"its size is off by {off:.3g} mm")
    if found.collapsed:
        raise _failed(path, f"{found.collapsed} of its triangles have two equal corners")
    if not solid.is_closed:
        return
    if not found.is_closed:
        raise _failed(path, "it is not closed")
    wrong = abs(found.volume_mm3 - solid.volume_mm3)
    if not wrong <= _VOLUME_SHARE * solid.volume_mm3 + solid.facts.get("volume_error_mm3", 0.0):
        raise _failed(path, f"its volume is {found.volume_mm3:.6g} mm3 instead of {solid.volume_mm3:.6g} mm3")


def _failed(path: Path, what: str) -> OutputError:
    return OutputError(f"{path}: failed the check after writing: {what}; nothing is kept. Report this as a bug")


@dataclass
class _Measured:
    """What was found in a file, summed over its triangles."""

    faces: int = 0
    low: Float64 = field(default_factory=lambda: np.full(3, np.inf))
    high: Float64 = field(default_factory=lambda: np.full(3, -np.inf))
    volume_mm3: float = 0.0
    collapsed: int = 0
    edge_sum: int = 0
    edges: list[Hashes] = field(default_factory=list)

    def add(self, corners: Float64, middle: Float64, is_closed: bool) -> None:
        """Add some triangles; volumes are measured from ``middle``."""
        self.faces += len(corners)
        axes = np.moveaxis(corners, 2, 0)  # one by one, because NumPy is slow on rows of three
        self.low = np.minimum(self.low, [axis.min() for axis in axes])
        self.high = np.maximum(self.high, [axis.max() for axis in axes])
        first, second = _hashes(corners)
        self.collapsed += int(np.count_nonzero((first == np.roll(first, 1, axis=0)).any(axis=0)))
        if is_closed:
            self.volume_mm3 += _volume(corners - middle)
            self.edge_sum = (self.edge_sum + _edge_sum(first, second)) % 2**64
            if self.faces <= _COUNTED_FACES:
                self.edges.append((first * np.roll(first, 1, axis=0)).ravel())

    @property
    def bounds_mm(self) -> Float64:
        return np.stack([self.low, self.high])

    @property
    def is_closed(self) -> bool:
        """Whether each edge is used as often in one direction as in the other, and twice, where edges were counted."""
        if self.edge_sum:
            return False
        if self.faces > _COUNTED_FACES:
            return True
        _, counts = np.unique(np.concatenate(self.edges), return_counts=True)
        return bool((counts == 2).all())


def _volume(corners: Float64) -> float:
    """Sum of the signed volumes between triangles and the origin."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = np.moveaxis(corners, 0, 2)
    return float((ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)).sum() / 6)


def _hashes(corners: Float64) -> tuple[Hashes, Hashes]:
    """Two (3, n) numbers for the corners of triangles, equal where the corners are equal in single precision."""
    bits = (corners.astype(np.float32) + np.float32(0.0)).view(np.uint32)  # + 0 makes -0 equal to 0
    mixed = bits[..., 0].T * _MIX[0] + bits[..., 1].T * _MIX[1] + bits[..., 2].T * _MIX[2] + _SECOND
    mixed ^= mixed >> np.uint64(29)
    mixed *= _MIX[1]
    mixed ^= mixed >> np.uint64(32)
    mixed *= _MIX[0]
    other = mixed ^ (mixed >> np.uint64(31))
    other *= _SECOND
    other ^= other >> np.uint64(30)
    return mixed, other


def _edge_sum(first: Hashes, second: Hashes) -> int:
    """A sum over the directed edges that is 0 for a closed surface, and otherwise almost never.

    An edge from a to b counts f(a) g(b) - f(b) g(a) modulo 2^64 for random f and g, so it cancels exactly against the
    same edge from b to a.
    """
    next_first, next_second = np.roll(first, -1, axis=0), np.roll(second, -1, axis=0)
    return int((first * next_second - next_first * second).sum(dtype=np.uint64))
