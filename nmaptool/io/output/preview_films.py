"""Film files: animated WebP and GIF, and MP4."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.core.arrays import Srgb
from nmaptool.core.errors import OutputError, reason_of

# a film takes this long, unless its pictures would follow each other too quickly for a GIF
_SECONDS = 4.0
_SHORTEST_MS = 20
_QUALITY = 86
_FOURCC = "mp4v"


def frame_ms(count: int) -> int:
    """Milliseconds of each of a film's pictures, in whole hundredths of a second, as a GIF holds them.

    >>> frame_ms(36), frame_ms(1000)
    (110, 20)
    """
    return max(_SHORTEST_MS, round(100 * _SECONDS / count) * 10)


def _write_webp(pictures: Iterable[Srgb], count: int, path: Path) -> None:
    _write_frames(pictures, count, path, {"quality": _QUALITY, "method": 3})


def _write_gif(pictures: Iterable[Srgb], count: int, path: Path) -> None:
    _write_frames(pictures, count, path, {"optimize": False, "disposal": 1})


def _write_frames(pictures: Iterable[Srgb], count: int, path: Path, settings: dict[str, Any]) -> None:
    from PIL import Image, features

    if path.suffix.lower() == ".webp" and not features.check("webp"):
        raise OutputError(f"{path}: this Pillow has no WebP encoder; write a .gif or an .mp4")
    images: Iterator[Any] = (Image.fromarray(picture) for picture in pictures)
    if path.suffix.lower() == ".gif":
        images = (image.convert("P", palette=Image.Palette.ADAPTIVE, colors=256) for image in images)
    first = next(images)
    try:
        first.save(path, save_all=True, append_images=images, duration=frame_ms(count), loop=0, **settings)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None


def _write_mp4(pictures: Iterable[Srgb], count: int, path: Path) -> None:
    import cv2

    frames = iter(pictures)
    first = next(frames)
    # its colours are stored for blocks of 2 x 2 pixels
    rows, cols = (side - side % 2 for side in first.shape[:2])
    film = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*_FOURCC), 1000 / frame_ms(count), (cols, rows))
    if not film.isOpened():
        raise OutputError(f"{path}: this OpenCV has no encoder for MP4; write a .webp or a .gif")
    for picture in chain([first], frames):
        film.write(np.ascontiguousarray(picture[:rows, :cols, ::-1]))
    film.release()
    found = cv2.VideoCapture(str(path))
    written = int(found.get(cv2.CAP_PROP_FRAME_COUNT)) if found.isOpened() else 0
    found.release()
    if written != count:
        raise OutputError(f"{path}: cannot be written (holds {written} of {count} pictures; is the disk full?)")


FILM_FORMATS: dict[str, Callable[[Iterable[Srgb], int, Path], None]] = {
    ".webp": _write_webp,
    ".gif": _write_gif,
    ".mp4": _write_mp4,
}
