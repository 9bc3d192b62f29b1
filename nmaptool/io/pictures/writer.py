"""Write pictures through OpenImageIO and read them back to check them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - the name in its documentation
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, OutputError
from nmaptool.io.compression import PICTURES
from nmaptool.io.pictures.metadata import PREFIX, one_line
from nmaptool.io.pictures.reader import PlacedImage, read_image, read_pages
from nmaptool.io.pictures.through_oiio import error_text


@dataclass(frozen=True, eq=False)
class Picture:
    """The content of one picture, or of one part of a multi-part EXR.

    Attributes
    ----------
    pixels : (H, W, C) uint8, uint16 or float32
        Alpha unassociated.
    channels : tuple of str
        One name per channel.
    attributes : mapping
        Metadata; keys without prefix.
    name : str
        Name of the part.
    half : bool
        Store float32 as half.
    window : tuple of int, optional
        EXR: (left, top) of the picture in a display window of (cols, rows).
    """

    pixels: NDArray[Any]
    channels: tuple[str, ...]
    attributes: Mapping[str, str]
    name: str = ""
    half: bool = False
    window: tuple[int, int, int, int] | None = None


def write_image(
    pixels: NDArray[Any],
    path: Path,
    channels: tuple[str, ...],
    attributes: Mapping[str, str],
    half: bool = False,
) -> None:
    """Write one picture with `write_pictures`."""
    write_pictures([Picture(pixels, channels, attributes, half=half)], path)


def write_pictures(pictures: Sequence[Picture], path: Path) -> None:
    """Write pictures and read them back; no colour-space data, metadata under ``nmaptool:``.

    Parameters
    ----------
    pictures : sequence of Picture
        Several pictures become the parts of an EXR.
    path : Path

    Raises
    ------
    OutputError
        If writing fails, or the file on disk differs from what was written.
    """
    specs = [_spec(path.suffix.lower(), picture) for picture in pictures]
    if len(specs) > 1:
        for spec, picture in zip(specs, pictures, strict=True):
            spec.attribute("oiio:subimagename", picture.name)
    sink: Any = oiio.ImageOutput.create(f"picture{path.suffix.lower()}")
    if sink is None:
        raise OutputError(f"{path}: cannot be written ({error_text(oiio)})")
    good = sink.open(str(path), tuple(specs) if len(specs) > 1 else specs[0])
    for number, picture in enumerate(pictures):
        if number:
            good = good and sink.open(str(path), specs[number], "AppendSubimage")
        good = good and sink.write_image(np.ascontiguousarray(picture.pixels))
    reason = "" if good else error_text(sink)
    good = bool(sink.close()) and good
    if good:  # the PNG writer reports success on a full disk
        placed = any(picture.window is not None for picture in pictures)
        back = _placed_on_disk(path) if placed else None
        good = all(_same_on_disk(path, picture, len(specs) > 1, back) for picture in pictures)
    if not good:
        raise OutputError(f"{path}: cannot be written ({reason or 'is the disk full?'})")


def _spec(kind: str, picture: Picture) -> Any:
    rows, cols, count = picture.pixels.shape
    stored = "half" if picture.half else {"u1": "uint8", "u2": "uint16", "f4": "float"}[picture.pixels.dtype.str[1:]]
    spec = oiio.ImageSpec(cols, rows, count, stored)
    if picture.window is not None:
        spec.x, spec.y, spec.full_width, spec.full_height = picture.window
    spec.channelnames = picture.channels
    spec.alpha_channel = picture.channels.index("A") if "A" in picture.channels else -1
    spec.attribute("oiio:UnassociatedAlpha", 1)
    spec.attribute("oiio:ColorSpace", "data")
    spec.attribute("Software", "nmaptool")
    for key, value in PICTURES.get(kind, {}).items():
        spec.attribute(key, value)
    if kind in (".tif", ".tiff"):
        lines = (f"{PREFIX}{key}={one_line(value)}" for key, value in picture.attributes.items())
        spec.attribute("ImageDescription", "\n".join(lines))
    else:
        for key, text in picture.attributes.items():
            spec.attribute(PREFIX + key, text)
    return spec


def _placed_on_disk(path: Path) -> list[PlacedImage]:
    try:
        return read_pages(path, max_megapixels=float("inf"))
    except InputError:
        return []


def _same_on_disk(path: Path, picture: Picture, named: bool, placed: list[PlacedImage] | None) -> bool:
    if placed is not None:
        found = [page for page in placed if not named or page.image.layer == picture.name]
        windows = [(page.left, page.top, page.cols, page.rows) for page in found]
        return windows == [picture.window] and _equal(found[0].image.pixels, picture)
    try:
        back = read_image(path, picture.name if named else None, max_megapixels=float("inf")).pixels
    except InputError:
        return False
    return _equal(back, picture)


def _equal(back: NDArray[Any], picture: Picture) -> bool:
    expected = picture.pixels.astype(np.float16).astype(np.float32) if picture.half else picture.pixels
    if back.shape != expected.shape:
        return False
    if back.dtype == expected.dtype == np.float32 and np.array_equal(back.view(np.uint32), expected.view(np.uint32)):
        return True  # the same bits, which is quicker to tell than equal numbers or NaN
    return bool(np.array_equal(back, expected, equal_nan=expected.dtype.kind == "f"))
