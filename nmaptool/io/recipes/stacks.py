"""Read the maps and masks of a recipe, as input of `nmaptool.compose`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, TypeVar, cast

from nmaptool.composition.recipe_values import with_recipe_keys
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, LimitError, NmaptoolError
from nmaptool.io.pictures.normal_maps import read_grey, read_normal_map, split_layer
from nmaptool.io.recipes.reader import identity, read_recipe
from nmaptool.options import CanvasOptions, ReadOptions
from nmaptool.types.layers import Layer, LayerGroup
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.recipe import READ_KEYS, Entry, Recipe, RecipeGroup, RecipeLayer, RecipeLink
from nmaptool.types.shown import OneLine, counted

_T = TypeVar("_T")


@dataclass(frozen=True, eq=False, repr=False)
class Stack(OneLine):
    """The layers and canvas of a recipe, for ``nm.compose(stack.layers, stack.canvas)``.

    Attributes
    ----------
    layers : tuple of Layer or LayerGroup
        The layers that are not hidden.
    canvas : CanvasOptions
    recipe : Recipe
        Including the given reading options, so that the recipe alone reproduces the layers.
    maps : tuple of NormalMap
        Each map once.
    outside : tuple of str
        Files that were read from outside the recipe's folder.
    """

    layers: tuple[Layer | LayerGroup, ...]
    canvas: CanvasOptions
    recipe: Recipe
    maps: tuple[NormalMap, ...]
    outside: tuple[str, ...]

    def _line(self) -> str:
        layers, maps = counted(len(self.layers), "layer"), counted(len(self.maps), "map")
        return f"{self.recipe.name}: {layers} from {maps}"


class PictureCache:
    """Maps and masks of the last recipe that was read: files that have not changed since are not read again."""

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], Any] = {}
        self._used: dict[tuple[object, ...], Any] = {}

    def get(self, file: Path, key: tuple[object, ...], read: Callable[[], _T]) -> _T:
        """Return what ``read`` returns; from memory if the file has the same size and time as before."""
        try:
            stat = file.stat()
        except (OSError, ValueError):  # reading it will say why
            return read()
        key = (*key, stat.st_mtime_ns, stat.st_size)
        found = self._used.get(key, self._known.get(key))
        found = read() if found is None else found
        self._used[key] = found
        return cast(_T, found)

    def forget(self) -> None:
        """Forget what was not used since the last time."""
        self._known, self._used = self._used, {}


def read_stack(
    recipe: Recipe | str | Path,
    reading: ReadOptions | None = None,
    *,
    folder: str | Path | None = None,
    cache: PictureCache | None = None,
) -> Stack:
    """Read the maps and masks of a recipe.

    Parameters
    ----------
    recipe : Recipe, str or Path
        A recipe, or a file for `nmaptool.read_recipe`.
    reading : ReadOptions, optional
        For all maps; options of a single layer override them. ``max_megapixels`` limits all pictures together.
    folder : str or Path, optional
        The folder to which file names are relative. Default: the recipe's own folder.
    cache : PictureCache, optional
        Keeps what is read for the next recipe.

    Returns
    -------
    Stack
        Layers and canvas for `nmaptool.compose`.

    Raises
    ------
    InputError
        If a file cannot be read or is not a normal map, a mask does not fit, or every layer is hidden; the message
        names the layer and the recipe.
    LimitError
        If the pictures are larger than ``reading.max_megapixels`` together.

    Examples
    --------
    >>> stack = nm.read_stack("samples/scene.toml")
    >>> nm.compose(stack.layers, stack.canvas).normal_map.frame.shape
    (340, 640)
    """
    reading = reading or ReadOptions()
    if not isinstance(recipe, Recipe):
        recipe = read_recipe(recipe, folder=folder, max_megapixels=reading.max_megapixels)
    place = Path(recipe.folder if folder is None else folder)
    given = {key: getattr(reading, key) for key in READ_KEYS if getattr(reading, key) != _default(key)}
    recipe = replace(recipe, layers=tuple(_with_reading(layer, given) for layer in recipe.layers))
    pictures = _Pictures(place, reading.max_megapixels, cache or PictureCache())
    layers = tuple(pictures.layers(recipe.layers))
    if not layers:
        raise InputError(f"{recipe.name}: every layer is hidden; there is nothing to compose")
    return Stack(layers, recipe.canvas, recipe, tuple(pictures.maps.values()), outside(recipe, place))


def outside(recipe: Recipe, folder: Path) -> tuple[str, ...]:
    """Return the files of a recipe, as it names them, that are outside ``folder`` once links are followed."""
    return tuple(name for name in (*recipe.sources, *recipe.files) if not _lies_in(folder, name))


def _lies_in(folder: Path, name: str) -> bool:
    file, _ = split_layer(str(folder / name))
    try:
        return file.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # a cycle of links or a null character: reading the file will report it
        return True


def _default(key: str) -> object:
    return next(f.default for f in fields(ReadOptions) if f.name == key)


def _with_reading(entry: Entry, given: dict[str, object]) -> Entry:
    if isinstance(entry, RecipeLayer):
        return replace(entry, read={**given, **entry.read})
    if isinstance(entry, RecipeGroup):
        return replace(entry, layers=tuple(_with_reading(layer, given) for layer in entry.layers))
    return entry


@dataclass
class _Pictures:
    """Maps and masks, each read once, within one limit."""

    folder: Path
    max_megapixels: float
    cache: PictureCache
    maps: dict[tuple[object, ...], NormalMap] = field(default_factory=dict)
    masks: dict[tuple[object, ...], Float32] = field(default_factory=dict)
    taken: float = 0.0

    def layers(self, entries: tuple[Entry, ...]) -> list[Layer | LayerGroup]:
        """Read the layers and groups that are not hidden."""
        found = (self._layer(entry) for entry in entries if not entry.hidden)
        return [layer for layer in found if layer is not None]

    def _layer(self, entry: Entry) -> Layer | LayerGroup | None:
        if isinstance(entry, RecipeLink):
            raise InputError(f"{entry.label}: the recipe {entry.recipe} has not been read; use nmaptool.read_recipe")
        if isinstance(entry, RecipeGroup):
            layers = tuple(self.layers(entry.layers))
            if not layers:  # all of them hidden
                return None
            return _with_context(
                entry, lambda: LayerGroup(layers, entry.options, self._mask(entry), origin=entry.origin)
            )
        return _with_context(
            entry, lambda: Layer(self._map(entry), entry.options, self._mask(entry), origin=entry.origin)
        )

    def _map(self, entry: RecipeLayer) -> NormalMap:
        source = str(self.folder / entry.file)
        file, layer = split_layer(source)
        options = ReadOptions(**{**entry.read, "max_megapixels": self._left()})
        key = (identity(file), layer, tuple(sorted((k, v) for k, v in entry.read.items() if v is not None)))
        if key not in self.maps:
            self.maps[key] = self.cache.get(file, key, lambda: self._within(lambda: read_normal_map(source, options)))
            self._take(self.maps[key].coverage.size)
        return self.maps[key]

    def _mask(self, entry: RecipeLayer | RecipeGroup) -> Float32 | None:
        if entry.mask is None:
            return None
        source = str(self.folder / entry.mask)
        file, layer = split_layer(source)
        key = (identity(file), layer)
        if key not in self.masks:
            self.masks[key] = self.cache.get(
                file, ("grey", *key), lambda: self._within(lambda: read_grey(source, max_megapixels=self._left()))
            )
            self._take(self.masks[key].size)
        return self.masks[key]

    def _left(self) -> float:
        return max(self.max_megapixels - self.taken, 1e-9)

    def _take(self, pixels: int) -> None:
        self.taken += pixels / 1e6

    def _within(self, read: Callable[[], _T]) -> _T:
        try:
            return read()
        except LimitError as error:
            if not self.taken:
                raise
            spent = f"other files of the recipe take {self.taken:.3g} of {self.max_megapixels:g} megapixels"
            raise LimitError(f"{error} ({spent})") from None


def _with_context(entry: Entry, make: Callable[[], _T]) -> _T:
    """Return the result of ``make``; its errors are given the name of the layer and the recipe."""
    try:
        return make()
    except NmaptoolError as error:
        text = str(error)
        if isinstance(entry, RecipeLayer) and set(error.options) & set(entry.read):
            text = with_recipe_keys(text)
        raise type(error)(f"{entry.label}: {text}") from None
