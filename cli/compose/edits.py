"""The last step of every command that edits normal maps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nmaptool_cli.inputs import map_header
from nmaptool_cli.run import Run
from nmaptool_cli.wording.maps import say_map

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.io.output.normal_map import WrittenMap
    from nmaptool.io.output.transaction import Outputs


def finish_edit(
    run: Run,
    outputs: Outputs[WrittenMap],
    composition: nm.Composition,
    maps: Sequence[nm.NormalMap],
    *,
    written: WrittenMap | None = None,
    more: Sequence[str] = (),
    **facts: Any,
) -> None:
    """Write an edited map and report how its inputs were read and what was done.

    Parameters
    ----------
    run : Run
    outputs : Outputs
    composition : Composition
    maps : sequence of NormalMap
        The inputs.
    written : WrittenMap, optional
        The map as it is written. Default: with the composition's own recipe.
    more : sequence of str
        More messages about the inputs.
    **facts
        More entries of the report.
    """
    from nmaptool.io.output.composition import composed_map
    from nmaptool_cli.wording.edits import describe_composition

    for normal_map in maps:
        say_map(run, normal_map)
    run.say(*more)
    run.say(*describe_composition(composition))
    run.warn(*composition.report.warnings)
    run.seconds(composition.report.seconds)
    metadata = map_header(run, *maps, **facts) | composition.report.to_dict()
    run.finish(outputs, written or composed_map(composition), metadata)
