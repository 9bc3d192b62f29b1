"""Exact height: find the factor t for which a + t b has a given range (max - min)."""

from __future__ import annotations

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError

_MAX_STEPS = 200


def spread_of(values: Float64) -> float:
    """Return the maximum minus the minimum."""
    return float(values.max() - values.min())


def _range_and_slope(a: Float64, b: Float64, t: float) -> tuple[float, float]:
    """Return the range of a + t b and its right-hand derivative in t."""
    z = a + t * b
    top, bottom = int(z.argmax()), int(z.argmin())
    return float(z[top] - z[bottom]), float(b[top] - b[bottom])


def least_range(a: Float64, b: Float64) -> tuple[float, float]:
    """Return the t that minimises the range of a + t b, and that range; it is convex and piecewise linear in t.

    Parameters
    ----------
    a, b : (N,) float64
    """
    size = spread_of(b)
    if size == 0:
        return 0.0, spread_of(a)
    low = -2 * spread_of(a) / size - 1.0
    high = -low
    value_low, slope_low = _range_and_slope(a, b, low)
    value_high, slope_high = _range_and_slope(a, b, high)
    for _ in range(_MAX_STEPS):
        if slope_low >= 0 or slope_high <= 0 or high - low <= 1e-15 * max(1.0, abs(high)):
            break
        # the crossing of the two tangents; exact after finitely many steps
        cross = (value_high - value_low + slope_low * low - slope_high * high) / (slope_low - slope_high)
        value, slope = _range_and_slope(a, b, cross)
        tangent = value_low + slope_low * (cross - low)
        if value <= tangent + 1e-14 * max(1.0, abs(value)):
            return cross, value
        if slope < 0:
            low, value_low, slope_low = cross, value, slope
        else:
            high, value_high, slope_high = cross, value, slope
    return (low, value_low) if value_low <= value_high else (high, value_high)


def factor_for_range(a: Float64, b: Float64, wanted: float, what: str, pitch_mm: float) -> float:
    """Return the largest t for which a + t b has the range ``wanted``; never negative, which would invert b.

    Parameters
    ----------
    a, b : (N,) float64
        Heights in px.
    wanted : float
        Range in px.
    what : str
        What t scales, for the error message.
    pitch_mm : float
        Pitch, to convert the smallest reachable height to mm for the error message.

    Raises
    ------
    InputError
        If no t >= 0 reaches the range; the message states the smallest reachable one.
    """
    # if b is the same everywhere, up to the solver's tolerance, it moves the relief but does not change its range
    without_effect = spread_of(b) <= 1e-4 * float(abs(b).max())
    best, least = (0.0, spread_of(a)) if without_effect else least_range(a, b)
    if best < 0:
        best, least = 0.0, spread_of(a)
    if wanted < least or without_effect:
        reason = "does not change the height, which is" if without_effect else "alone gives at least"
        raise InputError(
            f"`height='{wanted * pitch_mm:g}mm'`: changing {what} {reason} {least * pitch_mm:.4g} mm; "
            f"{'' if without_effect else 'choose a larger `height`, or '}use `fit='scale'`"
        )
    t = best + max(1.0, best)
    value, slope = _range_and_slope(a, b, t)
    while value < wanted or slope <= 0:
        t = best + 2 * (t - best)
        value, slope = _range_and_slope(a, b, t)
    for _ in range(_MAX_STEPS):  # Newton from the right of a convex, piecewise linear function
        following = t - (value - wanted) / slope
        if not following < t:
            break
        t = following
        value, slope = _range_and_slope(a, b, t)
        if value <= wanted or slope <= 0:
            break
    return t
