"""Read recipes: TOML files, the recipes that they include, and the recipe in a composed map's metadata."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Any

from nmaptool.composition.recipe_parsing import parse_recipe
from nmaptool.composition.recipe_places import LineOf
from nmaptool.composition.relief_parsing import parse_relief
from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.opening import read_head
from nmaptool.io.pictures.formats import is_picture
from nmaptool.io.pictures.reader import read_image
from nmaptool.io.recipes.lines import Lines
from nmaptool.options import CanvasOptions
from nmaptool.types.recipe import (
    DEEPEST,
    MOST_LAYERS,
    Entry,
    Recipe,
    RecipeGroup,
    RecipeLayer,
    RecipeLink,
    RecipeRelief,
)

_LARGEST_BYTES = 1_000_000
_LONGEST_SHOWN = 60
_PLACE = re.compile(r"\(at line (\d+), column (\d+)\)")


def read_recipe(
    path: str | Path,
    *,
    folder: str | Path | None = None,
    name: str | None = None,
    max_megapixels: float = 270.0,
) -> Recipe:
    """Read a recipe and the recipes that it includes, which become groups of layers.

    Parameters
    ----------
    path : str or Path
        A TOML file, or a map that was composed from a recipe and has it in its metadata.
    folder : str or Path, optional
        The folder to which its file names are relative. Default: that of ``path``.
    name : str, optional
        Name for messages. Default: ``path``.
    max_megapixels : float
        Refuse a larger map if the recipe is in one.

    Returns
    -------
    Recipe
        All files are relative to ``folder``. Recipes of hidden layers are not read.

    Raises
    ------
    InputError
        If a recipe cannot be read or is not valid, or recipes include each other in a cycle.
    LimitError
        If a recipe is larger than 1 MB or in a map larger than ``max_megapixels``, or recipes are nested more than 16
        deep or hold more than 1000 layers in total.

    Examples
    --------
    >>> recipe = nm.read_recipe("samples/scene.toml")
    >>> recipe.files[0]
    'medal_base.png'
    """
    path = Path(path)
    name = str(path) if name is None else name
    folder = path.parent if folder is None else Path(folder)
    values, line_of = _values(path, name, max_megapixels)
    recipe = parse_recipe(values, name=name, folder="" if folder == Path() else str(folder), line_of=line_of)
    return _Linking(folder, max_megapixels).linked(recipe, _Chain(((identity(path), name),)))


def read_relief(path: Path, *, name: str | None = None) -> RecipeRelief:
    """Read a file that holds the table ``[relief]`` of a recipe alone, such as a preset.

    Raises
    ------
    InputError, LimitError
        As `read_recipe`.
    """
    name = str(path) if name is None else name
    values, line_of = _values(path, name, 0.0)
    return parse_relief(values, name=name, line_of=line_of)


@dataclass(frozen=True)
class _Chain:
    """The recipes that lead to one, outermost first, each with its identity and name; and the nesting depth."""

    recipes: tuple[tuple[Path, str], ...]
    depth: int = 1

    def to(self, path: Path, name: str, origin: str) -> _Chain:
        """The chain with one more recipe."""
        names = [known for known, _ in self.recipes]
        if path in names:
            circle = " -> ".join(name for _, name in (*self.recipes[names.index(path) :], (path, name)))
            raise InputError(f"{origin}: recipes include each other: {circle}; remove one of them")
        return _Chain((*self.recipes, (path, name)), self.depth)

    def deeper(self, origin: str) -> _Chain:
        """The chain with one more level of nesting."""
        if self.depth >= DEEPEST:
            raise LimitError(f"{origin}: recipes and groups are nested more than {DEEPEST} deep; flatten them")
        return replace(self, depth=self.depth + 1)


@dataclass
class _Linking:
    """Replaces the names of other recipes by their layers."""

    folder: Path
    max_megapixels: float
    parsed: dict[Path, Recipe] = field(default_factory=dict)
    sources: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    layers: int = 0

    def linked(self, recipe: Recipe, chain: _Chain) -> Recipe:
        entries = self._entries(recipe.layers, "", chain)
        sources, notes = (tuple(dict.fromkeys(found)) for found in (self.sources, self.notes))
        return replace(recipe, layers=entries, sources=sources, notes=notes)

    def _entries(self, entries: tuple[Entry, ...], below: str, chain: _Chain) -> tuple[Entry, ...]:
        return tuple(self._entry(each, below, chain) for each in entries)

    def _entry(self, entry: Entry, below: str, chain: _Chain) -> Entry:
        """An entry with file names relative to the outermost recipe's folder; ``below`` is that of its own recipe."""
        self.layers += 1
        if self.layers > MOST_LAYERS:
            raise LimitError(f"{entry.origin}: there are more than {MOST_LAYERS} layers in total; compose in steps")
        mask = None if entry.mask is None else _from(below, entry.mask)
        if isinstance(entry, RecipeLayer):
            return replace(entry, file=_from(below, entry.file), mask=mask)
        if isinstance(entry, RecipeGroup):
            return replace(entry, layers=self._entries(entry.layers, below, chain.deeper(entry.origin)), mask=mask)
        named = _from(below, entry.recipe)
        if entry.hidden:
            return replace(entry, recipe=named, mask=mask)
        inner = self._read(entry, named, chain)
        chain = chain.to(identity(self.folder / named), named, entry.origin).deeper(entry.origin)
        layers = self._entries(inner.layers, _from("", str(PurePath(named).parent)), chain)
        return RecipeGroup(layers, entry.options, mask, origin=entry.origin)

    def _read(self, link: RecipeLink, named: str, chain: _Chain) -> Recipe:
        path = self.folder / named
        own = identity(path)
        if own not in self.parsed:
            try:
                values, line_of = _values(path, str(path), self.max_megapixels)
            except (InputError, LimitError) as error:
                raise type(error)(f"{link.origin}: {error}") from None
            self.parsed[own] = parse_recipe(values, name=str(path), line_of=line_of)
        inner = self.parsed[own]
        self.sources.append(named)
        if inner.canvas != CanvasOptions():
            outer = chain.recipes[0][1]
            self.notes.append(f"{path}: its canvas is ignored; its layers are placed on the canvas of {outer}")
        if inner.relief is not None:
            self.notes.append(f"{path}: its [relief] is ignored; only its layers are used")
        if inner.plate is not None:
            self.notes.append(f"{path}: its plate is ignored; only its layers are used")
        return inner


