"""A map, masks and weights as arrays and as Zarr stores, for tests of large maps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import nmaptool as nm
from nmaptool.io.stores.opening import create_picture
from nmaptool.options import ReliefFiles

ROWS, COLS = 420, 540
WIDTH = nm.length("54mm")


def store(path: Path, values: NDArray[Any], channels: tuple[str, ...], **more: Any) -> str:
    """Write an array as a Zarr store with small chunks."""
    made = create_picture(str(path), *values.shape[:2], channels, values.dtype, chunk=128, inner=64, **more)
    made.write(0, 0, values)
    return str(path)


def waves(rows: int = ROWS, cols: int = COLS) -> NDArray[np.float32]:
    """(rows, cols, 3) float32 unit normals of waves with noise."""
    y, x = np.mgrid[0:rows, 0:cols].astype(np.float32)
    noise = np.random.default_rng(0).normal(0, 0.1, x.shape)
    steep = np.dstack([np.sin(x / 19) * 0.5 + np.cos(y / 31 + x / 40) * 0.5 + noise, np.cos(x / 23 + y / 37) * 0.7])
    vectors = np.dstack([steep, np.ones_like(x)])
    return np.asarray(vectors / np.linalg.norm(vectors, axis=2, keepdims=True), np.float32)


class Case:
    """A motif with holes and islands, with detail and maps of mu, beta and delta.

    Parameters
    ----------
    folder : Path
    """

    def __init__(self, folder: Path) -> None:
        y, x = np.mgrid[0:ROWS, 0:COLS]
        rng = np.random.default_rng(1)
        mask = np.hypot(x - COLS / 2, y - ROWS / 2) < 190
        for _ in range(25):
            row, col, radius = rng.uniform(0, ROWS), rng.uniform(0, COLS), rng.uniform(3, 25)
            mask &= np.hypot(x - col, y - row) > radius
        mask |= (abs(x - y - 60) < 4) & (y % 150 < 130)  # thin lines across tiles
        mask |= np.hypot(x - 20, y - 380) < 15  # an island
        self.normals = waves()
        self.detail = self.normals * np.array([1, -1, 1], np.float32)
        grey = {
            "mask": np.where(mask, 255, 0).astype(np.uint8),
            "mu_map": (127.5 + 127.5 * np.sin(x / 50)).astype(np.uint8),
            "beta_map": np.where(y > 200, 255, 128).astype(np.uint8),
            "delta_map": (200 + 50 * np.cos(y / 60)).astype(np.uint8),
        }
        self.grey = {name: values / np.float32(255) for name, values in grey.items()}
        self.original = store(folder / "original.zarr", self.normals, ("R", "G", "B"), attributes={"kind": "normal"})
        detail = store(folder / "detail.zarr", self.detail, ("R", "G", "B"), attributes={"kind": "normal"})
        named = {name: store(folder / f"{name}.zarr", values, ("Y",)) for name, values in grey.items()}
        self.files = ReliefFiles(detail=detail, **named)
        self.masked = ReliefFiles(mask=named["mask"])

    def in_memory(self, options: nm.ReliefOptions, *, mask_only: bool = False) -> nm.Relief:
        """The same relief, solved in memory to a smaller tolerance."""
        original = nm.NormalMap.from_array(self.normals)
        if mask_only:
            return nm.relief(original, mask=self.grey["mask"], options=options)
        return nm.relief(original, nm.NormalMap.from_array(self.detail), options=options, **self.grey)
