"""Write pictures and films of reliefs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool._version import __version__
from nmaptool.core.arrays import Srgb
from nmaptool.core.progress import Progress
from nmaptool.figures.preview import Previewed, film, preview
from nmaptool.io.output.preview_films import FILM_FORMATS
from nmaptool.io.output.targets import Destination, place_of
from nmaptool.io.output.transaction import Metadata, Outputs, wanted
from nmaptool.io.pictures.writer import write_image
from nmaptool.options import PreviewOptions
from nmaptool.options.plain_values import plain_values

PICTURE_ENDINGS = (".png",)


@dataclass(frozen=True, eq=False)
class DrawnPreview:
    """What is written: a picture, or the pictures of a film, which are drawn while they are written.

    Attributes
    ----------
    pictures : iterable of (h, w, 3) uint8
    count : int
        How many.
    progress : callable, optional
    """

    pictures: Iterable[Srgb]
    count: int = 1
    progress: Progress | None = None

    def watched(self) -> Iterable[Srgb]:
        """The pictures; the progress is told."""
        for number, picture in enumerate(self.pictures):
            if self.progress is not None:
                self.progress("drawing", number / self.count)
            yield picture


def drawn(relief: Previewed | Mapping[str, Previewed], options: PreviewOptions) -> DrawnPreview:
    """Draw a picture now, or plan a film."""
    if not options.is_film:
        return DrawnPreview([preview(relief, options)])
    (one,) = relief.values() if isinstance(relief, Mapping) else (relief,)
    return DrawnPreview(film(one, options), options.frames)


def preview_outputs(
    output: Destination | None,
    options: PreviewOptions | None = None,
    *,
    report: Destination | None = None,
    overwrite: bool = False,
) -> Outputs[DrawnPreview]:
    """The plan of `write_preview`."""
    is_film = options is not None and options.is_film
    write: Callable[[DrawnPreview, Path], object] = _write_film if is_film else _write_picture
    endings, what = (tuple(FILM_FORMATS), "a film") if is_film else (PICTURE_ENDINGS, "a preview")
    return Outputs(wanted(output, what, endings, write), place_of(report), overwrite)


def write_preview(
    relief: Previewed | Mapping[str, Previewed],
    output: Destination,
    options: PreviewOptions | None = None,
    *,
    report: Destination | None = None,
    overwrite: bool = False,
    metadata: Metadata | None = None,
) -> None:
    """Write a picture of a relief, or a film.

    Parameters
    ----------
    relief : Height, Relief, NormalMap, Mesh, or a mapping of names to them
        As for `nmaptool.preview`; a film shows one.
    output : str, Path or OutputStream
        .png; films are .webp, .gif or .mp4.
    options : PreviewOptions, optional
    report : str, Path or OutputStream, optional
        .json.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: the options.

    Raises
    ------
    UsageError
        If the extension does not fit, or as `nmaptool.preview`.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 4)), np.ones((2, 3), bool), nm.Frame(2, 3, pitch_mm=0.5))
    >>> nm.write_preview(height, "plate.png", nm.PreviewOptions(material="silver"))
    >>> nm.write_preview(height, "plate.webp", nm.PreviewOptions(turntable=True, frames=4, size=64))
    """
    options = options or PreviewOptions()
    plan = preview_outputs(output, options, report=report, overwrite=overwrite)
    plan.check()
    facts: dict[str, Any] = {"version": __version__, "options": plain_values(options)}
    plan.write(drawn(relief, options), facts if metadata is None else metadata)


def _write_picture(value: DrawnPreview, path: Path) -> None:
    (picture,) = value.watched()
    write_image(np.asarray(picture), path, ("R", "G", "B"), {"kind": "preview", "version": __version__})


def _write_film(value: DrawnPreview, path: Path) -> None:
    FILM_FORMATS[path.suffix.lower()](value.watched(), value.count, path)
