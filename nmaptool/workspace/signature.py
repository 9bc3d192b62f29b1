"""The signature of a layer: a small picture of its vectors, their quantiles and their curl when it was packed."""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.vectors import mean_abs_curl, unit

CELLS = 16
_QUANTILES = 65
_SMOOTH_PX = 2.0
# pixels with less alpha are not content: editors leave such traces when they resample
_CLEAR = 0.02
_SAMPLE = 200_000


@dataclass(frozen=True, eq=False)
class Signature:
    """The appearance of a layer when it was packed.

    Parameters
    ----------
    box : tuple of int
        (left, top, cols, rows) of the pixels that are not transparent, on the canvas.
    cells : (16, 16, 4) float32
        Mean (n + 1)/2 over the covered pixels in each cell of the box, and the share covered.
    quantiles : (65, 3) float32
        Quantiles of (n + 1)/2 over the covered pixels.
    mean_curl : float
        Mean |curl| of the smoothed normals, in slope per px.
    """

    box: tuple[int, int, int, int]
    cells: Float32
    quantiles: Float32
    mean_curl: float

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; the pictures as 16-bit codes in base64."""
        return {
            "box": list(self.box),
            "cells": _packed(self.cells),
            "quantiles": _packed(self.quantiles),
            "mean_curl": self.mean_curl,
        }


def _packed(values: Float32) -> str:
    return base64.b64encode(np.rint(values.clip(0, 1) * 65535).astype(">u2").tobytes()).decode("ascii")


def _unpacked(text: object, shape: tuple[int, ...]) -> Float32 | None:
    if not isinstance(text, str) or len(text) > 8 * math.prod(shape):
        return None
    try:
        raw = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        return None
    if len(raw) != 2 * math.prod(shape):
        return None
    return (np.frombuffer(raw, ">u2").reshape(shape) / 65535).astype(np.float32)


def signature_from(facts: Mapping[str, Any]) -> Signature | None:
    """Read the signature from a layer's metadata; None if it is missing or invalid."""
    box, curl = facts.get("box"), facts.get("mean_curl")
    cells = _unpacked(facts.get("cells"), (CELLS, CELLS, 4))
    quantiles = _unpacked(facts.get("quantiles"), (_QUANTILES, 3))
    if not isinstance(box, list) or len(box) != 4 or cells is None or quantiles is None:
        return None
    if not all(isinstance(n, int) and abs(n) < 2**31 for n in box) or box[2] < 1 or box[3] < 1:
        return None
    if isinstance(curl, bool) or not isinstance(curl, int | float) or not (math.isfinite(curl) and curl >= 0):
        return None
    return Signature((box[0], box[1], box[2], box[3]), cells, quantiles, float(curl))


def content_box(alpha: Float32, left: int = 0, top: int = 0) -> tuple[int, int, int, int]:
    """(left, top, cols, rows) of the pixels that are not transparent; of all pixels if all are transparent.

    >>> content_box(np.float32([[0, 0, 0], [0, 1, 1]]), left=10)
    (11, 1, 2, 1)
    """
    seen = alpha > _CLEAR
    rows, cols = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    if not rows.size:
        return left, top, alpha.shape[1], alpha.shape[0]
    return (
        left + int(cols[0]),
        top + int(rows[0]),
        int(cols[-1] - cols[0]) + 1,
        int(rows[-1] - rows[0]) + 1,
    )


def sign(codes: Float32, alpha: Float32, normals: Float32, left: int, top: int) -> Signature:
    """Compute the signature of a layer.

    Parameters
    ----------
    codes : (h, w, 3) float32
        (n + 1)/2 as stored.
    alpha : (h, w) float32
        0 to 1.
    normals : (h, w, 3) float32
        Unit normals.
    left, top : int
        Position on the canvas.
    """
    box = content_box(alpha, left, top)
    rows = slice(box[1] - top, box[1] - top + box[3])
    cols = slice(box[0] - left, box[0] - left + box[2])
    covered = alpha > 0.5
    return Signature(
        box,
        cells(codes[rows, cols], alpha[rows, cols]),
        quantiles(codes, covered if covered.any() else np.ones_like(covered)),
        mean_abs_curl(smoothed(normals), covered),
    )


def smoothed(normals: Float32) -> Float32:
    """Smooth normals to their large forms; the curl of fine texture is mostly rendering noise."""
    return unit(cv2.GaussianBlur(normals, (0, 0), _SMOOTH_PX))


def cells(codes: Float32, alpha: Float32) -> Float32:
    """(16, 16, 4): mean code over the covered pixels in each cell, and the share covered."""
    weighted = np.dstack([codes * alpha[..., None], alpha])
    small = _area_mean(weighted)
    share = small[..., 3:]
    color = np.divide(small[..., :3], share, out=np.full_like(small[..., :3], 0.5), where=share > 1e-3)
    return np.dstack([color.clip(0, 1), share.clip(0, 1)]).astype(np.float32)


def _area_mean(picture: Float32) -> Float32:
    rows, cols = picture.shape[:2]
    if rows < CELLS or cols < CELLS:  # an area mean needs a pixel in every cell
        size = (max(cols, CELLS), max(rows, CELLS))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_NEAREST)
    return np.asarray(cv2.resize(picture, (CELLS, CELLS), interpolation=cv2.INTER_AREA), np.float32)


def quantiles(codes: Float32, covered: Mask) -> Float32:
    """(65, 3): evenly spaced quantiles of the covered codes, from the smallest to the largest."""
    values = codes[covered]
    values = values[:: max(1, len(values) // _SAMPLE)]
    found: NDArray[Any] = np.quantile(values, np.linspace(0, 1, _QUANTILES), axis=0)
    return found.astype(np.float32)
