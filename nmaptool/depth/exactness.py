"""What a picture's steps and noise allow: which jumps are told, how far the surface may leave the heights."""

from __future__ import annotations

from nmaptool.depth.scale import in_px
from nmaptool.depth.source import FINE_SLOPE, DepthSource
from nmaptool.depth.steps import JumpRule
from nmaptool.options import DepthOptions

# a jump is this high at least: in px, in steps of the codes, and in deviations of the noise
_JUMP_PX, _JUMP_STEPS, _JUMP_NOISE = 1.0, 4.0, 7.0
# a pixel of a smoothed outline is off its side by so much at least: in px, in steps
_MIXED_PX, _MIXED_STEPS = 0.02, 2.0
# how far the surface may leave the stored heights: half a step, and the noise; lossy files are off by more than that
_NOISE_REACH, _LOSSY_STEPS = 3.0, 1.5
# steps of descent, more where the surface may leave the heights by more than so many of the steps they hold
_LEAST_DESCENT, _MOST_DESCENT, _THOROUGH_STEPS = 10, 40, 0.6
# pictures of more pixels than this get fewer steps: their forms bend less from pixel to pixel
_FULL_DESCENT_PIXELS = 1e6
# pixels beside a line of jumps: a motif of one pixel has five, noise often more
_LEAST_LINE, _NOISY_LINE = 5, 12


def jump_rule(options: DepthOptions, source: DepthSource) -> JumpRule | None:
    """What counts as a jump; None where none is to be looked for."""
    if options.jump == "none":
        return None
    unsure, image = source.unsure, source.image
    mixed = max(_MIXED_PX, _MIXED_STEPS * source.step_px, _JUMP_NOISE / 2 * unsure)
    if options.jump != "auto":
        least = in_px(options.jump, image.frame.cols, source.scale.pitch_mm, "jump", image.name)
        return JumpRule(least, mixed, by_hand=True)
    least = max(_JUMP_PX, _JUMP_STEPS * source.step_px, _JUMP_NOISE * unsure)
    return JumpRule(least, mixed, 2 * unsure, _NOISY_LINE if unsure else _LEAST_LINE)


def tolerance_of(options: DepthOptions, source: DepthSource) -> float:
    """How far in px the surface may leave the stored heights; 0 where nothing is to be fitted."""
    image = source.image
    if options.smooth == "none":
        return 0.0
    if options.smooth != "auto":
        return in_px(options.smooth, image.frame.cols, source.scale.pitch_mm, "smooth", image.name)
    if max(source.step_px, source.noise_px) < FINE_SLOPE:
        return 0.0
    return source.step_px * (_LOSSY_STEPS if image.lossy else 0.5) + _NOISE_REACH * source.noise_px


def descent_steps(tolerance: float, source: DepthSource) -> int:
    """Steps of descent that fit a surface."""
    share = (_FULL_DESCENT_PIXELS / source.heights.size) ** 0.5
    most = _MOST_DESCENT if tolerance > _THOROUGH_STEPS * source.step_px else round(_MOST_DESCENT * share)
    return min(max(most, _LEAST_DESCENT), _MOST_DESCENT)
