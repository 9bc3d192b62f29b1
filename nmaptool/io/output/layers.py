"""Write layer sets to files: a folder of PNG or EXR files, or one multi-part EXR."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.figures.contact_sheet import contact_sheet
from nmaptool.figures.mixture import mixture_plot
from nmaptool.io.output.map_pictures import curl_image
from nmaptool.io.output.targets import Destination, OutputStream, Place, cannot_be_written, place_of
from nmaptool.io.output.transaction import Metadata, Outputs, Target, wanted
from nmaptool.io.pictures.layer_pictures import NORMAL_LAYERS, layer_picture
from nmaptool.io.pictures.writer import write_image, write_pictures
from nmaptool.options.formats import LAYER_FORMATS
from nmaptool.types.layer_set import LayerSet

_Sets = Sequence[LayerSet]


def layer_outputs(
    output: Destination,
    views: Sequence[str] = ("",),
    *,
    format: str = "exr",
    overwrite: bool = False,
    report: Destination | None = None,
    depth: bool = False,
    faces: bool = False,
    plot: Destination | None = None,
    curl: Destination | None = None,
) -> Outputs[_Sets]:
    """The plan of `write_layers`; several ``views`` get a folder each, or a prefix each in a multi-part EXR."""
    place = place_of(output)
    names = (*NORMAL_LAYERS, "coverage", *(["depth"] if depth else []), *(["faces"] if faces else []))
    is_one_file = place.suffix.lower() == ".exr"
    folders: list[Path] = []
    if isinstance(place, Path) and not is_one_file:
        folders = [place, *(place / view for view in views if len(views) > 1)]
    targets = [
        *(_in_one_file(place, names) if not folders else _in_folders(folders, names, format)),
        *wanted(plot, "a plot", (".png",), _write_plot),
        *wanted(curl, "a picture of the curl", (".png",), _write_curl),
    ]
    outputs: Outputs[_Sets] = Outputs(
        targets, place_of(report), overwrite, folders, "layers are written into a folder; give another name"
    )
    return replace(outputs, rules=[partial(_check_format, place, format), partial(_check_names, place, outputs.paths)])


def _in_one_file(place: Place, names: Sequence[str]) -> Iterator[Target[_Sets]]:
    yield Target(place, "one file of all layers", (".exr",), partial(_write_parts, names=names, floating=True))
    if isinstance(place, Path):
        yield Target(place.with_name(f"{place.stem}_sheet.png"), "a contact sheet", (".png",), _write_sheet)


def _in_folders(folders: Sequence[Path], names: Sequence[str], format: str) -> Iterator[Target[_Sets]]:
    for number, folder in enumerate(folders[1:] or folders):
        for name in names:
            write = partial(_write_layer, number=number, name=name, floating=LAYER_FORMATS.get(format, False))
            yield Target(folder / f"{name}.{format}", "a layer", (f".{format}",), write)
    yield Target(folders[0] / "sheet.png", "a contact sheet", (".png",), _write_sheet)


def _check_format(place: Place, format: str) -> None:
    is_one_file = place.suffix.lower() == ".exr"
    if format not in LAYER_FORMATS:
        raise UsageError(f"`format={format!r}`: use one of {', '.join(LAYER_FORMATS)}")
    if is_one_file and format != "exr":
        raise UsageError(f"{place}: `format={format!r}` applies to a folder; one file for all layers is EXR")
    try:
        is_folder = not isinstance(place, OutputStream) and (not place.suffix or place.is_dir())
    except OSError as error:  # the name is too long
        raise cannot_be_written(place, error) from None
    if not (is_one_file or is_folder):
        raise UsageError(
            f"{place}: layers are written into a folder, such as maps, with `format='png'` (create it first if its "
            "name has a dot), or into one .exr"
        )


def _check_names(place: Place, paths: Sequence[Path]) -> None:
    if len({path.resolve() for path in paths}) < len(paths):
        raise UsageError(f"{place}: two of the outputs have the same name; give different names")


def write_layers(
    layer_sets: LayerSet | Sequence[LayerSet],
    output: Destination,
    *,
    format: str = "exr",
    depth: bool = False,
    faces: bool = False,
    plot: Destination | None = None,
    report: Destination | None = None,
    curl: Destination | None = None,
    overwrite: bool = False,
    metadata: Metadata | None = None,
) -> list[Path]:
    """Write layer sets and a contact sheet: all files appear, or none.

    Parameters
    ----------
    layer_sets : LayerSet or sequence of LayerSet
        One per view.
    output : str, Path or OutputStream
        A folder, created if missing, or an ``.exr`` file with all layers as its parts. With a stream, no contact sheet
        is written.
    format : str
        Format of the files in a folder: ``exr`` (float) or ``png`` (16 bits).
    depth, faces : bool
        Also write these layers. Depth as EXR is in mm in channel Z, transparent where there is no surface; as PNG it
        has 16 bits, white at the nearest and black at the farthest point, with both distances in the metadata. Faces
        as EXR are face numbers, -1 for none; as PNG they are the number + 1 in three bytes, R + 256 G + 65536 B.
    plot : str, Path or OutputStream, optional
        Figure of the mixture, .png.
    report : str, Path or OutputStream, optional
        JSON report of the run.
    curl : str, Path or OutputStream, optional
        Picture of the |curl| of the first view's base, .png: see `nmaptool.curl_picture`.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: the reports of the layer sets.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    UsageError
        If an extension is not supported.
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
    outputs = layer_outputs(
        output,
        format=format,
        depth=depth,
        faces=faces,
        plot=plot,
        report=report,
        curl=curl,
        views=[layers.report.view for layers in sets],
        overwrite=overwrite,
    )
    values = metadata or {"version": __version__, "layers": [layers.report.to_dict() for layers in sets]}
    outputs.write(sets, values)
    return outputs.paths


def _write_parts(sets: _Sets, path: Path, names: Sequence[str], floating: bool) -> None:
    """Write layers as parts of one file, named like ``front.original`` if there are several views."""
    parts = []
    for layers in sets:
        prefix = f"{layers.report.view}." if len(sets) > 1 else ""
        pictures = (layer_picture(layers, name, floating) for name in names)
        parts += [replace(picture, name=prefix + picture.name) for picture in pictures]
    write_pictures(parts, path)


def _write_layer(sets: _Sets, path: Path, number: int, name: str, floating: bool) -> None:
    _write_parts([sets[number]], path, [name], floating)


def _write_look(pixels: Any, path: Path, kind: str) -> None:
    write_image(pixels, path, ("R", "G", "B"), {"kind": kind, "version": __version__})


def _write_sheet(sets: _Sets, path: Path) -> None:
    _write_look(contact_sheet(sets), path, "contact sheet")


def _write_plot(sets: _Sets, path: Path) -> None:
    _write_look(mixture_plot(sets[0].report.mixture), path, "plot")


def _write_curl(sets: _Sets, path: Path) -> None:
    write_pictures([curl_image(sets[0].base)], path)
