"""Write learned filters and unfinished trainings to files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from nmaptool.core.errors import UsageError
from nmaptool.filters.learned.arrays import filter_to_arrays, training_to_arrays
from nmaptool.filters.learned.model import FilterModel, TrainingState
from nmaptool.io.filter_files import packed, read_training
from nmaptool.io.output.targets import Destination, Place, check_place, place_of
from nmaptool.io.output.transaction import Outputs, Target

_ENDING = ".npz"


@dataclass(frozen=True)
class TrainingFile:
    """The file that keeps the state of a training.

    Parameters
    ----------
    path : Path or None
        A .npz file, which each new state replaces. None: no state is kept.
    """

    path: Path | None = None

    def check(self, output: Place, overwrite: bool = False) -> None:
        """Refuse a file that cannot be written or replaced, before any work is done.

        Raises
        ------
        UsageError
            If the extension is not .npz, or the file is also that of the filter.
        OutputError
            If it cannot be written.
        """
        if self.path is None:
            return
        _check_ending(self.path)
        if isinstance(output, Path) and self.path.resolve() == output.resolve():
            raise UsageError(f"{self.path}: is named twice as an output")
        check_place(self.path, overwrite or self.path.exists())

    def begun(self) -> TrainingState | None:
        """Return the training to resume, or None if the file does not exist.

        Raises
        ------
        InputError
            If the file is not an unfinished training.
        """
        return read_training(self.path) if self.path is not None and self.path.exists() else None

    def keep(self, state: TrainingState) -> None:
        """Write the state to the file, if one was given."""
        if self.path is not None:
            write_training(state, self.path)

    def remove(self) -> None:
        """Remove the file, which is not needed once the filter is written."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)


def filter_outputs(
    output: Destination,
    *,
    report: Destination | None = None,
    overwrite: bool = False,
    kept: TrainingFile | None = None,
) -> Outputs[FilterModel]:
    """The plan of `write_filter_model`; ``kept`` is checked with it."""
    place = place_of(output)
    rules = [partial(_check_ending, place), partial((kept or TrainingFile()).check, place, overwrite)]
    return Outputs(
        [Target(place, "learned filters", (), _write_model)],
        place_of(report),
        overwrite,
        report_endings=(),
        rules=rules,
    )


def write_filter_model(model: FilterModel, path: Destination, *, overwrite: bool = False) -> None:
    """Write a learned filter; the same filter always gives the same bytes.

    Parameters
    ----------
    model : FilterModel
    path : str, Path or OutputStream
        A .npz file.
    overwrite : bool
        Replace a file that exists.

    Raises
    ------
    UsageError
        If the extension is not .npz.
    OutputError
        If it cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> nm.write_filter_model(nm.shipped_filter(), "mine.npz", overwrite=True)
    """
    filter_outputs(path, overwrite=overwrite).write(model)


def write_training(state: TrainingState, path: Destination) -> None:
    """Write an unfinished training; the file is replaced if it exists.

    Parameters
    ----------
    state : TrainingState
        As passed to the ``keep`` callback of `nmaptool.train`.
    path : str, Path or OutputStream
        A .npz file.

    Raises
    ------
    OutputError
        If it cannot be written.

    Examples
    --------
    >>> nm.write_training(nm.TrainingState("0123456789ab"), "begun.npz")
    """
    plan: Outputs[TrainingState] = Outputs([Target(place_of(path), "a training", (), _write_state)], overwrite=True)
    plan.write(state, final=False)


def _check_ending(place: Place) -> None:
    if place.suffix.lower() != _ENDING:
        raise UsageError(f"{place}: learned filters and trainings are written as {_ENDING}")


def _write_model(model: FilterModel, path: Path) -> None:
    path.write_bytes(packed(filter_to_arrays(model)))


def _write_state(state: TrainingState, path: Path) -> None:
    path.write_bytes(packed(training_to_arrays(state)))
