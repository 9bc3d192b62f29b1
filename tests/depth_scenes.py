"""A sphere and a bust before a camera, and how programs and devices write their depths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from depth_cases import grid

import nmaptool as nm

ROWS, COLS = 150, 200
FOV = 50.0
FOCAL = COLS / (2 * np.tan(np.radians(FOV / 2)))


@dataclass(frozen=True)
class Scene:
    """Distances from the camera in mm, in perspective; the motif's mask."""

    mm: Any
    mask: Any

    @property
    def inside(self) -> Any:
        """The mask eroded by 6 px."""
        return cv2.erode(self.mask.astype(np.uint8), np.ones((13, 13), np.uint8), borderValue=0) > 0

    @property
    def slopes(self) -> Any:
        """(H, W, 2) slopes to the right and up that are true in perspective."""
        return gradients(-FOCAL * np.log(self.mm))


def gradients(heights: Any) -> Any:
    """(H, W, 2) slopes to the right and up, to fourth order: the normals of clean pictures are."""
    out = [np.gradient(heights, axis=1), -np.gradient(heights, axis=0)]
    for axis, slope in ((1, out[0]), (0, out[1])):
        h = np.moveaxis(heights, axis, 0)
        fine = (h[:-4] - 8 * h[1:-3] + 8 * h[3:-1] - h[4:]) / 12
        np.moveaxis(slope, axis, 0)[2:-2] = fine if axis else -fine
    return np.stack(out, axis=-1)


def sphere(distance_mm: float = 4000, depth_mm: float = 300) -> Scene:
    """A sphere cut off below its equator."""
    x, y = grid(ROWS, COLS)
    r = np.hypot(x - 4, y + 3) / 62
    cap = np.sqrt(np.maximum(1.25**2 - r**2, 0)) - 0.75
    return Scene(distance_mm - depth_mm * cap.clip(0) / 0.5, r < 1)


def bust(distance_mm: float = 4000, depth_mm: float = 300) -> Scene:
    """A head with nose, brows and eyes, on neck and shoulders."""
    x, y = (v / 75 for v in grid(ROWS, COLS))

    def bump(height: float, cx: float, cy: float, wide: float, tall: float) -> Any:
        return height * np.exp(-(((x - cx) / wide) ** 2) - ((y - cy) / tall) ** 2)

    h = bump(0.75, 0, 0.25, 0.5, 0.6) + bump(0.2, 0, 0.12, 0.09, 0.2) + bump(0.1, 0, 0.5, 0.35, 0.12)
    for side in (-1, 1):
        h = h + bump(-0.08, 0.2 * side, 0.3, 0.11, 0.07) + bump(0.35, 0.55 * side, -0.85, 0.5, 0.25)
    h = h + bump(0.4, 0, -0.6, 0.25, 0.4)
    return Scene(distance_mm - depth_mm * h, h > 0.12)


SCENES: dict[str, Callable[..., Scene]] = {"sphere": sphere, "bust": bust}


def floats(values: Any, **more: Any) -> nm.RasterImage:
    """A grey picture of floats."""
    return nm.RasterImage(np.asarray(values, np.float32)[..., None], ("Y",), bits=32, **more)


def codes(values: Any, bits: int, **more: Any) -> nm.RasterImage:
    """A grey picture of codes, truncated as most writers do."""
    kind = np.uint8 if bits == 8 else np.uint16
    return nm.RasterImage(np.asarray(values).astype(kind)[..., None], ("Y",), bits=bits, **more)


def stretched(values: Any, top: float = 1.0) -> Any:
    """Values scaled per picture to 0..top."""
    return (values - values.min()) / np.ptp(values) * top


@dataclass(frozen=True)
class Writer:
    """How a program encodes a scene, and what is expected of it.

    Attributes
    ----------
    write : callable
        Returns the picture of a scene.
    metric : bool
        Whether it states real distances.
    empties : bool
        Whether pixels outside the motif are empty.
    """

    preset: str
    write: Callable[[Scene], nm.RasterImage]
    metric: bool = False
    empties: bool = False


def _nothing(scene: Scene, values: Any, nothing: float) -> Any:
    return np.where(scene.mask, values, nothing)


WRITERS = {
    "Depth Anything, grey PNG": Writer("depth-anything", lambda s: codes(stretched(1 / s.mm, 255), 8)),
    "Depth Anything, floats": Writer("depth-anything", lambda s: floats(9e4 / s.mm - 3)),
    "Depth Anything metric, .npy": Writer("depth-anything-metric", lambda s: floats(s.mm / 1000), metric=True),
    "Depth Anything metric, PNG": Writer("depth-anything-metric", lambda s: codes(stretched(s.mm, 255), 8)),
    "Depth Anything 3": Writer("depth-anything-3", lambda s: floats(s.mm / 1234)),
    "Depth Pro": Writer("depth-pro", lambda s: floats(s.mm / 1000), metric=True),
    "Metric3D": Writer("metric3d", lambda s: floats(s.mm / 1000), metric=True),
    "MoGe": Writer("moge", lambda s: floats(_nothing(s, s.mm / 1000, np.inf)), metric=True, empties=True),
    "ZoeDepth, 16-bit PNG": Writer("zoedepth", lambda s: codes(s.mm / 1000 * 256, 16), metric=True),
    "ZoeDepth, floats": Writer("zoedepth", lambda s: floats(s.mm / 1000), metric=True),
    "Marigold, 16-bit PNG": Writer("marigold", lambda s: codes(stretched(s.mm, 65535), 16)),
    "Marigold, .npy": Writer("marigold", lambda s: floats(stretched(s.mm))),
    "GeoWizard": Writer("geowizard", lambda s: floats(0.1 + 0.8 * stretched(s.mm))),
    "Lotus": Writer("lotus", lambda s: floats(0.2 + 0.6 * stretched(1 / s.mm))),
    "MiDaS, .pfm": Writer("midas", lambda s: floats(4e6 / s.mm)),
    "MiDaS, PNG": Writer("midas", lambda s: codes(stretched(1 / s.mm, 255), 8)),
    "ComfyUI": Writer("comfyui", lambda s: codes(255 - np.floor(stretched(s.mm, 255)), 8)),
    "Blender": Writer("blender", lambda s: floats(_nothing(s, s.mm / 1000, 1e10)), metric=True, empties=True),
    "RealSense": Writer("realsense", lambda s: codes(_nothing(s, np.round(s.mm), 0), 16), metric=True, empties=True),
    "Kinect": Writer("kinect", lambda s: codes(_nothing(s, np.round(s.mm), 0), 16), metric=True, empties=True),
    "iPhone, floats": Writer("iphone", lambda s: floats(1000 / s.mm), metric=True),
    "iPhone, 8 bit": Writer("iphone", lambda s: codes(stretched(1 / s.mm, 255), 8)),
}
