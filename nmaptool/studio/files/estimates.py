"""What an export will be: its size in mm, its triangles and the size of its file, before it is made."""

from __future__ import annotations

import dataclasses
from typing import Any

from nmaptool.core.progress import Progress
from nmaptool.io.solids.sizes import about_bytes, exact_bytes
from nmaptool.options import SolidOptions
from nmaptool.shading.field import picture_shape
from nmaptool.solids.solid import solid
from nmaptool.studio.document import Document
from nmaptool.studio.engine import PREVIEW_TOLERANCE, Engine
from nmaptool.studio.files.export import Wanted
from nmaptool.types.relief import Relief

# bytes per sample of pictures, measured on reliefs of one to four megapixels; their compression decides
_PER_SAMPLE = {".png": 1.1, ".exr": 2.5, ".tif": 1.7, "preview": 0.65}
# header of a .npy file, bytes of a height, and of a record of height and mask
_NPY_HEADER, _NPY_CENTER, _NPY_CORNER = 128, 8, 9


def estimate(engine: Engine, document: Document, wanted: Wanted, progress: Progress | None = None) -> dict[str, Any]:
    """Return the message that tells a page what the export of a document will be.

    It comes from the heights that the page shows, which are exact to the tolerance of the preview.

    Parameters
    ----------
    engine : Engine
        With the maps of the document.
    document : Document
    wanted : Wanted
    progress : callable, optional
        An exception that it raises ends the estimate.

    Raises
    ------
    NmaptoolError
        If the relief cannot be solved or made into triangles.
    """
    head = {"kind": "estimate", "format": wanted.format, "at": wanted.at}
    if document.plate is not None:
        return {**head, "text": "its size is known once it is made, with its plate or for its machine"}
    solved = engine.full.solve(document.options, preview_tolerance=PREVIEW_TOLERANCE, progress=progress)
    found = _mesh(solved, document.solid, wanted) if wanted.kind == "mesh" else _picture(solved, wanted)
    return {**head, **found}


def _mesh(solved: Relief, options: SolidOptions, wanted: Wanted) -> dict[str, Any]:
    """Size, triangles and bytes of a mesh; at most those if triangles are left out."""
    body = solid(solved, dataclasses.replace(options, max_error=None, triangles=None))
    faces, limit = body.face_count, options.triangle_count
    thins = options.max_error is not None or (limit is not None and limit < faces)
    if limit is not None:
        faces = min(faces, limit)
    size = None if thins else exact_bytes(wanted.ending, body)
    is_exact = size is not None or (thins and wanted.format == "stl")
    return {
        "size_mm": body.size_mm,
        "triangles": faces,
        "bytes": about_bytes(wanted.ending, faces) if size is None else size,
        "precision": ("at most" if thins else "exact") if is_exact else "about",
        "at_most": thins,
        "is_closed": body.is_closed,
    }


def _picture(solved: Relief, wanted: Wanted) -> dict[str, Any]:
    """Size, grid and bytes of a picture."""
    frame = solved.height.frame
    low, high = solved.height.range_mm
    is_preview = wanted.kind == "picture"
    more = int(wanted.at == "corners" and not is_preview)
    rows, cols = picture_shape(*frame.shape) if is_preview else (frame.rows + more, frame.cols + more)
    if wanted.format == "npy":
        size, precision = float(_NPY_HEADER + rows * cols * (_NPY_CORNER if more else _NPY_CENTER)), "exact"
    else:
        per_sample = _PER_SAMPLE.get("preview" if is_preview else wanted.ending, 0.0)
        size, precision = per_sample * rows * cols, "about"
    return {
        "size_mm": (frame.cols * solved.height.pitch_mm, frame.rows * solved.height.pitch_mm, high - low),
        "grid": (cols, rows),
        "bytes": size,
        "precision": precision,
    }
