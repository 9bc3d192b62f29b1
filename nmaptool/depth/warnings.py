"""What is doubtful about how a depth picture was read, with the option that changes it."""

from __future__ import annotations

from collections.abc import Iterator

from nmaptool.depth.source import DepthSource
from nmaptool.options import DepthOptions

# with a given scale, a smaller share of the codes in use makes a surface that is nearly flat
_FLAT_SHARE = 0.01


def warnings_of(source: DepthSource, options: DepthOptions, range_px: float) -> Iterator[str]:
    """Yield a line for each doubt.

    Parameters
    ----------
    source : DepthSource
    options : DepthOptions
    range_px : float
        Height of the highest pixel of the surface above the lowest.
    """
    meaning, scale, grey = source.meaning, source.scale, source.grey
    low, high = source.in_use
    share = (high - low) / grey.top
    if scale.scale_from == "given" and not grey.is_float and 0 < share <= _FLAT_SHARE:
        deeper = f"{scale.scale_px / share:.0f}px"
        yield (
            f"only the codes {low:g} to {high:g} of 0 to {grey.top:g} are in use, so the surface is only "
            f"{range_px:.3g} px deep, because `depth_scale` is the height of all codes; leave it out, or give "
            f"`depth_scale='{deeper}'` for {scale.scale_px:.4g} px"
        )
    if "0" in grey.empty and meaning.values_from == "assumed" and options.empty == "auto" and 0 not in meaning.empty:
        yield (
            "0 is read as no reading, as depth cameras write it, but large values as near; if they are distances, give "
            "`values='distance'` or `from_='realsense'`, and if 0 is a height, `empty='none'`"
        )
    if range_px > source.image.frame.cols and not scale.fov and scale.scale_from in ("given", "file", "unit"):
        yield (
            f"the surface is {range_px:.4g} px deep, more than the picture is wide ({source.image.frame.cols} px): "
            f"check {_scale_options(source, options)}"
        )


def _scale_options(source: DepthSource, options: DepthOptions) -> str:
    """The options that set the scale."""
    if options.depth_scale is not None:
        return "`depth_scale`"
    return "`unit` and `width`" if source.meaning.unit is not None else "`width`"
