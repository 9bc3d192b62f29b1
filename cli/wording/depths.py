"""Messages about depth and height pictures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from nmaptool.types.shown import counted
from nmaptool_cli.mentions import in_flags

if TYPE_CHECKING:
    from nmaptool import DepthReport, DepthResult
    from nmaptool_cli.run import Run

# how the scale of a picture was settled
_SCALES = {"range": "assumed for the values in use", "fov": "from the distances and the field of view"}


def describe_depth(run: Run, name: str, result: DepthResult) -> None:
    """How a depth picture was read, with warnings."""
    run.say(f"{name}: {result.normal_map.frame}")
    run.say(*(f"{name}: {in_flags(note)}" for note in result.report.notes))
    run.warn(*(f"{name}: {warning}" for warning in result.report.warnings))
    run.say(*describe_depth_report(result.report))
    run.seconds(result.report.seconds)


def describe_depth_report(report: DepthReport) -> Iterator[str]:
    """What was found in a depth picture, one line each."""
    near = "near is dark or small" if report.inverted else "near is bright or large"
    lens = f", {report.fov:.4g} degrees across ({report.fov_from})" if report.fov else ""
    plain = report.kind != "grey" or report.values_from == "assumed"
    kind = f"{report.bits} bit {report.kind if plain else report.values}"
    source = f"{report.inverted_from} {report.preset}" if report.inverted_from == "preset" else report.inverted_from
    scale = f"scale {report.scale_px:.4g} px ({_SCALES.get(report.scale_from, report.scale_from)})"
    yield f"  {kind}, {near} ({source}), {scale}{lens}"
    yield from _describe_values(report)
    yield from _describe_empty(report)
    steps = f"steps of {report.step_px:.3g} px" if report.step_px else "no steps"
    noise = f"noise {report.noise_px:.3g} px" if report.noise_px else "no noise"
    fitted = f"smoothed within {report.tolerance_px:.3g} px" if report.tolerance_px else "slopes kept as they are"
    yield f"  {steps}, {noise}: {fitted}"
    if report.jump_px is None:
        yield "  jumps: not searched for"
    else:
        mixed = f", {counted(report.mixed_pixels, 'mixed pixel')} assigned to one side" if report.mixed_pixels else ""
        yield f"  jumps: {report.jump_px:.3g} px or more, beside {report.jump_share:.1%} of the surface{mixed}"
    keep = (
        "; --background flat keeps the flat patches at the lowest height" if report.background.endswith("cut") else ""
    )
    yield f"  background {report.background}, {report.background_share:.0%} of the picture{keep}"
    yield f"  mean |curl| {report.curl:.4f} slope per px"
    yield from _describe_scale(report)


def _describe_values(report: DepthReport) -> Iterator[str]:
    """What the values mean, if anything but plain heights."""
    if report.orientation != 1:
        yield f"  turned upright by its EXIF orientation {report.orientation}"
    if report.preset and report.preset_from == "found":
        yield f"  written by {report.preset} (found; --values height reads near as large)"
    elif report.values_from == "found":
        yield "  the name of its layer says that it holds distances; --values height reads near as large"
    if report.values == "disparity":
        if report.absolute:
            yield "  disparities are read as 1 over distance and converted to distances"
        else:
            known = "" if report.preset else "; --unit, the distance where the value is 1, converts them to distances"
            yield f"  disparities up to an unknown scale and offset are read as heights{known}"


def _describe_empty(report: DepthReport) -> Iterator[str]:
    """The pixels without a depth, and the holes that were filled."""
    if report.empty:
        found = ", ".join(f"{value} ({counted(number, 'pixel')})" for value, number in report.empty.items())
        keep = "" if set(report.empty) <= {"NaN", "infinite"} else "; --empty none reads them as depths"
        yield f"  no depth: {found}{keep}"
    if report.filled_holes:
        holes = f"{counted(report.filled_holes, 'hole')} of at most {report.fill_px:.3g} px"
        yield f"  filled {holes}, {counted(report.filled_pixels, 'pixel')}; --fill none leaves them open"


def _describe_scale(report: DepthReport) -> Iterator[str]:
    """How true to scale the slopes are, and how to set that."""
    if report.pitch_from == "depth":
        middle = f"the median distance of {_length(report.distance_mm or 0.0)}"
        yield f"  pitch {report.pitch_mm:.4g} mm at {middle}, from the field of view; --width sets another"
    is_camera = report.values == "distance" or (report.values == "disparity" and report.absolute)
    if report.unit is not None and report.scale_from in ("assumed", "range"):
        where = f" (see {report.lens})" if report.lens else ""
        needed = f"--fov 60, or --fov 525px for a focal length{where}" if is_camera else "--width 80mm"
        yield f"  the unit of {report.unit} is not used, because the size of a pixel is not known: add {needed}"
    elif (
        is_camera
        and report.absolute
        and report.kind == "grey"
        and report.fov_from == "assumed"
        and not report.options.invert
    ):
        where = f" (see {report.lens})" if report.lens else ""
        yield f"  no field of view given: read as orthographic; set it with --fov 60, or --fov 525px{where}"
    if report.scale_from == "assumed":
        assumed = "white at 10% of the width above black is assumed"
        yield f"  no depth scale given: {assumed}; set yours with --depth-scale 5%"
    elif report.scale_from == "range":
        share = "" if report.used_share is None else f", {report.used_share:.2%} of the codes"
        ends = f"{report.lowest_value:.6g} to {report.highest_value:.6g}{share}"
        yield f"  no depth scale given: 10% of the width is assumed for the values in use, {ends}"


def _length(mm: float) -> str:
    return f"{mm / 1000:.3g} m" if mm >= 1000 else f"{mm:.3g} mm"
