"""Find the layers in the channels and parts of a file: ``R,G,B``, ``N.X,N.Y,N.Z``, ``Nx,Ny,Nz``, single channels."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from nmaptool.core.errors import InputError
from nmaptool.io.pictures import layer_names
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.pictures.request import Request

# sets of component names that writers use for R, G, B; never mixed, since Z beside R, G, B is depth
_TRIPLES = (("r", "g", "b"), ("x", "y", "z"), ("red", "green", "blue"))
# maps of x and y alone; used only if a file has no such triple, since beside one they often hold motion
_PAIRS = (("r", "g"), ("x", "y"), ("red", "green"))
_ALPHA = ("a", "alpha")
# a component at the end of a channel's name, without a dot: Nx, normal_X
_ENDING = re.compile(r"(.+?)[_ ]?([xyzrgb])", re.IGNORECASE)
# names that OpenImageIO makes for channels without one
_NO_NAME = re.compile(r"channel\d+")
# luminance and chroma: only the luminance is read, as a grey picture
_LUMINANCE = ("y", "ry", "by")
# names of the channel of a layer of one, which say nothing
_SINGLE = ("z", "y", "v", "x", "r", "l", "value")
# the name of the unnamed layer in lists and requests
_UNNAMED = "RGB"


@dataclass(frozen=True)
class Layer:
    """One layer of a file.

    Attributes
    ----------
    name : str or None
        None for the only one.
    part : int
    indices : tuple of int
        Its channels' positions.
    channels : tuple of str
        Their names: R, G, B, A or Y.
    aliases : tuple of str
        Further names under which it is found.
    minor : bool
        Whether it is read only by name, or as a grey picture: a single channel or a pair beside a layer of three.
    notes : tuple of str
        As in `nmaptool.RasterImage`.
    """

    name: str | None
    part: int
    indices: tuple[int, ...]
    channels: tuple[str, ...]
    aliases: tuple[str, ...] = ()
    minor: bool = False
    notes: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """Its name in lists and requests."""
        return self.name or _UNNAMED


@dataclass
class _Part:
    """A part of a file: its channels by layer, and by the lower-case component within the layer."""

    number: int
    name: str
    spec: Any
    groups: dict[str, dict[str, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for index, channel in enumerate(self.spec.channelnames):
            prefix, _, component = channel.rpartition(".")
            self.groups.setdefault(prefix, {})[component.lower()] = index
        self._split_endings()

    def _split_endings(self) -> None:
        """Make layers of three of channels like Nx, Ny, Nz."""
        for prefix, members in list(self.groups.items()):
            stems: dict[str, dict[str, str]] = {}
            for component, index in members.items():
                ending = _ENDING.fullmatch(self.spec.channelnames[index].rpartition(".")[2])
                if ending is not None:
                    stems.setdefault(ending[1].lower(), {})[ending[2].lower()] = component
            for parts in stems.values():
                if any(set(names) <= set(parts) for names in _TRIPLES[:2]):
                    own = {letter: members.pop(component) for letter, component in parts.items()}
                    first = self.spec.channelnames[min(own.values())].rpartition(".")[2]
                    label = first[:-1].rstrip("_ ")
                    self.groups.setdefault(f"{prefix}.{label}" if prefix else label, {}).update(own)
        self.groups = {prefix: members for prefix, members in self.groups.items() if members}

    def label(self, prefix: str) -> str:
        """A layer's name; channel names often repeat the name of their part."""
        if not self.name or prefix == self.name or prefix.startswith(f"{self.name}."):
            return prefix
        return f"{self.name}.{prefix}" if prefix else self.name

    def sets(self, sets: tuple[tuple[str, ...], ...]) -> list[Layer]:
        """The layers whose component names are one of the sets."""
        found: list[Layer] = []
        shared_alpha = _alpha(self.groups.get("", {}))
        for prefix, members in self.groups.items():
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
            found.append(Layer(self.label(prefix), self.number, tuple(indices), channels))
        return found

    def plain(self) -> Layer:
        """A part without colour channels as a layer: grey, with alpha if it has one."""
        names = tuple(self.spec.channelnames)
        alpha = next((i for i, n in enumerate(names) if n.rpartition(".")[2].lower() in _ALPHA), None)
        rest = [i for i in range(len(names)) if i != alpha]
        if not rest:  # alpha alone is a grey picture
            return Layer(self.name, self.number, (0,), ("Y",))
        note: tuple[str, ...] = ()
        lower = [names[i].rpartition(".")[2].lower() for i in rest]
        if sorted(lower) == sorted(_LUMINANCE):
            rest = [rest[lower.index("y")]]
            note = ("stores luminance and chroma; only the luminance is read",)
        if len(rest) == 1:
            indices, channels = ((rest[0],), ("Y",)) if alpha is None else ((rest[0], alpha), ("Y", "A"))
            return Layer(self.name, self.number, indices, channels, _aliases(names[rest[0]]), notes=note)
        return Layer(self.name, self.number, tuple(range(len(names))), names)

    def singles(self, used: set[int]) -> list[Layer]:
        """Channels that belong to no layer of several, each as a grey layer, such as ``ViewLayer.Depth``."""
        found: list[Layer] = []
        for prefix, members in self.groups.items():
            rest = {name: index for name, index in members.items() if index not in used and name not in _ALPHA}
            for index in rest.values():
                channel = str(self.spec.channelnames[index])
                full = self.label(channel)
                name = _aliases(full)[0] if len(members) == 1 and prefix else full
                found.append(Layer(name, self.number, (index,), ("Y",), (full, channel), minor=True))
        return found


