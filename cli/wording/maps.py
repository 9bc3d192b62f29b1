"""Messages about normal maps: how they were read, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from nmaptool.options.presets import DEPTH_PRESETS, NORMAL_PRESETS
from nmaptool.types.shown import counted

if TYPE_CHECKING:
    from nmaptool import Decoding, Inspection, NormalMap
    from nmaptool_cli.run import Run


COMPONENTS = {"xyz": "x, y and z", "xy": "x and y, z computed from them", "octahedral": "octahedral codes"}


def say_map(run: Run, normal_map: NormalMap, *, makes_heights: bool = False) -> None:
    """How an input was read, in one line, with warnings and what was assumed about the order of its channels."""
    import nmaptool as nm
    from nmaptool.maps.order_doubts import order_notes

    share = float(normal_map.foreground.mean())
    run.say(f"{normal_map.name}: {normal_map.frame}, {describe_decoding(normal_map.decoding, share)}")
    run.say(*(f"{normal_map.name}: {note}" for note in normal_map.decoding.notes))
    run.say(*(f"  {note}" for note in order_notes(normal_map.decoding, makes_heights=makes_heights)))
    for warning in (*normal_map.decoding.warnings, *nm.diagnose(normal_map)):
        run.warn(f"{normal_map.name}: {warning}")


def describe_decoding(decoding: Decoding, foreground_share: float | None = None) -> str:
    """How a map was read, in one line."""
    parts = [] if decoding.preset is None else [f"as {decoding.preset} writes it ({decoding.preset_from})"]
    parts.append(f"background {decoding.background} ({decoding.background_from})")
    if foreground_share is not None:
        parts.append(f"motif {foreground_share:.0%}")
    if decoding.swizzle != "r,g,b":
        parts.append(f"channels {decoding.swizzle} ({decoding.swizzle_from})")
    if decoding.components != "xyz":
        parts.append(f"{COMPONENTS[decoding.components]} ({decoding.components_from})")
    parts.append(f"green {decoding.green} ({decoding.green_from})")
    parts.append(f"zero at {decoding.zero_code} ({decoding.zero_code_from})")
    return ", ".join(parts)


def describe_inspection(seen: Inspection) -> Iterator[str]:
    """An inspection, one line each."""
    d = seen.decoding
    kind = f"{seen.bits} bit {'float' if seen.is_float else 'integer'}{', lossy compression' if seen.lossy else ''}"
    yield f"{seen.name}: {seen.cols} x {seen.rows}, {kind}, channels {' '.join(seen.channels)}"
    if d.notes and not seen.coarse:  # otherwise a finding says so
        yield f"  file         {'; '.join(d.notes)}"
    if d.preset is not None:
        yield f"  preset       {d.preset} ({d.preset_from}): {NORMAL_PRESETS[d.preset].description}"
    yield f"  green        {d.green} ({d.green_from}; {_green_evidence(d)})"
    order = f"x,y,z = {d.swizzle} ({d.swizzle_from})"
    yield f"  channels     {order}; {d.encoding}; zero at {d.zero_code} ({d.zero_code_from})"
    if seen.foreground_share:
        yield f"  order        {_order(d)}"
    if d.components != "xyz":
        yield f"  components   {COMPONENTS[d.components]} ({d.components_from})"
    yield f"  background   {d.background} ({d.background_from}); motif {seen.foreground_share:.1%} of the picture"
    yield f"  coverage     {seen.coverage_mean:.1%} of the picture has normals"
    if d.rim_pixels:
        yield f"  rim          {counted(d.rim_pixels, 'anti-aliased pixel')}, with normals taken from inside the motif"
    yield f"  unit length  off by {seen.unit_length_error:.4f} on average; {seen.off_length_share:.2%} by more than 0.1"
    yield f"  facing away  {seen.away_share:.2%} (nz <= 0)"
    yield f"  mean |curl|  {seen.mean_abs_curl:.4f} slope per px"
    if seen.neutral_bias_px is not None:
        tilt = f"{seen.neutral_bias_px:+.2f} px from side to side"
        yield f"  neutral bias {tilt} if flat were not recognised; zero is read as {d.zero_code}"
    if seen.pitch_mm is not None:
        yield f"  pitch        {seen.pitch_mm:g} mm per px"
    for finding in seen.findings:
        yield f"! {finding.message}"
        yield f"    -> {finding.remedy}"
    if not seen.findings:
        yield "  clean: no findings"


def _order(decoding: Decoding) -> str:
    """The orders that fit a map, and what tells them apart."""
    from nmaptool.maps.conventions import better_swizzle

    fits, sign = decoding.fits or (), decoding.outline_sign
    outline = "no outline" if sign is None else f"outline {sign:+.2f}, raised is +1"
    if not fits:
        return "no order of the channels faces the viewer"
    if better_swizzle(decoding) is not None:
        outline = "not the order in use"
    if len(fits) == 1:
        return f"x,y,z = {fits[0]} fits ({outline})"
    if len(fits) == 2:
        return f"x,y,z = {fits[0]} fits, and so does its inside-out, {fits[1]} ({outline})"
    return f"{len(fits)} orders fit (too little curl to tell; {outline})"


def _green_evidence(decoding: Decoding) -> str:
    """What tells the direction of green."""
    from nmaptool.maps.conventions import better_swizzle

    if decoding.curl_ratio is None:
        return "too little curl to tell"
    if better_swizzle(decoding) is not None:
        return "another order fits"
    ratio = decoding.curl_ratio if decoding.green == "up" else 1 / decoding.curl_ratio
    return f"the other direction has {ratio:.1f} times the curl"


def describe_presets() -> Iterator[str]:
    """The programs whose files can be read with --from, one line each."""
    yield "Normal maps (--from NAME, in every command that reads one):"
    width = max(map(len, (*NORMAL_PRESETS, *DEPTH_PRESETS))) + 1
    for name, preset in NORMAL_PRESETS.items():
        green = {"up": "", "auto": ", green detected"}.get(preset.green, f", green {preset.green}")
        zero = "" if preset.zero_code == "auto" else f", zero at {preset.zero_code}"
        yield f"  {name:{width}}{preset.description} [{preset.swizzle}{green}{zero}]"
    yield "Depth and height pictures (nmap compose depth --from NAME):"
    for name, depth in DEPTH_PRESETS.items():
        yield f"  {name:{width}}{depth.description} [{depth.values}]"
