"""What was written, read back: size, volume, and whether it is closed."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nmaptool import kernels
from nmaptool.core.arrays import Float64
from nmaptool.core.errors import OutputError
from nmaptool.core.progress import Progress
from nmaptool.io.solids.bands import Triangles, UnreadableError
from nmaptool.io.solids.triangles import triangles_of
from nmaptool.types.solid import Solid

_SIZE_MM = 1e-4
_VOLUME_SHARE = 1e-3
# up to this many triangles every edge is counted
_COUNTED_FACES = 1_000_000


def check_written(solid: Solid, path: Path, progress: Progress | None = None) -> None:
    """Read a file back and compare it with the solid.

    Checked are the number of triangles, the size to 1e-4 mm, that no triangle lost its area to rounding; for a closed
    solid also that its volume is that of the heights to 0.1 %, and that every edge is used once in each direction.

    Raises
    ------
    OutputError
        If something differs.
    """
    found = _Measured(solid.bounds_mm.mean(axis=0), solid.is_closed)
    try:
        for triangles in triangles_of(path):
            found.add(triangles)
            if progress is not None:
                progress("checking", min(1.0, found.faces / max(1, solid.face_count)))
    except UnreadableError as error:
        raise _failed(path, str(error)) from None
    if found.faces != solid.face_count:
        raise _failed(path, f"it holds {found.faces} triangles instead of {solid.face_count}")
    if found.lost:
        raise _failed(path, f"{found.lost} of its triangles have corners that do not exist")
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
    """What was found in a file, summed over its triangles; volumes are measured from ``middle_mm``."""

    middle_mm: Float64
    is_closed_wanted: bool
    faces: int = 0
    lost: int = 0
    unit_mm: float = 1.0
    # least and greatest x, y and z, and the volume, in units of the file
    sums: Float64 = field(default_factory=lambda: np.array([np.inf] * 3 + [-np.inf] * 3 + [0.0]))
    # triangles with two equal corners, and the sum over the edges
    counts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, np.int64))
    edges: list[NDArray[np.int64]] = field(default_factory=list)

    def add(self, triangles: Triangles) -> None:
        """Add some triangles."""
        points, records = triangles.points, triangles.records
        self.unit_mm = triangles.unit_mm
        self.faces += len(records)
        counted = self.is_closed_wanted and self.faces <= _COUNTED_FACES
        edges = np.empty((len(records) if counted else 0, 3), np.int64)
        middle, stride = self.middle_mm / self.unit_mm, records.shape[1]
        self.lost += int(
            kernels.triangle_sums(
                points,
                records,
                stride,
                triangles.offset,
                middle,
                self.is_closed_wanted,
                edges,
                self.sums,
                self.counts,
            )
        )
        self.edges.append(edges)

    @property
    def bounds_mm(self) -> Float64:
        return self.sums[:6].reshape(2, 3) * self.unit_mm

    @property
    def volume_mm3(self) -> float:
        return float(self.sums[6]) * self.unit_mm**3

    @property
    def collapsed(self) -> int:
        return int(self.counts[0])

    @property
    def is_closed(self) -> bool:
        """Whether each edge is used as often in one direction as in the other, and twice, where edges were counted."""
        if self.counts[1]:
            return False
        if self.faces > _COUNTED_FACES:
            return True
        edges = np.sort(np.concatenate(self.edges).ravel())
        # pairs of equal numbers, which differ from one another
        return bool(len(edges) % 2 == 0 and (edges[::2] == edges[1::2]).all() and (edges[1:-1:2] != edges[2::2]).all())
