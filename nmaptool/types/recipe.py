"""Recipes: layers and their positions as a designer writes them, before any map is read.

A recipe is a mapping, as ``tomllib`` reads it from a file: a table ``canvas`` and a list ``layer``, from the lowest to
the topmost; `nmaptool.read_recipe` reads the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, TypeAlias

from nmaptool.core.errors import InputError
from nmaptool.options import (
    CanvasOptions,
    GroupOptions,
    LayerOptions,
    ReadOptions,
    ReliefFiles,
    ReliefOptions,
    SolidOptions,
)
from nmaptool.types.recipe_plate import RecipePlate
from nmaptool.types.shown import OneLine, counted

# limits for nested groups and recipes, and for all layers: larger recipes are mistakes or attacks
DEEPEST = 16
MOST_LAYERS = 1000

# a recipe cannot raise the size limit of its maps, or the memory of the solver
RELIEF_KEYS = tuple(f.name for f in fields(ReliefOptions) if f.name != "memory_limit")
READ_KEYS = tuple(f.name for f in fields(ReadOptions) if f.name != "max_megapixels")


class _Part(OneLine):
    """Base of layers, groups and links to recipes; the first field must not be empty."""

    _lacking: ClassVar[str]
    options: LayerOptions | GroupOptions
    mask: str | None
    hidden: bool
    origin: str

    def __post_init__(self) -> None:
        if not self._content:
            raise InputError(f"{self.label}: {self._lacking}")

    @property
    def _content(self) -> Any:
        return getattr(self, fields(self)[0].name)  # type: ignore[arg-type]  # mixed into dataclasses only

    @property
    def label(self) -> str:
        """Name for messages."""
        return self.origin or self.options.name

    @property
    def files(self) -> Iterator[str]:
        """The mask, if there is one; the files of a linked recipe are not known yet."""
        if self.mask is not None:
            yield self.mask


@dataclass(frozen=True, repr=False)
class RecipeLayer(_Part):
    """A normal map file with its position on the canvas.

    Parameters
    ----------
    file : str
        ``FILE`` or ``FILE.exr:layer``, relative to the recipe's folder.
    options : LayerOptions
    mask : str, optional
        Grey picture with the size of the map, white where the layer shows.
    read : mapping
        Fields of `nmaptool.ReadOptions` for this file, without ``max_megapixels``.
    hidden : bool
        Whether to leave it out.
    origin : str
        Name for messages, such as "scene.toml: layer 2 (bunny)".

    Raises
    ------
    InputError
        If ``file`` is empty or ``read`` has an unknown key.
    UsageError
        If a value in ``read`` is not accepted.
    """

    file: str
    options: LayerOptions = field(default_factory=LayerOptions)
    mask: str | None = None
    read: Mapping[str, Any] = field(default_factory=dict)
    hidden: bool = False
    origin: str = field(default="", compare=False)
    _lacking: ClassVar[str] = "file: found nothing, expected the name of a normal map"

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in self.read:
            if key not in READ_KEYS:
                raise InputError(f"{self.label}: read: unknown key {key!r}; use one of {', '.join(READ_KEYS)}")
        ReadOptions(**self.read)

    @property
    def label(self) -> str:
        """Name for messages."""
        return super().label or self.file

    @property
    def files(self) -> Iterator[str]:
        """The map and the mask."""
        yield self.file
        yield from super().files

    def _line(self) -> str:
        return f"{self.label}: {self.file}, mode {self.options.mode}{', hidden' if self.hidden else ''}"


@dataclass(frozen=True, repr=False)
class RecipeGroup(_Part):
    """Layers that are composed with each other first.

    Parameters
    ----------
    layers : tuple of RecipeLayer, RecipeGroup or RecipeLink
        As in a `Recipe`.
    options : GroupOptions
    mask : str, optional
        Grey picture with the size of the canvas, white where the group shows.
    hidden : bool
        Whether to leave it out.
    origin : str
        Name for messages.
    """

    layers: tuple[Entry, ...]
    options: GroupOptions = field(default_factory=GroupOptions)
    mask: str | None = None
    hidden: bool = False
    origin: str = field(default="", compare=False)
    _lacking: ClassVar[str] = "a group needs at least one layer"

    @property
    def files(self) -> Iterator[str]:
        """Maps and masks of the layers that are not hidden."""
        yield from super().files
        for layer in self.layers:
            if not layer.hidden:
                yield from layer.files

    def _line(self) -> str:
        hidden = ", hidden" if self.hidden else ""
        return f"{self.label}: {counted(len(self.layers), 'layer')}{hidden}"


@dataclass(frozen=True, repr=False)
class RecipeLink(_Part):
    """A link to another recipe; `nmaptool.read_recipe` replaces it by a group of that recipe's layers.

    Parameters
    ----------
    recipe : str
        File name, relative to the folder of the recipe with the link.
    options : GroupOptions
    mask : str, optional
        As for a group.
    hidden : bool
        Leave it out; the linked recipe is then not read.
    origin : str
        Name for messages.
    """

    recipe: str
    options: GroupOptions = field(default_factory=GroupOptions)
    mask: str | None = None
    hidden: bool = False
    origin: str = field(default="", compare=False)
    _lacking: ClassVar[str] = "recipe: found nothing, expected the name of a recipe"

    def _line(self) -> str:
        return f"{self.label}: {self.recipe}{', hidden' if self.hidden else ''}"


@dataclass(frozen=True, repr=False)
class RecipeRelief(OneLine):
    """How the composed map becomes a relief.

    Parameters
    ----------
    files : ReliefFiles
        Relative to the recipe's folder. The detail may be a recipe, too.
    options : mapping
        Fields of `nmaptool.ReliefOptions` that are given, without ``memory_limit``.
    solid : mapping
        Fields of `nmaptool.SolidOptions` that are given.

    Raises
    ------
    UsageError
        If a value is not accepted, or values contradict each other.
    """

    files: ReliefFiles = field(default_factory=ReliefFiles)
    options: Mapping[str, Any] = field(default_factory=dict)
    solid: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ReliefOptions(**self.options)
        SolidOptions(**self.solid)

    def _line(self) -> str:
        given = {**vars(self.files), **self.options, **self.solid}
        named = [f"{name} {value}" for name, value in given.items() if value is not None]
        return ", ".join(named) or "default options"


Entry: TypeAlias = RecipeLayer | RecipeGroup | RecipeLink


@dataclass(frozen=True, repr=False)
class Recipe(OneLine):
    """Layers and the canvas that they are composed on.

    Parameters
    ----------
    layers : tuple of RecipeLayer, RecipeGroup or RecipeLink
        From the lowest to the topmost, at least one.
    canvas : CanvasOptions
    name : str
        Name for messages.
    folder : str
        Folder that its file names are relative to; "" is the current folder.
    sources : tuple of str
        The recipes it was read from.
    notes : tuple of str
        What was ignored when it was read.
    relief : RecipeRelief, optional
        How the composed map becomes a relief. None: not stated; the default options.
    plate : RecipePlate, optional
        The plate that the relief is put on, with frame and lettering.

    Raises
    ------
    InputError
        If there is no layer.
    """

    layers: tuple[Entry, ...]
    canvas: CanvasOptions = field(default_factory=CanvasOptions)
    name: str = field(default="recipe", compare=False)
    folder: str = field(default="", compare=False)
    sources: tuple[str, ...] = field(default=(), compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)
    relief: RecipeRelief | None = None
    plate: RecipePlate | None = None

    def __post_init__(self) -> None:
        if not self.layers:
            raise InputError(f'{self.name}: has no layers; start one with [[layer]] and file = "map.png"')

    @property
    def files(self) -> tuple[str, ...]:
        """Maps and masks of all layers that are not hidden, each once."""
        named = (name for layer in self.layers if not layer.hidden for name in layer.files)
        return tuple(dict.fromkeys(named))

    @property
    def hidden(self) -> tuple[str, ...]:
        """Labels of the layers that are left out."""
        return tuple(_hidden(self.layers))

    def _line(self) -> str:
        size = self.canvas.size or "of the lowest layer's size"
        return f"{self.name}: {counted(len(self.layers), 'layer')}, {counted(len(self.files), 'file')}, canvas {size}"


def _hidden(layers: tuple[Entry, ...]) -> Iterator[str]:
    for layer in layers:
        if layer.hidden:
            yield layer.label
        elif isinstance(layer, RecipeGroup):
            yield from _hidden(layer.layers)
