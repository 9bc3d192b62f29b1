"""Layer sets to files, all of them or none: a folder of PNG or EXR files, or one multi-part EXR."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.core.errors import OutputError, UsageError, reason_of
from nmaptool.figures.contact_sheet import contact_sheet
from nmaptool.figures.mixture import mixture_plot
from nmaptool.io.output.maps import curl_image
from nmaptool.io.pictures.layer_pictures import NORMAL_LAYERS, layer_picture
from nmaptool.io.pictures.writer import write_image, write_pictures
from nmaptool.io.replace import check_target, named, written_beside
from nmaptool.io.unfinished import unfinished
from nmaptool.types.layer_set import LayerSet

FORMATS = ("exr", "png")


@dataclass(frozen=True)
class LayerFiles:
    """Where layer sets go.

    Parameters
    ----------
    output : Path
        A folder (made if missing), or a file ``.exr`` that holds all layers as parts.
    format : str
        ``exr`` or ``png``: of the files in a folder.
    depth, faces : bool
        Write these layers too.
    plot : Path or None
        Figure of the mixture, .png.
    report : Path or None
        .json.
    curl : Path or None
        Picture of the base's |curl|, .png.
    views : tuple of str
        Names of the views; several get a folder, or a prefix in a multi-part EXR, each.
    overwrite : bool
        Replace files that exist.
    """

    output: Path
    format: str = "exr"
    depth: bool = False
    faces: bool = False
    plot: Path | None = None
    report: Path | None = None
    curl: Path | None = None
    views: tuple[str, ...] = ("",)
    overwrite: bool = False

    @property
    def is_one_file(self) -> bool:
        """Whether all layers go into one multi-part EXR."""
        return self.output.suffix.lower() == ".exr"

    @property
    def layers(self) -> tuple[str, ...]:
        """Names of the layers that are written."""
        extra = tuple(name for name in ("depth", "faces") if getattr(self, name))
        return (*NORMAL_LAYERS, "coverage", *extra)

    @property
    def sheet(self) -> Path:
        """The contact sheet."""
        if self.is_one_file:
            return self.output.with_name(f"{self.output.stem}_sheet.png")
        return self.output / "sheet.png"

    def place(self, view: str, layer: str) -> Path:
        """The file of one layer of one view in a folder."""
        folder = self.output / view if len(self.views) > 1 else self.output
        return folder / f"{layer}.{self.format}"

    @property
    def targets(self) -> list[Path]:
        """All files: maps first, then the contact sheet, the plot, the picture of the curl and the report."""
        maps = [self.output] if self.is_one_file else [self.place(v, name) for v in self.views for name in self.layers]
        return [*maps, self.sheet, *(p for p in (self.plot, self.curl, self.report) if p is not None)]

    def check(self) -> None:
        """Refuse what could not be written, before any work is done.

        Raises
        ------
        UsageError
            If an ending or format is not offered or a file is named twice.
        OutputError
            If a target cannot be written or exists.
        """
        try:
            self._check_names()
            self._check_places()
        except (OutputError, UsageError):
            raise
        except OSError as error:  # a name too long, a folder that may not be looked into
            raise OutputError(f"{self.output}: cannot be written ({reason_of(error)})") from None

    def _check_names(self) -> None:
        ending = self.output.suffix.lower()
        if self.format not in FORMATS:
            raise UsageError(f"--format {self.format!r}: use one of {', '.join(FORMATS)}")
        if self.is_one_file and self.format != "exr":
            raise UsageError(f"{self.output}: --format {self.format} is for a folder; one file for all layers is EXR")
        if ending and not self.is_one_file and not self.output.is_dir():
            raise UsageError(
                f"{self.output}: layers are written into a folder, such as -o maps --format png (make it first if its "
                "name has a dot), or into one .exr"
            )
        pictures = ((self.plot, ".png", "a plot"), (self.curl, ".png", "a picture of the curl"))
        for path, kind, what in (*pictures, (self.report, ".json", "a report")):
            if path is not None and path.suffix.lower() != kind:
                raise UsageError(f"{path}: {what} is written as {kind}")
        targets = self.targets
        if len({path.resolve() for path in targets}) < len(targets):
            raise UsageError(f"{self.output}: two of the outputs have the same name; give others")

    def _check_places(self) -> None:
        folders, above = self._folders(), self.output.parent
        for folder in folders:
            if folder.exists() and not folder.is_dir():
                raise OutputError(f"{folder}: is a file; layers need a folder of that name; give another")
        if above.exists() and not above.is_dir():
            raise OutputError(f"{self.output}: {above} is a file, not a folder; give another place")
        if not above.exists():
            raise OutputError(f"{self.output}: the folder {above} does not exist; make it first")
        for path in self.targets:
            if path.parent.exists() or path.parent not in folders:
                check_target(path, self.overwrite)

    def _folders(self) -> list[Path]:
        if self.is_one_file:
            return []
        return [self.output, *(self.output / view for view in self.views if len(self.views) > 1)]

    @contextlib.contextmanager
    def folders(self) -> Iterator[None]:
        """The folders made; those that were not there before are removed again where the block fails."""
        made = []
        try:
            for folder in self._folders():
                if not folder.is_dir():
                    try:
                        folder.mkdir()
                    except OSError as error:
                        raise OutputError(f"{folder}: cannot be made ({reason_of(error)})") from None
                    made.append(folder)
            with unfinished(folders=made):
                yield
        except BaseException:
            for folder in reversed(made):
                with contextlib.suppress(OSError):
                    folder.rmdir()
            raise


def write_layers(
    layer_sets: LayerSet | Sequence[LayerSet],
    output: str | Path,
    *,
    format: str = "exr",
    depth: bool = False,
    faces: bool = False,
    plot: str | Path | None = None,
    report: str | Path | None = None,
    curl: str | Path | None = None,
    overwrite: bool = False,
    metadata: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Write layer sets and a contact sheet: all files appear, or none.

    Parameters
    ----------
    layer_sets : LayerSet or sequence of LayerSet
        One a view.
    output : str or Path
        A folder, made if missing, or a file ``.exr`` for all layers as parts of one file.
    format : str
        ``exr`` (float) or ``png`` (16 bit): of the files in a folder.
    depth, faces : bool
        Write these layers too. Depth: EXR in mm, channel Z, transparent where nothing is seen; PNG 16-bit, white at
        the nearest and black at the farthest point, both in the file's metadata. Faces: EXR the number of the face,
        -1 for none; PNG the number + 1 in three bytes, R + 256 G + 65536 B.
    plot : str or Path, optional
        Figure of the mixture, .png.
    report : str or Path, optional
        JSON account of the run.
    curl : str or Path, optional
        Picture of the |curl| of the first view's base, .png: see `nmaptool.curl_picture`.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: the reports of the layer sets.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    UsageError
        If an ending is not offered.
    LimitError
        If face numbers are too large for a picture.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> layers = nm.split(flat)
    >>> len(nm.write_layers(layers, "layers", format="png"))
    5
    """
    sets = [layer_sets] if isinstance(layer_sets, LayerSet) else list(layer_sets)
    views = tuple(layers.report.view for layers in sets)
    plot, report, curl = (Path(p) if p is not None else None for p in (plot, report, curl))
    files = LayerFiles(Path(output), format, depth, faces, plot, report, curl, views, overwrite)
    files.check()
    values = metadata or {"version": __version__, "layers": [layers.report.to_dict() for layers in sets]}
    jobs: list[Callable[[Path], object]] = []
    # pictures are made as they are written: all at once would cost twice the memory
    if files.is_one_file:
        jobs.append(partial(_write_parts, sets=sets, names=files.layers, floating=True))
    else:
        each = [([layers], [name]) for layers in sets for name in files.layers]
        jobs += [partial(_write_parts, sets=one, names=name, floating=format == "exr") for one, name in each]
    jobs.append(partial(_write_look, pixels=lambda: contact_sheet(sets), kind="contact sheet"))
    if files.plot is not None:
        jobs.append(partial(_write_look, pixels=lambda: mixture_plot(sets[0].report.mixture), kind="plot"))
    if files.curl is not None:
        jobs.append(lambda path: write_pictures(path, [curl_image(sets[0].base)]))
    if files.report is not None:
        jobs.append(lambda path: path.write_text(json.dumps(values, indent=2) + "\n"))
    with files.folders(), written_beside(files.targets, overwrite) as beside:
        for job, target, temporary in zip(jobs, files.targets, beside, strict=True):
            with named(target, temporary):
                job(temporary)
    return files.targets


def _write_parts(path: Path, sets: Sequence[LayerSet], names: Sequence[str], floating: bool) -> None:
    """Layers as parts of one file, ``front.original`` where there are several views, or one layer."""
    parts = []
    for layers in sets:
        prefix = f"{layers.report.view}." if len(sets) > 1 else ""
        pictures = (layer_picture(layers, name, floating) for name in names)
        parts += [replace(picture, name=prefix + picture.name) for picture in pictures]
    write_pictures(path, parts)


def _write_look(path: Path, pixels: Callable[[], Any], kind: str) -> None:
    write_image(path, pixels(), ("R", "G", "B"), {"kind": kind, "version": __version__})
