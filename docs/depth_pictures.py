"""Make the figure of depth images: ``python docs/depth_pictures.py [IMAGE...] [--out FILE]``.

One row per image: the depth image, its normals, the jumps found, and a relief of 2 mm. Without arguments it
draws an 8-bit image: a flower and a ball in a stepped frame.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np
from make_pictures import PICTURES, Picture, row, rows
from numpy.typing import NDArray

import nmaptool as nm

SIDE_PX = 360
DRAWN_PX = 640
Heights = NDArray[np.float64]


def ellipsoid(x: Heights, y: Heights, across: float, along: float, angle: float, tilt: float) -> Heights:
    """Heights of an ellipsoid around the origin whose long axis rises by ``tilt``; -inf outside its outline."""
    u, v = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
    inside = 1 - (u / along) ** 2 - (v / across) ** 2
    with np.errstate(invalid="ignore"):
        return np.where(inside > 0, across * np.sqrt(np.maximum(inside, 0)) + tilt * u, -np.inf)


def flower_in_a_frame(side: int = DRAWN_PX) -> nm.RasterImage:
    """An 8-bit depth image of overlapping rounded shapes; nearer is brighter."""
    y, x = (np.mgrid[:side, :side] + 0.5) * 200 / side - 100
    edge = 100 - np.maximum(np.abs(x), np.abs(y))
    heights = np.select([edge < 4, edge < 9, edge < 14], [18.0, 12.0, 6.0], 0.0)
    for ring, (petals, reach, width, lift) in enumerate([(9, 40.0, 15.0, 14.0), (6, 28.0, 13.0, 34.0)]):
        for petal in range(petals):
            angle = 2 * np.pi * (petal + 0.5 * ring) / petals
            middle = 8 + 0.75 * reach
            centre_x, centre_y = middle * np.cos(angle) - 8, middle * np.sin(angle) - 8
            leaf = ellipsoid(x - centre_x, y - centre_y, width, 0.72 * reach, angle, 0.25)
            heights = np.maximum(heights, lift + 3 * (petal % 2) + leaf)
    heights = np.maximum(heights, 62 + ellipsoid(x + 8, y + 8, 12, 12, 0, 0))
    heights = np.maximum(heights, 10 + ellipsoid(x - 62, y - 62, 20, 20, 0, 0))
    stem = np.abs(y - 62 - 14 * np.sin(x / 24)) * 1.0
    heights = np.maximum(heights, np.where((stem < 3) & (x < 40), 8 + np.sqrt(np.maximum(9.5 - stem**2, 0)), 0))
    codes = np.floor(heights / heights.max() * 255 + 0.5).astype(np.uint8)
    return nm.RasterImage(codes[..., None], ("Y",), name="flower")


def fitted(picture: NDArray[np.generic]) -> Picture:
    """The image in colour, SIDE_PX high."""
    colored = np.repeat(picture[..., None], 3, axis=2) if picture.ndim == 2 else picture
    width = round(SIDE_PX * colored.shape[1] / colored.shape[0])
    return cv2.resize(colored.astype(np.uint8), (width, SIDE_PX), interpolation=cv2.INTER_AREA)


def strip(image: nm.RasterImage) -> Picture:
    """A depth image, its normals, its jumps and its relief."""
    # a plate: the relief then does not pull other flat parts either, such as a frame
    result = nm.depth_to_normals(image, nm.DepthOptions(background="flat"))
    relief = nm.relief(result.normal_map, options=nm.ReliefOptions(height=nm.length("2mm")))
    grey = image.pixels[..., 0].astype(np.float64)
    jumps = 255 * (1 - np.minimum(result.jumps / max(np.percentile(result.jumps[result.jumps > 0], 95), 1), 1) ** 0.5)
    normals = np.clip(np.rint(127.5 * (result.normal_map.normals + 1)), 0, 255)
    return row([fitted(grey / grey.max() * 255), fitted(normals), fitted(jumps), fitted(nm.preview(relief.height))])


def padded(strips: list[Picture]) -> list[Picture]:
    """Pad all strips to the same width."""
    width = max(picture.shape[1] for picture in strips)
    return [np.pad(p, ((0, 0), (0, width - p.shape[1]), (0, 0)), constant_values=255) for p in strips]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", nargs="*", type=Path, help="depth images")
    parser.add_argument("--out", type=Path, default=PICTURES / "depth.jpg")
    given = parser.parse_args()
    images = [nm.read_raster(path) for path in given.images] or [flower_in_a_frame()]
    picture = rows(padded([strip(image) for image in images]))
    given.out.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(given.out), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    main()
