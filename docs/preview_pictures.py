"""Make the figures of docs/previews.md from the samples: ``python docs/preview_pictures.py``."""

from __future__ import annotations

import math

import cv2
import numpy as np
from make_pictures import Picture, row, rows, sample, save

import nmaptool as nm
from nmaptool.types.contours import Contours

MATERIALS = ("clay", "plaster", "bronze", "silver", "gold", "marble", "walnut")


def medal() -> nm.Height:
    """The sample medal as a round plate of 40 mm."""
    options = nm.ReliefOptions(mu=0.5, height=nm.length("1.2mm"), width=nm.length("40mm"))
    height = nm.relief(sample("medal_original"), sample("medal_detail"), options=options).height
    side, pitch = height.frame.cols + 12, height.pitch_mm
    middle, radius = side * pitch / 2, 0.485 * side * pitch
    turn = np.linspace(0, math.tau, 1440, endpoint=False)
    ring = middle + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    y, x = (np.mgrid[0:side, 0:side] + 0.5) * pitch - middle
    z_mm = np.pad(height.z_mm, 6, mode="edge")
    return nm.Height(z_mm, np.hypot(x, y) < radius, nm.Frame(side, side, pitch), outline=Contours((ring,)))


def drawn(height: nm.Height, side: int, **options: object) -> Picture:
    """A preview in a square, drawn larger and reduced."""
    picture = nm.preview(height, nm.PreviewOptions(size=2 * side, thickness=nm.length("2mm"), **options))  # type: ignore[arg-type]
    tall = (2 * side - picture.shape[0]) // 2
    picture = np.pad(picture, ((tall, 2 * side - picture.shape[0] - tall), (0, 0), (0, 0)), mode="edge")
    return cv2.resize(picture, (side, side), interpolation=cv2.INTER_AREA).astype(np.uint8)


def materials() -> Picture:
    height = medal()
    upper = [drawn(height, 300, material=name) for name in MATERIALS[:4]]
    lower = [drawn(height, 300, material=name) for name in MATERIALS[4:]]
    lower.append(drawn(height, 300, material="clay", light=("100,14",)))
    return rows([row(upper), row(lower)])


def perspectives() -> Picture:
    height = medal()
    return row(
        [
            nm.preview(height, nm.PreviewOptions(material=name, view="iso", size=450, thickness=nm.length("2mm")))
            for name in ("bronze", "silver", "marble")
        ]
    )


if __name__ == "__main__":
    save("materials.jpg", materials())
    save("perspectives.jpg", perspectives())
    save("section.jpg", nm.preview(medal(), nm.PreviewOptions(section="y=50%", size=900, thickness=nm.length("2mm"))))
