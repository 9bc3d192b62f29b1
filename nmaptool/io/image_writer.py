"""Writing pictures through OpenImageIO, and reading them back before they are called written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own documentation's name
from numpy.typing import NDArray

from nmaptool.errors import InputError, OutputError
from nmaptool.io.images import PREFIX, error_text, read_image


def write_image(
    path: Path,
    pixels: NDArray[Any],
    channels: tuple[str, ...],
    attributes: Mapping[str, str],
    half: bool = False,
) -> None:
    """Write a picture and read it back; alpha unassociated, no colour-space data, metadata under ``nmaptool:``.

    Parameters
    ----------
    path : Path
        Where to write.
    pixels : (H, W, C) uint8, uint16 or float32
    channels : tuple of str
        One name per channel.
    attributes : mapping
        Metadata; keys without prefix.
    half : bool
        Store float32 as half.

    Raises
    ------
    OutputError
        If writing fails or what is on disk is not what was written.
    """
    rows, cols, count = pixels.shape
    kind = path.suffix.lower()
    stored = "half" if half else {"u1": "uint8", "u2": "uint16", "f4": "float"}[pixels.dtype.str[1:]]
    spec = oiio.ImageSpec(cols, rows, count, stored)
    spec.channelnames = channels
    spec.alpha_channel = channels.index("A") if "A" in channels else -1
    spec.attribute("oiio:UnassociatedAlpha", 1)
    spec.attribute("oiio:ColorSpace", "data")
    spec.attribute("Software", "nmaptool")
    spec.attribute("compression", "zip")
    if kind == ".png":
        spec.attribute("png:compressionLevel", 5)
    if kind in (".tif", ".tiff"):
        spec.attribute("ImageDescription", "\n".join(f"{PREFIX}{k}={v}" for k, v in attributes.items()))
    else:
        for key, value in attributes.items():
            spec.attribute(PREFIX + key, value)
    sink = oiio.ImageOutput.create(f"picture{kind}")
    good = sink is not None and sink.open(str(path), spec) and sink.write_image(np.ascontiguousarray(pixels))
    reason = "" if good else error_text(sink if sink is not None else oiio)
    if sink is not None:
        good = bool(sink.close()) and good
    if good:
        good = _same_on_disk(path, pixels, half)  # the PNG writer calls a full disk a success
    if not good:
        raise OutputError(f"{path}: cannot be written ({reason or 'is the disk full?'})")


def _same_on_disk(path: Path, pixels: NDArray[Any], half: bool) -> bool:
    try:
        back = read_image(path, max_megapixels=float("inf")).pixels
    except InputError:
        return False
    expected = pixels.astype(np.float16).astype(np.float32) if half else pixels
    return bool(back.shape == expected.shape and np.array_equal(back, expected, equal_nan=expected.dtype.kind == "f"))
