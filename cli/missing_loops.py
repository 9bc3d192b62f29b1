"""The warning of commands that take longer because the compiled loops are missing."""

from __future__ import annotations

from collections.abc import Container

from nmaptool.core.extension import extension_is_missing
from nmaptool.options import FilterOptions, ReliefOptions, SplitOptions, TrainOptions
from nmaptool.options.fields import Options

WARNING = (
    "the compiled loops are missing, so slower NumPy code ran in their place; to get them, install a C compiler and "
    "reinstall nmaptool-relief (in a clone: make setup); NMAPTOOL_KERNELS=numpy hides this warning"
)
# the filters of normals and the solver
_WITH_LOOPS = (ReliefOptions, SplitOptions, TrainOptions)


def loop_warnings(classes: Container[type[Options]], filtering: Options | None = None) -> tuple[str, ...]:
    """The warning, if a command with these options runs the loops and they should be compiled."""
    over_surface = isinstance(filtering, FilterOptions) and filtering.neighborhood == "surface"
    runs_loops = over_surface or any(options in classes for options in _WITH_LOOPS)
    return (WARNING,) if runs_loops and extension_is_missing() else ()
