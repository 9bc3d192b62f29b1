"""Motifs, designs and helpers of the tests of plates: small maps, short options."""

from __future__ import annotations

from typing import Any

import numpy as np

import nmaptool as nm
from nmaptool.io.fonts import read_font
from nmaptool.options.plates import TextOptions
from nmaptool.types.contours import Contours

FONT = "DejaVu Serif:bold"
LENGTHS = (
    "margin", "corner", "loop", "frame", "frame_height", "pitch", "finest", "text_size", "text_height", "text_inset",
    "width", "height", "base", "hollow", "max_error",
)  # fmt: skip


def lengths(values: dict[str, Any]) -> dict[str, Any]:
    """Options with their lengths read from text."""
    return {name: nm.length(v) if name in LENGTHS and isinstance(v, str) else v for name, v in values.items()}


def star(points: int = 5, outer: float = 20.0, inner: float = 9.0) -> Contours:
    """A star with one point upwards."""
    angle = np.pi / 2 + np.arange(2 * points) * np.pi / points
    away = np.where(np.arange(2 * points) % 2 == 0, outer, inner)
    return Contours((np.column_stack([away * np.cos(angle), away * np.sin(angle)]),))


def ball(rows: int = 64, cols: int = 64, radius: float = 0.8) -> tuple[np.ndarray, np.ndarray]:
    """(rows, cols, 3) normals of a shallow cap in the middle, and its mask."""
    half = min(rows, cols) / 2
    y, x = ((np.arange(n) + 0.5 - n / 2) / half for n in (rows, cols))
    x, y = np.meshgrid(x, -y)
    inside = np.hypot(x, y) < radius
    normals = np.dstack([np.where(inside, 0.6 * x, 0), np.where(inside, 0.6 * y, 0), np.ones(x.shape)])
    return normals, inside


def design(shape: str | None = "round", texts: Any = (), **values: Any) -> nm.PlateDesign:
    """A design from options of plate, frame and machine by name; a star for ``star.svg``."""
    values = lengths(values)
    outline, profile = values.pop("outline", None), values.pop("profile", None)
    if outline is None and shape == "star.svg":
        outline = star()
    made = []
    for kind in (nm.PlateOptions, nm.FrameOptions, nm.MachineOptions):
        names = set(kind.__dataclass_fields__) & set(values)
        own = {name: values.pop(name) for name in names}
        made.append(kind(**({"shape": shape} | own if kind is nm.PlateOptions else own)))
    assert not values, f"no such options: {sorted(values)}"
    texts = tuple(TextOptions(**lengths(text)) for text in texts)
    fonts = {FONT: read_font(FONT)} if texts else {}
    return nm.PlateDesign(made[0], made[1], texts, made[2], fonts, outline, profile)


def made(design_: nm.PlateDesign, motif: Any = None, detail: Any = None, **values: Any) -> nm.Relief:
    """A relief 40 mm wide and 1 mm high on a plate."""
    normals, mask = ball() if motif is None else motif
    width = values.pop("width", "40mm")
    options = nm.ReliefOptions(**lengths({"width": width, "height": "1mm"} | values))
    return nm.plate(normals, detail, options, design=design_, mask=mask)


def solid(relief: nm.Relief, **values: Any) -> nm.Solid:
    """Its solid with a base of 2 mm."""
    return nm.solid(relief, nm.SolidOptions(**lengths({"base": "2mm"} | values)))


def depth_of(relief: nm.Relief, outline: Contours) -> np.ndarray:
    """(rows, cols) float64: distance of the vertices from the edge of a plate, positive inside."""
    from nmaptool.plates.board import Board

    rows, cols = relief.height.frame.shape
    board = Board(0, 0, rows, cols, relief.pitch_mm)
    return board.field(outline, np.inf).depth_mm()


def genus(found: nm.Solid) -> int:
    """Number of handles of a solid of one body: 1 - Euler characteristic / 2."""
    mesh = found.to_mesh()
    edges = np.sort(np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]), axis=1)
    euler = len(mesh.vertices) - len(np.unique(edges, axis=0)) + len(mesh.faces)
    assert euler % 2 == 0
    return 1 - euler // 2


def blob(rows: int = 60, cols: int = 44, seed: int = 1) -> np.ndarray:
    """A crooked motif."""
    from scipy import ndimage

    noise = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal((rows, cols)), 6)
    y, x = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : cols * 1j]
    mask = noise / np.abs(noise).max() - 1.2 * np.hypot(x, y) ** 2 > -0.6
    assert not mask[0].any()
    return mask


def corners_mm(mask: np.ndarray, layout: Any) -> np.ndarray:
    """Corners of the pixels of a motif, from the middle of the plate."""
    rows, cols = np.nonzero(mask)
    x, y = (np.concatenate([each, each, each + 1, each + 1]) for each in (cols, mask.shape[0] - rows - 1))
    y = np.concatenate([y[: len(rows)], y[: len(rows)] + 1] * 2)
    return np.column_stack([x, y]) * layout.pitch_mm - layout.middle_mm
