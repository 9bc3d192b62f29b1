"""The flat ground of a large depth picture: patches at the lowest height, which may reach across tiles."""

from __future__ import annotations

from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.depth.ground import kept_patches
from nmaptool.solver.tiling.grid import Tile
from nmaptool.solver.tiling.islands import merge
from nmaptool.tiled.edits import Edit
from nmaptool.tiled.job import TileJob
from nmaptool.tiled.sweep import Records


def _labels(low: Mask) -> tuple[NDArray[np.int32], int]:
    count, labels = cv2.connectedComponents(low.view(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    return np.asarray(labels, np.int32), count - 1


def label_low(low: Mask) -> dict[str, Any]:
    """The record of a tile: the patches of its lowest pixels, their sizes, and their numbers along its borders.

    Parameters
    ----------
    low : (h, w) bool
        The pixels at the lowest height.
    """
    labels, count = _labels(low)
    return {
        "sizes": np.bincount(labels.ravel(), minlength=count + 1)[1:],
        "top": labels[0],
        "bottom": labels[-1],
        "left": labels[:, 0],
        "right": labels[:, -1],
    }


def find_ground(job: TileJob, run: Edit, low: Records, known: int) -> bool:
    """Join the patches of all tiles, and store those that are ground in the array ``ground``.

    Parameters
    ----------
    job : TileJob
        Its folder holds the array ``low``.
    run : Edit
    low : dict of Tile to mapping
        Records of `label_low`.
    known : int
        Pixels of the picture that have a height.

    Returns
    -------
    bool
        Whether there is any.
    """
    tiles = list(job.grid)
    place = {tile: number for number, tile in enumerate(tiles)}
    pairs = []
    for tile in tiles:
        for other, side, there in (
            (Tile(tile.row - 1, tile.col), "top", "bottom"),
            (Tile(tile.row, tile.col - 1), "left", "right"),
        ):
            if other in place:
                pairs.append((place[tile], low[tile][side], place[other], low[other][there]))
    numbers, count = merge([len(low[tile]["sizes"]) for tile in tiles], pairs)
    sizes = np.zeros(count + 1, np.int64)
    for tile in tiles:
        np.add.at(sizes, numbers[place[tile]][1:], low[tile]["sizes"])
    keep = kept_patches(sizes, job.grid.rows * job.grid.cols, known)
    if keep is None:
        return False
    keep[0] = False
    kept = {tile: keep[numbers[place[tile]]] for tile in tiles}
    job.folder.make_array("ground", (job.grid.rows, job.grid.cols), "u1", job.grid.tile, packed=True)
    run.run(job, "ground", partial(_store_tile, job, kept), "storing the ground")
    return True


def _store_tile(job: TileJob, kept: dict[Tile, Mask], tile: Tile) -> None:
    box = job.grid.faces(tile)
    labels, _ = _labels(job.folder.read("low", box).astype(bool))
    job.folder.write("ground", box, kept[tile][labels].astype(np.uint8))
    job.folder.put(f"ground/{tile.row}_{tile.col}", {})
