"""A relief to files, all of them or none."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.figures.preview import preview
from nmaptool.io.meshes import writer as meshes
from nmaptool.io.pictures import heights
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.replace import check_targets, named, written_beside
from nmaptool.meshes.tessellate import surface_mesh
from nmaptool.types.height import Height
from nmaptool.types.mesh import Mesh
from nmaptool.types.relief import Relief

RELIEF_ENDINGS = tuple(dict.fromkeys((*heights.ENDINGS, *meshes.ENDINGS)))


@dataclass(frozen=True)
class ReliefFiles:
    """Where a relief goes.

    Parameters
    ----------
    outputs : sequence of Path
        Heights (.exr .tif .npy .png) and meshes (.stl .ply .obj .glb), by ending.
    preview : Path or None
        Shaded picture, .png.
    report : Path or None
        .json.
    overwrite : bool
        Replace files that exist.
    """

    outputs: Sequence[Path] = ()
    preview: Path | None = None
    report: Path | None = None
    overwrite: bool = False

    @property
    def targets(self) -> list[Path]:
        """All files, in the order they are named."""
        return [*self.outputs, *(p for p in (self.preview, self.report) if p is not None)]

    def check(self) -> None:
        """Refuse what could not be written, before any work is done.

        Raises
        ------
        UsageError
            If an ending is not offered or a file is named twice.
        OutputError
            If a target cannot be written or exists.
        """
        for path in self.outputs:
            if path.suffix.lower() not in RELIEF_ENDINGS:
                found = f"ends in {path.suffix}" if path.suffix else "has no ending"
                raise UsageError(f"{path}: {found}; a relief is written as {', '.join(RELIEF_ENDINGS)}")
        if self.preview is not None and self.preview.suffix.lower() != ".png":
            raise UsageError(f"{self.preview}: a preview is written as .png")
        check_targets(self.targets, self.overwrite)


def write_relief(
    relief: Relief,
    *outputs: str | Path,
    preview: str | Path | None = None,
    report: str | Path | None = None,
    overwrite: bool = False,
    metadata: Mapping[str, Any] | None = None,
) -> None:
    """Write a relief to any number of files: all of them appear, or none.

    Parameters
    ----------
    relief : Relief
    *outputs : str or Path
        Heights and meshes, by ending: .exr .tif .npy .png .stl .ply .obj .glb.
    preview : str or Path, optional
        Shaded picture, .png.
    report : str or Path, optional
        JSON account of the run.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: ``relief.report.to_dict()``.

    Raises
    ------
    UsageError
        If an ending is not offered.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> relief = nm.relief(np.dstack([np.full((8, 8), 0.5), np.zeros((8, 8)), np.ones((8, 8))]))
    >>> nm.write_relief(relief, "relief.stl", "heights.npy", preview="relief.png")
    >>> nm.read_mesh("relief.stl")
    <Mesh relief.stl: 384 vertices, 128 faces, 1 mm to a unit (assumed)>
    """
    files = ReliefFiles(
        [Path(p) for p in outputs],
        Path(preview) if preview is not None else None,
        Path(report) if report is not None else None,
        overwrite,
    )
    files.check()
    report_values = relief.report.to_dict() if metadata is None else metadata
    recipe = {key: report_values[key] for key in ("options", "reading", "files") if key in report_values}
    attributes = {"version": __version__, **{key: json.dumps(value) for key, value in recipe.items()}}
    mesh: Mesh | None = None
    with written_beside(files.targets, overwrite) as beside:
        for target, temporary in zip(files.targets, beside, strict=True):
            with named(target, temporary):
                if target is files.report:
                    temporary.write_text(json.dumps(report_values, indent=2) + "\n")
                elif target is files.preview:
                    _write_preview(temporary, relief.height, attributes)
                elif target.suffix.lower() in meshes.ENDINGS:
                    mesh = mesh or surface_mesh(relief.height)
                    meshes.write_mesh(temporary, mesh)
                else:
                    heights.write_height(temporary, relief.height, attributes)


def _write_preview(path: Path, height: Height, attributes: Mapping[str, str]) -> None:
    write_image(path, preview(height), ("R", "G", "B"), {"kind": "preview", **attributes})
