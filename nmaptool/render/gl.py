"""Render the face that each pixel sees, with OpenGL through pyrender: EGL, then OSMesa, then a window."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import LimitError, RendererError
from nmaptool.render.numpy_raster import Draw
from nmaptool.render.offscreen import PLATFORM_VARIABLE, Offscreen
from nmaptool.types.mesh import Faces

# software OpenGL reports 16384 but fails at it; two buffers of four samples per pixel take 100 MB at this size
TILE_PX = 2048
PLATFORMS = ("egl", "osmesa", "window")
_REMEDY = (
    "install the OpenGL libraries (Debian, Ubuntu: sudo apt-get install libegl1 libgl1 libgl1-mesa-dri libxrender1; "
    "Fedora: sudo dnf install mesa-libEGL mesa-libGL mesa-dri-drivers libXrender), or render without them, which is "
    "slower: `renderer='numpy'`"
)


@contextlib.contextmanager
def drawing(renderer: str = "auto") -> Iterator[tuple[Draw, str]]:
    """Open an OpenGL context for any number of renderings; all its resources are freed at the end.

    Parameters
    ----------
    renderer : str
        ``egl``, ``osmesa``, ``window``, or ``auto``: the first of them that works, or the one that the environment
        variable PYOPENGL_PLATFORM names.

    Yields
    ------
    draw, platform
        ``draw``, used like `nmaptool.render.numpy_raster.visible_faces`, and the platform that is used.

    Raises
    ------
    RendererError
        If no context is available; the message says why, and what to install.
    """
    context = _open(renderer)
    try:
        yield lambda points, faces, rows, cols: _draw(context, points, faces, rows, cols), context.platform
    finally:
        context.close()


def _open(renderer: str) -> Offscreen:
    wanted = (renderer,) if renderer != "auto" else PLATFORMS
    chosen = os.environ.get(PLATFORM_VARIABLE)
    if renderer == "auto" and chosen in PLATFORMS:
        wanted = (chosen,)
    reasons = []
    for platform in wanted:
        loaded = {name for name in sys.modules if _is_graphics(name)}
        try:
            return Offscreen(platform)
        except Exception as error:  # noqa: BLE001 - drivers and their bindings raise all kinds of errors
            reasons.append(f"{platform}: {_reason(platform, error)}")
        for name in [name for name in sys.modules if _is_graphics(name) and name not in loaded]:
            del sys.modules[name]  # PyOpenGL binds itself to a platform when it is imported
    raise RendererError(f"no OpenGL context is available ({'; '.join(reasons)}); {_REMEDY}")


def _reason(platform: str, error: Exception) -> str:
    if platform == "osmesa" and isinstance(error, (ImportError, AttributeError)):
        return "needs libosmesa6 and a newer binding, pip install PyOpenGL==3.1.10"
    stated = " ".join(str(error).split()).partition(" (")[0].rstrip(".:;")
    return stated[:90] or type(error).__name__


def _is_graphics(name: str) -> bool:
    return name.partition(".")[0] in ("OpenGL", "pyrender")


def _draw(context: Offscreen, points: Float64, faces: Faces, rows: int, cols: int) -> NDArray[np.int32]:
    """Render the whole picture, in tiles that the renderer can hold."""
    toward = _turned_to_viewer(points, faces)
    near = points[:, 2]
    depth = 0.999 - (near - near.min()) * (1.998 / max(float(np.ptp(near)), 1e-30))
    shown = np.empty((rows, cols), np.int32)
    for top in range(0, rows, TILE_PX):
        for left in range(0, cols, TILE_PX):
            high, wide = min(TILE_PX, rows - top), min(TILE_PX, cols - left)
            clip = np.column_stack(
                [(points[:, 0] - left) * (2 / wide) - 1, 1 - (points[:, 1] - top) * (2 / high), depth]
            ).astype(np.float32)
            number = None
            drawn = toward
            if (high, wide) != (rows, cols):
                number = np.flatnonzero(_touches(clip, toward))
                drawn = toward[number]
            tile = _draw_tile(context, clip, drawn, high, wide)
            shown[top : top + high, left : left + wide] = tile if number is None else _renumbered(tile, number)
    return shown


def _turned_to_viewer(points: Float64, faces: Faces) -> Faces:
    """Orient faces counter-clockwise as seen, because pyrender culls back faces in segmentation."""
    col, row = (np.ascontiguousarray(points[:, axis]) for axis in (0, 1))
    a, b, c = (np.ascontiguousarray(faces[:, k]) for k in range(3))
    left, top = col.take(a), row.take(a)
    away = (col.take(b) - left) * (row.take(c) - top) > (col.take(c) - left) * (row.take(b) - top)  # rows go down
    return np.column_stack([np.where(away, c, a), b, np.where(away, a, c)])


def _touches(clip: NDArray[np.float32], faces: Faces) -> NDArray[np.bool_]:
    """Mask of the faces whose bounding box overlaps the tile."""
    out = np.ones(len(faces), bool)
    for axis in (0, 1):
        corner = clip[:, axis][faces]
        out &= (corner.max(axis=1) >= -1) & (corner.min(axis=1) <= 1)
    return out


def _renumbered(tile: NDArray[np.int32], number: NDArray[np.int64]) -> NDArray[np.int32]:
    out = np.full(tile.shape, -1, np.int32)
    seen = tile >= 0
    out[seen] = number[tile[seen]]
    return out


def _draw_tile(context: Offscreen, clip: NDArray[np.float32], faces: Faces, rows: int, cols: int) -> NDArray[np.int32]:
    if not len(faces):
        return np.full((rows, cols), -1, np.int32)
    color = context.draw(clip, faces, rows, cols)
    if color.shape[-1] < 4 and len(faces) >= 1 << 24:
        raise LimitError(
            f"{len(faces)} faces are more than {context.platform} can number (16777215); use `renderer='egl'`"
        )
    return face_numbers(color)


def face_numbers(color: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Decode face numbers from rendered bytes.

    Parameters
    ----------
    color : (H, W, 3 or 4) uint8
        Number + 1, lowest byte first; where nothing is drawn, black and opaque.

    Returns
    -------
    (H, W) int32
        -1 where nothing was drawn.
    """
    number = color[..., 0].astype(np.int64)
    number |= color[..., 1].astype(np.int64) << 8
    number |= color[..., 2].astype(np.int64) << 16
    if color.shape[-1] == 4:
        number |= np.where((number == 0) & (color[..., 3] == 255), 0, color[..., 3].astype(np.int64) << 24)
    return (number - 1).astype(np.int32)
