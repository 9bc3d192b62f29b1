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
    "marigold": NormalPreset("Marigold normals, PNG or .npy", zero_code="127"),
    "dsine": NormalPreset("DSINE, PNG", "-r,g,b", zero_code="127"),
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