def _aliases(channel: str) -> tuple[str, ...]:
    """The names of a layer of one channel: ``ViewLayer.Depth`` and ``ViewLayer.Depth.Z``."""
    prefix, _, component = channel.rpartition(".")
    return (prefix, channel) if prefix and component.lower() in _SINGLE else (channel,)


def _alpha(members: dict[str, int]) -> int | None:
    return next((members[name] for name in _ALPHA if name in members), None)


def _parts(specs: list[Any]) -> list[_Part]:
    several = len(specs) > 1
    return [
        _Part(number, str(spec.getattribute("oiio:subimagename") or "") if several else "", spec)
        for number, spec in enumerate(specs)
    ]


def find(specs: list[Any]) -> list[Layer]:
    """Return the layers of a file from the specs of its parts, without single channels beside layers of several.

    Parameters
    ----------
    specs : list of ImageSpec
    """
    return [layer for layer in find_all(specs) if not layer.minor]


def find_all(specs: list[Any]) -> list[Layer]:
    """Return all layers of a file; those beside layers of three are ``minor``."""
    found: list[Layer] = []
    for part in _parts(specs):
        triples = part.sets(_TRIPLES)
        pairs = part.sets(_PAIRS)
        main = triples or pairs
        if not main:
            plain = part.plain()
            if plain.channels in (("Y",), ("Y", "A")):
                found.append(plain)
                continue
            main = [plain] if len(part.groups) == 1 else []
        taken = {index for layer in triples or pairs for index in layer.indices}
        beside = [replace(p, minor=True) for p in pairs if triples and not taken & set(p.indices[:2])]
        taken |= {index for layer in beside for index in layer.indices}
        singles = part.singles(taken)
        found += main + beside + ([replace(one, minor=False) for one in singles] if not main else singles)
    return found


