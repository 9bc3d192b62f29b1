"""What `nmap relief` makes a relief from: maps, or a recipe with a table ``[relief]``."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress
from nmaptool.options import ReadOptions, ReliefFiles, ReliefOptions, SolidOptions
from nmaptool.options.fields import Options
from nmaptool.options.plates import MachineOptions
from nmaptool.options.relief_presets import PresetOptions
from nmaptool_cli.inputs import read_grey, read_map
from nmaptool_cli.plate_sources import plate_of
from nmaptool_cli.run import Run

if TYPE_CHECKING:
    import nmaptool as nm

# flags of the solid that take the place of others of a preset or recipe
_INSTEAD = {"shell": ("base", "hollow"), "base": ("shell",), "triangles": ("max_error",), "max_error": ("triangles",)}


@dataclass
class Work:
    """Inputs that have been read.

    Attributes
    ----------
    arguments : mapping
        Those of `nmaptool.relief`.
    maps : list of NormalMap
        The maps that were read, for messages.
    read_s : float
        Seconds of reading.
    facts : mapping
        More entries of the report.
    notes : list of str
        More messages.
    design : PlateDesign or None
        The plate to put the relief on.
    machine : MachineOptions
    """

    arguments: Mapping[str, Any]
    maps: Sequence[nm.NormalMap]
    read_s: float
    facts: Mapping[str, Any] = field(default_factory=dict)
    notes: Sequence[str] = ()
    design: nm.PlateDesign | None = None
    machine: MachineOptions = field(default_factory=MachineOptions)

    def solved(self, progress: Progress | None) -> nm.Relief:
        """The relief; its report states the seconds of reading."""
        import nmaptool as nm

        if self.design is not None:
            result = nm.plate(**self.arguments, design=self.design, progress=progress)
        elif self.machine.pitch is None:
            result = nm.relief(**self.arguments, progress=progress)
        else:
            from nmaptool.plates.resampling import relief_at_pitch

            result = relief_at_pitch(self.arguments, self.machine, progress)
        report = dataclasses.replace(result.report, seconds={"reading": self.read_s, **result.report.seconds})
        return dataclasses.replace(result, report=report)


@dataclass(frozen=True)
class Sources:
    """The inputs by role, and the options after the recipe, if there is one.

    Attributes
    ----------
    role : str
        Role of the first argument in the report.
    inputs : mapping
        Other files to read, by role.
    files : mapping
        Names of the files besides the map, by role, for messages.
    options : ReliefOptions
    solid : SolidOptions
    plate : RecipePlate
        Without a shape, there is no plate.
    recipe : Recipe or None
    """

    role: str
    inputs: Mapping[str, Any]
    files: Mapping[str, str | None]
    options: ReliefOptions
    solid: SolidOptions
    plate: nm.RecipePlate
    recipe: nm.Recipe | None = None

    def check_files(self, original: str) -> None:
        """Refuse files that do not exist, and fonts and drawings that cannot be used."""
        from nmaptool.io.designs import design_of
        from nmaptool.io.pictures.normal_maps import split_layer

        names = self.inputs.get("files", ()) if self.recipe is not None else (original,)
        for name in (*names, *(file for file in self.files.values() if file is not None)):
            if not Path(split_layer(name)[0]).is_file():
                raise InputError(f"{name}: no such file")
        design_of(self.plate, "" if self.recipe is None else self.recipe.folder)

    def read(self, run: Run, files: Mapping[str, Any], progress: Progress | None) -> Work:
        """Read the inputs."""
        from nmaptool.io.designs import design_of

        if self.recipe is not None:
            work = _read_recipe(run, self.recipe, progress)
        else:
            work = dataclasses.replace(_read_maps(run, self.options, files), design=design_of(self.plate))
        return dataclasses.replace(work, machine=self.plate.machine_options)


def map_sources(run: Run) -> Sources:
    """The sources of a relief of maps."""
    files = asdict(run[ReliefFiles])
    options, plate = ReliefOptions(**_given(run, ReliefOptions)), plate_of(run, None)
    return Sources("original", files, files, options, SolidOptions(**_solid(run, {}, plate)), plate)


def _given(run: Run, options: type[Options]) -> dict[str, Any]:
    """What the preset and the flags say."""
    return {**run[PresetOptions].values_of(options), **run.named(options)}


def _solid(run: Run, own: Mapping[str, Any], plate: nm.RecipePlate) -> dict[str, Any]:
    """What a recipe, the preset, the flags and the machine say about the solid."""
    given = {**own, **run[PresetOptions].values_of(SolidOptions)}
    flags = run.named(SolidOptions)
    for name in flags:
        for other in _INSTEAD.get(name, ()):
            given.pop(other, None)
    return plate.solid_values({**given, **flags})


def recipe_sources(run: Run, name: str) -> Sources:
    """The sources of a relief of a recipe; flags replace what its table ``[relief]`` says."""
    import nmaptool as nm

    run.begin(recipe=name)
    recipe = nm.read_recipe(name, max_megapixels=run[ReadOptions].max_megapixels)
    own = recipe.relief or nm.RecipeRelief()
    # flags are relative to the current folder, names in the recipe to its own
    flags = {role: str(Path(file).absolute()) for role, file in run.named(ReliefFiles).items() if file is not None}
    plate = plate_of(run, recipe)
    relief = nm.RecipeRelief(
        dataclasses.replace(own.files, **flags),
        {**own.options, **_given(run, ReliefOptions)},
        _solid(run, own.solid, plate),
    )
    recipe = dataclasses.replace(recipe, relief=relief, plate=plate)
    place = Path(recipe.folder)
    files = {role: None if file is None else str(place / file) for role, file in asdict(relief.files).items()}
    read = (*recipe.sources, *recipe.files)
    inputs = {"files": tuple(str(place / file) for file in read), **files}
    options, solid = ReliefOptions(**relief.options), SolidOptions(**relief.solid)
    return Sources("recipe", inputs, files, options, solid, plate, recipe)


def _read_maps(run: Run, options: ReliefOptions, files: Mapping[str, Any]) -> Work:
    import nmaptool as nm

    started = time.perf_counter()
    original = read_map(run, files["original"])
    detail = None
    if files["detail"] is not None:
        detail = read_map(run, files["detail"], like=original, own_layer=False)
    surface = None
    if files["surface"] is not None:
        pitch_mm, _ = nm.pitch_of(original, options)
        reading = dataclasses.replace(run[ReadOptions], layer=None)
        surface = nm.read_surface(files["surface"], reading, like=original, pitch_mm=pitch_mm)
    greys = {role: read_grey(run, files[role]) for role in ("mask", "mu_map", "beta_map", "delta_map", "wall_mask")}
    arguments = {
        "original": original,
        "detail": detail,
        "surface": surface,
        "options": options,
        **greys,
    }
    maps = [each for each in (original, detail, surface) if isinstance(each, nm.NormalMap)]
    return Work(arguments, maps, time.perf_counter() - started)


def _read_recipe(run: Run, recipe: nm.Recipe, progress: Progress | None) -> Work:
    import nmaptool as nm
    from nmaptool_cli.compose.stack import notes_of

    started = time.perf_counter()
    scene = nm.read_scene(recipe, run[ReadOptions], progress=progress)
    notes = [note for stack in scene.stacks for note in notes_of(stack)]
    notes += [f"nmap: warning: {text}" for text in scene.composition.report.warnings]
    facts = {"layers": list(recipe.files), "hidden": list(recipe.hidden), "notes": list(recipe.notes)}
    return Work(scene.inputs, scene.maps, time.perf_counter() - started, facts, notes, scene.design)
