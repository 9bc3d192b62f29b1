"""Write a comparison as a figure and as JSON."""

from __future__ import annotations

from pathlib import Path

from nmaptool._version import __version__
from nmaptool.figures.comparison import comparison_figure
from nmaptool.io.output.targets import Destination, place_of
from nmaptool.io.output.transaction import Metadata, Outputs, wanted
from nmaptool.io.pictures.writer import write_image
from nmaptool.types.comparison import Comparison


def comparison_outputs(
    figure: Destination | None = None, *, report: Destination | None = None, overwrite: bool = False
) -> Outputs[Comparison]:
    """The plan of `write_comparison`."""
    return Outputs(wanted(figure, "a figure", (".png",), _write_figure), place_of(report), overwrite)


def write_comparison(
    comparison: Comparison,
    figure: Destination | None = None,
    *,
    report: Destination | None = None,
    overwrite: bool = False,
    metadata: Metadata | None = None,
) -> None:
    """Write a comparison as a figure and as JSON: both files appear, or neither.

    Parameters
    ----------
    comparison : Comparison
    figure : str, Path or OutputStream, optional
        .png.
    report : str, Path or OutputStream, optional
        .json.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: ``comparison.to_dict()``.

    Raises
    ------
    UsageError
        If the figure is not a .png file, or the report not a .json file.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> import trimesh
    >>> sphere = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=1))
    >>> options = nm.CompareOptions(size="64x64", renderer="numpy")
    >>> nm.write_comparison(nm.compare(sphere, options), report="comparison.json")
    """
    values = {"version": __version__, **comparison.to_dict()} if metadata is None else metadata
    comparison_outputs(figure, report=report, overwrite=overwrite).write(comparison, values)


def _write_figure(comparison: Comparison, path: Path) -> None:
    facts = {"kind": "comparison", "version": __version__}
    write_image(comparison_figure(comparison), path, ("R", "G", "B"), facts)