def _from(below: str, name: str) -> str:
    """Make a name in the folder ``below`` relative to the outermost recipe's folder; absolute names are unchanged."""
    return (PurePath(below) / name).as_posix() if below else name


def identity(path: Path) -> Path:
    """Return the resolved path, the same for all names of and links to a file."""
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):  # a cycle of links or a null character: reading the file will report it
        return path


def _values(path: Path, name: str, max_megapixels: float) -> tuple[dict[str, Any], LineOf | None]:
    """The parsed TOML of a recipe file and the lines of its keys, or of the recipe in a map, which has no lines."""
    try:
        head, size = read_head(path, _LARGEST_BYTES + 1, "a recipe, such as scene.toml", "read a stream with -")
    except InputError as error:
        raise InputError(str(error).replace(str(path), name)) from None
    if is_picture(head):
        return _parsed(_recipe_of(path, name, max_megapixels), name), None
    if size > _LARGEST_BYTES:
        raise LimitError(f"{name}: is {size / 1e6:.1f} MB, more than the limit of 1 MB for a recipe; split it")
    try:
        text = head.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = head.count(b"\n", 0, error.start) + 1
        raise InputError(f"{name}: is not UTF-8 text (line {line}); save the recipe as UTF-8") from None
    return _parsed(text, name), Lines(text).of


def _recipe_of(path: Path, name: str, max_megapixels: float) -> str:
    """The recipe in a map's metadata."""
    text = read_image(path, max_megapixels=max_megapixels).attributes.get("recipe")
    if text is None:
        raise InputError(f"{name}: is a picture without a recipe in its metadata; give a recipe, such as scene.toml")
    if text.startswith("{"):
        raise InputError(f"{name}: was not made by nmap compose stack; its metadata hold no recipe to compose again")
    return text


def _parsed(text: str, name: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{name}: lists or tables are nested too deeply for a recipe; flatten them") from None
    except ValueError as error:  # a number of thousands of digits does not raise a TOMLDecodeError
        raise InputError(f"{name}: {_fault(text, str(error))}") from None


def _fault(text: str, reason: str) -> str:
    """Describe where TOML is invalid and what was found there."""
    lines = text.split("\n")
    place = _PLACE.search(reason)
    if place is None and "end of document" not in reason:
        return "is not valid TOML: a number is too long"
    line, column = (int(place[1]), int(place[2])) if place else (len(lines), len(lines[-1]) + 1)
    if any(word in reason for word in ("overwrite", "twice", "mutate", "already")):
        return f"is not valid TOML: a key or table is defined twice{_before(lines, line)}"
    found = _printable(lines[line - 1])
    what = f"found {found}" if found else "found the end of a line or of the file"
    return f"is not valid TOML at line {line}, column {column}: {what}; check quotes, = and brackets"


def _before(lines: list[str], line: int) -> str:
    """Describe the place of a fault that the parser reports only after reading past it."""
    found = _printable(lines[line - 1]) or (_printable(lines[line - 2]) if line > 1 else "")
    return f", at line {line}: {found}" if found else f", before line {line}"


def _printable(line: str) -> str:
    shown = "".join(c if c.isprintable() else " " for c in line).strip()
    return shown if len(shown) <= _LONGEST_SHOWN else f"{shown[: _LONGEST_SHOWN - 3]}..."
