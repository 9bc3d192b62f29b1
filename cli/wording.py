"""Reports as sentences for a designer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nmaptool import (
        Composition,
        ConvertReport,
        Decoding,
        DepthReport,
        FilterModel,
        Inspection,
        LayerReport,
        LayerSet,
        Mesh,
        MeshFindings,
        ReliefReport,
        TrainingExample,
        UnpackResult,
    )


_COMPONENTS = {"xyz": "x, y and z", "xy": "x and y, z made from them", "octahedral": "octahedral codes"}


def describe_decoding(decoding: Decoding, foreground_share: float) -> str:
    """How a map was read, in one line."""
    parts = [f"background {decoding.background} ({decoding.background_from})", f"motif {foreground_share:.0%}"]
    if decoding.swizzle != "r,g,b":
        parts.append(f"channels {decoding.swizzle}")
    if decoding.components != "xyz":
        parts.append(f"{_COMPONENTS[decoding.components]} ({decoding.components_from})")
    parts.append(f"green {decoding.green} ({decoding.green_from})")
    parts.append(f"zero at {decoding.zero_code} ({decoding.zero_code_from})")
    return ", ".join(parts)


def describe_inspection(seen: Inspection) -> Iterator[str]:
    """An inspection, a line each."""
    d = seen.decoding
    kind = f"{seen.bits} bit {'float' if seen.is_float else 'integer'}{', compressed with loss' if seen.lossy else ''}"
    yield f"{seen.name}: {seen.cols} x {seen.rows}, {kind}, channels {' '.join(seen.channels)}"
    sure = "too little curl to tell" if d.curl_ratio is None else f"the other way has {_ratio(d)} times the curl"
    yield f"  green        {d.green} ({d.green_from}; {sure})"
    yield f"  channels     x,y,z = {d.swizzle}; {d.encoding}; zero at {d.zero_code} ({d.zero_code_from})"
    if d.components != "xyz":
        yield f"  components   {_COMPONENTS[d.components]} ({d.components_from})"
    yield f"  background   {d.background} ({d.background_from}); motif {seen.foreground_share:.1%} of the picture"
    yield f"  coverage     {seen.coverage_mean:.1%} of the picture is defined"
    if d.rim_pixels:
        yield f"  rim          {d.rim_pixels} anti-aliased pixels take the normals just inside them"
    yield f"  unit length  off by {seen.unit_length_error:.4f} on average; {seen.off_length_share:.2%} by more than 0.1"
    yield f"  facing away  {seen.away_share:.2%} (nz <= 0)"
    yield f"  mean |curl|  {seen.mean_abs_curl:.4f} slope per px"
    if seen.neutral_bias_px is not None:
        tilt = f"{seen.neutral_bias_px:+.2f} px from side to side"
        yield f"  neutral bias {tilt}, were flat not recognised: zero is taken at {d.zero_code}"
    if seen.pitch_mm is not None:
        yield f"  pitch        {seen.pitch_mm:g} mm per px"
    for finding in seen.findings:
        yield f"! {finding.message}"
        yield f"    -> {finding.remedy}"
    if not seen.findings:
        yield "  clean: nothing to report"


def _ratio(decoding: Decoding) -> str:
    ratio = decoding.curl_ratio or 1.0
    return f"{ratio if decoding.green == 'up' else 1 / ratio:.1f}"


def describe_relief(report: ReliefReport) -> Iterator[str]:
    """A solve, a line each."""
    o = report.options
    reach = f"{report.reach_px:.1f} px = {report.reach_mm:.2f} mm" if report.reach_px < 1e9 else "any distance"
    detail = f"mu {report.mu:g}, " if report.mu else ""
    delta = report.delta_px / report.px_per_delta
    fitted = {"delta": " (fitted)", "slope": f", slopes times {report.scale:.3g}"}.get(o.fit, "")
    yield f"  {o.background}: {detail}beta {o.beta:g}, delta {delta:.4g}{fitted}, shape kept over {reach}"
    seconds = sum(report.seconds.get(stage, 0) for stage in ("setup", "solve"))
    yield (
        f"  {report.solver}: {report.unknowns} unknowns, {report.iterations} iterations, residual "
        f"{report.residual:.1e}, {seconds:.2f} s"
    )
    low, high = report.height_min_mm, report.height_max_mm
    size = f"pitch {report.pitch_mm:.4g} mm ({report.pitch_from})"
    yield f"  height {low:.3f} to {high:.3f} mm = {report.height_range_mm:.3f} mm, {size}"
    if o.background == "surface":
        yield f"  relief {report.relief_range_mm:.3f} mm from its curved background"
    if report.below_background_share > 0.02 and report.delta_px > 0:
        remedy = "" if o.fit == "delta" else "; a larger --delta lifts it"
        yield f"  {report.below_background_share:.1%} of the motif lies below its background{remedy}"
    if report.pitch_from == "assumed":
        yield "  no size was given: 100 mm on the longer side is assumed; say --width 80mm for your own"


def describe_mesh(mesh: Mesh, report: LayerReport) -> Iterator[str]:
    """A mesh as it was read and cleaned."""
    assert report.findings is not None  # every drawing has them
    yield describe_findings(mesh, report.findings)


def describe_findings(mesh: Mesh, found: MeshFindings) -> str:
    """A mesh as it was read and cleaned, in one line."""
    counted = (
        (found.welded_vertices, "vertices welded"),
        (found.degenerate_faces, "faces without area"),
        (found.nonfinite_faces, "faces with NaN"),
        (found.repeated_faces, "faces twice there"),
        (found.turned_faces, "faces turned to agree with their neighbours"),
        (found.unreferenced_vertices, "vertices unused"),
    )
    dropped = ", ".join(f"{count} {words}" for count, words in counted if count)
    return f"{mesh.name}: {found.vertices} vertices, {found.faces} faces{f'; {dropped}' if dropped else ''}"


def describe_split(report: LayerReport) -> Iterator[str]:
    """How base and detail were told apart."""
    yield f"  {_filter_words(report)}"
    m = report.mixture
    if report.curl:
        yield f"  mean |curl| {', '.join(f'{name} {size:.4f}' for name, size in report.curl.items())} slope per px"
    if m.form == "none":
        yield "  nothing to speak of is finer than that: the filter turns no normal by half a degree"
        return
    whole = "the surface" if report.faces else "the picture"
    threshold = f"theta {m.theta:.4f} ({m.form}{'' if m.form == 'midpoint' else ' crossing'})"
    yield (
        f"  residuals: base {m.low.mean:.4f} +- {m.low.sigma:.4f} ({m.low.weight:.0%}), detail {m.high.mean:.4f} +- "
        f"{m.high.sigma:.4f} ({m.high.weight:.0%}); {threshold}; {report.detail_share:.0%} of {whole} beyond it"
    )


def _filter_words(report: LayerReport) -> str:
    o = report.options
    if report.model:
        return f"learned filter {report.model}"
    where = f", {o['neighborhood']}" if "neighborhood" in o else ""
    size = str(o["sigma_s"]) if isinstance(o["sigma_s"], str) else f"{o['sigma_s']:g} edges"
    return (
        f"{o['filter']}{where}: sigma_s {size} = {report.sigma_s_px:.1f} px, sigma_r {o['sigma_r']:g}, "
        f"{o['iterations']} passes"
    )


def describe_view(layers: LayerSet) -> str:
    """One view, in one line."""
    report, frame = layers.report, layers.frame
    pitch = frame.pitch_mm or 0.0
    size = f"{frame.cols * pitch:.4g} x {frame.rows * pitch:.4g} mm"
    unit = {"assumed": "units taken as mm", "file": "units of the file", "given": "as given"}[report.pitch_from]
    angles = {name: report.options[name] for name in ("azimuth", "elevation", "roll")}
    turned = [f" {name} {value:g}" for name, value in angles.items() if value is not None and (value or name != "roll")]
    covered = float((layers.coverage > 0).mean())
    return (
        f"  {report.view}{''.join(turned)}: {frame}, {size} ({unit}), mesh on {covered:.0%} of it, drawn by "
        f"{report.renderer}"
    )


def describe_composition(composition: Composition) -> Iterator[str]:
    """An edit, a line each layer."""
    report, frame = composition.report, composition.normal_map.frame
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


def describe_depth(report: DepthReport) -> Iterator[str]:
    """How a depth picture was read, a line each."""
    near = "near is dark or small" if report.inverted else "near is bright or large"
    lens = f", {report.fov:g} degrees across ({report.fov_from})" if report.fov else ""
    kind = f"{report.bits} bit {report.kind}"
    yield f"  {kind}, {near} ({report.inverted_from}), scale {report.scale_px:.4g} px ({report.scale_from}){lens}"
    steps = f"steps of {report.step_px:.3g} px" if report.step_px else "no steps"
    noise = f"noise {report.noise_px:.3g} px" if report.noise_px else "no noise"
    fitted = f"fitted within {report.tolerance_px:.3g} px" if report.tolerance_px else "slopes taken as they are"
    yield f"  {steps}, {noise}: {fitted}"
    if report.jump_px is None:
        yield "  jumps were not looked for"
    else:
        mixed = f", {report.mixed_pixels} mixed pixels put on one side" if report.mixed_pixels else ""
        yield f"  jumps of {report.jump_px:.3g} px or more beside {report.jump_share:.1%} of the surface{mixed}"
    yield f"  background {report.background}, {report.background_share:.0%} of the picture"
    yield f"  mean |curl| {report.curl:.4f} slope per px"
    if report.scale_from == "assumed":
        yield "  no depth was given: white stands 10% of the width above black; say --depth-scale 5% for your own"


def describe_conversion(report: ConvertReport) -> Iterator[str]:
    """What a conversion changed, a line each."""
    was, now = report.source, report.target
    lossy = ", compressed with loss" if was["lossy"] else ""
    yield f"  was: {_kind(was)}{lossy}; now: {_kind(now)}"
    if was["components"] != "xyz":
        yield f"  {_COMPONENTS[was['components']]}: all three are written"
    if report.off_length:
        off = f"{report.off_length} of {report.vectors} vectors were off unit length"
        yield f"  {off}, by up to {report.off_length_largest:.2g}: normalised"
    else:
        yield "  no vector was off unit length by more than rounding"
    if report.rim_pixels:
        yield f"  {report.rim_pixels} anti-aliased pixels took the normals just inside them"
    if report.flattened:
        yield f"  {report.flattened} pixels of noise in the flat background are flat now"
    if now["alpha"]:
        yield f"  background {was['background']}: coverage is in alpha"


def _kind(facts: Mapping[str, Any]) -> str:
    bits, zero = facts["bits"], facts["zero_code"]
    codes = f"{bits} bit, zero at {zero}" if bits in ("8", "16") else bits
    return f"{codes}, green {facts['green']}"


def describe_unpacked(unpacked: UnpackResult) -> Iterator[str]:
    """A workspace taken apart, a line each."""
    yield f"{unpacked.name}: {unpacked.frame}, {unpacked.bits} bit, {len(unpacked.layers)} layers, bottom to top"
    for layer in unpacked.layers:
        groups = f" in {' / '.join(group.name for group in layer.groups)}" if layer.groups else ""
        more = f"{', mask' if layer.mask is not None else ''}{'' if layer.visible else ', hidden'}"
        place = f"{layer.normal_map.frame} at {layer.left},{layer.top}"
        yield f"  {layer.name}{groups}: {place}, {layer.mode}, strength {layer.strength:.3g}{more}"
        for repair in layer.repairs:
            yield f"    repaired: {repair}"
    if not unpacked.has_metadata:
        yield "  nmaptool's own words are not in the file: moves, mirrorings and fitted curves cannot be told"
    for finding in unpacked.findings:
        yield f"! {f'{finding.layer}: ' if finding.layer is not None else ''}{finding.message}"
        yield f"    -> {finding.remedy}"
    if not unpacked.findings:
        yield "  clean: nothing to report"


def describe_training(examples: Sequence[TrainingExample], model: FilterModel) -> Iterator[str]:
    """A filter that was learned, a line each."""
    faces = sum(len(example.mesh.faces) for example in examples)
    yield f"learned from {len(examples)} meshes, {faces} faces: filter {model.digest}"
    before, *after = model.metadata["mean_angle_deg"]
    yield f"  mean angle to the targets {before:.2f} degrees, after each stage {', '.join(f'{a:.2f}' for a in after)}"
