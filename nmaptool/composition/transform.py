"""Crop, mirror, resize, rotate and pad a map: pixels and vectors together."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from nmaptool.composition.compositor import mix_normals
from nmaptool.composition.placement import (
    Piece,
    bounds,
    default_height_factor,
    is_exact,
    is_uneven,
    linear_part,
    map_piece,
    scale_factors,
    turn_vectors,
)
from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, LimitError
from nmaptool.core.vectors import FLAT, mean_abs_curl
from nmaptool.options import TransformOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.types.composition import ComposeReport, Composition
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame


def transform(
    normal_map: NormalsLike, options: TransformOptions | None = None, *, max_megapixels: float = 270.0
) -> Composition:
    """Crop, mirror, resize, rotate and pad a map together with its vectors (slopes by the inverse transpose).

    Parameters
    ----------
    normal_map : NormalMap or (H, W, 3) float of any type
    options : TransformOptions, optional
        Crop, mirrors, scale, rotation, borders.
    max_megapixels : float
        Limit of the result's size.

    Returns
    -------
    Composition
        Crops, borders, mirrors and quarter turns are bit-exact.

    Raises
    ------
    UsageError
        If a length is in mm and the pitch is unknown, or the map is neither a NormalMap nor an array.
    InputError
        If the crop is not inside the picture, or the result is empty.
    LimitError
        If the result is larger than ``max_megapixels``.

    Examples
    --------
    A mirrored slope rises in the opposite direction:

    >>> normals = np.zeros((4, 6, 3))
    >>> normals[...] = 0.6, 0, 0.8
    >>> nm.transform(normals, nm.TransformOptions(flip_h=True)).normal_map.normals[0, 0].tolist()
    [-0.6000000238418579, 0.0, 0.800000011920929]
    """
    normal_map = as_normal_map(normal_map)
    o = options or TransformOptions()
    start = time.perf_counter()
    frame = normal_map.frame
    if o.width is not None:
        frame = replace(frame, pitch_mm=o.width.to_mm(1.0, 1) / frame.cols)
    before = mean_abs_curl(normal_map.normals, normal_map.coverage >= 0.5)
    source = Piece(normal_map.normals, normal_map.coverage, normal_map.foreground)
    flat_ground = o.ground == "flat" or (o.ground == "auto" and _is_motif_on_plate(normal_map))
    linear = _linear(o, frame)
    factor = default_height_factor(linear) if o.height_factor is None else o.height_factor
    if o.vectors_only:
        turned = turn_vectors(source.normals, linear, factor)
        piece, result_frame = replace(source, normals=_flat_where_nothing(turned, source)), frame
    else:
        source, frame = _cropped(source, o, frame, normal_map.name)
        if o.new_size is not None:
            linear = _resizing(linear, o.new_size, frame)
            factor = default_height_factor(linear) if o.height_factor is None else o.height_factor
        matrix, result_frame = _canvas(linear, o, frame, max_megapixels, normal_map.name)
        window = (0, 0, result_frame.cols, result_frame.rows)
        piece = map_piece(source, matrix, window, factor, normal_map.name)
        if flat_ground:
            piece = _on_plate(piece)
    result = replace(
        normal_map,
        normals=piece.normals,
        coverage=piece.coverage,
        frame=result_frame,
        foreground=piece.foreground,
        flat_background=normal_map.flat_background or (o.ground == "flat" and not o.vectors_only),
    )
    report = ComposeReport(
        command="transform",
        options={**plain_values(o), "matrix": linear.tolist(), "height_factor": factor},
        curl_before=before,
        curl_after=mean_abs_curl(result.normals, result.coverage >= 0.5),
        seconds={"transform": round(time.perf_counter() - start, 4)},
        warnings=_warnings(linear, o),
    )
    return Composition(result, result.coverage, report)


def _warnings(linear: Float64, o: TransformOptions) -> tuple[str, ...]:
    """Return warnings about effects that may be unintended: heights kept when the picture is stretched."""
    scales = np.linalg.svd(linear, compute_uv=False)
    if o.height_factor is not None or not is_uneven(scales):
        return ()
    across, down = (1 / float(np.linalg.norm(linear[:, axis])) for axis in range(2))
    even = float(np.sqrt(scales.prod()))
    stated = (
        f"the picture is stretched unevenly and keeps its heights, so its slopes are multiplied by {across:.3g} across "
        f"and {down:.3g} down; `height_factor={even:.3g}` keeps them on average"
    )
    return (stated,)


def _is_motif_on_plate(normal_map: NormalMap) -> bool:
    """Whether the map is defined everywhere and its motif does not fill it."""
    return bool((normal_map.coverage == 1).all() and not normal_map.foreground.all())


def _linear(o: TransformOptions, frame: Frame) -> Float64:
    """Return scale, mirrors, rotation and the given matrix as one matrix, without a resize to a size in px."""
    factors = scale_factors(o.factors, frame, frame.cols)
    if o.affine is None:
        return linear_part(factors, o.flip_h, o.flip_v, o.rotate)
    return np.array(o.matrix).reshape(2, 2) @ linear_part(factors, o.flip_h, o.flip_v, o.rotate)


def _resizing(linear: Float64, size: tuple[int, int], frame: Frame) -> Float64:
    return linear @ np.diag([size[0] / frame.cols, size[1] / frame.rows])


def _cropped(source: Piece, o: TransformOptions, frame: Frame, name: str) -> tuple[Piece, Frame]:
    if o.window is None:
        return source, frame
    sides = (frame.cols, frame.rows) * 2
    left, top, cols, rows = (round(d.to_px(frame.pitch_mm, side)) for d, side in zip(o.window, sides, strict=True))
    if min(left, top) < 0 or left + cols > frame.cols or top + rows > frame.rows or min(cols, rows) < 1:
        raise InputError(
            f"{name}: `crop={o.crop!r}` is {cols} x {rows} px at {left},{top}, which is not inside the picture of "
            f"{frame} px; to enlarge a picture, use `pad`"
        )
    part = np.s_[top : top + rows, left : left + cols]
    piece = Piece(source.normals[part], source.coverage[part], source.foreground[part])
    return piece, replace(frame, rows=rows, cols=cols)


def _canvas(
    linear: Float64, o: TransformOptions, frame: Frame, max_megapixels: float, name: str
) -> tuple[Float64, Frame]:
    """Return the matrix onto the canvas of the result, and its frame."""
    across, down = frame.cols, frame.rows
    matrix = np.column_stack([linear, np.zeros(2)])
    left, top, right, bottom = bounds(matrix, across, down)
    cols, rows = right - left, bottom - top
    matrix[:, 2] = np.array([cols, rows]) / 2 - linear @ np.array([across, down]) / 2  # centred
    if o.keep_size:
        matrix[:, 2] += np.array([across - cols, down - rows]) / 2
        cols, rows = across, down
    if is_exact(linear):
        matrix[:, 2] = np.floor(matrix[:, 2] + 0.5)
    sides = (cols, rows, cols, rows)
    pad = [round(d.to_px(frame.pitch_mm, side)) for d, side in zip(o.borders, sides, strict=True)]
    matrix[:, 2] += pad[:2]
    cols, rows = cols + pad[0] + pad[2], rows + pad[1] + pad[3]
    if cols < 1 or rows < 1:
        raise InputError(f"{name}: the result would have no pixels; use a larger `scale`")
    if cols * rows > max_megapixels * 1e6:
        raise LimitError(
            f"{name}: the result of {cols} x {rows} px exceeds the limit of {max_megapixels:g} megapixels; make it "
            "smaller or raise `max_megapixels`"
        )
    pitch = frame.pitch_mm
    if pitch is not None and o.new_size is not None:
        pitch /= default_height_factor(linear)
    return matrix, Frame(rows, cols, pitch)


def _on_plate(piece: Piece) -> Piece:
    """Return a piece on a flat plate, which is a defined part of the map."""
    flat = np.empty_like(piece.normals)
    flat[...] = FLAT
    normals = mix_normals(flat, piece.normals, piece.coverage)
    return replace(piece, normals=normals, coverage=np.ones_like(piece.coverage))


def _flat_where_nothing(normals: np.ndarray, piece: Piece) -> np.ndarray:
    nothing = piece.coverage <= 0
    return np.where(nothing[..., None], np.array(FLAT, np.float32), normals) if nothing.any() else normals
