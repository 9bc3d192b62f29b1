"""``nmap relief`` of maps larger than memory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.core.errors import UsageError
from nmaptool.io.stores.recognition import is_large_map
from nmaptool.options import PartOptions, ReadOptions, ReliefFiles, ReliefOptions, SolidOptions, TilingOptions
from nmaptool.options.formats import LARGE_ENDING, MESH_FORMATS, is_recipe
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.options.relief_presets import PresetOptions
from nmaptool_cli.outputs import as_given
from nmaptool_cli.part_outputs import check_part_names
from nmaptool_cli.relief_outputs import ReliefOutputs
from nmaptool_cli.run import Run

if TYPE_CHECKING:
    from nmaptool.core.progress import Progress
    from nmaptool.types.parts import Assembly
    from nmaptool.types.tiled import TiledReport

# what needs the whole relief in memory
_NOT_LARGE = (PlateOptions, FrameOptions, TextOptions, MachineOptions)
# formats of heights besides the store
EXPORT_ENDINGS = (".tif", ".tiff", ".npy")


def is_large(name: str, outputs: Sequence[Path], max_megapixels: float) -> bool:
    """Whether a relief is made by tiles: of a store, or into one."""
    if is_recipe(name):
        return False
    if any(output.suffix.lower() == LARGE_ENDING for output in outputs):
        return True
    return is_large_map(name, max_megapixels)


def large_relief(run: Run, name: str, given: ReliefOutputs) -> None:
    """Make the relief of a large map."""
    import nmaptool as nm
    from nmaptool.io.output.transaction import Outputs
    from nmaptool_cli.wording.large import describe_large
    from nmaptool_cli.wording.parts import describe_assembly

    heights, exports = _outputs(run, name, given)
    _check_exports(exports, _solid(run), given)
    files = run[ReliefFiles]
    options = ReliefOptions(**run[PresetOptions].values_of(ReliefOptions), **run.named(ReliefOptions))
    run.begin(None, original=name, **asdict(files))
    for file in (name, *asdict(files).values()):
        if file is not None and file.rstrip("/") == heights.rstrip("/"):
            raise UsageError(f"{heights}: is an input; give the output another name")
    assembled: list[Assembly] = []
    with run.progress() as progress:
        made = nm.tiled.relief(
            name,
            heights,
            options,
            files,
            reading=run[ReadOptions],
            tiling=run[TilingOptions],
            at=given.at,
            overwrite=given.overwrite,
            progress=progress,
        )
        written = [heights, *_export(run, made, exports, given, assembled, progress)]
    describe_large(run, name, made)
    for assembly in assembled:
        describe_assembly(run, assembly, _parts_of(exports))
    run.say(*(f"  wrote {place}" for place in written))
    metadata = run.header(reading=asdict(run[ReadOptions]), **made.to_dict(), outputs=written)
    run.finish(Outputs((), None if given.prints_report else given.report, given.overwrite), None, metadata, written=())


def _outputs(run: Run, name: str, given: ReliefOutputs) -> tuple[str, list[str]]:
    """The store of the heights, and the other files.

    Raises
    ------
    UsageError
        If a flag is not for large maps, or there is not one store.
    """
    for options in _NOT_LARGE:
        for option in run.named(options):
            raise UsageError(f"`{option}`: is not for large maps; make a smaller one, or parts")
    if given.dry_run or given.save_recipe is not None:
        raise UsageError(f"`{'dry_run' if given.dry_run else 'save_recipe'}`: is not for large maps")
    stores = [as_given(path) for path in given.output if path.suffix.lower() == LARGE_ENDING]
    others = [str(path) for path in given.output if path.suffix.lower() != LARGE_ENDING]
    if len(stores) != 1:
        raise UsageError(f"{name}: is a large map; name one Zarr store for its heights, such as -o heights.zarr")
    check_part_names([Path(other) for other in others], given.assembly, run[PartOptions])
    for other in others:
        ending = Path(other).suffix.lower()
        if ending and ending not in (*EXPORT_ENDINGS, *MESH_FORMATS):
            raise UsageError(
                f"{other}: heights of a large map are written as {', '.join((LARGE_ENDING, *EXPORT_ENDINGS))}, "
                "a folder of PNG tiles, or parts of meshes"
            )
    return stores[0], others


def _parts_of(others: Sequence[str]) -> list[str]:
    """The names of parts among those of files."""
    return [other for other in others if Path(other).suffix.lower() in MESH_FORMATS]


def _solid(run: Run) -> SolidOptions:
    return SolidOptions(**run[PresetOptions].values_of(SolidOptions), **run.named(SolidOptions))


def _check_exports(others: Sequence[str], solid: SolidOptions, given: ReliefOutputs) -> None:
    """Refuse files that could not be written, before the work.

    Raises
    ------
    UsageError, OutputError
    """
    if not (others or given.assembly):
        return
    from nmaptool.io.stores.export import check_export
    from nmaptool.io.stores.part_files import check_part_files

    parts = _parts_of(others)
    for other in others:
        if other not in parts:
            check_export(other, given.overwrite)
    if parts or given.assembly:
        check_part_files(parts, solid, assembly=given.assembly, overwrite=given.overwrite)


def _export(
    run: Run,
    made: TiledReport,
    others: Sequence[str],
    given: ReliefOutputs,
    assembled: list[Assembly],
    progress: Progress | None,
) -> Iterator[str]:
    """Write the heights to the other files, and name them; add what the parts became."""
    if not (others or given.preview or given.assembly):
        return
    import nmaptool as nm
    from nmaptool.io.stores.export import export_heights
    from nmaptool.io.stores.heights import open_heights
    from nmaptool.io.stores.part_files import export_parts, small_height

    source = open_heights(made.output)
    parts = _parts_of(others)
    for other in others:
        if other not in parts:
            export_heights(source, other, overwrite=given.overwrite, progress=progress)
            yield other
    if parts or given.assembly:
        assembly = export_parts(
            source,
            *parts,
            options=run[PartOptions],
            solid=_solid(run),
            assembly=[str(path) for path in given.assembly],
            on_plate=made.relief.options.background == "plane",
            overwrite=given.overwrite,
            progress=progress,
        )
        assembled.append(assembly)
        yield from (*parts, *(str(path) for path in given.assembly))
    if given.preview is not None:
        small = small_height(source)
        if small is not None:
            nm.write_preview(small, given.preview, overwrite=given.overwrite)
        yield str(given.preview)
