"""Detect whether a packed layer was moved, mirrored, rotated or stretched, and whether its vectors were too."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.vectors import inner_vertices, mean_abs_curl, slopes
from nmaptool.maps.codec import decode_shares, encode_shares
from nmaptool.workspace.pose import Pose
from nmaptool.workspace.signature import Signature, smoothed

_CLEAR = 0.02
# mean difference of signatures, 0 to 1: alike up to the first (resampling, 8 bits), unlike from the second
_ALIKE, _UNLIKE = 0.004, 0.04
_SLOPE_CAP = 2.0
_LEAST_ANGLE_DEG = 2.0
_STRETCH = 0.02
# curl due to 16-bit codes and rims, slope per px; smaller curl is not evaluated
_CURL_NOISE = 1e-3
_RIM_PX = 4
# rotating the picture without its vectors increases the curl by at least this factor
_MORE = 1.02

# picture: the NumPy operations on (row, col); vectors: the matching 2 x 2 matrix on (x right, y up)
_TURNS: dict[str, tuple[tuple[bool, bool, bool], tuple[tuple[int, int], tuple[int, int]]]] = {
    # (transpose first, flip rows, flip cols)
    "none": ((False, False, False), ((1, 0), (0, 1))),
    "flip-h": ((False, False, True), ((-1, 0), (0, 1))),
    "flip-v": ((False, True, False), ((1, 0), (0, -1))),
    "180": ((False, True, True), ((-1, 0), (0, -1))),
    "transpose": ((True, False, False), ((0, -1), (-1, 0))),
    "90": ((True, True, False), ((0, -1), (1, 0))),
    "270": ((True, False, True), ((0, 1), (-1, 0))),
    "antitranspose": ((True, True, True), ((0, 1), (1, 0))),
}


def turned(picture: Float32, turn: str) -> Float32:
    """Mirror or rotate a picture without changing its values."""
    (transpose, flip_rows, flip_cols), _ = _TURNS[turn]
    out = picture.swapaxes(0, 1) if transpose else picture
    return out[:: -1 if flip_rows else 1, :: -1 if flip_cols else 1]


def with_vectors(shares: Float32, turn: str) -> Float32:
    """Mirror or rotate the vectors of (..., 3+) shares (n + 1)/2."""
    _, ((a, b), (c, d)) = _TURNS[turn]
    x, y = decode_shares(shares[..., 0]), decode_shares(shares[..., 1])
    out = shares.copy()
    out[..., 0], out[..., 1] = encode_shares(a * x + b * y), encode_shares(c * x + d * y)
    return out


def find_pose(now: Signature, packed: Signature | None, normals: Float32, covered: Mask) -> Pose:
    """Compare a layer with its signature.

    Parameters
    ----------
    now : Signature
    packed : Signature or None
        Without it, only a rotation without vectors can be detected, by its curl.
    normals : (h, w, 3) float32
        The present unit normals.
    covered : (h, w) bool
    """
    if packed is None:
        return free_turn(normals, covered, 0.0)
    alone = {turn: _difference(now.cells, turned(packed.cells, turn)) for turn in _TURNS}
    along = {turn: _difference(now.cells, with_vectors(turned(packed.cells, turn), turn)) for turn in _TURNS}
    same = alone["none"]
    without, together = min(alone, key=lambda t: alone[t]), min(along, key=lambda t: along[t])
    best = min(alone[without], along[together])
    if same <= max(_ALIKE, 1.25 * best) and same < _UNLIKE:
        turn = free_turn(normals, covered, packed.mean_curl) if same > _ALIKE else Pose()
        return _placed(now, packed) if turn.angle_deg is None else turn
    if best <= min(0.5 * same, _UNLIKE):
        if along[together] <= 1.25 * alone[without]:
            return Pose(turn=together, vectors_turned=True)
        return Pose(turn=without)
    return free_turn(normals, covered, packed.mean_curl)


def _difference(first: Float32, second: Float32) -> float:
    """Mean difference of two signatures where both are covered, plus a term for their outlines."""
    both = (first[..., 3] > 0.25) & (second[..., 3] > 0.25)
    outline = float(np.abs(first[..., 3] - second[..., 3]).mean())
    if not both.any():
        return 1.0
    # a painted patch should not hide that the rest is unchanged
    steps = np.abs(first[..., :3] - second[..., :3])[both].clip(0, 0.2)
    return float(steps.mean()) + 0.5 * max(outline - 0.01, 0.0)


def _placed(now: Signature, packed: Signature) -> Pose:
    left, top, cols, rows = now.box
    left0, top0, cols0, rows0 = packed.box
    if abs(cols - cols0) <= 2 and abs(rows - rows0) <= 2:
        dx, dy = round(left - left0 + (cols - cols0) / 2), round(top - top0 + (rows - rows0) / 2)
        still = (left, top) == (left0, top0) or (abs(dx) <= 1 and abs(dy) <= 1 and (cols, rows) != (cols0, rows0))
        return Pose() if still else Pose(moved=(dx, dy))
    sx, sy = cols / cols0, rows / rows0
    tolerance = _STRETCH + 2 / min(cols0, rows0, cols, rows)
    return Pose(stretched=(sx, sy)) if abs(math.log(sx / sy)) > tolerance else Pose()


def free_turn(normals: Float32, covered: Mask, packed_curl: float) -> Pose:
    """Find the angle by which a picture was rotated without its vectors, from curl and divergence; none if they agree.

    Rotating the slopes of a field with curl c and divergence d by t gives it the curl c cos t + d sin t. The angle at
    which the mean of its square is smallest has a closed form, up to half a turn.
    """
    core = ndimage.binary_erosion(covered, np.ones((3, 3)), iterations=_RIM_PX, border_value=1)
    forms = smoothed(normals)
    p, q = slopes(forms, _SLOPE_CAP)
    # capped slopes are not those of a surface, at any angle
    steep = ndimage.binary_dilation(np.hypot(p, q) >= 0.99 * _SLOPE_CAP, iterations=2)
    inside = inner_vertices(core & ~steep)
    if inside.sum() < 100 or mean_abs_curl(forms, covered) <= _MORE * packed_curl:
        return Pose()
    c, d = _curl_and_divergence(p, q, inside)
    size = np.hypot(c, d)
    # edges and jumps must not outweigh the rest
    weight = 1 / np.maximum(1, size / max(3 * float(np.median(size)), 1e-12)) ** 2
    a, b, e = (float((weight * product).mean()) for product in (c * c, c * d, d * d))
    angle = 0.5 * math.atan2(2 * b, a - e) + math.pi / 2
    angle = (angle + math.pi / 2) % math.pi - math.pi / 2

    def curls(c: Float64, d: Float64) -> tuple[float, float]:
        return float(np.abs(c).mean()), float(np.abs(c * math.cos(angle) + d * math.sin(angle)).mean())

    before, after = curls(c, d)
    degrees = math.degrees(angle)
    now, if_turned = curls(*_curl_and_divergence(*slopes(normals, _SLOPE_CAP), inside))
    if before <= _CURL_NOISE or after >= 0.5 * before or abs(degrees) < _LEAST_ANGLE_DEG:
        return Pose(curl=now)
    return Pose(angle_deg=degrees, curl=now, curl_if_turned=if_turned)


def _curl_and_divergence(p: Float32, q: Float32, inside: Mask) -> tuple[Float64, Float64]:
    p_x, p_y = _gradient(p)
    q_x, q_y = _gradient(q)
    return (q_x - p_y)[inside].astype(np.float64), (p_x + q_y)[inside].astype(np.float64)


def _gradient(field: Float32) -> tuple[Float32, Float32]:
    """d/dx and d/dy (y up) at the inner vertices, as in `nmaptool.core.vectors.curl`."""
    d_x = (field[:-1, 1:] - field[:-1, :-1] + field[1:, 1:] - field[1:, :-1]) / 2
    d_y = (field[:-1, :-1] - field[1:, :-1] + field[:-1, 1:] - field[1:, 1:]) / 2
    return np.asarray(d_x, np.float32), np.asarray(d_y, np.float32)
