"""The background of a picture: alpha, white, grey, black, flat, or a colour that is not a normal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.core.grid import dilated
from nmaptool.core.parallel import for_each_band
from nmaptool.maps.patches import big_patches, edge_patches, without_specks
from nmaptool.maps.zero_code import flat_codes, has_color
from nmaptool.types.picture import RasterImage

# smallest share of all patches of an impossible colour
_MIN_TOTAL_SHARE = 2e-3
# a flat background must have a patch that reaches this many sides: flat is a valid normal, so it needs more proof
_FLAT_SIDES = 3
# tolerances in steps of an 8-bit code: around impossible colours, around flat, and both in JPEG
_TOLERANCE, _FLAT_NOISE, _LOSSY_TOLERANCE, _LOSSY_FLAT = 3.0, 2.5, 8.0, 4.0
# noise around flat: its mean over a window is flat, and it varies more than that mean
_NOISE_WINDOW_PX = (15, 15)
_NOISE_MEAN = 0.75
_NOISE_ROUGHNESS = 0.1
_ALL_OVER = 0.995
# flat patches on less than this share of the edge are not a background if the pixels around them are almost flat, at
# least this share of them
_SURE_EDGE, _FADING = 0.5, 0.95
# any colour that is not a normal is a background if it fills this much of the edge and of the picture
_ODD_EDGE_SHARE, _ODD_SHARE, _ODD_LENGTH = 0.3, 0.05, 0.1
_DATA_ALPHA_SHARE = 0.3
# rows that decide whether an edge is noisy; more than the windows around a pixel reach
_STRIP_PX = 32
_PIXELS_AT_ONCE = 1 << 16
_ROWS_AT_ONCE = 16


@dataclass(frozen=True, eq=False)
class Background:
    """A background: its kind, its pixels (H, W bool), its stored colour (None for alpha), a warning if it is unsure."""

    kind: str
    mask: Mask
    codes: tuple[float, ...] | None = None
    warning: str | None = None


def alpha_is_data(image: RasterImage) -> bool:
    """Whether alpha varies like a height or gloss channel instead of covering a motif; never in files of nmaptool."""
    alpha = image.alpha
    if alpha is None or image.attributes.get("kind") == "normal":
        return False
    partial = 0
    for row in range(0, len(alpha), _ROWS_AT_ONCE):
        band = alpha[row : row + _ROWS_AT_ONCE]
        partial += int(np.count_nonzero((band > 0.02) & (band < 0.98)))
    return partial > _DATA_ALPHA_SHARE * alpha.size


@dataclass(frozen=True)
class Span:
    """The stored values of -1 and 1 in a picture of (H, W, 3) components, which may be floats from 0 to 1."""

    low: float
    top: float

    @property
    def middle(self) -> float:
        """The value halfway between."""
        return (self.low + self.top) / 2

    @property
    def step(self) -> float:
        """The distance between two 8-bit codes."""
        return (self.top - self.low) / 255


def span_of(image: RasterImage, xyz: NDArray[Any]) -> Span:
    """The stored values of -1 and 1, for floats from 0 if none is negative."""
    return Span(-1.0 if image.is_float and float(xyz.min()) < -1e-3 else 0.0, float(image.max_code))


def impossible_colors(span: Span) -> dict[str, tuple[float, ...]]:
    """Stored colours that are not normals and mean "nothing here"."""
    colors: dict[str, tuple[float, ...]] = {"white": (span.top,) * 3, "black": (0.0,) * 3}
    if span.low == 0:
        colors["grey"] = (span.middle + span.step / 2,) * 3
    return colors


def hex_codes(text: str, span: Span, order: tuple[int, ...]) -> tuple[float, ...]:
    """A colour #rrggbb as stored values of x, y and z."""
    eight = [int(text[1 + 2 * channel : 3 + 2 * channel], 16) for channel in order]
    return tuple(code * span.top / 255 for code in eight)


def color_slack(image: RasterImage, span: Span) -> float:
    """The difference up to which a stored value is that of a colour."""
    return (_LOSSY_TOLERANCE if image.lossy else _TOLERANCE) * span.step


