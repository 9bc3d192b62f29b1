"""Masks and face weights for solver tests, at any size: solid, thin, ragged and fragmented.

Masks are (side, side) float32 of 0 and 1, weights (H, W) float32 of at most 1, the same at every call. Solid shapes
scale with the side; thin ones stay 1 to 5 px wide.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.maps import outline
from nmaptool.core.arrays import Float32

Picture = NDArray[np.uint8]
Polyline = NDArray[np.int32]  # (N, 1, 2) columns and rows, as OpenCV takes them
Family = Callable[[int], Float32]
_SUBPIXELS = 4  # binary digits


def full(side: int) -> Float32:
    """No background at all."""
    return np.ones((side, side), np.float32)


def statue(rows: int, cols: int) -> Float32:
    """The motif of `bench.maps.scene`: overlapping domes with some holes."""
    return _statue(rows, cols).astype(np.float32)


def holes(side: int) -> Float32:
    """A plate with some 500 holes, from single pixels to 1/40 of the side."""
    random = np.random.default_rng(1)
    plate = np.ones((side, side), np.uint8)
    radii = side / 40 * random.random(500) ** 2
    for (x, y), radius in zip(random.uniform(0.01, 0.99, (500, 2)), radii, strict=True):
        cv2.circle(plate, (int(x * side), int(y * side)), int(radius), 0, -1)
    return plate.astype(np.float32)


def islands(side: int) -> Float32:
    """Up to 400 blobs that do not touch, one in each cell of a grid."""
    random = np.random.default_rng(2)
    across = max(min(20, side // 10), 1)
    cell = side / across
    out = np.zeros((side, side), np.uint8)
    for place in range(across**2):
        row, col = divmod(place, across)
        half = cell * random.uniform(0.12, 0.42, 2)
        free = cell / 2 - max(half) - 1
        centre = (np.array([col, row]) + 0.5) * cell + random.uniform(-1, 1, 2) * max(free, 0)
        cv2.ellipse(out, (centre.tolist(), (2 * half).tolist(), random.uniform(0, 180)), 1, -1)
    return out.astype(np.float32)


def gaps(side: int) -> Float32:
    """Square plates, 12 along each side, with gaps of one pixel between them."""
    cuts = np.arange(1, 12) * side // 12
    out = full(side)
    out[cuts] = 0
    out[:, cuts] = 0
    return out


def comb(side: int) -> Float32:
    """Teeth 2 to 40 px wide with gaps of one pixel, joined by a back of 1/20 of the side."""
    random = np.random.default_rng(3)
    cuts = np.cumsum(random.integers(3, 42, side // 3))
    out = full(side)
    out[max(side // 20, 1) :, cuts[cuts < side]] = 0
    return out


def bridge(side: int) -> Float32:
    """Two plates joined only by a bridge one pixel wide."""
    out = np.zeros((side, side), np.float32)
    edge, inner, outer = side // 16, side * 7 // 16, side * 9 // 16
    out[edge:-edge, edge:inner] = 1
    out[edge:-edge, outer:-edge] = 1
    out[side // 3, inner:outer] = 1
    return out


def hair(side: int) -> Float32:
    """The statue with some 300 wavy tendrils 1 to 3 px wide."""
    random = np.random.default_rng(4)
    head = _statue(side, side)
    inside = np.flatnonzero(head)
    starts = inside[random.integers(0, max(inside.size, 1), 300 if inside.size else 0)]
    strands: list[list[Polyline]] = [[], [], []]
    for start in starts.tolist():
        row, col = divmod(start, side)
        strands[random.integers(3)].append(_wavy(col, row, random.uniform(0, 2 * np.pi), side * 0.3, random))
    return np.maximum(head, _strokes(side, strands)).astype(np.float32)


def tree(side: int) -> Float32:
    """A vascular tree: branches from 5 px wide down to 1 px that fork up to 13 times, or until they are 8 px long."""
    random = np.random.default_rng(5)
    widths: list[list[Polyline]] = [[], [], [], [], []]
    growing = [(side / 2, side - 1.0, -np.pi / 2, side * 0.22, 0)]
    while growing:
        x, y, heading, length, forks = growing.pop()
        if length < 8 or forks > 13:
            continue
        branch = _wavy(x, y, heading, length, random)
        widths[max(4 - forks // 2, 0)].append(branch)
        x, y = branch[-1, 0].tolist()
        turn = random.uniform(0.3, 0.8)
        forked = heading - turn, heading + random.uniform(0.3, 1.1) - turn / 4
        growing += [(x, y, turned, length * random.uniform(0.72, 0.86), forks + 1) for turned in forked]
    return _strokes(side, widths).astype(np.float32)


def lines(side: int, covered: float = 0.2) -> Float32:
    """Random straight lines, 1 to 5 px wide, that cover this share of the image."""
    random = np.random.default_rng(6)
    # 0.52: mean distance of two random points in a unit square
    count = max(round(-np.log(1 - covered) * side / (3 * 0.52)), 1)
    ends = random.integers(0, side, (count, 2, 1, 2)).astype(np.int32)
    return _strokes(side, [list(ends[width::5]) for width in range(5)]).astype(np.float32)


def spiral(side: int, width: int = 2) -> Float32:
    """One spiral corridor of 1 to 3 px with walls of one pixel: the longest possible path."""
    out = np.zeros((side, side), np.float32)
    step = width + 1
    for ring in range((side // 2 + step - 1) // step):
        low, high = ring * step, side - ring * step
        if high - low < width:
            break
        out[low : low + width, max(low - step, 0) : high] = 1  # the top starts at the outer ring
        out[low:high, high - width : high] = 1
        out[high - width : high, low:high] = 1
        out[low + step : high, low : low + width] = 1
    return out


def maze(side: int, width: int = 2) -> Float32:
    """Corridors of 1 to 3 px between walls of one pixel, with exactly one path between any two places."""
    step = width + 1
    cells = max((side + 1) // step, 1)
    out = np.zeros((cells * step, cells * step), np.float32)
    rooms = out.reshape(cells, step, cells, step)
    rooms[:, :width, :, :width] = 1
    # every cell opens to the one below or to its right; at the far edges only one exists
    right = np.random.default_rng(7).random((cells, cells)) < 0.5
    right[-1], right[:, -1] = True, False
    rooms[:, :width, :, width] = right[:, None, :]
    down = ~right
    down[-1, -1] = False
    rooms[:, width, :, :width] = down[:, :, None]
    fitted = np.zeros((side, side), np.float32)
    used = min(side, cells * step)
    fitted[:used, :used] = out[:used, :used]
    return fitted


def noise(side: int, covered: float = 0.6) -> Float32:
    """Random pixels."""
    return (np.random.default_rng(8).random((side, side), np.float32) < covered).astype(np.float32)


def checkerboard(side: int) -> Float32:
    """Pixels that touch only at their corners."""
    odd = (np.arange(side) % 2).astype(bool)
    return (odd[:, None] ^ odd).astype(np.float32)


SOLID: dict[str, Family] = {
    "full": full,
    "statue": lambda side: statue(side, side),
    "holes": holes,
    "islands": islands,
    "gaps": gaps,
    "comb": comb,
    "bridge": bridge,
    "hair": hair,
}
THIN: dict[str, Family] = {
    "tree": tree,
    "lines 5%": lambda side: lines(side, 0.05),
    "lines 20%": lines,
    "lines 30%": lambda side: lines(side, 0.3),
    "spiral": spiral,
    "maze": maze,
    "noise": noise,
    "checkerboard": checkerboard,
}
FAMILIES: dict[str, Family] = SOLID | THIN


def spanning(shape: tuple[int, int], span: float, grain: int = 1) -> Float32:
    """Log-normal weights from 1/span to 1, constant on squares of ``grain`` px."""
    cells = -(-shape[0] // grain), -(-shape[1] // grain)
    drawn = np.random.default_rng(9).standard_normal(cells, np.float32)
    np.clip(drawn, -3, 3, out=drawn)
    drawn -= 3
    drawn *= np.float32(np.log(span) / 6)
    np.exp(drawn, out=drawn)
    return drawn if grain == 1 else np.kron(drawn, np.ones((grain, grain), np.float32))[: shape[0], : shape[1]].copy()


def mu_map(shape: tuple[int, int]) -> Float32:
    """The weights 1 + mu for a mu that varies by a tenth, like a mu map from a scan; at most 1."""
    drawn = np.random.default_rng(10).standard_normal(shape, np.float32)
    np.clip(drawn, -3, 3, out=drawn)
    drawn *= 0.1
    drawn += 2
    drawn /= 2.3
    return drawn


WEIGHTS: dict[str, Callable[[tuple[int, int]], Float32]] = {
    "one": lambda shape: np.ones(shape, np.float32),
    "mu map": mu_map,
    "span 1e4": lambda shape: spanning(shape, 1e4),
    "span 1e4, 16 px": lambda shape: spanning(shape, 1e4, 16),
    "span 1e12": lambda shape: spanning(shape, 1e12),
}


def _statue(rows: int, cols: int) -> Picture:
    longer = max(rows, cols)
    out = np.zeros((rows, cols), np.uint8)
    for discs, value in zip(outline((cols / longer, rows / longer)), (1, 0), strict=True):
        for disc in discs:
            centre = disc.x * longer - 0.5, rows - disc.y * longer - 0.5
            fine = [round(each * 2**_SUBPIXELS) for each in (*centre, disc.radius * longer)]
            cv2.circle(out, (fine[0], fine[1]), fine[2], value, -1, shift=_SUBPIXELS)
    return out


def _wavy(x: float, y: float, heading: float, length: float, random: np.random.Generator) -> Polyline:
    """A randomly bent line."""
    count = max(int(length / 12), 2)
    headings = heading + np.cumsum(random.normal(0, 0.12, count))
    steps = np.stack([np.cos(headings), np.sin(headings)], axis=1) * length / count
    points = np.array([x, y]) + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return np.rint(points).astype(np.int32)[:, None]


def _strokes(side: int, by_width: Sequence[Sequence[Polyline]]) -> Picture:
    """Lines drawn 1, 2, 3... px wide. OpenCV's own thick lines are wider than requested."""
    out = np.zeros((side, side), np.uint8)
    for width, strokes in enumerate(by_width, 1):
        layer = np.zeros((side, side), np.uint8)
        for points in strokes:  # drawn together, they would be filled where they cross
            cv2.polylines(layer, [points], False, 1)
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
        np.maximum(out, cv2.dilate(layer, kernel), out=out)
    return out
