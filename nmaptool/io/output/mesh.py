"""Write a mesh to files."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from nmaptool._version import __version__
from nmaptool.io.meshes import writer as meshes
from nmaptool.io.output.targets import Destination, place_of
from nmaptool.io.output.transaction import Metadata, Outputs, Target
from nmaptool.options.formats import MESH_FORMATS
from nmaptool.types.mesh import Mesh


def mesh_outputs(
    outputs: Iterable[Destination], *, report: Destination | None = None, overwrite: bool = False
) -> Outputs[Mesh]:
    """The plan of `write_mesh`."""
    targets = [Target(place_of(output), "a mesh", MESH_FORMATS, meshes.write_mesh) for output in outputs]
    return Outputs(targets, place_of(report), overwrite)


def mesh_metadata(mesh: Mesh, metadata: Metadata | None = None) -> dict[str, Any]:
    """The content of a mesh's report: its numbers of vertices and faces, and the metadata of the run."""
    return {"version": __version__, "vertices": len(mesh.vertices), "faces": len(mesh.faces), **(metadata or {})}


def write_mesh(
    mesh: Mesh,
    *outputs: Destination,
    report: Destination | None = None,
    metadata: Metadata | None = None,
    overwrite: bool = False,
) -> None:
    """Write a mesh to any number of files: all of them appear, or none.

    Parameters
    ----------
    mesh : Mesh
    *outputs : str, Path or OutputStream
        The extension sets the format: .stl .ply .obj in mm, .glb in metres, as its specification requires. Unknown
        units are taken as mm, so only .glb changes the numbers. Vertices and faces keep their order.
    report : str, Path or OutputStream, optional
        JSON report of the run.
    metadata : mapping, optional
        What to put in the report besides the numbers of vertices and faces.
    overwrite : bool
        Replace files that exist.

    Raises
    ------
    UsageError
        If an extension is not supported for meshes, or the report is not a .json file.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> mesh = nm.Mesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> nm.write_mesh(mesh, "triangle.ply", "triangle.obj")
    >>> nm.read_mesh("triangle.ply")
    <Mesh triangle.ply: 3 vertices, 1 face, 1 mm per unit (assumed)>
    """
    mesh_outputs(outputs, report=report, overwrite=overwrite).write(mesh, mesh_metadata(mesh, metadata))
