"""Find the layers in the channels and parts of a file: ``R,G,B``, ``N.X,N.Y,N.Z``, ``detail.X`` ..., multi-part."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from nmaptool.core.errors import InputError

# sets of component names that writers use for R, G, B; never mixed, since Z beside R, G, B is depth
_TRIPLES = (("r", "g", "b"), ("x", "y", "z"), ("red", "green", "blue"))
# maps of x and y alone; used only if a file has no such triple, since beside one they often hold motion
_PAIRS = (("r", "g"), ("x", "y"), ("red", "green"))
_ALPHA = ("a", "alpha")
# the layers to choose from, in this order, if a file has several and none is named
_FIRST_CHOICE = ("original", "n", "normal", "normals", "")
# the name of the unnamed layer in lists and requests
_UNNAMED = "RGB"


@dataclass(frozen=True)
class Layer:
    """One layer: its name (None for the only one), its part, and its channels' positions and names R, G, B, A or Y."""

    name: str | None
    part: int
    indices: tuple[int, ...]
    channels: tuple[str, ...]


def find(parts: list[Any]) -> list[Layer]:
    """Return all layers of a file, from the specs of its parts.

    Parameters
    ----------
    parts : list of ImageSpec
    """
    found: list[Layer] = []
    for number, (spec, part_name, groups) in enumerate(_grouped(parts)):
        layers = _of_names(_TRIPLES, groups, part_name, number) or _of_names(_PAIRS, groups, part_name, number)
        found += layers or [_plain(part_name, number, spec)]
    return found


def _grouped(parts: list[Any]) -> Iterator[tuple[Any, str, dict[str, dict[str, int]]]]:
    """Each part's spec, its name, and its channels' positions by layer and lower-case component."""
    for spec in parts:
        part_name = str(spec.getattribute("oiio:subimagename") or "") if len(parts) > 1 else ""
        groups: dict[str, dict[str, int]] = {}
        for index, channel in enumerate(spec.channelnames):
            prefix, _, component = channel.rpartition(".")
            groups.setdefault(prefix, {})[component.lower()] = index
        yield spec, part_name, groups


def _pairs_beside(parts: list[Any]) -> list[Layer]:
    """Layers of two components beside layers of three: often motion, so they are chosen only by name."""
    return [
        layer
        for number, (_, part_name, groups) in enumerate(_grouped(parts))
        if _of_names(_TRIPLES, groups, part_name, number)
        for layer in _of_names(_PAIRS, groups, part_name, number)
        if layer.name or not any(set(names) <= set(groups.get("", {})) for names in _TRIPLES)
    ]


def _of_names(
    sets: tuple[tuple[str, ...], ...], groups: dict[str, dict[str, int]], part_name: str, number: int
) -> list[Layer]:
    """The layers of a part whose component names are one of the sets."""
    found: list[Layer] = []
    shared_alpha = _alpha(groups.get("", {}))
    for prefix, members in groups.items():
        chosen = next((names for names in sets if set(names) <= set(members)), None)
        if chosen is None:
            continue
        indices = [members[name] for name in chosen]
        channels = ("R", "G", "B")[: len(chosen)]
        alpha = _alpha(members)
        alpha = shared_alpha if alpha is None else alpha
        if alpha is not None:
            indices.append(alpha)
            channels = (*channels, "A")
        found.append(Layer(_label(part_name, prefix), number, tuple(indices), channels))
    return found


def _alpha(members: dict[str, int]) -> int | None:
    return next((members[name] for name in _ALPHA if name in members), None)


def _label(part_name: str, prefix: str) -> str:
    """A layer's name; channel names often repeat the name of their part."""
    if not part_name or prefix == part_name or prefix.startswith(f"{part_name}."):
        return prefix
    return f"{part_name}.{prefix}" if prefix else part_name


def _plain(label: str, number: int, spec: Any) -> Layer:
    """A part without colour channels as a layer: grey, with alpha if it has one."""
    names = tuple(spec.channelnames)
    alpha = next((i for i, n in enumerate(names) if n.rpartition(".")[2].lower() in _ALPHA), None)
    rest = [i for i in range(len(names)) if i != alpha]
    if not rest:  # alpha alone is a grey picture
        return Layer(label, number, (0,), ("Y",))
    if len(rest) == 1:
        channels = ("Y",) if alpha is None else ("Y", "A")
        return Layer(label, number, (rest[0],) if alpha is None else (rest[0], alpha), channels)
    return Layer(label, number, tuple(range(len(names))), names)


def choose(path: Path, parts: list[Any], wanted: str | None) -> Layer:
    """Return the wanted layer, or the obvious one if none is named.

    Raises
    ------
    InputError
        If the layer does not exist, or several exist and none is the obvious one; the message lists them.
    """
    found = find(parts)
    if not found:
        raise InputError(f"{path}: holds no picture")
    names = ", ".join(layer.name or _UNNAMED for layer in found)
    if wanted is not None:
        for layer in (*found, *_pairs_beside(parts)):
            if (layer.name or _UNNAMED).lower() == wanted.lower():
                return layer
        raise InputError(f"{path}: has no layer {wanted!r}; it holds: {names}")
    if len(found) == 1:
        layer = found[0]
        return Layer(None, layer.part, layer.indices, layer.channels)
    for first in _FIRST_CHOICE:
        for layer in found:
            if (layer.name or "").lower() == first:
                return layer if first else Layer(None, layer.part, layer.indices, layer.channels)
    example = f"{path.name}:{found[0].name or _UNNAMED}"
    raise InputError(f"{path}: holds several layers ({names}); name one, such as {example}")


def pick(pixels: NDArray[Any], layer: Layer) -> NDArray[Any]:
    """Select the layer's channels from all channels of its part."""
    if layer.indices == tuple(range(pixels.shape[2])):
        return pixels
    return pixels[..., list(layer.indices)]
