"""How programs write normal maps and depth pictures: one table, which `from_` reads and `nmap inspect --presets` lists.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

DepthValues = Literal["height", "distance", "disparity"]


@dataclass(frozen=True)
class NormalPreset:
    """How a program writes normal maps: the values of those `nmaptool.ReadOptions` that are not given.

    Parameters
    ----------
    description : str
        The program and its files, in a few words.
    swizzle, green, zero_code, components : str
        As in `nmaptool.ReadOptions`.
    """

    description: str
    swizzle: str = "r,g,b"
    green: str = "up"
    zero_code: str = "auto"
    components: str = "auto"


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
    "opengl": NormalPreset("green up: Blender's baker, Unity, Godot, Marmoset, Maya"),
    "directx": NormalPreset("green down: Unreal, 3ds Max, CryEngine, Source", green="down"),
    "blender": NormalPreset("Blender's Normal pass (EXR) of a model seen from the front: world axes", "r,b,-g"),
    "unity": NormalPreset("Unity, as PNG or TGA: green up"),
    "unreal": NormalPreset("Unreal: green down", green="down"),
    "substance": NormalPreset("Substance Painter and Designer with their default, DirectX: green down", green="down"),
    "dxt5nm": NormalPreset("Unity, Unreal and Source textures with x in alpha, y in green", "a,g,b", components="xy"),
    "world": NormalPreset("world-space maps with z up, seen from the front", "r,b,-g"),
    "marigold": NormalPreset("Marigold normals, PNG or .npy", zero_code="127"),
    "dsine": NormalPreset("DSINE, PNG", "-r,g,b", zero_code="127"),
    "normalbae": NormalPreset("NormalBae, PNG", "-r,g,b", zero_code="127"),
    "controlnet": NormalPreset("ControlNet 1.1 NormalBae, PNG", "-r,g,b", zero_code="127"),
    "controlnet-midas": NormalPreset(
        "ControlNet 1.0 MiDaS normals, PNG; steepness arbitrary", "-b,g,r", zero_code="127"
    ),
    "stablenormal": NormalPreset("StableNormal, PNG; masked parts are white", "-r,g,b", zero_code="127"),
    "lotus": NormalPreset("Lotus normals, PNG or .npy", "-r,g,b", zero_code="127"),
    "geowizard": NormalPreset("GeoWizard normals, PNG or .npy", "-r,g,b", zero_code="127"),
    "omnidata": NormalPreset("Omnidata, PNG", "r,g,-b", green="down", zero_code="127"),
    "metric3d": NormalPreset(
        "Metric3D figures, cut from the three stacked pictures", "r,g,-b", green="down", zero_code="128"
    ),
    "metric3d-hub": NormalPreset("Metric3D hub demo: red and blue swapped", "b,g,-r", green="down", zero_code="127"),
    "metric3d-comfyui": NormalPreset("Metric3D in ComfyUI", "-r,g,b", zero_code="127"),
    "moge": NormalPreset("MoGe normal.png or normal.exr, ComfyUI normal_opengl", zero_code="127"),
    "moge-array": NormalPreset("MoGe normals as an array (.npy): OpenCV axes", "r,g,-b", green="down"),
    "opencv": NormalPreset("OpenCV camera axes: x right, y down, z away", "r,g,-b", green="down"),
}
DEPTH_PRESETS: dict[str, DepthPreset] = {
    "depth-anything": DepthPreset("Depth Anything V2, grey PNG: disparity, near is bright", "disparity"),
    "marigold": DepthPreset("Marigold depth, 16-bit PNG or .npy: 0 is near, 1 is far", "distance"),
    "realsense": DepthPreset("Kinect and RealSense, 16-bit PNG in mm, 0 is no reading", "distance", "1mm", (0.0,)),
    "blender": DepthPreset(
        "Blender's Z or Depth pass, EXR: distance in metres, 1e10 is empty", "distance", "1m", (1e10,)
    ),
}
