"""Large maps of known heights for bench.tiled: fractal terrain, its normals, a mask."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.grid import height_slopes
from nmaptool.io.stores.opening import create_picture

# the power of fractal terrain falls with this power of the wave number
_ROUGHNESS = 3.4
# root mean square of the slopes
_SLOPE = 0.5
_BLOCK = 2048


def terrain(side: int, seed: int = 0) -> NDArray[np.float32]:
    """(side, side) float32 heights in px of a periodic fractal terrain."""
    from scipy import fft

    rng = np.random.default_rng(seed)
    down = fft.fftfreq(side).astype(np.float32)[:, None]
    across = fft.rfftfreq(side).astype(np.float32)[None]
    square = down * down + across * across
    square[0, 0] = 1
    spectrum = rng.standard_normal(square.shape, np.float32) + 1j * rng.standard_normal(square.shape, np.float32)
    spectrum *= square ** np.float32(-_ROUGHNESS / 4)
    spectrum[0, 0] = 0
    slope = np.sqrt((np.abs(spectrum) ** 2 * square).sum(dtype=np.float64) * 2) * 2 * np.pi / side**2
    spectrum *= np.float32(_SLOPE / slope)
    return np.asarray(fft.irfft2(spectrum, (side, side), workers=-1), np.float32)


def write_maps(folder: Path, side: int, period: int) -> tuple[str, str, NDArray[np.float32]]:
    """Write a 16-bit normal map of terrain and the mask of a disc, both as Zarr stores of ``side`` px.

    Parameters
    ----------
    folder : Path
    side : int
    period : int
        Side of the terrain, which repeats.

    Returns
    -------
    normals, mask : str
        Names of the stores.
    heights : (period, period) float32
        Heights in px at the corners of the pixels.
    """
    heights = terrain(period)
    names = str(folder / "normals.zarr"), str(folder / "mask.zarr")
    kind = {"kind": "normal"}
    normals = create_picture(names[0], side, side, ("R", "G", "B"), np.uint16, attributes=kind, overwrite=True)
    mask = create_picture(names[1], side, side, ("Y",), np.uint8, overwrite=True)
    for row in range(0, side, _BLOCK):
        for col in range(0, side, _BLOCK):
            rows, cols = np.arange(row, min(row + _BLOCK, side)), np.arange(col, min(col + _BLOCK, side))
            corners = np.arange(rows[0], rows[-1] + 2) % period, np.arange(cols[0], cols[-1] + 2) % period
            p, q = height_slopes(heights[np.ix_(*corners)].astype(np.float64))
            vectors = np.dstack([-p, -q, np.ones_like(p)])
            vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
            normals.write(row, col, np.rint((vectors + 1) / 2 * 65535).astype(np.uint16))
            away = np.hypot(rows[:, None] - side / 2, cols[None] - side / 2)
            mask.write(row, col, np.where(away < 0.47 * side, 255, 0).astype(np.uint8))
    return *names, heights
