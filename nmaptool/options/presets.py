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
    """How a program or device writes depth pictures.

    Parameters
    ----------
    description : str
        The program and its files, in a few words.
    values : str
        What a stored value grows with: "height" (white is high or near), "distance" from the camera, or "disparity",
        which is 1 over distance.
    unit, code_unit : str or None
        Length of one stored unit in floats and in integer codes, such as "1m"; for disparities, the distance where the
        value is 1. None if it is unknown.
    empty : tuple of float
        Stored values that mean "no depth", besides NaN and infinity.
    absolute : bool
        Whether the zero of floats is known: at the camera, or for disparities infinitely far. Codes have a known zero
        if they have a unit.
    lens : str
        Where the field of view of a perspective picture is stated; empty if the picture is not in perspective.
    """

    description: str
    values: DepthValues
    unit: str | None = None
    code_unit: str | None = None
    empty: tuple[float, ...] = ()
    absolute: bool = True
    lens: str = ""


NORMAL_PRESETS: dict[str, NormalPreset] = {
    "opengl": NormalPreset("green up: Blender's baker, Unity, Godot, Marmoset, Maya"),
    "directx": NormalPreset("green down: Unreal, 3ds Max, CryEngine, Source", green="down"),
    "blender": NormalPreset("Blender's Normal pass (EXR) of a model seen from the front: world axes", "r,b,-g"),
    "unity": NormalPreset("Unity, as PNG or TGA: green up"),
    "unreal": NormalPreset("Unreal: green down", green="down"),
    "substance": NormalPreset("Substance Painter and Designer with their default, DirectX: green down", green="down"),
    "dxt5nm": NormalPreset(
        "Unity, Unreal and Source textures with x in alpha, y in green", "a,g,b", green="auto", components="xy"
    ),
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
_CAMERA = "the data sheet of the camera"
# read from the programs' own code and documents; the tests encode known surfaces in the same way
DEPTH_PRESETS: dict[str, DepthPreset] = {
    "depth-anything": DepthPreset(
        "Depth Anything 1 and 2, grey PNG or floats: near is bright",
        "disparity",
        absolute=False,
    ),
    "depth-anything-metric": DepthPreset(
        "metric Depth Anything: floats in metres; in its PNG near is dark",
        "distance",
        "1m",
        lens="the photograph's metadata",
    ),
    "depth-anything-3": DepthPreset(
        "Depth Anything 3, floats: distance in an unknown unit", "distance", lens="its intrinsics"
    ),
    "depth-pro": DepthPreset(
        "Depth Pro, floats: distance in metres", "distance", "1m", lens="its output, as a focal length in px"
    ),
    "metric3d": DepthPreset("Metric3D, floats: distance in metres", "distance", "1m", lens="the photograph's metadata"),
    "moge": DepthPreset(
        "MoGe, depth.exr: distance in metres, infinite is empty", "distance", "1m", lens="fov.json beside it"
    ),
    "zoedepth": DepthPreset(
        "ZoeDepth, 16-bit PNG in 1/256 m, or floats in metres",
        "distance",
        "1m",
        "3.90625mm",
        lens="the photograph's metadata",
    ),
    "marigold": DepthPreset("Marigold, 16-bit PNG or floats: 0 is near, 1 is far", "distance", absolute=False),
    "geowizard": DepthPreset("GeoWizard, floats: 0 is near, 1 is far", "distance", absolute=False),
    "lotus": DepthPreset("Lotus, floats of its disparity models: near is bright", "disparity", absolute=False),
    "midas": DepthPreset("MiDaS, grey PNG or floats: near is bright", "disparity", absolute=False),
    "comfyui": DepthPreset(
        "depth nodes of ComfyUI for ControlNet: near is bright, whatever the model", "disparity", absolute=False
    ),
    "blender": DepthPreset(
        "Blender, Z or Depth pass, EXR: distance in metres, 1e10 is empty",
        "distance",
        "1m",
        empty=(1e10,),
        lens="its camera",
    ),
    "realsense": DepthPreset(
        "RealSense, 16-bit PNG in mm, 0 is no reading", "distance", "1m", "1mm", empty=(0.0,), lens=_CAMERA
    ),
    "kinect": DepthPreset(
        "Kinect, 16-bit PNG in mm, 0 is no reading", "distance", "1m", "1mm", empty=(0.0,), lens=_CAMERA
    ),
    "iphone": DepthPreset(
        "portrait photograph of an iPhone: disparity; in floats, 1 over metres",
        "disparity",
        "1m",
        lens="the photograph's metadata",
    ),
    "dem": DepthPreset("elevation model: heights in metres, with a value for no data", "height", "1m", "1m"),
}
