"""What is said about a plate, one line each."""

from __future__ import annotations

from collections.abc import Iterator

from nmaptool.types.plate import PlateReport


def describe_plate(report: PlateReport) -> Iterator[str]:
    """Size, motif, frame, texts and openings."""
    yield f"{report.shape} plate {report.width_mm:.5g} x {report.height_mm:.5g} mm, {report.area_mm2:.5g} mm2"
    place = "covers the field" if report.fill == "cover" else f"with a margin of {report.margin_mm:.3g} mm"
    yield f"motif {report.motif_width_mm:.4g} x {report.motif_height_mm:.4g} mm, {place}"
    if report.resampled != 1:
        finer = "finer" if report.resampled > 1 else "coarser"
        factor = f"{report.resampled:.3g} for each of the map"
        yield f"pixels of {report.pitch_mm:.3g} mm, {factor} ({finer}; `pitch` changes it)"
    if report.frame:
        width, height = report.frame["width_mm"], report.frame["height_mm"]
        yield f"frame {report.frame['profile']}, {width:.3g} mm wide and {height:.3g} mm high"
    for text in report.texts:
        size = f"capitals {text['size_mm']:.3g} mm, strokes {text['stroke_mm']:.2g} mm, {text['length_mm']:.3g} mm long"
        yield f"text {text['text']!r}: {size}"
    for hole in report.holes:
        kind = "loop with an eye of" if hole["loop"] else "hole of"
        yield f"{kind} {hole['diameter_mm']:.3g} mm, rim {hole['rim_mm']:.3g} mm"
    yield f"from {report.lowest_mm:.3f} to {report.top_mm:.3f} mm, measured from the surface of the plate"
