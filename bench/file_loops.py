"""The rows of `bench.kernels` for the loops that write and check files of triangles."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from nmaptool import kernels
from nmaptool.io.solids.text import decimals_as_text, wholes_as_text, words_of
from nmaptool.kernels import face_twins, text_twins, triangle_twins

# a band of a large relief
_ROWS, _COLS = 64, 1024
_WORDS = words_of("a # # #\n")


def file_rows(repeats: int, best: Callable[[Callable[[], object], int], float]) -> list[list[str]]:
    """A row of the table for each loop; ``best`` measures the shortest time of some runs in milliseconds."""
    y, x = (each.ravel() * 0.1 for each in np.mgrid[: _ROWS + 1, : _COLS + 1])
    points = np.column_stack([x, y, np.sin(x) + np.cos(y)])
    corner = np.arange(_ROWS * (_COLS + 1)).reshape(_ROWS, -1)[:, :-1].ravel()
    below = corner + _COLS + 1
    faces = np.concatenate(
        [np.column_stack([corner, below, below + 1]), np.column_stack([corner, below + 1, corner + 1])]
    )
    faces = faces.astype(np.int32)
    decimals, wholes = b"".join(decimals_as_text(points, _WORDS)), b"".join(wholes_as_text(faces, _WORDS))
    z = np.ascontiguousarray(points[:, 2]).reshape(_ROWS + 1, -1)
    return [
        _row("falling_diagonals", face_twins, corner.size, partial(_diagonals, z), repeats, best),
        _row("pixel_faces", face_twins, corner.size, _pixels, repeats, best),
        _row("stl_records", triangle_twins, len(faces), partial(_records, points, faces), repeats, best),
        _row("triangle_sums", triangle_twins, len(faces), partial(_sums, points, faces), repeats, best),
        _row("mark_corners", triangle_twins, len(faces), partial(_marks, points, faces), repeats, best),
        _row("decimal_rows", text_twins, len(points), partial(_write, points, (_WORDS, -1)), repeats, best),
        _row("whole_rows", text_twins, len(faces), partial(_write, faces, (1, _WORDS)), repeats, best),
        _row(
            "read_decimal_rows",
            text_twins,
            len(points),
            partial(_read, decimals, points.shape, np.float64),
            repeats,
            best,
        ),
        _row("read_whole_rows", text_twins, len(faces), partial(_read, wholes, faces.shape, np.int32), repeats, best),
    ]


def _row(
    name: str,
    twins: Any,
    count: int,
    work: Callable[[Callable[..., float]], object],
    repeats: int,
    best: Callable[[Callable[[], object], int], float],
) -> list[str]:
    fast, slow = (best(partial(work, getattr(loops, name)), repeats) for loops in (kernels, twins))
    return [name, f"{fast / count * 1e6:.0f} ns a row", f"{fast:.2f}", f"{slow:.2f}", f"{slow / fast:.1f}"]


def _diagonals(z: Any, loop: Callable[..., float]) -> None:
    loop(z, _COLS + 1, 0, np.empty((_ROWS, _COLS), bool))


def _pixels(loop: Callable[..., float]) -> None:
    inside, faces = np.ones((_ROWS, _COLS), bool), np.empty((2 * _ROWS * _COLS, 3), np.int32)
    loop(inside, inside, _COLS + 1, False, faces)


def _records(points: Any, faces: Any, loop: Callable[..., float]) -> None:
    loop(points, faces, np.empty((len(faces), 50), np.uint8))


def _sums(points: Any, faces: Any, loop: Callable[..., float]) -> None:
    sums, counts, edges = np.zeros(7), np.zeros(2, np.int64), np.empty((0, 3), np.int64)
    loop(points, faces.view(np.uint8), 12, 0, np.zeros(3), True, edges, sums, counts)


def _marks(points: Any, faces: Any, loop: Callable[..., float]) -> None:
    loop(faces, np.zeros(len(points), bool))


def _write(values: Any, how: tuple[Any, Any], loop: Callable[..., float]) -> None:
    out, state = np.empty(1 << 20, np.uint8), np.zeros(2, np.int64)
    while len(values):
        loop(values, *how, out, state)
        values = values[state[1] :]


def _read(text: bytes, shape: tuple[int, ...], kind: type[Any], loop: Callable[..., float]) -> None:
    loop(text, _WORDS, 0, np.empty(shape, kind), np.zeros(2, np.int64))
