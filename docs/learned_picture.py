"""Bases of held-out meshes side by side: ``python docs/learned_picture.py [FILE.jpg]``.

One row per mesh: the mesh; the base of the default filter, of ``--filter grnf`` and of ``--filter learned``, all
without parameters.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import nmaptool as nm

sys.path.insert(0, str(Path(__file__).parents[1] / "samples"))
sys.path.insert(0, str(Path(__file__).parents[1] / "samples" / "training"))
from meshes import held_out_meshes

SHOWN = ("beast bosses", "goblet bricks", "tablet letters", "cross scales")
FILTERS = ("rnf", "grnf", "learned")
SIDE_PX = 300
LIGHT = np.array([-0.5, 0.5, 0.7]) / np.linalg.norm([0.5, 0.5, 0.7])
HOME = Path(__file__).parent / "pictures" / "learned.jpg"
Picture = NDArray[np.uint8]


def lit(shown: nm.NormalMap) -> Picture:
    """A map under one light, on white."""
    light = np.clip(shown.normals @ LIGHT, 0, 1) * 255
    cover = shown.coverage
    return np.asarray(light * cover + 255 * (1 - cover), np.uint8)


def views(mesh: nm.Mesh) -> list[Picture]:
    """The original, and the base of each filter."""
    options = nm.BakeOptions(size=f"{SIDE_PX}x{SIDE_PX}", supersample=2, azimuth=25.0, elevation=20.0)
    sets = [nm.bake(mesh, options, nm.FilterOptions(filter=name)) for name in FILTERS]
    return [lit(sets[0].original), *(lit(each.base) for each in sets)]


def main() -> None:
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else HOME
    made = {each.name: each for each in held_out_meshes(0)}
    rows = [np.hstack(views(nm.Mesh(made[name].vertices, made[name].faces, name=name))) for name in SHOWN]
    half = len(rows) // 2
    picture = np.hstack([np.vstack(rows[:half]), np.vstack(rows[half:])])
    cv2.imwrite(str(target), picture, [cv2.IMWRITE_JPEG_QUALITY, 88])


if __name__ == "__main__":
    main()
