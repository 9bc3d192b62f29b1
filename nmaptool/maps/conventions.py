"""Detect how the channels of a map point, from its curl and from the normals along its outline."""

from __future__ import annotations

import cv2
import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import dilated
from nmaptool.core.vectors import mean_abs_curl
from nmaptool.maps.codec import apply_signs, format_swizzle, parse_swizzle, signs_of
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.normal_map import Decoding, NormalMap

# an order or sign counts as wrong only if its curl is this many times that of another
SURE_CURL_RATIO = 1.5
# in a large map, a window in the middle is enough
_WINDOW_PX = 800
_OUTLINE_PIXELS = 50
_INVERTED = -0.15
# channels for x and y, up to a common sign: every way in which a map can be rotated or mirrored
_TURNS = (("r", "g", 1), ("r", "g", -1), ("g", "r", 1), ("g", "r", -1))


def _window(shape: tuple[int, int]) -> tuple[slice, slice]:
    starts = [max(0, (n - _WINDOW_PX) // 2) for n in shape]
    return slice(starts[0], starts[0] + _WINDOW_PX), slice(starts[1], starts[1] + _WINDOW_PX)


def green_evidence(normals: Float32, mask: Mask, code_step: float) -> float | None:
    """Mean |curl| with green down over that with green up (below 1: green down fits better).

    None if both are close to the curl of quantisation alone, which proves nothing.

    Parameters
    ----------
    normals : (H, W, 3) float32
        Decoded as green up.
    mask : (H, W) bool
        Pixels to use.
    code_step : float
        Smallest step of a component in the file.
    """
    window = _window(mask.shape)
    normals, mask = normals[window], mask[window]
    up = mean_abs_curl(normals, mask)
    down = mean_abs_curl(apply_signs(normals, signs_of(green="down")), mask)
    if max(up, down) < max(2 * code_step, 1e-6):
        return None
    return down / max(up, 1e-9)


def outline_sign(normals: Float32, foreground: Mask) -> float | None:
    """Mean of n . outward along the outline: near +1 for a raised motif, negative for an inverted one.

    None if there is no outline, or too little of it.

    Parameters
    ----------
    normals : (H, W, 3) float32
    foreground : (H, W) bool
    """
    if min(foreground.shape) < 2 or foreground.all() or not foreground.any():
        return None
    smooth = cv2.GaussianBlur(foreground.astype(np.float32), (25, 25), 3.0, borderType=cv2.BORDER_REPLICATE)
    down, across = np.gradient(smooth)
    size = np.hypot(down, across)
    at = foreground & dilated(~foreground, 3) & (size > 0.02)
    if at.sum() < _OUTLINE_PIXELS:
        return None
    outward = (normals[..., 1] * down - normals[..., 0] * across)[at] / size[at]
    return float(outward.mean())


def better_swizzle(normal_map: NormalMap, code_step: float) -> str | None:
    """Channel order with clearly the least curl, as --swizzle takes it, if it takes x from green and y from red.

    Parameters
    ----------
    normal_map : NormalMap
        Read with the order r,g,b.
    code_step : float
        Smallest step of a component in the file.
    """
    if normal_map.decoding.swizzle != "r,g,b":
        return None
    window = _window(normal_map.frame.shape)
    signs = signs_of(green=normal_map.decoding.green)
    part, mask = apply_signs(normal_map.normals[window], signs), normal_map.foreground[window]
    curls = {turn: mean_abs_curl(_turned(part, turn), mask) for turn in _TURNS}
    turn, runner_up = sorted(curls, key=lambda turn: curls[turn])[:2]
    least, second = curls[turn], curls[runner_up]
    x, y, sign = turn
    # for x from red and y from green only the sign of green is open, and `green_evidence` decides that
    if x == "r" or second < max(2 * code_step, 1e-6) or second < SURE_CURL_RATIO * least:
        return None
    outline = outline_sign(_turned(apply_signs(normal_map.normals, signs), turn), normal_map.foreground)
    flip = -1 if outline is not None and outline < 0 else 1
    return format_swizzle((("rgb".index(x), flip), ("rgb".index(y), flip * sign), (2, 1)))


def _turned(normals: Float32, turn: tuple[str, str, int]) -> Float32:
    """Stored normals with x and y taken from the channels of ``turn``, y times its sign."""
    x, y, sign = turn
    return apply_signs(normals[..., ["rgb".index(x), "rgb".index(y), 2]], (1, sign, 1))


def upright_swizzle(decoding: Decoding) -> str:
    """The swizzle that makes an inverted relief a raised one: x and y change sign.

    If green was detected as down, y keeps its sign: giving a swizzle switches that detection off.

    >>> upright_swizzle(Decoding(swizzle="-g,r,b"))
    'g,-r,b'
    """
    (x, x_sign), (y, y_sign), z = parse_swizzle(decoding.swizzle)
    found_down = decoding.green == "down" and decoding.green_from == "found"
    return format_swizzle(((x, -x_sign), (y, y_sign if found_down else -y_sign), z))


def is_inverted(sign: float | None) -> bool:
    """Whether an `outline_sign` means that the motif is sunken instead of raised."""
    return sign is not None and sign < _INVERTED


def diagnose(normal_map: NormalsLike, *, code_step: float = 2 / 255) -> tuple[str, ...]:
    """Warn if a map looks inverted, rotated or mirrored.

    Parameters
    ----------
    normal_map : NormalMap or (H, W, 3) float of any type
    code_step : float
        Smallest step of a component in the file, such as 2/255 for 8 bits. Smaller curl is rounding.

    Returns
    -------
    tuple of str
        Warnings, each with a remedy; empty if nothing looks wrong.

    Raises
    ------
    InputError
        If a normal of an array has no direction.
    UsageError
        If the map is neither a NormalMap nor an array.

    Examples
    --------
    The normals of a dome that was turned into a hollow:

    >>> y, x = np.mgrid[1:-1:64j, -1:1:64j]
    >>> normals = np.dstack([-x, -y, np.ones_like(x)])
    >>> nm.diagnose(nm.NormalMap.from_array(normals, mask=np.hypot(x, y) < 0.8))
    ("it looks inverted; for a raised motif try `swizzle='-r,-g,b'`, for an engraving `delta=-30`",)
    """
    normal_map = as_normal_map(normal_map)
    if normal_map.decoding.green_from == "file":  # the file states how to read it
        return ()
    better = better_swizzle(normal_map, code_step)
    if better is not None:
        return (f"its channels look rotated or mirrored; try `swizzle={better!r}`",)
    if is_inverted(outline_sign(normal_map.normals, normal_map.foreground)):
        swizzle = upright_swizzle(normal_map.decoding)
        return (f"it looks inverted; for a raised motif try `swizzle={swizzle!r}`, for an engraving `delta=-30`",)
    return ()
