"""How programs write normal maps and depth pictures: one table, which `from_` reads and `nmap inspect --presets` lists.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

DepthValues = Literal["height", "distance", "disparity"]


@dataclass(frozen=True)
class NormalPreset:
    """How a program writes normal maps. Its values replace those defaults of `nmaptool.ReadOptions` that are not given.

    Parameters
    ----------
    description : str
        The program and its files, in a few words.
    swizzle, zero_code, encoding, components, background_color : str
        As in `nmaptool.ReadOptions`.
    """

    description: str
    swizzle: str = "r,g,b"
    zero_code: str = "auto"
    encoding: str = "auto"
    components: str = "auto"
    background_color: str = "auto"


@dataclass(frozen=True)
class DepthPreset:
    """How a program writes depth pictures.

    Parameters
    ----------
    description : str
        The program and its files, in a few words.
    values : str
        What a stored value grows with: "height" (white is high), "distance" from the eye, or "disparity", which is 1
        over distance up to scale and offset.
    unit : str or None
        Length of a stored unit, such as "1m" or "1mm"; None if values have no unit.
    empty : tuple of float
        Stored values that mean "no depth".
    """

    description: str
    values: DepthValues
    unit: str | None = None
    empty: tuple[float, ...] = ()


NORMAL_PRESETS: dict[str, NormalPreset] = {
    "marigold": NormalPreset("Marigold normals, PNG or .npy", zero_code="127"),
    "dsine": NormalPreset("DSINE, PNG", "-r,g,b", zero_code="127"),
}
DEPTH_PRESETS: dict[str, DepthPreset] = {
    "depth-anything": DepthPreset("Depth Anything V2, grey PNG: disparity, near is bright", "disparity"),
    "marigold": DepthPreset("Marigold depth, 16-bit PNG or .npy: 0 is near, 1 is far", "distance"),
    "realsense": DepthPreset("Kinect and RealSense, 16-bit PNG in mm, 0 is no reading", "distance", "1mm", (0.0,)),
    "blender": DepthPreset(
        "Blender's Z or Depth pass, EXR: distance in metres, 1e10 is empty", "distance", "1m", (1e10,)
    ),
}
