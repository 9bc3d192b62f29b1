"""``nmap compare``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.core.errors import UsageError
from nmaptool.options import CompareOptions, FilterOptions, MeshReadOptions, ReconstructOptions
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
class FigureOutputs(ReportOutputs):
    """Outputs of the comparison.

    Parameters
    ----------
    output:
        Figure (.png) that compares both schemes: rebuilt meshes, vertex deviations, histograms, curves and the verdict.
    """

    output: Path | None = option(None, short="-o")

    def plan(self, prints_json: bool) -> Outputs[nm.Comparison]:
        """The files to write."""
        from nmaptool.io.output.comparison import comparison_outputs

        refuse_stream("a figure is written to a file, such as -o figure.png", self.output)
        if not (self.output or self.report or prints_json):
            raise UsageError("no output given: add one, such as -o figure.png")
        return comparison_outputs(self.output, **self.shared)


@command(FigureOutputs, CompareOptions, ReconstructOptions, FilterOptions, LearnedFilter, MeshReadOptions)
def compare(run: Run, mesh: str, /) -> None:
    """Compare gSfG with Poisson reconstruction on one mesh's base normals.

    Reports the vertex and normal deviation of each scheme. Settings are swept to compare the schemes at equal normal
    deviation.

    Example: nmap compare bunny.obj -o figure.png --report figure.json

    Parameters
    ----------
    mesh:
        Mesh file: {meshes}.
    """
    outputs = run[FigureOutputs].plan(run.options.json)
    begin_mesh(run, outputs, mesh)
    import nmaptool as nm
    from nmaptool_cli.wording.meshes import describe_comparison, describe_curves, describe_notes

    source, comparison = rebuild_mesh(run, nm.compare, run[CompareOptions])
    run.say(*describe_comparison(comparison))
    describe_notes(run, source)
    run.detail(*describe_curves(comparison))
    run.finish(outputs, comparison, mesh_header(run, source) | comparison.to_dict())
