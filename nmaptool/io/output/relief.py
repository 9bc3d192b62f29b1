"""Write a relief to files: heights, meshes, a preview and a report."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

from nmaptool._version import __version__
from nmaptool.core.progress import Progress
from nmaptool.io.output.parts import (
    CutRelief,
    assembly_targets,
    check_templates,
    is_template,
    new_folders,
    part_targets,
)
from nmaptool.io.output.targets import Destination, place_of
from nmaptool.io.output.transaction import Metadata, Outputs, Target, wanted
from nmaptool.options import HeightsAt
from nmaptool.options.fields import choice_of
from nmaptool.options.formats import MESH_FORMATS, RECIPE_ENDING, RELIEF_FORMATS
from nmaptool.types.height import Height
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Solid


@dataclass(frozen=True, eq=False)
class WrittenRelief:
    """A relief, its triangles for files of meshes, what is told the progress of writing them, and its parts."""

    relief: Relief
    solid: Solid | None = None
    progress: Progress | None = None
    cut: CutRelief | None = None


class _Surface:
    """The data that the files of a relief share."""

    def __init__(self, at: HeightsAt, written: WrittenRelief, metadata: Metadata) -> None:
        recipe = {key: metadata[key] for key in ("options", "reading", "files") if key in metadata}
        self.relief, self.height, self.at = written.relief, written.relief.height, at
        self._solid, self.progress, self.cut = written.solid, written.progress, written.cut
        self.attributes = {"version": __version__, **{key: json.dumps(value) for key, value in recipe.items()}}

    @cached_property
    def solid(self) -> Solid:
        """The triangles, planned once for all files."""
        if self._solid is not None:
            return self._solid
        from nmaptool.solids.solid import solid

        return solid(self.relief)


def relief_outputs(
    outputs: Iterable[Destination] = (),
    *,
    preview: Destination | None = None,
    report: Destination | None = None,
    overwrite: bool = False,
    at: HeightsAt = "centers",
    recipe: tuple[Destination, str] | None = None,
    assembly: Iterable[Destination] = (),
) -> Outputs[WrittenRelief]:
    """The plan of `write_relief`; the text of a recipe may be written with it.

    The files of parts come in with `with_parts`, once their number is known; names for them are checked here.
    """
    choice_of(HeightsAt).read("at", at)
    outputs = list(outputs)
    templates = [str(output) for output in outputs if is_template(output)]
    places = [place_of(output) for output in outputs if not is_template(output)]
    surfaces = [
        Target(place, "a relief", tuple(RELIEF_FORMATS), partial(_write_surface, title=Path(str(place)).stem))
        for place in places
    ]
    views = [*wanted(preview, "a preview", (".png",), _write_preview)]
    if recipe is not None:
        place, text = recipe
        views += wanted(place, "a recipe", (RECIPE_ENDING,), lambda _, path: _write_text(text, path))
    return Outputs(
        [*surfaces, *views, *assembly_targets(assembly)],
        place_of(report),
        overwrite,
        new_folders(templates),
        "parts are written into it; give another name",
        report_endings=(),
        rules=[partial(check_templates, templates, overwrite)],
        prepare=partial(_Surface, at),
    )


def with_parts(outputs: Outputs[WrittenRelief], cut: CutRelief) -> Outputs[WrittenRelief]:
    """The plan with the files of the parts."""
    return replace(outputs, targets=[*part_targets(cut), *outputs.targets])


def write_relief(
    relief: Relief,
    *outputs: Destination,
    preview: Destination | None = None,
    report: Destination | None = None,
    overwrite: bool = False,
    metadata: Metadata | None = None,
    at: HeightsAt = "centers",
    solid: Solid | None = None,
) -> None:
    """Write a relief to any number of files: all of them appear, or none.

    Parameters
    ----------
    relief : Relief
    *outputs : str, Path or OutputStream
        Heights and meshes; the extension sets the format: .exr .tif .npy .png .stl .ply .obj .glb .3mf. Meshes are read
        back and checked.
    preview : str, Path or OutputStream, optional
        Shaded picture, .png.
    report : str, Path or OutputStream, optional
        JSON report of the run.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: ``relief.report.to_dict()``.
    at : str
        Where height files hold heights: at the "centers" of the pixels, or without loss at their "corners". Meshes
        always have the heights of the corners.
    solid : Solid, optional
        The triangles for meshes, from `nmaptool.solid`. Default: the open surface.

    Raises
    ------
    UsageError
        If an extension is not supported for reliefs, or the preview is not a .png file.
    OutputError
        If a file cannot be written or fails its check, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> relief = nm.relief(np.dstack([np.full((8, 8), 0.5), np.zeros((8, 8)), np.ones((8, 8))]))
    >>> nm.write_relief(relief, "relief.stl", "heights.npy", preview="relief.png")
    >>> nm.read_mesh("relief.stl")
    <Mesh relief.stl: 384 vertices, 128 faces, 1 mm per unit (assumed)>
    """
    plan = relief_outputs(outputs, preview=preview, report=report, overwrite=overwrite, at=at)
    plan.write(WrittenRelief(relief, solid), relief.report.to_dict() if metadata is None else metadata)


# each kind of file loads only what writes it


def _write_surface(surface: _Surface, path: Path, title: str) -> None:
    if path.suffix.lower() in MESH_FORMATS:
        from nmaptool.io.solids.writer import write_solid

        thumbnail = partial(_thumbnail, surface.height)
        write_solid(surface.solid, path, title=title, thumbnail_png=thumbnail, progress=surface.progress)
    else:
        from nmaptool.io.pictures import heights

        heights.write_height(surface.height, path, surface.attributes, at=surface.at)


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")


def _thumbnail(height: Height) -> bytes:
    from nmaptool.figures.notebook import png_of

    return png_of(height)


def _write_preview(surface: _Surface, path: Path) -> None:
    from nmaptool.figures.preview import preview
    from nmaptool.io.pictures.writer import write_image

    write_image(preview(surface.relief), path, ("R", "G", "B"), {"kind": "preview", **surface.attributes})
