"""The document of the studio: a recipe, and the steps that led to it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nmaptool.composition.recipe_parsing import parse_recipe
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.units import Length
from nmaptool.io.pictures.normal_maps import split_layer
from nmaptool.io.recipes.reader import read_recipe
from nmaptool.options import CanvasOptions, ReliefFiles, ReliefOptions, SolidOptions
from nmaptool.options.fields import Options, kind_of
from nmaptool.options.formats import is_recipe
from nmaptool.options.kinds import Count
from nmaptool.types.recipe import RELIEF_KEYS, Entry, Recipe, RecipeGroup, RecipeLayer, RecipeRelief
from nmaptool.types.recipe_plate import RecipePlate

MOST_STEPS = 200
# of numbers, before the options check them
_LARGEST = 1e15
_SOLID_KEYS = tuple(f.name for f in dataclasses.fields(SolidOptions))
_KINDS = {
    f.name: kind
    for options in (ReliefOptions, SolidOptions)
    for f in dataclasses.fields(options)
    if (kind := kind_of(f)) is not None
}


@dataclass(frozen=True)
class Document:
    """The layers, the canvas and the relief of a recipe; unlike a recipe, it may have no layers yet.

    Parameters
    ----------
    layers : tuple of RecipeLayer, RecipeGroup or RecipeLink
    canvas : CanvasOptions
    relief : RecipeRelief
    folder : Path
        Absolute; file names are relative to it.
    path : Path or None
        The recipe that it was read from and is saved to.
    name : str
        Name for messages.
    plate : RecipePlate or None
        The plate that exported files have; the stage shows the relief without it.
    """

    layers: tuple[Entry, ...] = ()
    canvas: CanvasOptions = field(default_factory=CanvasOptions)
    relief: RecipeRelief = field(default_factory=RecipeRelief)
    folder: Path = field(default_factory=Path.cwd)
    path: Path | None = None
    name: str = field(default="relief", compare=False)
    plate: RecipePlate | None = None

    @classmethod
    def of(cls, recipe: Recipe, path: Path | None = None) -> Document:
        """Return the document of a recipe that was read from ``path``."""
        relief = recipe.relief or RecipeRelief()
        layers = tuple(_without_line(layer) for layer in recipe.layers)
        folder, name = Path(recipe.folder).absolute(), Path(recipe.name).name
        return cls(layers, recipe.canvas, relief, folder, path, name, recipe.plate)

    @property
    def recipe(self) -> Recipe:
        """The recipe.

        Raises
        ------
        InputError
            If there are no layers.
        """
        if not self.layers:
            raise InputError("there is nothing to shape yet: drop a normal map, a depth picture or a mesh")
        return Recipe(self.layers, self.canvas, self.name, str(self.folder), relief=self.relief, plate=self.plate)

    @property
    def options(self) -> ReliefOptions:
        """The options of its relief."""
        return ReliefOptions(**self.relief.options)

    @property
    def solid(self) -> SolidOptions:
        """The options of its solid."""
        given = self.relief.solid
        return SolidOptions(**(given if self.plate is None else self.plate.solid_values(given)))

    def changed(self, values: Mapping[str, Any]) -> Document:
        """Return the document with other options; None or the default removes one.

        Raises
        ------
        UsageError
            If an option is not known or its value is not accepted.
        """
        options, solid = dict(self.relief.options), dict(self.relief.solid)
        for name, value in values.items():
            if name not in RELIEF_KEYS and name not in _SOLID_KEYS:
                raise UsageError(f"`{name}`: is not an option of a relief")
            table = options if name in RELIEF_KEYS else solid
            table.pop(name, None)
            if value is not None:
                table[name] = _of_type(name, value)
        options, solid = _read(ReliefOptions, options), _read(SolidOptions, solid)
        return dataclasses.replace(self, relief=RecipeRelief(self.relief.files, options, solid))

    @property
    def files(self) -> tuple[str, ...]:
        """The files that it names, each once; those of hidden layers, too."""
        found: dict[str, None] = {}

        def note(name: str) -> str:
            found[name] = None
            return name

        self.renamed(note)
        return tuple(found)

    def renamed(self, new: Callable[[str], str]) -> Document:
        """Return the document with other names of its files."""
        layers = tuple(_renamed(layer, new) for layer in self.layers)
        named = {role: name if name is None else new(name) for role, name in vars(self.relief.files).items()}
        relief = RecipeRelief(ReliefFiles(**named), self.relief.options, self.relief.solid)
        plate = None if self.plate is None else self.plate.renamed(new)
        return dataclasses.replace(self, layers=layers, relief=relief, plate=plate)


def _renamed(entry: Entry, new: Callable[[str], str]) -> Entry:
    if isinstance(entry, RecipeLayer):
        entry = dataclasses.replace(entry, file=new(entry.file))
    elif isinstance(entry, RecipeGroup):
        entry = dataclasses.replace(entry, layers=tuple(_renamed(layer, new) for layer in entry.layers))
    return entry if entry.mask is None else dataclasses.replace(entry, mask=new(entry.mask))


def _of_type(name: str, value: Any) -> Any:
    """Return a value that has the type of its option, as in a recipe; lengths may be text."""
    kind = _KINDS[name]
    if kind.toml is not float:
        if isinstance(value, str | Length) if kind.toml is str else isinstance(value, kind.toml):
            return value
        raise UsageError(f"`{name}={value!r}`: expected {kind.such_as or 'True or False'}")
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > _LARGEST:
        raise UsageError(f"`{name}={value!r}`: expected a number, such as {kind.such_as}")
    if isinstance(kind, Count) and not float(value).is_integer():
        raise UsageError(f"`{name}={value!r}`: expected a whole number, such as {kind.such_as}")
    return int(value) if isinstance(kind, Count) else float(value)


def _read(kind: type[Options], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that are not the defaults, as the options class reads them."""
    made, default = kind(**given), kind()
    return {name: getattr(made, name) for name in given if getattr(made, name) != getattr(default, name)}


