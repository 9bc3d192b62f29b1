"""Read back the metadata that nmaptool writes into pictures."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any, Literal

from nmaptool.types.picture import DepthFacts

PREFIX = "nmaptool:"
_BREAKS = {"n": "\n", "r": "\r", "\\": "\\"}
_ESCAPED = re.compile(r"\\([nr\\])")
# attribute names of the values at code 0 and at the largest code
_ENDS: dict[Literal["depth", "height"], tuple[str, str]] = {
    "depth": ("far_mm", "near_mm"),
    "height": ("height_min_mm", "height_max_mm"),
}


def own_attributes(spec: Any) -> dict[str, str]:
    """Return nmaptool's own metadata in an OpenImageIO ImageSpec, with keys without the prefix."""
    own = {a.name[len(PREFIX) :]: str(a.value) for a in spec.extra_attribs if a.name.startswith(PREFIX)}
    return own or own_lines(str(spec.getattribute("ImageDescription") or ""))


def own_lines(description: str) -> dict[str, str]:
    """Return nmaptool's own metadata in the description of a TIFF, which has no free-form attributes: one per line."""
    own: dict[str, str] = {}
    for line in description.split("\n"):
        key, mark, value = line.removesuffix("\r").partition("=")
        if mark and key.startswith(PREFIX):
            own[key[len(PREFIX) :]] = _ESCAPED.sub(lambda found: _BREAKS[found[1]], value)
    return own


def one_line(text: str) -> str:
    """Escape a value to fit on a line of a TIFF's description; `own_attributes` restores it."""
    return text.replace("\\", "\\\\").replace("\n", "\\n").replace("\r", "\\r")


def depth_facts(attributes: Mapping[str, str]) -> DepthFacts | None:
    """Return the facts in the metadata of a depth or height file, else None; damaged values count as missing.

    Parameters
    ----------
    attributes : mapping
        As in `nmaptool.RasterImage`.
    """
    for kind, names in _ENDS.items():
        if attributes.get("kind") == kind:
            black_mm, white_mm = (_number(attributes.get(name)) for name in names)
            fov_deg = _camera_fov(attributes.get("recipe", "")) if kind == "depth" else None
            return DepthFacts(kind, black_mm, white_mm, fov_deg, attributes.get("at", "centers"))
    return None


def _number(text: object) -> float | None:
    """A finite number in text or JSON."""
    try:
        value = float(text)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return None
    return value if math.isfinite(value) else None


def _camera_fov(recipe: str) -> float | None:
    """The camera's field of view in the options with which the layers were rendered."""
    try:
        options = json.loads(recipe)
    except (ValueError, RecursionError):
        return None
    return _number(options.get("fov")) if isinstance(options, dict) else None