def near_color(xyz: NDArray[Any], codes: tuple[float, ...], slack: float) -> Mask:
    """Pixels within ``slack`` of a colour in every channel."""
    near: Mask = np.ones(xyz.shape[:2], bool)

    def look(band: slice) -> None:
        for channel, code in enumerate(codes):
            near[band] &= np.abs(xyz[band, :, channel].astype(np.float32) - np.float32(code)) <= slack

    for_each_band(len(near), max(1, _PIXELS_AT_ONCE // xyz.shape[1]), look)
    return near


def _exactly_flat(image: RasterImage, xyz: NDArray[Any], span: Span) -> Mask:
    if image.is_float:
        slack = 1e-6 if image.bits == 32 else 3e-4
        middles: tuple[float, ...] = (0.0,) if span.low < 0 else (0.0, 0.5, 128 / 255, 127 / 255)
        return np.asarray(np.any([near_color(xyz, (m, m, span.top), slack) for m in middles], axis=0))
    found: Mask = np.zeros(xyz.shape[:2], bool)

    def look(band: slice) -> None:
        for color in flat_codes(image.max_code).values():
            found[band] |= has_color(xyz[band], color)

    for_each_band(len(found), max(1, _PIXELS_AT_ONCE // xyz.shape[1]), look)
    return found


def _near_flat(xyz: NDArray[Any], span: Span, lossy: bool) -> Mask:
    """Pixels that noise or dither may have made of flat."""
    slack = (_LOSSY_FLAT if lossy else _FLAT_NOISE) * span.step
    near = near_color(xyz[..., :2], (span.middle, span.middle), slack)
    near &= xyz[..., 2] >= span.top - slack - 2 * span.step
    return near


def _noisy(xyz: NDArray[Any], span: Span, near: Mask) -> Mask:
    """Those of the pixels near flat that are flat on average and vary from pixel to pixel by more than that average."""
    near = near.copy()
    for channel in range(2):
        values = (xyz[..., channel].astype(np.float32) - np.float32(span.middle)) / np.float32(span.step)
        values = np.ascontiguousarray(np.where(near, values, np.float32(0)))
        mean = cv2.blur(values, _NOISE_WINDOW_PX, borderType=cv2.BORDER_REPLICATE)
        off = np.abs(values - cv2.blur(values, (3, 3), borderType=cv2.BORDER_REFLECT))
        rough = cv2.blur(off, _NOISE_WINDOW_PX, borderType=cv2.BORDER_REFLECT)
        near &= (np.abs(mean) <= _NOISE_MEAN) & (rough > _NOISE_ROUGHNESS * np.abs(mean)) & (rough > 0)
    return near


def _noisy_flat(xyz: NDArray[Any], span: Span, lossy: bool, sides: int) -> Mask:
    """Flat with noise or dither, its specks filled; empty if it cannot reach this many sides of the picture."""
    if min(xyz.shape[:2]) >= _STRIP_PX:
        # an edge depends only on a strip along it; an edge without noise is too long to be filled as a speck
        turned = xyz.swapaxes(0, 1)
        strips = (xyz[:_STRIP_PX], xyz[-_STRIP_PX:][::-1], turned[:_STRIP_PX], turned[-_STRIP_PX:][::-1])
        if sum(bool(_noisy(strip, span, _near_flat(strip, span, lossy))[0].any()) for strip in strips) < sides:
            return np.zeros(xyz.shape[:2], bool)
    near = _near_flat(xyz, span, lossy)
    # what is near flat holds all that is noisy: if it does not reach the sides, neither does the noisy part
    if not edge_patches(without_specks(near), sides).any():
        return np.zeros(xyz.shape[:2], bool)
    return without_specks(_noisy(xyz, span, near))


def _edge(picture: NDArray[Any]) -> NDArray[Any]:
    """The pixels along the picture's edge."""
    return np.concatenate([picture[0], picture[-1], picture[1:-1, 0], picture[1:-1, -1]])


def _score(mask: Mask) -> float:
    """How much of the edge and of the picture a mask fills; the candidate with the highest score is the background."""
    return float(_edge(mask).mean() + mask.mean())


def _fades(flat: Mask, xyz: NDArray[Any], span: Span) -> bool:
    """Whether the surface around flat patches is as good as flat: a shallow surface, flat only by rounding."""
    around = dilated(flat, 1) & ~flat
    off = np.abs(xyz[around][:, :2].astype(np.float32) - np.float32(span.middle)).max(axis=1)
    return bool((off <= _FLAT_NOISE * span.step).mean() > _FADING) if off.size else False


def _find_flat(image: RasterImage, xyz: NDArray[Any], span: Span, sides: int) -> Background:
    exact = edge_patches(_exactly_flat(image, xyz, span), sides)
    if 0 < _edge(exact).mean() < _SURE_EDGE and _fades(exact, xyz, span):
        exact[:] = False
    noisy = edge_patches(_noisy_flat(xyz, span, image.lossy, sides), sides)
    # a map with noise near flat everywhere is a very shallow surface
    is_noise = noisy.sum() > 1.25 * exact.sum() and noisy.mean() < _ALL_OVER
    return Background("flat", noisy if is_noise else exact, (span.middle, span.middle, span.top))


def _find_impossible(xyz: NDArray[Any], span: Span, slack: float, wanted: str) -> Background | None:
    """The wanted colour that is not a normal and fills most of the picture; None if there is none."""
    found: list[Background] = []
    for kind, codes in impossible_colors(span).items():
        if wanted in ("auto", kind):
            mask = big_patches(near_color(xyz, codes, slack))
            if wanted != "auto" or mask.mean() >= _MIN_TOTAL_SHARE:
                found.append(Background(kind, mask, codes))
    return max(found, key=lambda background: _score(background.mask), default=None)


def _find_odd(xyz: NDArray[Any], span: Span, order: tuple[int, ...]) -> Background | None:
    """A colour that fills much of the edge: a background if it is not a normal, otherwise only a warning."""
    edge = _edge(xyz)
    colors, counts = np.unique(edge, axis=0, return_counts=True)
    codes = tuple(float(c) for c in colors[np.argmax(counts)])
    vector = (np.array(codes) - span.middle) / ((span.top - span.low) / 2)
    if counts.max() < _ODD_EDGE_SHARE * len(edge):
        return None
    mask = big_patches(near_color(xyz, codes, _TOLERANCE * span.step))
    if mask.mean() < _ODD_SHARE:
        return None
    name = "#{:02x}{:02x}{:02x}".format(*(round((codes[order.index(c)] - span.low) / span.step) for c in range(3)))
    if abs(np.linalg.norm(vector) - 1) >= _ODD_LENGTH:
        # where most vectors are not of unit length, an odd length proves nothing
        return None if _mostly_off_length(xyz[~mask], span) else Background(name, mask, codes)
    if max(abs(code - span.middle) for code in codes[:2]) <= _FLAT_NOISE * span.step:
        return None  # flat areas are an ordinary part of textures
    warning = f"{mask.mean():.0%} of the picture is {name}; if that is the background, use `background_color={name!r}`"
    return Background("none", np.zeros(mask.shape, bool), warning=warning)


def _mostly_off_length(codes: NDArray[Any], span: Span) -> bool:
    """Whether most of the (N, 3) stored vectors are not of unit length."""
    sample = codes[:: max(1, len(codes) // _PIXELS_AT_ONCE)].astype(np.float64)
    lengths = np.linalg.norm((sample - span.middle) / ((span.top - span.low) / 2), axis=1)
    return len(lengths) > 0 and bool((np.abs(lengths - 1) >= _ODD_LENGTH).mean() > 0.5)


def _find_alpha(image: RasterImage, wanted: str, shape: tuple[int, ...]) -> Background | None:
    """The transparent pixels, if alpha is wanted or holds coverage."""
    alpha = image.alpha
    if alpha is None:
        return Background("alpha", np.zeros(shape, bool)) if wanted == "alpha" else None
    if wanted not in ("auto", "alpha") or (wanted == "auto" and alpha_is_data(image)):
        return None
    see_through = alpha < 0.5
    return Background("alpha", see_through) if wanted == "alpha" or see_through.any() else None


def find_background(
    image: RasterImage, xyz: NDArray[Any], wanted: str, order: tuple[int, ...] = (0, 1, 2), components: int = 3
) -> Background:
    """Find the background of a picture.

    Parameters
    ----------
    image : RasterImage
        Supplies alpha, the range of codes and whether they are lossy.
    xyz : (H, W, 3)
        The stored codes of the three components.
    wanted : str
        "auto", "none", a kind, or "#rrggbb".
    order : tuple of int
        Which of the channels R, G, B each component came from.
    components : int
        2 if the third component is computed from the first two; a colour is then recognised by these two.

    Returns
    -------
    Background
        Kind "none" with an empty mask if nothing is found.
    """
    nothing = Background("none", np.zeros(xyz.shape[:2], bool))
    if wanted == "none":
        return nothing
    by_alpha = _find_alpha(image, wanted, xyz.shape[:2])
    if by_alpha is not None:
        return by_alpha
    span = span_of(image, xyz)
    slack = color_slack(image, span)
    if wanted.startswith("#"):
        codes = hex_codes(wanted, span, order)[:components]
        return Background(wanted, near_color(xyz, codes, slack), codes)
    best = _find_impossible(xyz, span, slack, wanted)
    best = best if best is not None and best.mask.any() else nothing
    if wanted in ("auto", "flat"):
        flat = _find_flat(image, xyz, span, _FLAT_SIDES if wanted == "auto" else 1)
        best = flat if _score(flat.mask) > _score(best.mask) else best
    if best.kind == "none" and wanted == "auto":
        return _find_odd(xyz, span, order) or nothing
    return best
