"""``nmap relief``."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, cast

from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.mentions import written_name
from nmaptool.options import (
    PartOptions,
    ReadOptions,
    ReliefFiles,
    ReliefOptions,
    SolidOptions,
    TilingOptions,
)
from nmaptool.options.formats import is_recipe
from nmaptool.options.plain_values import plain_values
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.options.relief_presets import PresetOptions
from nmaptool_cli.command import command
from nmaptool_cli.large_relief import is_large, large_relief
from nmaptool_cli.part_outputs import cut_relief
from nmaptool_cli.relief_outputs import ReliefOutputs
from nmaptool_cli.relief_sources import Sources, map_sources, recipe_sources
from nmaptool_cli.run import Run
from nmaptool_cli.saved_recipe import print_recipe, recipe_text

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress
    from nmaptool.io.output.relief import WrittenRelief
    from nmaptool.io.output.transaction import Outputs

# names of the inputs in the library's error messages, by role
_CALLED = {
    "mask": "the mask",
    "mu_map": "the mu map",
    "beta_map": "the beta map",
    "delta_map": "the delta map",
    "wall_mask": "the wall mask",
    "surface": "the curved background",
}


@command(
    *(ReliefFiles, ReliefOutputs, PresetOptions, ReliefOptions),
    *(PlateOptions, FrameOptions, TextOptions, SolidOptions, PartOptions, MachineOptions, TilingOptions, ReadOptions),
    completed=(ReliefOptions, PlateOptions, FrameOptions, TextOptions, SolidOptions, MachineOptions),
)
def relief(run: Run, map: str, /) -> None:
    """Make a relief in millimetres from one or two normal maps, or from a recipe.

    The original map with --detail keeps both shape and detail; a base map alone keeps only the structure.

    Example: nmap relief lion.png -o lion.stl --preview lion-view.png --height 4mm --width 80mm

    Parameters
    ----------
    map:
        Original or base normal map: {pictures}; FILE.exr:layer reads one layer; - reads standard input. Or a recipe
        (.toml): its layers are composed, and its table [relief] holds options and files, which flags replace. Or a map
        larger than memory: a Zarr store, a folder of tiles, a large TIFF; its heights go to a Zarr store.
    """
    import nmaptool as nm
    from nmaptool.io.output.relief import WrittenRelief, with_parts
    from nmaptool_cli.wording.parts import describe_parts, written_names
    from nmaptool_cli.wording.plates import describe_machine, describe_plate
    from nmaptool_cli.wording.reliefs import describe_relief
    from nmaptool_cli.wording.solids import describe_solid

    if is_large(map, run[ReliefOutputs].output, run[ReadOptions].max_megapixels):
        large_relief(run, map, run[ReliefOutputs])
        return
    if run.named(TilingOptions):
        raise UsageError(f"`{next(iter(run.named(TilingOptions)))}`: is for large maps, such as -o heights.zarr")
    given, outputs, sources, recipe = _begin(run, map)
    if given.is_recipe_only and not run.options.json:
        _save_recipe(run, outputs, sources, recipe, map)
        return
    with run.work() as (files, progress), _named_inputs(sources.files):
        work = sources.read(run, files, progress)
        result = work.solved(progress)
        cut = cut_relief(run, result, sources.solid, given.meshes)
        solid = nm.solid(result, sources.solid) if given.meshes and cut is None else None
    run.say(*work.notes)
    describe_relief(run, work.maps, result)
    describe_machine(run, work.machine, sources.solid, result)
    if result.plate is not None:
        describe_plate(run, result.plate)
    if solid is not None:
        describe_solid(run, solid, given.meshes)
    if cut is not None:
        describe_parts(run, cut)
    read = [{"name": m.name, "cols": m.frame.cols, "rows": m.frame.rows, **asdict(m.decoding)} for m in work.maps]
    metadata = run.header(inputs=read, reading=asdict(run[ReadOptions]), **work.facts, **result.report.to_dict())
    if result.plate is not None:
        metadata["plate"] = {"design": plain_values(sources.plate), **result.plate.to_dict()}
    if sources.plate.machine:
        metadata["machine"] = {written_name(name): value for name, value in plain_values(work.machine).items()}
    if solid is not None:
        metadata["solid"] = {"options": plain_values(sources.solid), **solid.to_dict()}
    if cut is not None:
        metadata["solid"] = {"options": plain_values(sources.solid)}
        metadata["parts"] = {"options": plain_values(run[PartOptions]), **cut.assembly.to_dict()}
        outputs = with_parts(outputs, cut)
    if given.dry_run:
        run.say("  nothing written (--dry-run)")
        nothing = dataclasses.replace(outputs, targets=(), report=None, folders=())
        run.finish(nothing, WrittenRelief(result), metadata)
        if given.prints_recipe and recipe is not None:
            print_recipe(recipe)
        return
    written = [f"{name}{_png_range(name, given, result)}" for name in written_names(outputs.paths, cut)]

    def watched(value: WrittenRelief, progress: Progress) -> WrittenRelief:
        return dataclasses.replace(value, progress=progress)

    run.finish(outputs, WrittenRelief(result, solid, cut=cut), metadata, written=written, watched=watched)
    if given.prints_recipe and recipe is not None:
        print_recipe(recipe)


def _begin(run: Run, name: str) -> tuple[ReliefOutputs, Outputs[WrittenRelief], Sources, str | None]:
    """Check everything that can be checked before the work; the recipe to save, if one is wanted, comes last."""
    given = run[ReliefOutputs]
    sources = recipe_sources(run, name) if is_recipe(name) else map_sources(run)
    recipe = None if given.save_recipe is None else recipe_text(run, name, sources, given.save_recipe)
    outputs = given.plan(run.options.json, run.named(SolidOptions), recipe, run[PartOptions])
    run.begin(outputs, **{sources.role: name}, **sources.inputs)
    if given.prints_recipe and run.options.json:
        raise UsageError("`save_recipe` and `json` both print to standard output; save the recipe in a file")
    return given, outputs, sources, recipe


def _save_recipe(run: Run, outputs: Outputs[WrittenRelief], sources: Sources, recipe: str | None, name: str) -> None:
    """Write the recipe alone; the files that it names must be there."""
    sources.check_files(name)
    if run[ReliefOutputs].prints_recipe:
        print_recipe(recipe or "")
    elif run[ReliefOutputs].dry_run:
        run.say("nothing written (--dry-run)")
    else:
        dataclasses.replace(outputs, prepare=lambda value, _: value).write(cast("WrittenRelief", None))
        run.say(*(f"wrote {path}" for path in outputs.paths))
    run.speak()


@contextlib.contextmanager
def _named_inputs(inputs: Mapping[str, str | None]) -> Iterator[None]:
    """Add the file name to errors about the mask or a weight map."""
    try:
        yield
    except InputError as error:
        text = str(error)
        for role, called in _CALLED.items():
            if inputs[role] is not None:
                text = text.replace(called, f"{called} {inputs[role]}", 1)
        raise InputError(text) from None


def _png_range(name: str, given: ReliefOutputs, result: nm.Relief) -> str:
    """The heights of black and white in a picture of heights."""
    low, high = result.height.range_mm
    is_heights = Path(name) in given.output and name.lower().endswith(".png")
    return f" (black {low:.3f} mm, white {high:.3f} mm)" if is_heights else ""
