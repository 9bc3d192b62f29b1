"""Messages about previews."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nmaptool.io.output.preview import DrawnPreview
    from nmaptool.io.previewed import PreviewSource
    from nmaptool.options import PreviewOptions
    from nmaptool_cli.run import Run


def describe_source(run: Run, name: str, source: PreviewSource) -> None:
    """What was read, and what was assumed."""
    import nmaptool as nm

    value = source.value
    if isinstance(value, nm.Mesh):
        size = (value.vertices_mm.max(axis=0) - value.vertices_mm.min(axis=0)).tolist() if len(value.vertices) else []
        facts = [f"mesh of {' x '.join(f'{side:.4g}' for side in size)} mm, {len(value.faces)} triangles"]
    elif isinstance(value, nm.NormalMap):
        facts = [f"{value.frame} px"]
    else:
        height = value.height if isinstance(value, nm.Relief) else value
        low, high = height.range_mm
        rows, cols = (side * height.pitch_mm for side in height.frame.shape)
        facts = [f"{cols:.4g} x {rows:.4g} mm ({height.frame} px)", f"{low:.4g} to {high:.4g} mm high"]
    run.say(f"{name}: {', '.join([*facts, *source.notes])}")


def describe_drawn(run: Run, drawn: DrawnPreview, options: PreviewOptions) -> None:
    """What the picture shows."""
    if options.section is not None:
        return
    lights = ", ".join(f"{light.azimuth_deg:g}/{light.elevation_deg:g}" for light in options.lights)
    run.say(f"  {options.material}, lights from {lights} degrees (azimuth/elevation)")
    if options.is_film:
        run.say(f"  {drawn.count} pictures")
