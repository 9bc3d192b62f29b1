"""Limits set by a picture's steps and noise: which jumps are detected, how far the surface may leave the heights."""

from __future__ import annotations

from nmaptool.depth.scale import in_px
from nmaptool.depth.source import FINE_SLOPE, DepthSource
from nmaptool.depth.steps import JumpRule
from nmaptool.options import DepthOptions

# a mixed pixel differs from its side by at least this many standard deviations of the noise
_MIXED_NOISE = 3.5
# least difference of a mixed pixel on a smoothed outline from its side: in px, in steps
_MIXED_PX, _MIXED_STEPS = 0.02, 2.0
# how far the surface may leave the stored heights: half a step plus _NOISE_REACH deviations of noise; lossy files have
# larger errors
_NOISE_REACH, _LOSSY_STEPS = 3.0, 1.5
# limits of the descent steps; the most are used if the tolerance is more than _THOROUGH_STEPS steps of the heights
_LEAST_DESCENT, _MOST_DESCENT, _THOROUGH_STEPS = 10, 40, 0.6
# larger pictures get fewer descent steps, because their forms bend less from pixel to pixel
_FULL_DESCENT_PIXELS = 1e6
# least number of pixels beside a line of jumps: a motif of one pixel has five, noise often more
_LEAST_LINE, _NOISY_LINE = 5, 12


def jump_rule(options: DepthOptions, source: DepthSource) -> JumpRule | None:
    """Return the rule for jumps; None if jumps are not to be detected."""
    if options.jump == "none":
        return None
    unsure, image = source.unsure, source.image
    mixed = max(_MIXED_PX, _MIXED_STEPS * source.step_px, _MIXED_NOISE * unsure)
    if options.jump != "auto":
        least = in_px(options.jump, image.frame.cols, source.scale.pitch_mm, "jump", image.name)
        return JumpRule(least, mixed, by_hand=True)
    return JumpRule(source.least_jump_px, mixed, 2 * unsure, _NOISY_LINE if unsure else _LEAST_LINE)


def tolerance_of(options: DepthOptions, source: DepthSource) -> float:
    """Return how far the surface may leave the stored heights, in px; 0 if no surface is to be fitted."""
    image = source.image
    if options.smooth == "none":
        return 0.0
    if options.smooth != "auto":
        return in_px(options.smooth, image.frame.cols, source.scale.pitch_mm, "smooth", image.name)
    if max(source.step_px, source.noise_px) < FINE_SLOPE:
        return 0.0
    return source.step_px * (_LOSSY_STEPS if image.lossy else 0.5) + _NOISE_REACH * source.noise_px


def descent_steps(tolerance: float, step_px: float, pixels: float) -> int:
    """Return the number of descent steps for fitting the surface of a picture with so many pixels."""
    share = (_FULL_DESCENT_PIXELS / pixels) ** 0.5
    most = _MOST_DESCENT if tolerance > _THOROUGH_STEPS * step_px else round(_MOST_DESCENT * share)
    return min(max(most, _LEAST_DESCENT), _MOST_DESCENT)
