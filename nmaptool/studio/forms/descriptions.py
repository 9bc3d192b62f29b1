"""Forms of the page: names, help and choices of options, derived from the options classes."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from typing import Any

from nmaptool.core.units import Length
from nmaptool.options import (
    BakeOptions,
    DepthOptions,
    FilterOptions,
    LayerOptions,
    MeshReadOptions,
    ReadOptions,
    ReliefFiles,
    SplitOptions,
)
from nmaptool.options.bake import VIEWS
from nmaptool.options.fields import Options, descriptions, kind_of
from nmaptool.options.kinds import Choice, Count, Numeric, Switch
from nmaptool.options.length_kinds import LengthText
from nmaptool.types.recipe import READ_KEYS

_DEPTH = ("from_", "values", "depth_scale", "unit", "invert", "fov", "fill", "jump", "smooth", "background", "width")

# kinds of input of the page; any other option is text
_INPUTS: dict[str, type | tuple[type, ...]] = {
    "choice": Choice,
    "switch": Switch,
    "number": (Count, Numeric),
    "length": LengthText,
}
# the view is chosen by buttons and by turning
_NOT_SHOWN = ("view", "max_megapixels", "detail_encoding")
_CAMERA = [f.name for f in dataclasses.fields(BakeOptions) if f.name not in _NOT_SHOWN]


def forms() -> dict[str, Any]:
    """Return the message with the fields of each form of the page."""
    layer = [f.name for f in dataclasses.fields(LayerOptions)]
    return {
        "kind": "forms",
        "layer": described(LayerOptions, layer),
        "read": described(ReadOptions, [name for name in READ_KEYS if name != "layer"]),
        "depth": described(DepthOptions, _DEPTH),
        "camera": described(BakeOptions, _CAMERA),
        "reading": described(MeshReadOptions, ["unit"]),
        "filter": described(FilterOptions, [f.name for f in dataclasses.fields(FilterOptions)]),
        "split": described(SplitOptions, ["filter", "sigma_s", "sigma_r", "iterations"]),
        "views": VIEWS,
        "files": described(ReliefFiles, [f.name for f in dataclasses.fields(ReliefFiles)]),
    }


def described(options: type[Options], names: Iterable[str]) -> list[dict[str, Any]]:
    """Return one mapping for each option: name, label, help, kind of input, default, example and choices."""
    fields = {f.name: f for f in dataclasses.fields(options)}
    helps = descriptions(options)
    return [_described(fields[name], helps[name]) for name in names]


def _described(field: dataclasses.Field[Any], told: str) -> dict[str, Any]:
    kind = kind_of(field)
    assert kind is not None
    return {
        "name": field.name,
        "label": field.name.rstrip("_").replace("_", " "),
        "help": re.sub(r"--([a-z-]+)", lambda flag: flag[1].replace("-", " "), told),
        "kind": next((name for name, kinds in _INPUTS.items() if isinstance(kind, kinds)), "text"),
        "default": plain(field.default),
        "example": kind.such_as,
        "choices": list(kind.names) if isinstance(kind, Choice) else [],
    }


def plain(value: Any) -> Any:
    """Return an option's value as JSON holds it: lengths as text."""
    return str(value) if isinstance(value, Length) else value


def plain_options(options: Options) -> dict[str, Any]:
    """Return options as JSON holds them."""
    return {name: plain(value) for name, value in vars(options).items()}