def opened(names: Sequence[str]) -> Document:
    """Return the document of some files.

    Parameters
    ----------
    names : sequence of str
        A recipe; or normal maps as layers, the first one lowest; or nothing.

    Raises
    ------
    UsageError
        If a recipe and other files are named.
    InputError, LimitError
        If a file does not exist or the recipe cannot be read.
    """
    if not names:
        return Document()
    if is_recipe(names[0]):
        if len(names) > 1:
            raise UsageError(f"{names[0]}: a recipe is opened alone")
        path = Path(names[0]).absolute()
        return Document.of(read_recipe(path, name=names[0]), path)
    for name in names:
        if not split_layer(name)[0].is_file():
            raise InputError(f"{name}: no such file")
    folder = Path(names[0]).absolute().parent
    layers = [{"file": relative(Path(name).absolute(), folder)} for name in names]
    return Document.of(parse_recipe({"layer": layers}, name=Path(names[0]).stem, folder=str(folder)))


def _without_line(entry: Entry) -> Entry:
    """Return a layer without the line it was read from: the page moves layers."""
    entry = dataclasses.replace(entry, origin="")
    if isinstance(entry, RecipeGroup):
        return dataclasses.replace(entry, layers=tuple(_without_line(layer) for layer in entry.layers))
    return entry


def relative(path: Path, folder: Path) -> str:
    """Return the name of a file in a recipe in a folder: relative if the file lies in it."""
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else str(path)


@dataclass
class History:
    """A document that can be changed and changed back."""

    now: Document
    _before: list[Document] = field(default_factory=list)
    _after: list[Document] = field(default_factory=list)

    def do(self, document: Document, *, joined: bool = False) -> None:
        """Take a changed document; ``joined`` makes it one step with the one before, as while a slider moves."""
        if document == self.now:
            return
        if not joined or not self._before:
            self._before = [*self._before, self.now][-MOST_STEPS:]
        self._after.clear()
        self.now = document

    def undo(self) -> bool:
        """Go one step back; whether there was one."""
        if not self._before:
            return False
        self._after.append(self.now)
        self.now = self._before.pop()
        return True

    def redo(self) -> bool:
        """Take a step again; whether there was one."""
        if not self._after:
            return False
        self._before.append(self.now)
        self.now = self._after.pop()
        return True

    def moved(self, old: Path | None, new: Path) -> None:
        """The recipe of the document, and of the steps before and after, has another file now."""

        def move(document: Document) -> Document:
            return dataclasses.replace(document, path=new) if document.path == old else document

        self.now = move(self.now)
        self._before, self._after = ([move(one) for one in steps] for steps in (self._before, self._after))

    @property
    def steps(self) -> tuple[int, int]:
        """How many steps can be undone and redone."""
        return len(self._before), len(self._after)
