"""``nmap bake``."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from nmaptool.options import BakeOptions, FilterOptions, MeshReadOptions
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Switch
from nmaptool_cli.command import command
from nmaptool_cli.inputs import LearnedFilter, begin_mesh, read_mesh
from nmaptool_cli.outputs import LayerOutputs, by_folder
from nmaptool_cli.run import Run


@dataclass(frozen=True)
class DrawnOutputs(Options, group="Outputs"):
    """More layers to write.

    Parameters
    ----------
    depth:
        Also write the distance from the camera, in mm.
    faces:
        Also write the face number of each pixel.
    """

    depth: bool = option(False, Switch())
    faces: bool = option(False, Switch())


@command(LayerOutputs, DrawnOutputs, BakeOptions, FilterOptions, LearnedFilter, MeshReadOptions)
def bake(run: Run, mesh: str, /) -> None:
    """Render a mesh to original, base and detail normal maps.

    The base keeps the larger forms; the detail holds everything finer than --sigma-s. nmap relief takes the original
    with the detail, or the base alone.

    Example: nmap bake bunny.obj -o maps, then nmap relief maps/original.exr --detail maps/detail.exr -o bunny.stl

    Parameters
    ----------
    mesh:
        Mesh file: {meshes}.
    """
    options, drawn = run[BakeOptions], run[DrawnOutputs]
    outputs = run[LayerOutputs].plan(views=options.views, depth=drawn.depth, faces=drawn.faces)
    begin_mesh(run, outputs, mesh)
    import nmaptool as nm
    from nmaptool_cli.wording.layers import describe_layers

    with run.work() as (files, progress):
        model = run[LearnedFilter].read()
        source = read_mesh(run, files["mesh"])
        layer_sets = nm.bake_views(source, options, run[FilterOptions], model=model, progress=progress)
    describe_layers(run, source, layer_sets)
    reports = [layers.report.to_dict() for layers in layer_sets]
    metadata = run.header(reading=asdict(run[MeshReadOptions]), layers=reports)
    run.finish(outputs, layer_sets, metadata, written=by_folder(outputs.paths))
