"""Triangles of files, packed and summed, in NumPy: the twin of ``triangles.h``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64, Mask

Bytes = NDArray[np.uint8]
Ints = NDArray[np.int32]
Whole = NDArray[np.int64]
Hashes = NDArray[np.uint64]
# x, y and z of a number of points
Place = tuple[Float32, Float32, Float32]

_STL_RECORD = 50
_MIX = tuple(np.uint64(number) for number in (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9))
_SECOND = np.uint64(0xD6E8FEB86659FD93)
_AT_ONCE = 1 << 16


def stl_records(xyz: Float64, faces: Ints, out: Bytes) -> float:
    """Pack triangles as binary STL has them: the unit normal and three corners in float32, and two zero bytes.

    Parameters
    ----------
    xyz : (n, 3) float64
    faces : (m, 3) int32
        Rows of ``xyz``.
    out : (m, 50) uint8
    """
    # coordinate by coordinate, because NumPy is slow on rows of three
    x, y, z = np.ascontiguousarray(xyz.T, np.float32)
    corners = [(x[c], y[c], z[c]) for c in np.ascontiguousarray(faces.T)]
    numbers = np.empty((len(faces), 12), np.float32)
    with np.errstate(over="ignore", invalid="ignore"):  # triangles of more than 1e19 mm have no normal
        for axis, values in enumerate(_unit_normals(*corners)):
            numbers[:, axis] = values
    for corner, place in enumerate(corners, start=1):
        for axis, values in enumerate(place):
            numbers[:, 3 * corner + axis] = values
    out[:, :48] = numbers.astype("<f4", copy=False).view(np.uint8)
    out[:, 48:] = 0
    return 0.0


def _unit_normals(a: Place, b: Place, c: Place) -> Place:
    """The coordinates of the unit normals of triangles."""
    first, second = [q - p for p, q in zip(a, b, strict=True)], [q - p for p, q in zip(a, c, strict=True)]
    x = first[1] * second[2] - first[2] * second[1]
    y = first[2] * second[0] - first[0] * second[2]
    z = first[0] * second[1] - first[1] * second[0]
    length = np.maximum(np.sqrt(x * x + y * y + z * z), np.finfo(np.float32).tiny)
    return x / length, y / length, z / length


def mark_corners(faces: Ints, marked: Mask) -> float:
    """Set True for every vertex that a face uses.

    Parameters
    ----------
    faces : (m, 3) int32
    marked : (n,) bool
    """
    marked[faces] = True
    return 0.0


def triangle_sums(
    points: NDArray[Any],
    records: Bytes,
    stride: int,
    offset: int,
    middle: Float64,
    is_closed: bool,
    edges: Whole,
    sums: Float64,
    counts: Whole,
) -> float:
    """Add up some triangles of a file, in place.

    Parameters
    ----------
    points : (n, 3) float32 or float64
        Vertices; with none, the records themselves hold coordinates.
    records : (m, stride) uint8
        One record for each triangle; at ``offset``, three int32, the rows of its corners, or nine float32, their
        coordinates. Little endian.
    stride, offset : int
        Bytes.
    middle : (3,) float64
        Where volumes are measured from.
    is_closed : bool
        Whether volume and edges are summed, too.
    edges : (m, 3) or (0, 3) int64
        Gets a number for each edge of each triangle, the same in both directions.
    sums : (7,) float64
        Least x, y, z and greatest x, y, z, NaN if a coordinate is not finite; volume.
    counts : (2,) int64
        Triangles with two equal corners in single precision; the sum over the directed edges modulo 2^64: an edge from
        a to b counts f(a) g(b) - f(b) g(a) for random f and g, so it cancels exactly against the edge from b to a.

    Returns
    -------
    float
        How many triangles were left out because a corner does not exist.
    """
    total = records.size // stride
    rows, lost = records.reshape(total, stride), 0
    total_sum = int(counts[1])
    for at in range(0, total, _AT_ONCE):
        corners = _corners(points, rows[at : at + _AT_ONCE, offset:])
        lost += min(_AT_ONCE, total - at) - len(corners)
        if not len(corners):
            continue
        _widen(corners, sums)
        first, second = _hashes(corners)
        counts[0] += np.count_nonzero((first == np.roll(first, 1, axis=0)).any(axis=0))
        if is_closed:
            sums[6] += _volume(corners - middle)
            total_sum += _edge_sum(first, second)
            if edges.size:
                edges.reshape(-1, 3)[at : at + len(corners)] = (first * np.roll(first, -1, axis=0)).T.view(np.int64)
    counts[1] = (total_sum + 2**63) % 2**64 - 2**63
    return float(lost)


def _corners(points: NDArray[Any], records: Bytes) -> Float64:
    """(k, 3, 3) float64 corners of the triangles whose corners exist."""
    if not points.size:
        places = np.ascontiguousarray(records[:, :36]).view("<f4")
        return places.reshape(-1, 3, 3).astype(np.float64)
    faces = np.ascontiguousarray(records[:, :12]).view("<i4").astype(np.int64)
    vertices = points.reshape(-1, 3)
    exist = ((faces >= 0) & (faces < len(vertices))).all(axis=1)
    found: Float64 = vertices[faces if exist.all() else faces[exist]].astype(np.float64)
    return found


def _widen(corners: Float64, sums: Float64) -> None:
    for axis, values in enumerate(np.moveaxis(corners, 2, 0)):  # one by one: NumPy is slow on rows of three
        low, high = values.min(), values.max()
        if not np.isfinite(high - low):
            sums[:6] = np.nan
        sums[axis] = np.minimum(sums[axis], low)
        sums[3 + axis] = np.maximum(sums[3 + axis], high)


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
    """The sum over the directed edges of some triangles, modulo 2^64."""
    next_first, next_second = np.roll(first, -1, axis=0), np.roll(second, -1, axis=0)
    return int((first * next_second - next_first * second).sum(dtype=np.uint64))
