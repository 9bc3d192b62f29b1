"""Which orders and signs of three components are the normals of a surface seen from the front.

All 24 readings of three components are tried: each of six orders of the axes, with four signs of x and y; the sign of z
follows from the side that the surface shows. Three facts decide. A surface that a camera sees faces the camera: z is
positive. The slopes of a surface have no curl: n . curl(n) = 0, which tells orders and relative signs apart, but not
(x, y) from (-x, -y), which are each other's inside-out. A motif is raised where it ends: its normals point outwards
along its outline, which decides between those two and where curl is silent.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations
from typing import NamedTuple

import cv2
import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import dilated
from nmaptool.core.vectors import inner_vertices

# an order counts as wrong only if its curl is this many times that of another
SURE_CURL_RATIO = 1.5
# z is a component that faces away in at most this share of the motif, and is at least this large on average
MOST_AWAY, _LEAST_MEAN_Z = 0.1, 0.3
# a seam is not wider than this many steps beside it, plus some noise of 8-bit codes
_SEAM, _SEAM_NOISE, _LEAST_TILE_PX = 1.5, 0.01, 16
# an outline decides if its sign is at least this, or this if curl leaves more than two orders, and this much more than
# that of any other order
SURE_OUTLINE, _SURE_ALONE, _OUTLINE_MARGIN = 0.3, 0.4, 0.15
# in a large map, one window is enough
_WINDOW_PX = 512
# outlines of larger pictures are measured on every second, third ... pixel
_OUTLINE_SIDE_PX = 1000
# curl leaves two orders at best: a surface and its inside-out
_INSIDE_OUT = 2
_OUTLINE_PIXELS, _LEAST_VERTICES = 50, 50
# curl is measured as stored, and smoothed, which finds forms below the noise of the codes
_SCALES_PX = (0.0, 1.5)
# rounding to codes makes a curl of this many steps at each of these scales; less than so many times that proves nothing
_ROUNDING_CURL, _TIMES_ROUNDING = (0.41, 0.04), 3.0
# vectors that turn by more than this within a pixel are creases and jumps, where curl means nothing
_LARGEST_TURN = 0.5

# (component, sign) for each of x, y and z, as `codec.Swizzle`, but of vectors in memory
Order = tuple[tuple[int, int], ...]
AS_READ: Order = ((0, 1), (1, 1), (2, 1))


class _Axes(NamedTuple):
    """Components for x, y and z, and the sign of y if that of x is +1."""

    x: int
    y: int
    z: int
    sign: int


@dataclass(frozen=True, eq=False)
class OrderEvidence:
    """What a map tells about its order.

    Attributes
    ----------
    curl2 : mapping
        Mean squared curl of each choice of axes, in units of the mean squared change per px; empty if too few pixels
        tell.
    outline : (3, 2) float64 or None
        Mean of each component times the outward direction (x, y) of the outline; None without an outline.
    away : (3, 2) float64
        Share of the motif where a component, and its negative, is 0 or less.
    mean : (3,) float64
        Mean of each component.
    """

    curl2: dict[_Axes, float]
    outline: Float64 | None
    away: Float64
    mean: Float64

    def curl_ratio(self, one: Order, other: Order) -> float | None:
        """Root mean square curl of an order over that of another; None if nothing tells."""
        first, second = (self.curl2.get(_axes(order)) for order in (one, other))
        if first is None or second is None or max(first, second) <= 0:
            return None
        return float(np.sqrt(first / max(second, 1e-12 * first)))

    def outline_sign(self, order: Order) -> float | None:
        """Mean of n . outward along the outline: near +1 for a raised motif, negative for an inverted one."""
        if self.outline is None:
            return None
        (x, x_sign), (y, y_sign), _ = order
        return float(x_sign * self.outline[x, 0] + y_sign * self.outline[y, 1])

    def faces_away(self, order: Order) -> float:
        """Share of the motif that faces away from the viewer (nz <= 0) in this order."""
        axis, sign = order[2]
        return float(self.away[axis, 0 if sign > 0 else 1])

    def fitting(self, *, z_known: bool = False) -> tuple[Order, ...]:
        """The orders that fit, the most likely first; several if nothing tells them apart, none if none is a surface.

        Parameters
        ----------
        z_known : bool
            Whether the third component is z, because it was computed from the other two.
        """
        axis = (2, 1) if z_known else self._z()
        if axis is None:
            return ()
        x, y = (i for i in range(3) if i != axis[0])
        around = [_Axes(*pair, axis[0], sign) for pair in ((x, y), (y, x)) for sign in (1, -1)]
        least = min((self.curl2[axes] for axes in around if axes in self.curl2), default=0.0)
        kept = [axes for axes in around if self.curl2.get(axes, 0.0) <= max(least, 1e-12) * SURE_CURL_RATIO**2]
        orders = [((axes.x, flip), (axes.y, flip * axes.sign), axis) for axes in kept for flip in (1, -1)]
        return self._by_outline(sorted(orders, key=_distance))

    def _z(self) -> tuple[int, int] | None:
        """The component that is z, and its sign; the third unless it cannot be."""
        able = [
            (axis, sign)
            for axis in (2, 1, 0)
            for sign in (1, -1)
            if self.away[axis, 0 if sign > 0 else 1] <= MOST_AWAY and sign * self.mean[axis] >= _LEAST_MEAN_Z
        ]
        if not able or (2, 1) in able:
            return able[0] if able else None
        return max(able, key=lambda one: one[1] * self.mean[one[0]])

    def _by_outline(self, orders: list[Order]) -> tuple[Order, ...]:
        """Only the order whose normals point outwards along the outline, if one stands out."""
        signs = [self.outline_sign(order) or 0.0 for order in orders]
        ranked = sorted(signs, reverse=True)
        sure = SURE_OUTLINE if len(orders) == _INSIDE_OUT else _SURE_ALONE
        if len(ranked) > 1 and ranked[0] >= sure and ranked[0] - ranked[1] >= _OUTLINE_MARGIN:
            return (orders[signs.index(ranked[0])],)
        return tuple(orders)


def _axes(order: Order) -> _Axes:
    (x, x_sign), (y, y_sign), (z, _) = order
    return _Axes(x, y, z, x_sign * y_sign)


def _distance(order: Order) -> int:
    """How much an order differs from that of the file: first by its axes, then by its signs, y before x."""
    moved = sum(axis != place for place, (axis, _) in enumerate(order))
    (_, x), (_, y), (_, z) = order
    return 10 * moved + 2 * (x < 0) + (y < 0) + 4 * (z < 0)


def find_evidence(normals: Float32, foreground: Mask, defined: Mask, step: float = 0.0) -> OrderEvidence:
    """Measure what a map tells about its order.

    Parameters
    ----------
    normals : (H, W, 3) float32
        Unit vectors, read in some order.
    foreground : (H, W) bool
        The motif.
    defined : (H, W) bool
        Where there are normals: the motif and a flat background.
    step : float
        Smallest step of a component that the file can hold, such as 2/255; 0 for floats.
    """
    window = _window(foreground)
    part, motif, inside = normals[window], foreground[window], np.ascontiguousarray(defined[window])
    seen = part[motif] if motif.any() else normals[foreground]
    seen = seen if len(seen) else np.zeros((1, 3), np.float32)
    planes = np.ascontiguousarray(part.transpose(2, 0, 1))
    away = np.stack([(seen <= 0).mean(axis=0), (seen >= 0).mean(axis=0)], axis=1)
    scales = [
        _curls(planes, inside, scale, rounding * step)
        for scale, rounding in zip(_SCALES_PX, _ROUNDING_CURL, strict=True)
    ]
    curl2 = max((found for found in scales if found), key=_telling, default={})
    return OrderEvidence(curl2, outline_matrix(normals, foreground), away, seen.mean(axis=0, dtype=np.float64))


def repeats(normals: Float32) -> bool:
    """Whether opposite edges of a map continue each other, as those of a tileable texture do.

    Parameters
    ----------
    normals : (H, W, 3) float32
    """
    if min(normals.shape[:2]) < _LEAST_TILE_PX:
        return False
    for turned in (normals, normals.swapaxes(0, 1)):
        seam = float(np.abs(turned[0] - turned[-1]).mean())
        beside = float((np.abs(turned[1] - turned[0]).mean() + np.abs(turned[-1] - turned[-2]).mean()) / 2)
        if seam > _SEAM * beside + _SEAM_NOISE:
            return False
    return True


def _window(mask: Mask) -> tuple[slice, slice]:
    """The window of the picture that holds most of a mask; of several such windows, one near the middle."""
    sides = [min(n, _WINDOW_PX) for n in mask.shape]
    if sides == list(mask.shape):
        return slice(None), slice(None)
    step = max(1, min(sides) // 8)
    cells = tuple(-(-n // step) for n in mask.shape[::-1])
    # means, not samples: a motif may be smaller than a step
    coarse = cv2.resize(mask.view(np.uint8) * np.uint8(255), cells, interpolation=cv2.INTER_AREA).astype(np.float32)
    size = (max(1, sides[1] // step), max(1, sides[0] // step))
    held = cv2.boxFilter(coarse, -1, size, borderType=cv2.BORDER_CONSTANT)
    rows, cols = np.nonzero(held >= 0.999 * held.max())
    middle = [n / 2 for n in mask.shape]
    best = np.argmin((rows * step - middle[0]) ** 2 + (cols * step - middle[1]) ** 2)
    centres = (int(rows[best]) * step, int(cols[best]) * step)
    starts = [min(max(0, at - side // 2), n - side) for at, side, n in zip(centres, sides, mask.shape, strict=True)]
    return slice(starts[0], starts[0] + sides[0]), slice(starts[1], starts[1] + sides[1])


def _telling(curl2: dict[_Axes, float]) -> float:
    """How far apart the curls with y up and y down are."""
    up, down = curl2[_Axes(0, 1, 2, 1)], curl2[_Axes(0, 1, 2, -1)]
    return max(up, down) / max(min(up, down), 1e-12 * max(up, down), 1e-30)


def _curls(planes: Float32, mask: Mask, scale_px: float, rounding: float) -> dict[_Axes, float]:
    """Mean squared curl for every choice of axes, in units of the mean squared change per px; empty if nothing tells.

    ``rounding`` is the root mean square curl that rounding makes. Less than that counts as that much; nothing tells if
    neither y up nor y down gives several times as much.

    With y up, n . curl(n) = (nx dnz/dy - nz dnx/dy) + (nz dny/dx - ny dnz/dx): one wedge product along each direction,
    so all choices follow from the products of the six wedges. ``planes`` is (3, H, W) float32.
    """
    inside = inner_vertices(mask)
    if scale_px:
        planes, inside = _smoothed(planes, mask, scale_px)
    if np.count_nonzero(inside) < _LEAST_VERTICES:
        return {}
    down_sum, up = planes[:, :-1] + planes[:, 1:], planes[:, :-1] - planes[:, 1:]
    mean, across = (down_sum[..., :-1] + down_sum[..., 1:]) / 4, (down_sum[..., 1:] - down_sum[..., :-1]) / 2
    up = (up[..., :-1] + up[..., 1:]) / 2
    change2 = np.square(across).sum(axis=0) + np.square(up).sum(axis=0)
    smooth = inside & (change2 < _LARGEST_TURN**2)
    vertices = np.count_nonzero(smooth)
    total = float(change2.sum(where=smooth, dtype=np.float64))
    if vertices < _LEAST_VERTICES or not total > 0:
        return {}
    pairs = ((0, 1), (0, 2), (1, 2))
    wedges = np.stack([mean[i] * step[j] - mean[j] * step[i] for step in (up, across) for i, j in pairs])
    wedges *= smooth
    rows = wedges.reshape(len(wedges), -1)
    products = (rows @ rows.T).astype(np.float64)
    place = {pair: (n, 1) for n, pair in enumerate(pairs)} | {pair[::-1]: (n, -1) for n, pair in enumerate(pairs)}
    curl2, least = {}, rounding**2 * vertices / total
    for x, y, z in permutations(range(3)):
        first, first_sign = place[x, z]
        second, second_sign = place[z, y]
        own = products[first, first] + products[3 + second, 3 + second]
        mixed = 2 * first_sign * second_sign * products[first, 3 + second]
        for sign in (1, -1):
            curl2[_Axes(x, y, z, sign)] = max(least, float(own + sign * mixed) / total)
    telling = max(curl2[_Axes(0, 1, 2, 1)], curl2[_Axes(0, 1, 2, -1)])
    return curl2 if telling > _TIMES_ROUNDING**2 * least else {}


def _smoothed(planes: Float32, mask: Mask, scale_px: float) -> tuple[Float32, Mask]:
    """Vectors averaged with their neighbours in the mask, and the inner vertices away from the edge of the mask."""
    weight = mask.astype(np.float32)
    share = np.maximum(cv2.GaussianBlur(weight, (0, 0), scale_px), np.float32(1e-6))
    mean = np.stack([cv2.GaussianBlur(plane * weight, (0, 0), scale_px) / share for plane in planes])
    rounds = int(np.ceil(2 * scale_px))
    kept = cv2.erode(mask.view(np.uint8), np.ones((3, 3), np.uint8), iterations=rounds)  # the edge of the picture stays
    return mean, inner_vertices(kept.astype(bool))


def outline_matrix(normals: Float32, foreground: Mask) -> Float64 | None:
    """(3, 2) float64: mean of each component times the outward direction, x to the right and y up, along the outline.

    None if there is no outline, or too little of it.

    Parameters
    ----------
    normals : (H, W, 3) float32
    foreground : (H, W) bool
    """
    every = max(1, max(foreground.shape) // _OUTLINE_SIDE_PX)
    if every > 1:
        normals, foreground = normals[::every, ::every], np.ascontiguousarray(foreground[::every, ::every])
    if min(foreground.shape) < 2 or foreground.all() or not foreground.any():
        return None
    smooth = cv2.GaussianBlur(foreground.astype(np.float32), (25, 25), 3.0, borderType=cv2.BORDER_REPLICATE)
    down, across = np.gradient(smooth)
    size = np.hypot(down, across)
    at = foreground & dilated(~foreground, 3) & (size > 0.02)
    if at.sum() < _OUTLINE_PIXELS:
        return None
    outward = np.stack([-across[at] / size[at], down[at] / size[at]], axis=1)
    return np.asarray(normals[at].astype(np.float64).T @ outward / len(outward))
