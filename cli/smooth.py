"""``nmap smooth``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.core.errors import UsageError
from nmaptool.options import FilterOptions, MeshReadOptions, ReconstructOptions, SmoothOptions
from nmaptool.options.fields import option
from nmaptool_cli.command import command
from nmaptool_cli.inputs import LearnedFilter, begin_mesh, mesh_header, rebuild_mesh
from nmaptool_cli.outputs import ReportOutputs
from nmaptool_cli.run import Run
from nmaptool_cli.streams import refuse_stream

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.io.output.transaction import Outputs


@dataclass(frozen=True)
class MeshOutputs(ReportOutputs):
    """Meshes.

    Parameters
    ----------
    output:
        Mesh to write; repeat the flag for several files. The ending sets the format: .stl .ply .obj in mm, .glb in
        metres. If the units of the input are unknown, they are taken as mm and the numbers stay as they are. Faces keep
        their order.
    """

    output: tuple[Path, ...] = option((), short="-o")

    def plan(self, prints_json: bool) -> Outputs[nm.Mesh]:
        """The files to write."""
        from nmaptool.io.output.mesh import mesh_outputs

        refuse_stream("a mesh is written to a file, such as -o smooth.stl", *self.output)
        if not (self.output or self.report or prints_json):
            raise UsageError("no output given: add one, such as -o smooth.stl")
        return mesh_outputs(self.output, **self.shared)


@command(MeshOutputs, SmoothOptions, ReconstructOptions, FilterOptions, LearnedFilter, MeshReadOptions)
def smooth(run: Run, mesh: str, /) -> None:
    """Remove the fine detail of a mesh, or exaggerate it.

    Detail is everything finer than --sigma-s; --detail-gain sets how much of it is kept. The vertices move until the
    faces have the normals that this gives.

    Example: nmap smooth bunny.obj -o smooth.stl, or nmap smooth bunny.obj -o crisp.stl --detail-gain 2

    Parameters
    ----------
    mesh:
        Mesh file: {meshes}.
    """
    outputs = run[MeshOutputs].plan(run.options.json)
    begin_mesh(run, outputs, mesh)
    import nmaptool as nm
    from nmaptool.io.output.mesh import mesh_metadata
    from nmaptool_cli.wording.meshes import describe_smoothing

    source, result = rebuild_mesh(run, nm.smooth, run[SmoothOptions])
    describe_smoothing(run, source, result)
    metadata = mesh_metadata(result.mesh, mesh_header(run, source) | result.report.to_dict())
    meshes = run[MeshOutputs].output
    written = [f"{path}{_unit_of(path, source) if path in meshes else ''}" for path in outputs.paths]
    run.finish(outputs, result.mesh, metadata, written=written)


def _unit_of(path: Path, source: nm.Mesh) -> str:
    if path.suffix.lower() == ".glb":
        return " (in metres)" if source.unit_from != "assumed" else " (in metres, input coordinates taken as mm)"
    return " (in mm)" if source.unit_from != "assumed" else " (coordinates as in the input)"
