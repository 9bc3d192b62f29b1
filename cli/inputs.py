"""Inputs of commands: meshes, maps and learned filters, under the names that the user gave them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from nmaptool.options import FilterOptions, MeshReadOptions, ReadOptions, ReconstructOptions
from nmaptool.options.fields import Options, option
from nmaptool_cli.streams import display_name, refuse_stream

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.io.output.transaction import Outputs
    from nmaptool_cli.run import Run

_Result = TypeVar("_Result")

ONLY_FILES = "a mesh is read from a file, because its ending names the format"


@dataclass(frozen=True)
class LearnedFilter(Options, group="Filter"):
    """A filter that the user trained.

    Parameters
    ----------
    model:
        Filter made by nmap train (.npz), for --filter learned. Default: the filter that comes with nmaptool.
    """

    model: Path | None = option(None)

    @property
    def files(self) -> dict[str, str]:
        """The files to read, by role."""
        return {} if self.model is None else {"model": str(self.model)}

    def read(self) -> nm.FilterModel | None:
        """The filter; None if none is given."""
        import nmaptool as nm

        return None if self.model is None else nm.read_filter_model(self.model)


def begin_mesh(run: Run, outputs: Outputs[Any], mesh: str) -> None:
    """Check everything that can be checked before the mesh is read."""
    refuse_stream(ONLY_FILES, mesh)
    run.begin(outputs, mesh=mesh, **run[LearnedFilter].files)


def read_mesh(run: Run, name: str) -> nm.Mesh:
    """A mesh, read with the options of the run."""
    import nmaptool as nm

    reading = run[MeshReadOptions]
    with run.reading():
        return nm.read_mesh(name, unit=reading.unit, max_faces=reading.max_faces)


def mesh_header(run: Run, source: nm.Mesh) -> dict[str, Any]:
    """The first entries of a report on a rebuilt mesh."""
    reading = asdict(run[MeshReadOptions])
    return run.header(reading=reading, mm_per_unit=source.mm_per_unit, unit_from=source.unit_from)


def rebuild_mesh(run: Run, rebuild: Callable[..., _Result], options: Options) -> tuple[nm.Mesh, _Result]:
    """The mesh that was read, and the result of ``rebuild`` (`nmaptool.smooth`, `nmaptool.compare`) on it."""
    with run.work() as (files, progress):
        model = run[LearnedFilter].read()
        source = read_mesh(run, files["mesh"])
        result = rebuild(source, options, run[FilterOptions], run[ReconstructOptions], model=model, progress=progress)
    return source, result


def read_map(run: Run, file: str, like: nm.NormalMap | None = None, *, own_layer: bool = True) -> nm.NormalMap:
    """A normal map, read with the options of the run, under the name that the user gave it.

    ``--layer`` applies to the first map of a command; others are read with ``own_layer=False``.
    """
    import nmaptool as nm

    reading = run[ReadOptions] if own_layer else replace(run[ReadOptions], layer=None)
    with run.reading():
        normal_map = nm.read_normal_map(file, reading, like=like)
    name = display_name(normal_map.name)
    return normal_map if name == normal_map.name else replace(normal_map, name=name)


def read_grey(run: Run, file: str | None) -> Any:
    """A grey picture; None if none is given."""
    import nmaptool as nm

    if file is None:
        return None
    with run.reading():
        return nm.read_grey(file, max_megapixels=run[ReadOptions].max_megapixels)


def map_header(run: Run, *maps: nm.NormalMap, **more: Any) -> dict[str, Any]:
    """The first entries of a report on edited maps."""
    inputs = [{"name": m.name, "cols": m.frame.cols, "rows": m.frame.rows, **asdict(m.decoding)} for m in maps]
    return run.header(inputs=inputs, reading=asdict(run[ReadOptions]), **more)
