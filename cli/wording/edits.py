"""Messages about edits, conversions and unpacked files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from nmaptool.types.shown import counted
from nmaptool_cli.wording.maps import COMPONENTS

if TYPE_CHECKING:
    from nmaptool import ComposeReport, Composition, ConvertReport, Frame, UnpackResult


def describe_composition(composition: Composition) -> Iterator[str]:
    """An edit, one line per layer."""
    yield from describe_layers_and_curl(composition.report, composition.normal_map.frame)


def describe_layers_and_curl(report: ComposeReport, frame: Frame) -> Iterator[str]:
    """The layers of an edit, one line each, and the curl of the result."""
    for layer in report.layers:
        where = ""
        if "box_px" in layer:
            left, top, cols, rows = layer["box_px"]
            where = f" at {left},{top} px, {cols} x {rows}"
        strength = "" if layer["strength"] == 1 else f", strength {layer['strength']:g}"
        yield f"  {layer['name']}: {layer['mode']}{strength}{where}, on {layer['share']:.0%} of the canvas"
    before = "" if report.curl_before is None else f" (before {report.curl_before:.4f})"
    pitch = "" if frame.pitch_mm is None else f", pitch {frame.pitch_mm:.4g} mm"
    yield f"  {report.command}: {frame}{pitch}, mean |curl| {report.curl_after:.4f} slope per px{before}"


def describe_conversion(report: ConvertReport) -> Iterator[str]:
    """What a conversion changed, one line each."""
    was, now = report.source, report.target
    lossy = ", lossy compression" if was["lossy"] else ""
    yield f"  was: {_kind(was)}{lossy}; now: {_kind(now)}"
    if was["components"] != "xyz":
        yield f"  {COMPONENTS[was['components']]}: all three components are written"
    if report.off_length:
        off = f"{report.off_length} of {report.vectors} vectors were off unit length"
        yield f"  {off}, by up to {report.off_length_largest:.2g}: normalised"
    else:
        yield "  all vectors have unit length within rounding"
    if report.rim_pixels:
        yield f"  {counted(report.rim_pixels, 'anti-aliased pixel')} took their normals from inside the motif"
    if report.flattened:
        yield f"  {counted(report.flattened, 'noisy pixel')} in the flat background made flat"
    if now["alpha"]:
        yield f"  background {was['background']}: coverage is stored in alpha"


def _kind(facts: Mapping[str, Any]) -> str:
    bits, zero = facts["bits"], facts["zero_code"]
    codes = f"{bits} bit, zero at {zero}" if bits in ("8", "16") else bits
    return f"{codes}, green {facts['green']}"


def describe_unpacked(unpacked: UnpackResult) -> Iterator[str]:
    """An unpacked file, one line each."""
    size = f"{unpacked.frame}, {unpacked.bits} bit, {counted(len(unpacked.layers), 'layer')}"
    yield f"{unpacked.name}: {size}, bottom to top"
    for layer in unpacked.layers:
        groups = f" in {' / '.join(group.name for group in layer.groups)}" if layer.groups else ""
        more = f"{', mask' if layer.mask is not None else ''}{'' if layer.visible else ', hidden'}"
        place = f"{layer.normal_map.frame} at {layer.left},{layer.top}"
        yield f"  {layer.name}{groups}: {place}, {layer.mode}, strength {layer.strength:.3g}{more}"
        for repair in layer.repairs:
            yield f"    repaired: {repair}"
    if not unpacked.has_metadata:
        yield "  the file has no nmaptool metadata: moved or mirrored layers and adjusted curves cannot be detected"
    for finding in unpacked.findings:
        yield f"! {f'{finding.layer}: ' if finding.layer is not None else ''}{finding.message}"
        yield f"    -> {finding.remedy}"
    if not unpacked.findings:
        yield "  clean: no findings"
