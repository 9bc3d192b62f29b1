"""What commands read: meshes, maps and learned filters, under the names that the user gave them."""

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

ONLY_FILES = "a mesh is read from a file, whose ending tells what it is"


@dataclass(frozen=True)
class LearnedFilter(Options, group="Filter"):
    """A filter of one's own.

    Parameters
    ----------
    model:
        Filter made by nmap train, .npz, for --filter learned. Default: the one that comes with nmaptool.
    """

    model: Path | None = option(None)

    @property
    def files(self) -> dict[str, str]:
        """What is read, by role."""
        return {} if self.model is None else {"model": str(self.model)}

    def read(self) -> nm.FilterModel | None:
        """The filter; None where none is given."""
        import nmaptool as nm

        return None if self.model is None else nm.read_filter_model(self.model)


def begin_mesh(run: Run, outputs: Outputs[Any], mesh: str) -> None:
    """Check what can be checked before a mesh is worked on."""
    refuse_stream(ONLY_FILES, mesh)
    run.begin(outputs, mesh=mesh, **run[LearnedFilter].files)


def read_mesh(run: Run, name: str) -> nm.Mesh:
    """A mesh, read as the run's options say."""
    import nmaptool as nm

    reading = run[MeshReadOptions]
    return nm.read_mesh(name, unit=reading.unit, max_faces=reading.max_faces)


def mesh_header(run: Run, source: nm.Mesh) -> dict[str, Any]:
    """What the report of a rebuilt mesh begins with."""
    reading = asdict(run[MeshReadOptions])
    return run.header(reading=reading, mm_per_unit=source.mm_per_unit, unit_from=source.unit_from)


def rebuild_mesh(run: Run, rebuild: Callable[..., _Result], options: Options) -> tuple[nm.Mesh, _Result]:
    """A mesh as it was read, and what ``rebuild`` (`nmaptool.smooth`, `nmaptool.compare`) makes of it."""
    with run.work() as (files, progress):
        model = run[LearnedFilter].read()
        source = read_mesh(run, files["mesh"])
        result = rebuild(source, options, run[FilterOptions], run[ReconstructOptions], model=model, progress=progress)
    return source, result


def read_map(run: Run, file: str, like: nm.NormalMap | None = None, *, own_layer: bool = True) -> nm.NormalMap:
    """A normal map, read as the run's options say, under the name that the user gave it.

    ``--layer`` is for the first map of a command: others are read with ``own_layer=False``.
    """
    import nmaptool as nm

    reading = run[ReadOptions] if own_layer else replace(run[ReadOptions], layer=None)
    normal_map = nm.read_normal_map(file, reading, like=like)
    name = display_name(normal_map.name)
    return normal_map if name == normal_map.name else replace(normal_map, name=name)


def read_grey(run: Run, file: str | None) -> Any:
    """A grey picture; None where none is given."""
    import nmaptool as nm

    return None if file is None else nm.read_grey(file, max_megapixels=run[ReadOptions].max_megapixels)


def map_header(run: Run, *maps: nm.NormalMap, **more: Any) -> dict[str, Any]:
    """What the report of an edit of maps begins with."""
    inputs = [{"name": m.name, "cols": m.frame.cols, "rows": m.frame.rows, **asdict(m.decoding)} for m in maps]
    return run.header(inputs=inputs, reading=asdict(run[ReadOptions]), **more)
