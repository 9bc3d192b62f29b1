"""Which channels of which part of a file make a layer: ``R,G,B``, ``N.X,N.Y,N.Z``, ``detail.X`` ..., multi-part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from nmaptool.errors import InputError

# component names that writers use, and the channel they mean
_COMPONENTS = {
    "r": "R",
    "g": "G",
    "b": "B",
    "x": "R",
    "y": "G",
    "z": "B",
    "a": "A",
    "red": "R",
    "green": "G",
    "blue": "B",
}
# layer names that are taken where several are there and none was asked for
_FIRST_CHOICE = ("", "original", "n", "normal", "normals")


@dataclass(frozen=True)
class Layer:
    """One layer: its name (None for the only one), part, channel positions and their names R, G, B, A or Y."""

    name: str | None
    part: int
    indices: tuple[int, ...]
    channels: tuple[str, ...]


def find(parts: list[Any]) -> list[Layer]:
    """All layers of a file, from the specs of its parts.

    Parameters
    ----------
    parts : list of ImageSpec
    """
    found: list[Layer] = []
    for number, spec in enumerate(parts):
        part_name = str(spec.getattribute("oiio:subimagename") or "") if len(parts) > 1 else ""
        groups: dict[str, dict[str, int]] = {}
        single: dict[str, int] = {}
        for index, channel in enumerate(spec.channelnames):
            prefix, _, component = channel.rpartition(".")
            meaning = _COMPONENTS.get(component.lower())
            if meaning is not None and not (component in ("Y", "Z") and spec.nchannels <= 2):
                groups.setdefault(prefix, {})[meaning] = index
            else:
                single[channel] = index
        alpha = groups.get("", {}).get("A")
        for prefix, members in groups.items():
            if not {"R", "G", "B"} <= set(members):
                continue
            if "A" not in members and alpha is not None:
                members["A"] = alpha
            names = tuple(c for c in "RGBA" if c in members)
            label = ".".join(x for x in (part_name, prefix) if x)
            found.append(Layer(label, number, tuple(members[c] for c in names), names))
        if not any(layer.part == number for layer in found):
            found.append(_plain(part_name, number, spec))
    return found


def _plain(label: str, number: int, spec: Any) -> Layer:
    """A part without three colour channels: grey, with alpha where it has one."""
    names = tuple(spec.channelnames)
    alpha = next((i for i, n in enumerate(names) if n.rpartition(".")[2].lower() in ("a", "alpha")), None)
    rest = [i for i in range(len(names)) if i != alpha]
    if len(rest) == 1:
        channels = ("Y",) if alpha is None else ("Y", "A")
        return Layer(label, number, (rest[0],) if alpha is None else (rest[0], alpha), channels)
    return Layer(label, number, tuple(range(len(names))), names)


def choose(path: Path, parts: list[Any], wanted: str | None) -> Layer:
    """The wanted layer, or the one that is meant where nothing is said.

    Raises
    ------
    InputError
        If it is not there, or several are there and none is the obvious one; the message lists them.
    """
    found = find(parts)
    if not found:
        raise InputError(f"{path}: holds no picture")
    names = ", ".join(layer.name or "(unnamed)" for layer in found)
    if wanted is not None:
        for layer in found:
            if (layer.name or "").lower() == wanted.lower():
                return layer
        raise InputError(f"{path}: has no layer {wanted!r}; it holds: {names}")
    if len(found) == 1:
        layer = found[0]
        return Layer(None, layer.part, layer.indices, layer.channels)
    for first in _FIRST_CHOICE:
        for layer in found:
            if (layer.name or "").lower() == first:
                return layer if first else Layer(None, layer.part, layer.indices, layer.channels)
    raise InputError(f"{path}: holds several layers ({names}); name one, such as {path.name}:{found[0].name}")


def pick(pixels: NDArray[Any], layer: Layer) -> NDArray[Any]:
    """The layer's channels out of all channels of its part."""
    if layer.indices == tuple(range(pixels.shape[2])):
        return pixels
    return pixels[..., list(layer.indices)]
