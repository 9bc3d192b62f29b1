"""File names of unpacked layers, and the recipe that composes them again."""

from __future__ import annotations

import itertools
import math
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from nmaptool._version import __version__
from nmaptool.composition.recipe_toml import to_toml
from nmaptool.core.units import Length
from nmaptool.options import CanvasOptions, GroupOptions, LayerOptions
from nmaptool.types.recipe import Recipe, RecipeGroup, RecipeLayer
from nmaptool.types.unpacked import UnpackedLayer, UnpackResult
from nmaptool.types.workspace import NORMAL_BLEND, PASS_THROUGH, WorkspaceGroup

_LONGEST_NAME_BYTES = 100
# names that Windows reserves for devices
_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}


def safe_names(names: Sequence[str]) -> list[str]:
    """Turn layer names into file names without extension: valid, short and distinct on every system.

    >>> safe_names(["../x", "a/b", "con", "", "A/B"])
    ['x', 'a_b', '_con', 'layer', 'A_B 2']
    """
    out: list[str] = []
    seen: set[str] = set()
    for name in names:
        whole = unicodedata.normalize("NFC", name.encode("utf-8", "ignore").decode("utf-8"))
        plain = "".join(c if c.isalnum() or c in "-_+ .()" else "_" for c in whole)
        plain = plain.strip(" ._").encode("utf-8")[:_LONGEST_NAME_BYTES].decode("utf-8", "ignore").rstrip(" .")
        plain = plain or "layer"
        if plain.partition(".")[0].strip().casefold() in _DEVICES:
            plain = f"_{plain}"
        found, number = plain, 2
        while unicodedata.normalize("NFKC", found).casefold() in seen:
            found, number = f"{plain} {number}", number + 1
        seen.add(unicodedata.normalize("NFKC", found).casefold())
        out.append(found)
    return out


def layer_files(unpacked: UnpackResult, format: str) -> list[dict[str, str]]:
    """Return the ``name`` and ``file`` of each layer, and its ``mask`` if it has one."""
    files = []
    for layer, name in zip(unpacked.layers, safe_names([one.name for one in unpacked.layers]), strict=True):
        files.append({"name": layer.name, "file": f"{name}.{format}"})
        if layer.mask is not None:
            files[-1]["mask"] = f"{name}.mask.png"
    return files


def recipe_text(unpacked: UnpackResult, entries: Sequence[Mapping[str, str]]) -> str:
    """Return the recipe from which ``nmap compose stack`` composes the layers again, bottom to top.

    Parameters
    ----------
    unpacked : UnpackResult
    entries : sequence of mapping
        As returned by `layer_files`.
    """
    frame = unpacked.frame
    width = None if frame.pitch_mm is None else Length(frame.cols * frame.pitch_mm, "mm")
    canvas = CanvasOptions(f"{frame.cols}x{frame.rows}", width, "flat" if unpacked.ground == "flat" else "clear")
    pairs = list(zip(unpacked.layers, entries, strict=True))
    recipe = Recipe(tuple(_entries(pairs, 0)), canvas, name=unpacked.name)
    stated = f"# {_plain(Path(unpacked.name).name)}, unpacked by nmaptool {__version__}; bottom to top\n\n"
    return stated + to_toml(recipe)


def _mixed_first(layer: UnpackedLayer) -> tuple[WorkspaceGroup, ...]:
    """The groups that the recipe blends on their own; pass-through groups only keep layers together."""
    return tuple(group for group in layer.groups if group.blend_mode != PASS_THROUGH)


def _entries(
    pairs: Sequence[tuple[UnpackedLayer, Mapping[str, str]]], depth: int
) -> Iterator[RecipeLayer | RecipeGroup]:
    """The entries at one depth of groups; neighbouring layers in the same group form one entry."""

    def group_of(pair: tuple[UnpackedLayer, Mapping[str, str]]) -> WorkspaceGroup | None:
        groups = _mixed_first(pair[0])
        return groups[depth] if len(groups) > depth else None

    for _, run in itertools.groupby(pairs, lambda pair: id(group_of(pair)) if group_of(pair) else 0):
        members = list(run)
        group = group_of(members[0])
        if group is None:
            yield from (_recipe_layer(*pair) for pair in members)
            continue
        mode = "over" if group.blend_mode == NORMAL_BLEND else "rnm"
        options = GroupOptions(_plain(group.name) or "group", mode, _number(group.opacity))
        yield RecipeGroup(tuple(_entries(members, depth + 1)), options, hidden=not group.visible)


def _recipe_layer(layer: UnpackedLayer, entry: Mapping[str, str]) -> RecipeLayer:
    passed = [group for group in layer.groups if group.blend_mode == PASS_THROUGH]
    strength = _number(layer.strength * math.prod(group.opacity for group in passed))
    place = f"{layer.left}px,{layer.top}px"
    options = LayerOptions(
        _plain(layer.name) or "layer",
        layer.mode,
        min(strength, 1.0) if layer.mode == "over" else strength,
        place,
        "top-left",
    )
    visible = layer.visible and all(group.visible for group in passed)
    return RecipeLayer(entry["file"], options, entry.get("mask"), hidden=not visible)


def _number(value: float) -> float:
    """Round to more digits than the opacity of an editor has."""
    return round(float(value), 6)


def _plain(text: str) -> str:
    valid = text.encode("utf-8", "ignore").decode("utf-8")
    return "".join(c for c in valid if c.isprintable())
