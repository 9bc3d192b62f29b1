"""Where the motif lies on its plate, and how large both are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.plates import shapes
from nmaptool.plates.fitting import Drawn, drawn_scale, ellipse_for, enclosing_circle
from nmaptool.plates.sizes import Sizes
from nmaptool.types.contours import Contours
from nmaptool.types.plate import PlateDesign

# share of the picture from which a motif fills it
_FILLS = 0.98
_STEPS = 200
_LARGEST_MM = 1e6
# the smallest motif by the width of its plate
_SMALLEST = 1e-4
_MOST_ELONGATED = 2.0


@dataclass(frozen=True, eq=False)
class Layout:
    """A motif on its plate, in mm from the lower left corner of the picture.

    Attributes
    ----------
    pitch_mm : float
        Size of a pixel of the map.
    width_mm, height_mm : float
        Size of the plate.
    middle_mm : (2,) float64
        Of the plate.
    is_cover : bool
        Whether the picture covers the plate.
    sizes : Sizes
    """

    pitch_mm: float
    width_mm: float
    height_mm: float
    middle_mm: Float64
    is_cover: bool
    sizes: Sizes


class _Motif:
    """The motif of a map in px: what a plate of a given size must hold."""

    def __init__(self, motif: Mask, design: PlateDesign, is_cover: bool) -> None:
        self.design, self.is_cover = design, is_cover
        self.rows, self.cols = motif.shape
        whole = np.array([[0.0, 0.0], [self.cols, 0.0], [self.cols, self.rows], [0.0, self.rows]])
        self.hull = whole if is_cover else shapes.corner_points(motif)
        low, high = self.hull.min(axis=0), self.hull.max(axis=0)
        self.box = high - low
        self.middle: Float64 = (low + high) / 2
        self._pitches: dict[tuple[float, float], float] = {}

    @cached_property
    def circle(self) -> tuple[Float64, float]:
        """Middle and radius of the smallest circle around the motif."""
        return enclosing_circle(self.hull)

    @cached_property
    def drawn(self) -> Drawn:
        """The drawn shape."""
        assert self.design.outline is not None
        return Drawn(self.design.outline)

    @property
    def anchor(self) -> Float64:
        """The point of the picture in px that lies in the middle of the plate (of a drawn shape: of its field)."""
        return self.circle[0] if self.design.plate.shape == "round" and not self.is_cover else self.middle

    def size(self, pitch_mm: float, sizes: Sizes) -> tuple[float, float]:
        """Width and height of the plate that just holds the motif, for pixels of a given size."""
        design, plate = self.design, self.design.plate
        inset = sizes.inset(design, is_cover=self.is_cover)
        w, h = self.box * pitch_mm + 2 * inset
        h += sizes.strip(design) if not self.is_cover else 0.0
        aspect = plate.proportion
        if plate.is_drawn:
            return self._drawn_size(pitch_mm, inset)
        if plate.shape == "round":
            diameter = min(w, h) if self.is_cover else 2 * (self.circle[1] * pitch_mm + inset)
            return diameter, diameter
        if plate.shape == "oval" and not self.is_cover:
            own = float(np.clip(self.box[0] / self.box[1], 1 / _MOST_ELONGATED, _MOST_ELONGATED))
            return ellipse_for((self.hull - self.middle) * pitch_mm, inset, aspect, own)
        if aspect is not None:
            width = min(w, h * aspect) if self.is_cover else max(w, h * aspect)
            return width, width / aspect
        return float(w), float(h)

    def _drawn_size(self, pitch_mm: float, inset: float) -> tuple[float, float]:
        """Of a plate that the picture covers."""
        low, high = self.drawn.contours.bounds_mm
        width, height = self.drawn.size * float(((self.box * pitch_mm + 2 * inset) / (high - low)).min())
        return width, height

    def drawn_plate(self, width_mm: float, pitch_mm: float) -> tuple[float, Sizes, float]:
        """Height and sizes of a drawn plate, and the largest pixels with which the motif fits into its field."""
        factor = width_mm / float(self.drawn.size[0])
        sizes = Sizes(float(self.drawn.size.max()) * factor, pitch_mm)
        inset = sizes.inset(self.design)
        key = (factor, inset)
        if key not in self._pitches:
            self._pitches[key] = drawn_scale(self.drawn, self.hull - self.middle, inset / factor) * factor
        return float(self.drawn.size[1]) * factor, sizes, self._pitches[key]


def lay_out(motif: Mask, design: PlateDesign, *, pitch_mm: float | None, width_mm: float | None) -> Layout:
    """Place a motif on its plate.

    Parameters
    ----------
    motif : (H, W) bool
    design : PlateDesign
    pitch_mm : float, optional
        Size of a pixel; the plate is as large as the motif needs.
    width_mm : float, optional
        Width of the plate; the motif is as large as it can be. One of the two must be given.

    Raises
    ------
    InputError
        If frame, lettering and margin leave no room for the motif.
    """
    if not motif.any():
        raise InputError("the motif is empty; give a `mask` that is white where the motif is")
    is_cover = design.plate.fill == "cover" or (design.plate.fill == "auto" and motif.mean() >= _FILLS)
    if is_cover and design.plate.shape == "mask":
        if design.plate.fill == "cover":
            raise UsageError("`fill='cover'`: is not for `shape='mask'`, whose edge follows the motif")
        is_cover = False
    found = _Motif(motif, design, is_cover)
    is_drawn = design.plate.is_drawn and not is_cover
    if width_mm is None:
        assert pitch_mm is not None
        width, height, sizes = _grown_drawn(found, pitch_mm) if is_drawn else _grown(found, pitch_mm)
    else:
        fitted = _fitted_drawn if is_drawn else _fitted
        pitch_mm, width, height, sizes = fitted(found, width_mm)
    if is_drawn:
        middle = found.anchor * pitch_mm - found.drawn.field_middle(width, sizes.inset(design))
    else:
        middle = found.anchor * pitch_mm
        middle[1] -= sizes.strip(design) / 2 if not is_cover else 0.0
    return Layout(pitch_mm, width, height, middle, is_cover, sizes)


def _grown(motif: _Motif, pitch_mm: float) -> tuple[float, float, Sizes]:
    """Size of the plate around a motif whose pixels have a given size."""
    longer = float(motif.box.max()) * pitch_mm
    largest = _LARGEST_MM
    for _ in range(_STEPS):
        sizes = Sizes(longer, pitch_mm)
        width, height = motif.size(pitch_mm, sizes)
        if max(width, height) > largest:
            _refuse(motif, sizes, longer)
        if abs(max(width, height) - longer) < 1e-9 * longer:
            break
        longer = max(width, height)
    return width, height, Sizes(longer, pitch_mm)


def _fitted(motif: _Motif, width_mm: float) -> tuple[float, float, float, Sizes]:
    """Size of the pixels of a motif on a plate of a given width, and the plate's size."""
    largest = 4 * width_mm / float(motif.box.min())

    def over(pitch_mm: float) -> float:
        return _grown(motif, pitch_mm)[0] - width_mm

    from scipy import optimize  # takes long to load

    smallest = _SMALLEST * width_mm / float(motif.box.max())
    try:
        too_wide = over(smallest) > 0
    except InputError:
        too_wide = True
    if too_wide:
        _refuse(motif, Sizes(width_mm, smallest), width_mm)
    pitch_mm = float(optimize.brentq(over, smallest, largest, xtol=1e-12, rtol=1e-12))
    _, height, sizes = _grown(motif, pitch_mm)
    return pitch_mm, width_mm, height, sizes