def choose(path: Path, specs: list[Any], request: Request, *, pages: int = 0, names: tuple[str, ...] = ()) -> Layer:
    """Return the wanted layer, or the obvious one if none is named.

    Parameters
    ----------
    path : Path
    specs : list of ImageSpec
    request : Request
    pages : int
        If the parts are pages of a document, of which the first is the obvious one: how many of them are not merely
        smaller versions of others.
    names : tuple of str
        The names of the pages.

    Raises
    ------
    InputError
        If the layer does not exist, or several exist and none is the obvious one; the message lists them.
    """
    everything = find_all(specs)
    if not everything:
        raise InputError(f"{path}: holds no picture")
    if pages and len(specs) > 1:
        everything = [_page_layer(one, names) for one in everything]
    if request.layer is not None:
        return _named(path, everything, specs, request.layer)
    if pages and len(specs) > 1:
        first, more = everything[0], layer_names.pages_note(path.name, pages, names)
        return replace(first, name=None, notes=(*first.notes, *more))
    return _obvious(path, everything, request.holds)


def _page_layer(layer: Layer, names: tuple[str, ...]) -> Layer:
    number = layer_names.page_name(layer.part)
    own = names[layer.part] if layer.part < len(names) else number
    return replace(layer, name=own, aliases=(number,))


def _named(path: Path, layers: list[Layer], specs: list[Any], wanted: str) -> Layer:
    found = layer_names.matching(wanted, [[layer.shown, *layer.aliases] for layer in layers])
    if len(found) > 1 and len({layers[place].shown.lower() for place in found}) > 1:
        names = ", ".join(layers[place].shown for place in found)
        raise InputError(f"{path}: several layers are called {wanted!r}: {names}; give the whole name of one")
    if found:
        return layers[found[0]]
    for number, spec in enumerate(specs):  # one channel of a layer of several
        lower = [str(name).lower() for name in spec.channelnames]
        if wanted.lower() in lower:
            return Layer(wanted, number, (lower.index(wanted.lower()),), ("Y",))
    raise InputError(f"{path}: has no layer {wanted!r}; it holds: {', '.join(one.shown for one in layers)}")


def _obvious(path: Path, layers: list[Layer], holds: Holds) -> Layer:
    """The only layer, the only one whose name says that it is sought, or the unnamed one."""
    main = [layer for layer in layers if not layer.minor]
    single = [layer for layer in layers if _color_count(layer) == 1 and not _NO_NAME.fullmatch(layer.shown)]
    if len(layers) == 1 or (holds == "normals" and len(main) == 1):
        return _unnamed(main[0], holds)
    for fitting in (main,) if holds == "normals" else (single, main):
        places = layer_names.best_places([layer.shown for layer in fitting], holds)
        if len(places) == 1:
            return fitting[places[0]]
        if places:
            raise _several(path, layers, holds)
    if holds == "depth" and single:
        raise _several(path, layers, holds)
    if len(main) == 1:
        return _unnamed(main[0], holds)
    unnamed = [layer for layer in main if not layer.name]
    if not unnamed:
        raise _several(path, layers, holds)
    note = layer_names.others_note(_UNNAMED, [layer.name for layer in main if layer.name])
    return replace(_unnamed(unnamed[0], holds), notes=(*unnamed[0].notes, note))


def _unnamed(layer: Layer, holds: Holds) -> Layer:
    """The layer without a name, unless the name of its only channel says what it holds, such as Z."""
    telling = (name for name in (layer.shown, *layer.aliases) if layer_names.rank(name, holds) < layer_names.UNFIT)
    return replace(layer, name=next(telling, None) if holds == "depth" else None)


def _several(path: Path, layers: list[Layer], holds: Holds) -> InputError:
    names = ", ".join(one.shown for one in layers)
    best = _suggested(layers, holds)
    return InputError(f"{path}: holds several layers ({names}); name one, such as {path.name}:{best.shown}")


def _color_count(layer: Layer) -> int:
    return len(layer.channels) - ("A" in layer.channels)


def _suggested(layers: list[Layer], holds: Holds) -> Layer:
    """The layer that the message about several proposes."""
    width = 3 if holds == "normals" else 1

    def unfit(layer: Layer) -> tuple[int, bool, bool]:
        return layer_names.rank(layer.shown, holds), _color_count(layer) != width, "combined" in layer.shown.lower()

    return min(layers, key=unfit)
