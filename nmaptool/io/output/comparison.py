"""A comparison to files, all of them or none."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.figures.comparison import comparison_figure
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.replace import check_targets, named, written_beside
from nmaptool.types.comparison import Comparison


@dataclass(frozen=True)
class ComparisonFiles:
    """Where a comparison goes.

    Parameters
    ----------
    figure : Path or None
        .png.
    report : Path or None
        .json.
    overwrite : bool
        Replace files that exist.
    """

    figure: Path | None = None
    report: Path | None = None
    overwrite: bool = False

    @property
    def targets(self) -> list[Path]:
        """All files, the figure first."""
        return [path for path in (self.figure, self.report) if path is not None]

    def check(self) -> None:
        """Refuse what could not be written, before any work is done.

        Raises
        ------
        UsageError
            If an ending is not offered or a file is named twice.
        OutputError
            If a target cannot be written or exists.
        """
        for path, kind, what in ((self.figure, ".png", "a figure"), (self.report, ".json", "a report")):
            if path is not None and path.suffix.lower() != kind:
                raise UsageError(f"{path}: {what} is written as {kind}")
        check_targets(self.targets, self.overwrite)


def write_comparison(
    comparison: Comparison,
    figure: str | Path | None = None,
    *,
    report: str | Path | None = None,
    overwrite: bool = False,
    metadata: Mapping[str, Any] | None = None,
) -> None:
    """Write a comparison as a figure and as JSON: both appear, or none.

    Parameters
    ----------
    comparison : Comparison
    figure : str or Path, optional
        .png.
    report : str or Path, optional
        .json.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: ``comparison.to_dict()``.

    Raises
    ------
    UsageError
        If an ending is not offered.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> import trimesh
    >>> sphere = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=1))
    >>> nm.write_comparison(nm.compare(sphere, nm.CompareOptions(renderer="numpy")), report="comparison.json")
    """
    places = [None if path is None else Path(path) for path in (figure, report)]
    files = ComparisonFiles(places[0], places[1], overwrite)
    files.check()
    values = {"version": __version__, **comparison.to_dict()} if metadata is None else metadata
    with written_beside(files.targets, overwrite) as beside:
        for target, temporary in zip(files.targets, beside, strict=True):
            with named(target, temporary):
                if target is files.report:
                    temporary.write_text(json.dumps(values, indent=2) + "\n")
                else:
                    facts = {"kind": "comparison", "version": __version__}
                    write_image(temporary, comparison_figure(comparison), ("R", "G", "B"), facts)