def _grown_drawn(motif: _Motif, pitch_mm: float) -> tuple[float, float, Sizes]:
    """As `_grown`, for a drawn shape."""
    from scipy import optimize  # takes long to load

    low = high = float(motif.box.max()) * pitch_mm
    while motif.drawn_plate(high, pitch_mm)[2] < pitch_mm:
        low, high = high, 2 * high
        if high > _LARGEST_MM:
            _refuse(motif, Sizes(low, pitch_mm), low)
    while low > _SMALLEST * high and motif.drawn_plate(low, pitch_mm)[2] > pitch_mm:
        low /= 2
    width = float(optimize.brentq(lambda w: motif.drawn_plate(w, pitch_mm)[2] - pitch_mm, low, high, rtol=1e-10))
    return width, *motif.drawn_plate(width, pitch_mm)[:2]


def _fitted_drawn(motif: _Motif, width_mm: float) -> tuple[float, float, float, Sizes]:
    """As `_fitted`, for a drawn shape."""
    from scipy import optimize  # takes long to load

    largest = 4 * width_mm / float(motif.box.min())
    smallest = _SMALLEST * width_mm / float(motif.box.max())
    if motif.drawn_plate(width_mm, smallest)[2] < smallest:
        _refuse(motif, Sizes(width_mm, smallest), width_mm)
    found = optimize.brentq(lambda p: motif.drawn_plate(width_mm, p)[2] - p, smallest, largest, rtol=1e-12)
    pitch_mm = float(found)
    return pitch_mm, width_mm, *motif.drawn_plate(width_mm, pitch_mm)[:2]


def _refuse(motif: _Motif, sizes: Sizes, width_mm: float) -> None:
    design = motif.design
    parts = {"frame": sizes.frame(design), "lettering": sizes.band(design)}
    parts |= {} if motif.is_cover else {"margin": sizes.margin(design)}
    named = ", ".join(f"{name} {value:.4g} mm" for name, value in parts.items() if value)
    raise InputError(
        f"no room is left for the motif on a plate {width_mm:.4g} mm wide: {named or 'nothing'} on each side; make the "
        "plate wider, or these smaller"
    )


def outline_of(layout: Layout, motif: Mask, design: PlateDesign, spacing_mm: float) -> Contours:
    """The outline of the plate, without holes and loop, in mm from the lower left corner of the picture."""
    plate, sizes = design.plate, layout.sizes
    if plate.shape == "mask":
        found = shapes.motif_outline(motif, layout.pitch_mm, sizes.inset(design), spacing_mm)
        # the offset of pixels is right to a small part of a pixel; the width is exact
        return shapes.scaled_to(found, layout.width_mm, np.inf).moved(*found.bounds_mm.mean(axis=0).tolist())
    if plate.is_drawn:
        assert design.outline is not None
        found = shapes.scaled_to(design.outline, layout.width_mm, spacing_mm)
    elif plate.shape == "round":
        found = shapes.disc(layout.width_mm, spacing_mm)
    elif plate.shape == "oval":
        found = shapes.ellipse(layout.width_mm, layout.height_mm, spacing_mm)
    else:
        corner = 0.0 if plate.corner is None else sizes.mm(plate.corner)
        found = shapes.rectangle(layout.width_mm, layout.height_mm, corner, spacing_mm)
    return found.moved(*layout.middle_mm.tolist())
