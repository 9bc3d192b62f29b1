"""Read everything that a recipe's relief is made from."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from nmaptool.composition.compose import compose
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress
from nmaptool.io.designs import design_of
from nmaptool.io.pictures.heights import read_surface
from nmaptool.io.pictures.normal_maps import read_grey, read_normal_map, split_layer
from nmaptool.io.recipes.reader import read_recipe
from nmaptool.io.recipes.stacks import PictureCache, Stack, read_stack
from nmaptool.options import CanvasOptions, ReadOptions, ReliefFiles, ReliefOptions, SolidOptions
from nmaptool.options.formats import is_recipe
from nmaptool.options.plates import MachineOptions
from nmaptool.plates.plate import plate
from nmaptool.plates.resampling import relief_at_pitch
from nmaptool.reliefs.inputs import pitch_of
from nmaptool.types.composition import Composition
from nmaptool.types.height import Height
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.plate import PlateDesign
from nmaptool.types.recipe import Recipe, RecipeRelief
from nmaptool.types.recipe_plate import RecipePlate
from nmaptool.types.relief import Relief
from nmaptool.types.shown import OneLine

_GREYS = tuple(f.name for f in fields(ReliefFiles) if f.name not in ("detail", "surface"))


@dataclass(frozen=True, eq=False, repr=False)
class Scene(OneLine):
    """What a recipe's relief is made from, for ``nm.relief(**scene.inputs)`` and ``nm.solid(relief, scene.solid)``.

    `solve` does the former, and puts the relief on the plate of the recipe, if it has one.

    Attributes
    ----------
    stacks : tuple of Stack
        The recipe's layers; then, if the detail is a recipe, too, its layers.
    composition : Composition
        The composed layers; their map is the original map of the relief.
    detail : NormalMap or None
    surface : NormalMap, Height or None
    greys : mapping
        The mask and the weight maps that are given, by role.
    options : ReliefOptions
    solid : SolidOptions
    design : PlateDesign or None
        The plate of the recipe; None if it has none.
    machine : MachineOptions
    """

    stacks: tuple[Stack, ...]
    composition: Composition
    detail: NormalMap | None
    surface: NormalMap | Height | None
    greys: dict[str, Float32]
    options: ReliefOptions
    solid: SolidOptions
    design: PlateDesign | None = None
    machine: MachineOptions = field(default_factory=MachineOptions)

    def solve(self, progress: Progress | None = None) -> Relief:
        """The relief, on its plate if there is one, in pixels of the size that the recipe's machine needs.

        Raises
        ------
        NmaptoolError
            As for `nmaptool.relief` and `nmaptool.plate`.
        """
        if self.design is not None:
            return plate(**self.inputs, design=self.design, progress=progress)
        return relief_at_pitch(self.inputs, self.machine, progress)

    @property
    def inputs(self) -> dict[str, Any]:
        """The arguments of `nmaptool.relief`."""
        original = self.composition.normal_map
        return {
            "original": original,
            "detail": self.detail,
            "surface": self.surface,
            "options": self.options,
            **self.greys,
        }

    @property
    def maps(self) -> tuple[NormalMap, ...]:
        """The maps that were read, each once."""
        read = [each for stack in self.stacks for each in stack.maps]
        if len(self.stacks) == 1 and self.detail is not None:
            read.append(self.detail)
        if isinstance(self.surface, NormalMap):
            read.append(self.surface)
        return tuple(read)

    def _line(self) -> str:
        frame = self.composition.normal_map.frame
        given = RecipeRelief(options=_given(self.options))
        return f"{self.stacks[0].recipe.name}: {frame.cols} x {frame.rows} px, {given._line()}"


def read_scene(
    recipe: Recipe | str | Path,
    reading: ReadOptions | None = None,
    *,
    folder: str | Path | None = None,
    progress: Progress | None = None,
    cache: PictureCache | None = None,
) -> Scene:
    """Read the files of a recipe, compose its layers, and collect the options of its table ``[relief]``.

    Parameters
    ----------
    recipe : Recipe, str or Path
        A recipe, or a file for `nmaptool.read_recipe`.
    reading : ReadOptions, optional
        For all maps, as for `nmaptool.read_stack`.
    folder : str or Path, optional
        The folder to which file names are relative. Default: the recipe's own folder.
    progress : callable, optional
        Called with the stage and the share done, 0 to 1.
    cache : PictureCache, optional
        Keeps the maps and masks that are read for the next recipe.

    Returns
    -------
    Scene

    Raises
    ------
    InputError
        If a file cannot be read or does not fit; the message names the recipe.
    LimitError
        If the pictures are larger than ``reading.max_megapixels`` together.

    Examples
    --------
    >>> scene = nm.read_scene("samples/scene.toml")
    >>> nm.relief(**scene.inputs)
    <Relief 120 x 63.75 mm (640 x 340 px), 0 to 6.36 mm high, by multigrid in 8 iterations>
    """
    reading = reading or ReadOptions()
    if not isinstance(recipe, Recipe):
        recipe = read_recipe(recipe, folder=folder, max_megapixels=reading.max_megapixels)
    place = Path(recipe.folder if folder is None else folder)
    wanted = recipe.relief or RecipeRelief()
    options = ReliefOptions(**wanted.options)
    made_on = recipe.plate or RecipePlate()
    solid = SolidOptions(**made_on.solid_values(wanted.solid))
    cache = cache or PictureCache()
    stack = read_stack(recipe, reading, folder=place, cache=cache)
    composition = compose(stack.layers, stack.canvas, max_megapixels=reading.max_megapixels, progress=progress)
    original = composition.normal_map
    stacks = [stack]
    files = {role: None if name is None else str(place / name) for role, name in vars(wanted.files).items()}
    try:
        detail = None
        if files["detail"] is not None and is_recipe(files["detail"]):
            detail, own = _composed_like(original, files["detail"], reading, cache)
            stacks.append(own)
        elif files["detail"] is not None:
            named = files["detail"]
            key = ("detail", named, original.decoding.green, reading)
            detail = cache.get(split_layer(named)[0], key, lambda: read_normal_map(named, reading, like=original))
        surface = None
        if files["surface"] is not None:
            surface = read_surface(files["surface"], reading, like=original, pitch_mm=pitch_of(original, options)[0])
        greys = read_greys(wanted.files, place, max_megapixels=reading.max_megapixels)
    except InputError as error:
        raise InputError(f"{recipe.name}: relief: {error}") from None
    try:
        design = design_of(recipe.plate, place)
    except InputError as error:
        raise InputError(f"{recipe.name}: {error}") from None
    machine = made_on.machine_options
    return Scene(tuple(stacks), composition, detail, surface, greys, options, solid, design, machine)


def read_greys(files: ReliefFiles, folder: Path, *, max_megapixels: float = 270.0) -> dict[str, Float32]:
    """Read the mask and the weight maps that are given, by role.

    Raises
    ------
    InputError, LimitError
        If one cannot be read.
    """
    named = {role: name for role in _GREYS if (name := getattr(files, role)) is not None}
    return {role: read_grey(folder / name, max_megapixels=max_megapixels) for role, name in named.items()}


def _composed_like(
    original: NormalMap, file: str, reading: ReadOptions, cache: PictureCache
) -> tuple[NormalMap, Stack]:
    """Compose a recipe on a canvas of the original's size."""
    stack = read_stack(file, reading, cache=cache)
    frame = original.frame
    canvas = CanvasOptions(f"{frame.cols}x{frame.rows}", stack.canvas.width, stack.canvas.ground)
    composition = compose(stack.layers, canvas, max_megapixels=reading.max_megapixels)
    return composition.normal_map, replace(stack, canvas=canvas)


def _given(options: ReliefOptions) -> dict[str, Any]:
    default = ReliefOptions()
    return {key: value for key, value in vars(options).items() if value != getattr(default, key)}
