"""The pictures of 17 programs that write normal maps, in the words of their documentation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# the component of a normal that a high value of a channel means
WORDS = {
    "right": (0, 1),
    "left": (0, -1),
    "up": (1, 1),
    "down": (1, -1),
    "viewer": (2, 1),
    "away": (2, -1),
}


class Writer(NamedTuple):
    """What a high value of each channel means, how codes are made, and what stands outside the motif."""

    preset: str
    red: str
    green: str
    blue: str
    stored: str = "truncated"
    outside: str = "wall"


WRITERS = {
    "Marigold PNG": Writer("marigold", "right", "up", "viewer"),
    "Marigold npy": Writer("marigold", "right", "up", "viewer", "signed"),
    "DSINE PNG": Writer("dsine", "left", "up", "viewer"),
    "NormalBae PNG": Writer("normalbae", "left", "up", "viewer"),
    "ControlNet 1.1": Writer("controlnet", "left", "up", "viewer"),
    "StableNormal PNG": Writer("stablenormal", "left", "up", "viewer", outside="white"),
    "Lotus PNG": Writer("lotus", "left", "up", "viewer"),
    "Lotus npy": Writer("lotus", "left", "up", "viewer", "unsigned"),
    "GeoWizard PNG": Writer("geowizard", "left", "up", "viewer"),
    "Omnidata PNG": Writer("omnidata", "right", "down", "away"),
    "Metric3D figure": Writer("metric3d", "right", "down", "away", "zero 128"),
    "Metric3D hub": Writer("metric3d-hub", "away", "down", "right"),
    "Metric3D ComfyUI": Writer("metric3d-comfyui", "left", "up", "viewer"),
    "MoGe PNG": Writer("moge", "right", "up", "viewer", outside="grey"),
    "MoGe EXR": Writer("moge", "right", "up", "viewer", "signed", outside="zero"),
    "MoGe 16 bit": Writer("moge", "right", "up", "viewer", "16 bit", outside="zero"),
    "MoGe array": Writer("moge-array", "right", "down", "away", "signed"),
    "ControlNet 1.0": Writer("controlnet-midas", "viewer", "up", "left"),
    "Blender pass": Writer("blender", "right", "away", "up", "signed"),
    "Unreal": Writer("unreal", "right", "down", "viewer", "rounded"),
    "Substance": Writer("substance", "right", "down", "viewer", "rounded"),
    "Unity": Writer("unity", "right", "up", "viewer", "rounded"),
}


def picture_of(writer: Writer, normals: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """(H, W, 3) uint8, uint16 or float32: normals (H, W, 3) as the program stores them."""
    wall = np.where(inside[..., None], normals, (0.0, 0.0, 1.0))
    at = [WORDS[word] for word in (writer.red, writer.green, writer.blue)]
    stored = np.dstack([sign * wall[..., axis] for axis, sign in at])
    if writer.stored == "signed":
        pixels = stored.astype(np.float32)
        nothing = 0.0
    elif writer.stored == "unsigned":
        return ((stored + 1) / 2).astype(np.float32)
    elif writer.stored == "16 bit":
        pixels, nothing = ((stored + 1) / 2 * 65535).astype(np.uint16), 0
    elif writer.stored == "zero 128":
        pixels, nothing = np.round(stored * 127 + 128).astype(np.uint8), 0
    else:
        half = 0.5 if writer.stored == "rounded" else 0.0
        pixels, nothing = np.floor((stored + 1) / 2 * 255 + half).astype(np.uint8), 0
    if writer.outside != "wall":
        pixels[~inside] = {"white": 255, "grey": 127, "zero": nothing}[writer.outside]
    return pixels


def dxt5nm(normals: np.ndarray) -> np.ndarray:
    """(H, W, 4) uint8: x in alpha, y in green and blue, red full."""
    codes = np.floor((normals[..., :2] + 1) / 2 * 255 + 0.5).astype(np.uint8)
    full = np.full(codes.shape[:2], 255, np.uint8)
    return np.dstack([full, codes[..., 1], codes[..., 1], codes[..., 0]])
