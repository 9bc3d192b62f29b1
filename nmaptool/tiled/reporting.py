"""Reports of edits by tiles, and what is stored with their results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, TypeVar

from nmaptool.io.stores.normal_maps import NormalMapStore
from nmaptool.options.fields import Options
from nmaptool.options.plain_values import plain_values
from nmaptool.tiled.edits import Cut
from nmaptool.types.report import Report
from nmaptool.types.tiled_edit import TiledEdit, TiledInput

_Report = TypeVar("_Report", bound=Report)


def has_coverage(store: NormalMapStore) -> bool:
    """Whether parts of a map may be undefined: it has alpha, or a colour of its background is cut away."""
    return "A" in store.picture.channels or store.decoding.background != "none"


def recipe_text(command: str, options: Options, **more: Any) -> str:
    """The recipe that is stored with a result."""
    return json.dumps({"command": command, "options": plain_values(options), **more})


def tiled_edit(
    report: _Report,
    output: str,
    made: Cut,
    resumed: int,
    maps: Sequence[NormalMapStore],
    pitch_mm: float | None = None,
    overlap: int | None = None,
) -> TiledEdit[_Report]:
    """The report of a run; the pitch is that of the first map and the overlap that of the cut, unless given."""
    grid = made.grid
    inputs = tuple(TiledInput(one.name, one.rows, one.cols, one.decoding) for one in maps)
    pitch_mm = maps[0].pitch_mm if pitch_mm is None and maps else pitch_mm
    return TiledEdit(
        report,
        output,
        grid.rows,
        grid.cols,
        pitch_mm,
        grid.tile,
        grid.overlap if overlap is None else overlap,
        len(grid),
        made.workers,
        resumed,
        inputs,
    )
