"""Read the paths of an SVG file as curves in millimetres."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.curves import flatten_bezier
from nmaptool.core.errors import InputError, LimitError, UsageError, reason_of
from nmaptool.io.opening import read_head
from nmaptool.io.workspaces.plain_xml import Element, parse_xml

_LARGEST = 8 * 1024 * 1024
_MOST_DRAWN = 10_000
_MOST_PIECES = 4096
_PX_PER_INCH = 96.0
_INCHES_PER_MM = 0.0393701  # of svgelements
_PLAIN_DOCTYPE = re.compile(rb"<!DOCTYPE[^\[>]*>")
# ends that are as near as this close a path
_CLOSE_MM = 1e-3
_SAME_MM = 1e-9


@dataclass(frozen=True, eq=False)
class Stretch:
    """One continuous part of a path, flattened.

    Parameters
    ----------
    points : (n, 2) float64
        In mm, y up; of a closed one the last point is not the first again.
    gap_mm : float
        Distance between its ends, 0 if it is closed.
    """

    points: Float64
    gap_mm: float


def read_stretches(path: Path, tolerance_mm: float) -> list[Stretch]:
    """All parts of all paths and shapes of an SVG file.

    Units and the view box of the file are applied; pixels are 1/96 inch. Strokes, fills and pictures do not matter.

    Raises
    ------
    InputError
        If the file is not a readable SVG file, holds texts, or has no paths.
    LimitError
        If it is too large.
    UsageError
        If the tolerance is not a positive number.
    """
    if not (math.isfinite(tolerance_mm) and tolerance_mm > 0):
        raise UsageError(f"`tolerance_mm={tolerance_mm!r}`: must be a number greater than zero")
    data, root = _checked(path)
    mm = _to_mm(root)
    try:
        found = [part for shape in _shapes(data) for part in _stretches(shape, mm, tolerance_mm)]
    except Exception as error:  # a damaged file may raise anything
        if isinstance(error, MemoryError):
            raise
        raise InputError(f"{path}: is damaged; export it again") from None
    if not all(np.isfinite(part.points).all() for part in found):
        raise InputError(f"{path}: has coordinates that are not finite; export it again")
    if not found:
        raise InputError(f"{path}: has no path or shape; draw one, and convert objects to paths")
    return found


def _checked(path: Path) -> tuple[bytes, Element]:
    """The bytes and the first element of an SVG file without entities, texts or too many elements."""
    head, size = read_head(path, 3, "an SVG file", "write it to a file first")
    if head[:2] == b"\x1f\x8b":
        raise InputError(f"{path}: is compressed (.svgz); save it as plain SVG")
    if size > _LARGEST:
        raise LimitError(f"{path}: has {size} bytes, more than {_LARGEST}; simplify the drawing")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason_of(error)})") from None
    data = _PLAIN_DOCTYPE.sub(b"", data, count=1)
    root = parse_xml(data, str(path))
    if _name(root) != "svg":
        raise InputError(f"{path}: is not an SVG file (its first element is <{root.tag}>); save it as plain SVG")
    _check_reuse(root, path)
    texts = sum(_name(element) in ("text", "flowRoot") for element in root.walk())
    if texts:
        what = "a text, which is" if texts == 1 else f"{texts} texts, which are"
        raise InputError(f"{path}: holds {what} not a path; convert it to paths or delete it")
    return data, root


def _name(element: Element) -> str:
    return element.tag.rpartition(":")[2]


def _check_reuse(root: Element, path: Path) -> None:
    """Refuse <use> elements that draw themselves, or very many elements."""
    by_id = {element.attributes["id"]: element for element in root.walk() if "id" in element.attributes}
    counts: dict[int, int] = {}

    def count(element: Element) -> int:
        if id(element) not in counts:
            counts[id(element)] = -1
            total = 1 + sum(count(child) for child in element.children)
            if _name(element) == "use":
                link = element.attributes.get("href", element.attributes.get("xlink:href", ""))
                target = by_id.get(link.removeprefix("#"))
                total += count(target) if target is not None else 0
            counts[id(element)] = total
        if counts[id(element)] < 0:
            raise InputError(f"{path}: a <use> element draws itself; export it again")
        return counts[id(element)]

    try:
        drawn = count(root)
    except RecursionError:
        drawn = _MOST_DRAWN + 1
    if drawn > _MOST_DRAWN:
        raise LimitError(f"{path}: draws more than {_MOST_DRAWN} elements; simplify the drawing")


def _shapes(data: bytes) -> list[Any]:
    """The paths and shapes of a file, with the transforms to px that apply to them."""
    import svgelements

    drawing = svgelements.SVG.parse(io.BytesIO(data), reify=False, ppi=_PX_PER_INCH)
    return [shape for shape in drawing.elements() if isinstance(shape, svgelements.Shape)]


def _to_mm(root: Element) -> float:
    """Millimetres per pixel; if the file has a size in mm, by the millimetre of svgelements, which is 5e-7 too long."""
    in_mm = root.attributes.get("width", "").strip().endswith(("mm", "cm"))
    return 1 / (_PX_PER_INCH * _INCHES_PER_MM) if in_mm else 25.4 / _PX_PER_INCH


def _stretches(shape: Any, mm: float, tolerance_mm: float) -> list[Stretch]:
    """The parts of a path or shape."""
    import svgelements

    m = shape.transform
    matrix = np.array([[m.a, -m.b], [m.c, -m.d], [m.e, -m.f]], np.float64) * mm
    found: list[Stretch] = []
    pieces: list[Float64] = []

    def finish(is_closed: bool) -> None:
        if len(pieces) > 1 or (is_closed and pieces):
            found.append(_stretch(np.concatenate(pieces), is_closed))
        pieces.clear()

    for segment in shape.segments(False):
        if isinstance(segment, svgelements.Move):
            finish(False)
            pieces.append(_points([segment.end]) @ matrix)
            continue
        if not pieces:  # a path may go on after it was closed
            pieces.append(_points([segment.start]) @ matrix)
        if isinstance(segment, svgelements.Close):
            finish(True)
        else:
            pieces.append(_flattened(segment, matrix, tolerance_mm))
    finish(False)
    return found


def _stretch(points: Float64, is_closed: bool) -> Stretch:
    """A part without repeated points; ends that all but meet are closed."""
    if not np.isfinite(points).all():
        return Stretch(points, 0.0)
    keep = np.ones(len(points), bool)
    keep[1:] = np.hypot(*np.diff(points, axis=0).T) > _SAME_MM
    points = points[keep]
    gap = float(np.hypot(*(points[-1] - points[0])))
    if is_closed or (gap <= _CLOSE_MM and len(points) > 2):
        return Stretch(points[:-1] if gap <= _CLOSE_MM and len(points) > 1 else points, 0.0)
    return Stretch(points, gap)


def _points(points: Iterable[Any]) -> Float64:
    """(n, 3) float64: points with a third coordinate of 1, for a matrix."""
    return np.array([(point[0], point[1], 1.0) for point in points], np.float64).reshape(-1, 3)


def _flattened(segment: Any, matrix: Float64, tolerance_mm: float) -> Float64:
    """Points in mm of a line, curve or arc after its start."""
    import svgelements

    if isinstance(segment, svgelements.Arc):
        radius = max(abs(segment.rx), abs(segment.ry)) * float(np.linalg.norm(matrix[:2], 2))
        step = 2 * math.acos(max(1 - tolerance_mm / radius, 0.0)) if radius > 0 else math.inf
        pieces = int(np.clip(math.ceil(abs(segment.sweep) / step), 1, _MOST_PIECES))
        between = segment.npoint(np.linspace(0, 1, pieces + 1)[1:-1]) if pieces > 1 else []
        return np.asarray(_points([*between, segment.end]) @ matrix, np.float64)
    between = [getattr(segment, name) for name in ("control", "control1", "control2") if hasattr(segment, name)]
    return flatten_bezier(_points([segment.start, *between, segment.end]) @ matrix, tolerance_mm)
