"""What the stored values of a depth picture mean: heights, distances or disparities, their unit, which are empty."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, length
from nmaptool.depth.values import BLENDER_NOTHING
from nmaptool.options import DepthOptions
from nmaptool.options.presets import DEPTH_PRESETS, DepthPreset, DepthValues
from nmaptool.types.picture import RasterImage

# names of layers that hold distances from the camera; "zdepth" is not one, since V-Ray stores near as white there
_DISTANCE_LAYERS = ("z", "depth", "pz", "denoising depth")
_DECLARED: dict[str, DepthValues] = {"depth": "distance", "height": "height"}


@dataclass(frozen=True)
class Meaning:
    """What the stored values of a picture mean, and how that is known.

    Attributes
    ----------
    values : str
        "height", "distance" or "disparity".
    values_from : str
        ``given``, ``file``, ``preset``, ``found`` (from the name of the layer, or Blender's value for nothing) or
        ``assumed``.
    absolute : bool
        Whether the value at the camera is known: 0 for distances, infinite for disparities.
    unit : Length or None
        Length of a stored unit.
    unit_from : str
        ``given``, ``preset`` or ``none``.
    preset, preset_from : str
        The writer and its source, ``given`` or ``found``; empty if it is unknown.
    empty : tuple of float
        Stored values that mean "no depth".
    lens : str
        Where the writer states the field of view; empty if it has none.
    """

    values: DepthValues = "height"
    values_from: str = "assumed"
    absolute: bool = False
    unit: Length | None = None
    unit_from: str = "none"
    preset: str = ""
    preset_from: str = ""
    empty: tuple[float, ...] = ()
    lens: str = ""

    @property
    def is_distance(self) -> bool:
        """Whether small values are near: distances, and disparities that can be converted to them."""
        return self.values == "distance" or (self.values == "disparity" and self.absolute)


def kind_of(image: RasterImage) -> str:
    """Return ``depth`` or ``height`` if the file declares it, else ``grey``."""
    return "grey" if image.depth_facts is None else image.depth_facts.kind


def meaning_of(image: RasterImage, options: DepthOptions) -> Meaning:
    """Return the meaning of a picture's values from the options, the file, the preset or the layer's name.

    Raises
    ------
    UsageError
        If an option contradicts the file.
    """
    kind = kind_of(image)
    empty = () if image.nodata is None or not np.isfinite(image.nodata) else (image.nodata,)
    if kind != "grey":
        _refuse_contradictions(image, kind, options)
        return Meaning(_DECLARED[kind], "file", kind == "depth" and image.is_float, empty=empty)
    name, name_from = (options.from_, "given") if options.from_ != "auto" else _recognised(image)
    preset = DEPTH_PRESETS.get(name)
    values, source = _values(image, options, preset)
    unit, unit_from = _unit(image, options, preset if name_from == "given" else None)
    return Meaning(
        values,
        source,
        _is_absolute(image, options, preset, values, unit),
        unit,
        unit_from,
        name if preset is not None else "",
        name_from,
        (*empty, *(value for value in (() if preset is None else preset.empty) if value not in empty)),
        "" if preset is None else preset.lens,
    )


def _refuse_contradictions(image: RasterImage, kind: str, options: DepthOptions) -> None:
    """Refuse options that a file's own statement about its values leaves no room for."""
    values = _DECLARED[kind]
    given = {
        "`invert`": options.invert,
        f"`values={options.values!r}`": options.values not in ("auto", values),
        f"`from_={options.from_!r}`": options.from_ != "auto",
        f"`unit='{options.unit}'`": options.unit is not None,
    }
    for name, contradicts in given.items():
        if contradicts:
            fixed = "scale" if name.startswith("`unit") else "direction"
            raise UsageError(
                f"{name}: {image.name} declares that it holds {kind}, which fixes the {fixed}; leave it out"
            )


def _recognised(image: RasterImage) -> tuple[str, str]:
    """Return the writer of a picture that is unmistakable: Blender, by its value for nothing."""
    if image.is_float and float(np.max(image.pixels[..., 0])) == BLENDER_NOTHING:
        return "blender", "found"
    return "", ""


def is_distance_layer(image: RasterImage) -> bool:
    """Whether the name of the layer or of its only channel says that it holds distances, such as ViewLayer.Depth.Z."""
    names = [name for name in image.channels if name != "A"] if len(image.channels) < 3 else []
    names.append(image.layer or (image.name.rpartition(":")[2] if ":" in image.name else ""))
    return image.is_float and any(re.split(r"[.:/]", name)[-1].lower() in _DISTANCE_LAYERS for name in names)


def _values(image: RasterImage, options: DepthOptions, preset: DepthPreset | None) -> tuple[DepthValues, str]:
    if options.values != "auto":
        return options.values, "given"
    if options.invert:
        return "distance", "given"
    if preset is not None and options.from_ != "auto":
        return preset.values, "preset"
    if preset is not None or is_distance_layer(image):
        return "distance", "found"
    return "height", "assumed"


def _unit(image: RasterImage, options: DepthOptions, preset: DepthPreset | None) -> tuple[Length | None, str]:
    if options.unit is not None:
        return options.unit, "given"
    text = None if preset is None or options.depth_scale is not None else _text_of(image, preset)
    return (None, "none") if text is None else (length(text), "preset")


def _text_of(image: RasterImage, preset: DepthPreset) -> str | None:
    """The preset's unit for this picture; 8-bit codes are always normalised per picture."""
    return preset.unit if image.is_float else preset.code_unit if image.pixels.dtype == np.uint16 else None


def _is_absolute(
    image: RasterImage, options: DepthOptions, preset: DepthPreset | None, values: DepthValues, unit: Length | None
) -> bool:
    """Whether the zero of the values is known."""
    if values == "height":
        return False
    if unit is not None or (preset is not None and _text_of(image, preset) is not None):
        return True
    stored = image.pixels[..., 0]
    if not image.is_float:  # codes that do not reach white were not scaled per picture
        return stored.dtype == np.uint16 and options.values == "distance" and int(stored.max()) < image.max_code
    if preset is not None and not preset.absolute:
        return False
    if values == "disparity":
        finite = stored[np.isfinite(stored)]
        return finite.size > 0 and not (finite.min() == 0 and finite.max() == 1)  # those are normalised per picture
    return True
