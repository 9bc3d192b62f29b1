"""Small maps and masks to compose, and recipes that use them."""

import numpy as np

import nmaptool as nm
from nmaptool.core.vectors import unit


def waves(rows, cols, frequency, pitch=None, disc=False, name="map"):
    """A wavy surface that fills the image, or a disc of it."""
    y, x = (np.mgrid[0:rows, 0:cols] + 0.5) / np.array([rows, cols]).reshape(2, 1, 1) - 0.5
    normals = unit(np.stack([np.sin(frequency * x), 0.5 * np.cos(frequency * y), np.ones_like(x)], axis=-1))
    coverage = np.ones((rows, cols), np.float32)
    if disc:
        coverage = (np.hypot(x, y) < 0.45).astype(np.float32)
        normals[coverage == 0] = (0, 0, 1)
    return nm.NormalMap(normals.astype(np.float32), coverage, nm.Frame(rows, cols, pitch), name=name)


def write_maps(folder, png):
    """Write ``plate.exr`` (80 x 60, 0.5 mm), ``bunny.exr`` (30 x 40, a disc), ``leaf.png`` (24 x 20) and two masks."""
    nm.write_normal_map(waves(60, 80, 4, 0.5), folder / "plate.exr")
    nm.write_normal_map(waves(40, 30, 9, 0.5, disc=True), folder / "bunny.exr")
    nm.write_normal_map(waves(20, 24, 6, disc=True), folder / "leaf.png")
    half = np.zeros((40, 30), np.uint8)
    half[:, :15] = 255
    png(folder / "half.png", half)
    wide = np.zeros((60, 80), np.uint8)
    wide[10:50, 20:60] = 204
    png(folder / "wide.png", wide)
    return folder


# scenes begin with the plate and the bunny; the keys that follow place the bunny
BUNNY_ON_PLATE = """
[canvas]
width = "40mm"

[[layer]]
file = "plate.exr"

[[layer]]
name = "bunny"
file = "bunny.exr"
"""

THROUGH_WIDE = """mode = "rnm"
strength = 0.5
mask = "wide.png"
"""

SCENE = f"""{BUNNY_ON_PLATE}at = "30%,12mm"
anchor = "bottom"
scale = 0.7
rotate = 12
flip-h = true
feather = "3px"
strength = 0.8
mask = "half.png"

[[layer]]
name = "ornaments"
{THROUGH_WIDE}
  [[layer.layer]]
  file = "leaf.png"
  at = "50%,50%"
  [layer.layer.read]
  green = "down"

  [[layer.layer]]
  file = "leaf.png"
  at = "60%,40%"
  scale = "8mm"
  mode = "pd"
  clip = "no"
"""
