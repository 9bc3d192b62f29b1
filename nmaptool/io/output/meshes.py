"""A mesh to files, all of them or none."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.io.meshes import writer as meshes
from nmaptool.io.replace import check_targets, named, written_beside
from nmaptool.types.mesh import Mesh


@dataclass(frozen=True)
class MeshFiles:
    """Where a mesh goes.

    Parameters
    ----------
    outputs : sequence of Path
        .stl .ply .obj .glb, by ending.
    report : Path or None
        .json.
    overwrite : bool
        Replace files that exist.
    """

    outputs: Sequence[Path]
    report: Path | None = None
    overwrite: bool = False

    @property
    def targets(self) -> list[Path]:
        """All files, in the order they are named."""
        return [*self.outputs, *([] if self.report is None else [self.report])]

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
            if path.suffix.lower() not in meshes.ENDINGS:
                found = f"ends in {path.suffix}" if path.suffix else "has no ending"
                raise UsageError(f"{path}: {found}; a mesh is written as {', '.join(meshes.ENDINGS)}")
        if self.report is not None and self.report.suffix.lower() != ".json":
            raise UsageError(f"{self.report}: a report is written as .json")
        check_targets(self.targets, self.overwrite)


def write_mesh(
    mesh: Mesh,
    *outputs: str | Path,
    report: str | Path | None = None,
    overwrite: bool = False,
    metadata: Mapping[str, Any] | None = None,
) -> None:
    """Write a mesh to any number of files: all of them appear, or none.

    Parameters
    ----------
    mesh : Mesh
    *outputs : str or Path
        By ending: .stl .ply .obj in mm, .glb in metres as its specification says. Where the units of a mesh are not
        known they are taken as mm, so its numbers stay as they are but in .glb. Vertices and faces keep their order.
    report : str or Path, optional
        JSON account of the run.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report.

    Raises
    ------
    UsageError
        If an ending is not offered.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> mesh = nm.Mesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> nm.write_mesh(mesh, "triangle.ply", "triangle.obj")
    >>> nm.read_mesh("triangle.ply")
    <Mesh triangle.ply: 3 vertices, 1 face, 1 mm to a unit (assumed)>
    """
    files = MeshFiles([Path(p) for p in outputs], Path(report) if report is not None else None, overwrite)
    files.check()
    values = {"version": __version__, "vertices": len(mesh.vertices), "faces": len(mesh.faces), **(metadata or {})}
    with written_beside(files.targets, overwrite) as beside:
        for target, temporary in zip(files.targets, beside, strict=True):
            with named(target, temporary):
                if target is files.report:
                    temporary.write_text(json.dumps(values, indent=2) + "\n")
                else:
                    meshes.write_mesh(temporary, mesh)
