"""Workspaces as TIFF: one page per layer, with its name and place; OpenImageIO decodes the pixels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray

from nmaptool.core.errors import LimitError
from nmaptool.io.pictures.metadata import PREFIX
from nmaptool.io.pictures.reader import read_pages
from nmaptool.io.pictures.tiff import refuse_unusual
from nmaptool.io.pictures.tiff_pages import tiff_damage_named
from nmaptool.io.workspaces import metadata as metadata
from nmaptool.io.workspaces.limits import MOST_LAYERS, Budget
from nmaptool.io.workspaces.pages import FURTHEST, Page, layers_of, page_attributes, page_metadata
from nmaptool.types.picture import Frame
from nmaptool.types.workspace import MASK_SUFFIX, Workspace

_DPI = 72  # places are stored in inches
_CLASSIC_BYTES = 3_500_000_000  # the format's offsets end at 4 GB
_PAGE_NAME, _X_POSITION, _Y_POSITION, _FULL_COLS, _FULL_ROWS = 285, 286, 287, 33300, 33301
_X_RESOLUTION, _Y_RESOLUTION, _SUBFILE = 282, 283, 254


def write_layered_tiff(workspace: Workspace, path: Path) -> None:
    """Write one page per layer, bottom to top; a mask is a grey page after its layer, called ``NAME [mask]``.

    A page stores its name as PageName and its place as XPosition and YPosition, which cannot be negative. Its
    description holds the exact place and nmaptool's other metadata.
    """
    size = sum(layer.pixels.nbytes + (layer.mask.values.nbytes if layer.mask else 0) for layer in workspace.layers)
    with tifffile.TiffWriter(path, bigtiff=size > _CLASSIC_BYTES) as writer:
        for number, layer in enumerate(workspace.layers):
            said = page_attributes(workspace, number)
            _write(writer, layer.pixels, layer.name, (layer.left, layer.top), workspace.frame, said)
            if layer.mask is not None:
                place, said = (layer.mask.left, layer.mask.top), page_attributes(workspace, number, mask=True)
                _write(writer, layer.mask.values, layer.name + MASK_SUFFIX, place, workspace.frame, said)


def _write(
    writer: tifffile.TiffWriter,
    pixels: NDArray[Any],
    name: str,
    place: tuple[int, int],
    frame: Frame,
    said: Mapping[str, str],
) -> None:
    left, top = (max(n, 0) for n in place)
    writer.write(
        pixels,
        photometric="rgb" if pixels.ndim == 3 else "minisblack",
        extrasamples=["unassalpha"] if pixels.ndim == 3 else None,
        compression="adobe_deflate",
        rowsperstrip=max(1, (1 << 18) // pixels[0].nbytes),
        resolution=(_DPI, _DPI),
        resolutionunit="inch",
        description="\n".join(f"{PREFIX}{key}={value}" for key, value in said.items()).encode("utf-8"),
        software="nmaptool",
        metadata=None,
        subfiletype=2,  # one page of several
        extratags=[
            (_PAGE_NAME, 2, 0, name.encode("utf-8") + b"\0", True),
            (_X_POSITION, 5, 1, (left, _DPI), True),
            (_Y_POSITION, 5, 1, (top, _DPI), True),
            (_FULL_COLS, 4, 1, frame.cols, True),
            (_FULL_ROWS, 4, 1, frame.rows, True),
        ],
    )


@dataclass(frozen=True)
class _Tags:
    """The tags in the directory of a page."""

    cols: int
    rows: int
    name: str
    left: int
    top: int
    full: tuple[int, int]
    reduced: bool


def read_layered_tiff(path: Path, max_megapixels: float) -> Workspace:
    """Read every page as a layer.

    Raises
    ------
    InputError
        If it is damaged or of an unsupported kind.
    LimitError
        If all pages together are over ``max_megapixels``.
    """
    with tiff_damage_named(path):
        directories = _directories(path)
        refuse_unusual(path)
        budget = Budget(path, max_megapixels)
        for tags in directories:
            budget.add(tags.name, tags.cols, tags.rows)
        images = [page.image for page in read_pages(path, max_megapixels)]
        if len(images) != len(directories):
            raise ValueError("the two readers find different numbers of pages")
        kept = [(tags, image) for tags, image in zip(directories, images, strict=True) if not tags.reduced]
        pages = [Page(t.name or f"page {i + 1}", image, t.left, t.top) for i, (t, image) in enumerate(kept)]
        layers, own, orphans = layers_of(pages)
    first = next((said for said in map(page_metadata, images) if said), None)
    return Workspace(
        frame=_canvas([tags for tags, _ in kept], first),
        layers=layers,
        bits=max(image.bits for image in images),
        name=str(path),
        metadata=own,
        color_profile=next((", ".join(image.color_chunks) for image in images if image.color_chunks), None),
        skipped=tuple(orphans),
    )


def _canvas(pages: list[_Tags], first: Mapping[str, Any] | None) -> Frame:
    """The canvas that the file states, else the smallest that holds all pages."""
    size = (first or {}).get("canvas")
    pitch = metadata.pitch_in(first)
    if isinstance(size, list) and len(size) == 2 and all(isinstance(n, int) and 0 < n <= FURTHEST for n in size):
        return Frame(size[1], size[0], pitch)
    cols = max(max(page.left + page.cols, page.full[0]) for page in pages)
    rows = max(max(page.top + page.rows, page.full[1]) for page in pages)
    return Frame(rows, cols, pitch)


def _directories(path: Path) -> list[_Tags]:
    found: list[_Tags] = []
    with tifffile.TiffFile(path) as tiff:
        for page in tiff.pages:
            if len(found) >= MOST_LAYERS:
                raise LimitError(f"{path}: holds more pages than the limit of {MOST_LAYERS}; merge some")
            found.append(_tags(page if isinstance(page, tifffile.TiffPage) else page.aspage()))
    return found


def _tags(page: tifffile.TiffPage) -> _Tags:
    tags = page.tags
    # place and resolution are in the same unit, whichever it is
    left = round(_ratio(tags, _X_POSITION) * _ratio(tags, _X_RESOLUTION))
    top = round(_ratio(tags, _Y_POSITION) * _ratio(tags, _Y_RESOLUTION))
    full = (_number(tags, _FULL_COLS, 0), _number(tags, _FULL_ROWS, 0))
    reduced = bool(_number(tags, _SUBFILE, 0) & 1)
    return _Tags(page.imagewidth, page.imagelength, _text(tags, _PAGE_NAME), left, top, full, reduced)


def _text(tags: Any, code: int) -> str:
    value = tags.valueof(code, "")
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    return str(value).partition("\0")[0] if isinstance(value, str) else ""


def _number(tags: Any, code: int, default: int) -> int:
    value = tags.valueof(code, default)
    return int(value) if isinstance(value, int | np.integer) and 0 <= value <= FURTHEST else default


def _ratio(tags: Any, code: int) -> float:
    value = tags.valueof(code, (0, 1))
    if isinstance(value, tuple) and len(value) == 2 and value[1]:
        found = float(value[0]) / float(value[1])
        return found if abs(found) < 1e6 else 0.0
    return 0.0
