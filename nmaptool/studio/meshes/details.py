"""The detail maps of layers that were baked: composed like the layers, so that they stay beside each other."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.composition.recipe_toml import to_toml
from nmaptool.core.errors import NmaptoolError
from nmaptool.io.output.normal_map import write_normal_map
from nmaptool.io.pictures.normal_maps import read_normal_map, split_layer
from nmaptool.io.recipes.reader import read_recipe
from nmaptool.maps.masks import motif_coverage
from nmaptool.options import LayerOptions, ReadOptions
from nmaptool.options.formats import is_recipe
from nmaptool.studio.document import Document, relative
from nmaptool.studio.files.store import Store
from nmaptool.studio.layers import maps_of
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.recipe import Entry, Recipe, RecipeGroup, RecipeLayer, RecipeRelief


@dataclass(frozen=True)
class Split:
    """What a detail map was split from: the content of the document, and the options of the page."""

    content: object
    values: Mapping[str, Any]


def content_of(document: Document) -> object:
    """Return what the composed map of a document depends on."""
    return document.layers, document.canvas, document.folder


class Details:
    """Knows the detail map of each map, and makes the detail of a document from them.

    The composed detail is a recipe with the placement of the layers. Layers without a detail map get a flat one: they
    have no detail finer than their form, and they cover the detail of the layers below.

    Parameters
    ----------
    store : Store
        Recipes and flat maps are written into its folder ``details``.
    """

    def __init__(self, store: Store) -> None:
        self._folder = store.folder / "details"
        # detail maps by the path of the map that they belong to; those that cover the same pixels, and others
        self._known: dict[str, Path] = {}
        self._loose: dict[str, Path] = {}
        self._made: set[Path] = set()
        self._strange: set[Path] = set()

    def add(self, original: Path, detail: Path) -> None:
        """Remember the detail map of a map; it covers the same pixels."""
        self._known[str(original)] = detail

    def moved(self, copies: Mapping[Path, Path]) -> None:
        """The document names copies of files."""
        for known in (self._known, self._loose):
            for source, target in copies.items():
                if str(source) in known:
                    detail = known[str(source)]
                    known[str(target)] = copies.get(detail, detail)
        self._made |= {target for source, target in copies.items() if source in self._made}

    def can_follow(self, document: Document) -> bool:
        """Whether the detail of a document is that of its layers, or it has none."""
        detail = document.relief.files.detail
        if detail is None:
            return True
        path = document.folder / detail
        if path in self._made or path in self._known.values() or path in self._loose.values():
            return True
        if path not in self._strange and self._adopted(document, path):
            return True
        self._strange.add(path)
        return False

    def are_offered(self, document: Document) -> bool:
        """Whether layers have detail maps that the document does not use."""
        detail = document.relief.files.detail
        is_used = detail is not None and self.can_follow(document)
        return not is_used and any(self._detail(document, layer) for _, layer in maps_of(document.layers))

    def follow(self, before: Document, after: Document) -> bool:
        """Whether the detail has to change with the layers."""
        detail = before.relief.files.detail
        if detail is None or after.relief.files.detail != detail or content_of(before) == content_of(after):
            return False
        return self.can_follow(before)

    def followed(self, document: Document) -> Document:
        """Return the document with the detail of its layers.

        Raises
        ------
        InputError, LimitError
            If the map of a layer without a detail cannot be read.
        """
        files = dataclasses.replace(document.relief.files, detail=self._file(document))
        relief = RecipeRelief(files, document.relief.options, document.relief.solid)
        return dataclasses.replace(document, relief=relief)

    def _adopted(self, document: Document, path: Path) -> bool:
        """Take a detail map that was opened with the document, if it belongs to its layers one by one."""
        shown = [entry for entry in document.layers if not entry.hidden]
        if not is_recipe(path.name):
            alone = _alone(document, shown)
            if alone is not None:
                self._loose[str(document.folder / alone.file)] = path
            return alone is not None
        try:
            recipe = read_recipe(path)
        except NmaptoolError:  # said when the scene is read
            return False
        pairs = list(_pairs(shown, recipe.layers))
        if recipe.canvas != document.canvas or not all(is_alike for _, _, is_alike in pairs):
            return False
        for layer, detail, _ in pairs:
            if isinstance(layer, RecipeLayer) and isinstance(detail, RecipeLayer):
                self._known[str(document.folder / layer.file)] = Path(recipe.folder).absolute() / detail.file
        self._made.add(path)
        return True

    def _detail(self, document: Document, layer: RecipeLayer) -> Path | None:
        key = str(document.folder / layer.file)
        return self._known.get(key) or self._loose.get(key)

    def _file(self, document: Document) -> str | None:
        shown = [entry for entry in document.layers if not entry.hidden]
        if not any(self._detail(document, layer) for _, layer in maps_of(shown)):
            return None
        alone = _alone(document, shown)
        detail = None if alone is None else self._detail(document, alone)
        if detail is not None:
            return relative(detail, document.folder)
        layers = tuple(self._entry(document, entry) for entry in shown)
        text = to_toml(Recipe(layers, document.canvas, "details", str(self._folder)))
        path = self._folder / f"detail-{_digest(text)}.toml"
        self._folder.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        self._made.add(path)
        return relative(path, document.folder)

    def _entry(self, document: Document, entry: Entry) -> Entry:
        mask = None if entry.mask is None else str(document.folder / entry.mask)
        if isinstance(entry, RecipeLayer):
            detail = self._known.get(str(document.folder / entry.file)) or self._covered(document, entry)
            return dataclasses.replace(entry, file=str(detail), mask=mask, read={"background_color": "alpha"})
        if isinstance(entry, RecipeGroup):
            inside = tuple(self._entry(document, layer) for layer in entry.layers if not layer.hidden)
            return dataclasses.replace(entry, layers=inside, mask=mask)
        return dataclasses.replace(entry, recipe=str(document.folder / entry.recipe), mask=mask)

    def _covered(self, document: Document, layer: RecipeLayer) -> Path:
        """Return a detail map that covers what a layer covers, flat if the layer has none."""
        source = document.folder / layer.file
        own = self._loose.get(str(source))
        key = repr((str(source), sorted(layer.read.items()), own))
        kind = "flat" if own is None else "detail"
        path = self._folder / f"{split_layer(str(source))[0].stem}-{kind}-{_digest(key)}.exr"
        if not path.exists():
            read = read_normal_map(source, ReadOptions(**layer.read))
            normals = np.zeros_like(read.normals)
            normals[..., 2] = 1
            if own is not None:
                normals = read_normal_map(own, like=read).normals
            self._folder.mkdir(exist_ok=True)
            write_normal_map(NormalMap(normals, motif_coverage(read), read.frame), path)
        return path


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def _alone(document: Document, shown: Sequence[Entry]) -> RecipeLayer | None:
    """Return the only layer, if the composed map is its map, unchanged."""
    if len(shown) != 1 or document.canvas.size is not None:
        return None
    (entry,) = shown
    if not isinstance(entry, RecipeLayer) or entry.mask is not None:
        return None
    return entry if entry.options == LayerOptions(name=entry.options.name) else None


def _pairs(layers: Sequence[Entry], details: Sequence[Entry]) -> Iterator[tuple[Entry, Entry, bool]]:
    """Yield layers with those at the same place of another recipe, and whether they are alike but for their maps."""
    shown = [entry for entry in layers if not entry.hidden]
    if len(shown) != len(details):
        yield shown[0], details[0], False
        return
    for layer, detail in zip(shown, details, strict=True):
        yield layer, detail, type(layer) is type(detail) and layer.options == detail.options
        if isinstance(layer, RecipeGroup) and isinstance(detail, RecipeGroup):
            yield from _pairs(layer.layers, detail.layers)


def carried(path: Path, new: Callable[[str], str]) -> str:
    """Return the text of a recipe of details with other names for its files, which ``new`` gets as absolute paths.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    inside = Document.of(read_recipe(path))
    return to_toml(inside.renamed(lambda name: new(str(inside.folder / name))).recipe)
