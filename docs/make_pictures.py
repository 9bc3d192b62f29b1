"""Make the pictures of the docs from the samples: ``python docs/make_pictures.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import nmaptool as nm

ROOT = Path(__file__).parents[1]
SAMPLES = ROOT / "samples"
PICTURES = ROOT / "docs" / "pictures"
GAP_PX = 6
Picture = NDArray[np.uint8]


def sample(name: str) -> nm.NormalMap:
    return nm.read_normal_map(SAMPLES / f"{name}.png")


def shaded(original: str, detail: str | None = None, side: int = 300, **changes: Any) -> Picture:
    """A square preview of one relief."""
    beside = {k: changes.pop(k) for k in ("mask", "surface") if k in changes}
    layer = sample(detail) if detail is not None else None
    relief = nm.relief(sample(original), layer, options=nm.ReliefOptions(**changes), **beside)
    return cv2.resize(nm.preview(relief.height), (side, side), interpolation=cv2.INTER_AREA).astype(np.uint8)


def row(pictures: list[Picture]) -> Picture:
    gap = np.full((pictures[0].shape[0], GAP_PX, 3), 255, np.uint8)
    parts = [part for picture in pictures for part in (picture, gap)]
    return np.hstack(parts[:-1])


def rows(pictures: list[Picture]) -> Picture:
    gap = np.full((GAP_PX, pictures[0].shape[1], 3), 255, np.uint8)
    parts = [part for picture in pictures for part in (picture, gap)]
    return np.vstack(parts[:-1])


def save(name: str, picture: Picture) -> None:
    cv2.imwrite(str(PICTURES / name), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])


def gallery() -> Picture:
    """The reliefs of ``make demo``."""
    leaf_mask = nm.read_grey(SAMPLES / "leaf_mask.png")
    roll = nm.read_normal_map(SAMPLES / "roll.png")
    return row(
        [
            shaded("medal_original", "medal_detail", mu=0.5, height=nm.length("5%")),
            shaded("medal_base", height=nm.length("5%")),
            shaded("shell", height=nm.length("8%")),
            shaded("leaf_on_roll", background="surface", mask=leaf_mask, surface=roll, height=nm.length("5%")),
        ]
    )


def parameters() -> Picture:
    """One parameter growing along each row: mu, beta, delta; the same height scale within a row."""
    layers = ("medal_original", "medal_detail")
    return rows(
        [
            row([shaded(*layers, mu=mu, beta=0.001) for mu in (0.0, 0.3, 1.0, 3.0)]),
            row([shaded(*layers, beta=beta) for beta in (0.0001, 0.001, 0.01, 0.1)]),
            row([shaded(*layers, beta=0.01, delta=delta) for delta in (0.0, 15.0, 30.0, 60.0)]),
        ]
    )


if __name__ == "__main__":
    PICTURES.mkdir(exist_ok=True)
    save("gallery.jpg", gallery())
    save("parameters.jpg", parameters())
