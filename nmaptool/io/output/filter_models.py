"""Learned filters and unfinished trainings in files: NumPy's .npz, of which nothing is ever executed."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, UsageError, reason_of
from nmaptool.filters.learned.arrays import (
    filter_from_arrays,
    filter_to_arrays,
    training_from_arrays,
    training_to_arrays,
)
from nmaptool.filters.learned.model import FilterModel, TrainingState
from nmaptool.io.replace import check_targets, named, written_beside

ENDING = ".npz"
# of a file and of what it unpacks to: shipped ones take a hundredth
_MOST_BYTES = 64_000_000
_MOST_ARRAYS = 4000
# zip files begin with the time they were made, unless told otherwise
_NO_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class TrainingFiles:
    """Where a learned filter goes.

    Parameters
    ----------
    output : Path
        .npz
    state : Path or None
        What is finished is kept there, .npz.
    report : Path or None
        .json
    overwrite : bool
        Replace files that exist; a state is replaced by its next one anyhow.
    """

    output: Path
    state: Path | None = None
    report: Path | None = None
    overwrite: bool = False

    @property
    def targets(self) -> list[Path]:
        """What is there in the end."""
        return [self.output, *([self.report] if self.report is not None else [])]

    def check(self) -> None:
        """Refuse what could not be written, before any work is done.

        Raises
        ------
        UsageError
            If an ending is not offered or a file is named twice.
        OutputError
            If a target cannot be written or exists.
        InputError
            If the state exists and is none.
        """
        for path in (self.output, self.state):
            if path is not None:
                _check_ending(path)
        states = [self.state] if self.state is not None else []
        check_targets([*self.targets, *(path for path in states if not path.exists())], self.overwrite)
        if self.state in self.targets:
            raise UsageError(f"{self.state}: is named twice as an output")
        self.begun()

    def begun(self) -> TrainingState | None:
        """The training to go on with; None where there is none.

        Raises
        ------
        InputError
            If the file is no training.
        """
        return read_training(self.state) if self.state is not None and self.state.exists() else None

    def keep(self, state: TrainingState) -> None:
        """Keep what is finished, where that is asked for."""
        if self.state is not None:
            write_training(state, self.state)

    def write(self, model: FilterModel, metadata: Mapping[str, Any]) -> None:
        """Write the filter and its report, both or none; the state has served then and goes.

        Raises
        ------
        OutputError
            If one cannot be written.
        """
        with written_beside(self.targets, self.overwrite) as beside:
            with named(self.output, beside[0]):
                beside[0].write_bytes(_packed(filter_to_arrays(model)))
            if self.report is not None:
                with named(self.report, beside[1]):
                    beside[1].write_text(json.dumps(metadata, indent=2) + "\n")
        if self.state is not None:
            self.state.unlink(missing_ok=True)


def _check_ending(path: Path) -> None:
    if path.suffix.lower() != ENDING:
        raise UsageError(f"{path}: learned filters are kept in files that end in {ENDING}")


def read_filter_model(path: str | Path) -> FilterModel:
    """Read a learned filter, such as `nmaptool.train` makes.

    Parameters
    ----------
    path : str or Path
        .npz

    Returns
    -------
    FilterModel

    Raises
    ------
    InputError
        If it cannot be read or is not a learned filter. Code in the file is never run.

    Examples
    --------
    >>> nm.write_filter_model(nm.shipped_filter(), "mine.npz")
    >>> nm.read_filter_model("mine.npz").digest == nm.shipped_filter().digest
    True
    """
    try:
        return filter_from_arrays(_read(Path(path)))
    except InputError as error:
        raise _about(path, "a learned filter", error) from None


def write_filter_model(model: FilterModel, path: str | Path, *, overwrite: bool = False) -> None:
    """Write a learned filter; the same filter always gives the same bytes.

    Parameters
    ----------
    model : FilterModel
    path : str or Path
        .npz
    overwrite : bool
        Replace a file that exists.

    Raises
    ------
    UsageError
        If the ending is another.
    OutputError
        If it cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> nm.write_filter_model(nm.shipped_filter(), "mine.npz", overwrite=True)
    """
    target = Path(path)
    _check_ending(target)
    _write(target, filter_to_arrays(model), overwrite)


def read_training(path: str | Path) -> TrainingState:
    """Read the state of an unfinished training.

    Parameters
    ----------
    path : str or Path
        .npz, written by `nmaptool.write_training`.

    Returns
    -------
    TrainingState
        For ``state`` of `nmaptool.train`.

    Raises
    ------
    InputError
        If it cannot be read or is not a training.

    Examples
    --------
    >>> nm.write_training(nm.TrainingState("0123456789ab"), "begun.npz")
    >>> nm.read_training("begun.npz").fingerprint
    '0123456789ab'
    """
    try:
        return replace(training_from_arrays(_read(Path(path))), name=str(path))
    except InputError as error:
        raise _about(path, "a training that was begun", error) from None


def write_training(state: TrainingState, path: str | Path) -> None:
    """Write the state of an unfinished training; replaces what the file held before.

    Parameters
    ----------
    state : TrainingState
        As ``keep`` of `nmaptool.train` is given it.
    path : str or Path
        .npz

    Raises
    ------
    OutputError
        If it cannot be written.

    Examples
    --------
    >>> nm.write_training(nm.TrainingState("0123456789ab"), "begun.npz")
    """
    _write(Path(path), training_to_arrays(state), overwrite=True, last=False)


def _about(path: str | Path, what: str, error: InputError) -> InputError:
    return InputError(f"{path}: cannot be used as {what}: {error}")


def _write(target: Path, arrays: Mapping[str, NDArray[Any]], overwrite: bool, last: bool = True) -> None:
    with written_beside([target], overwrite, last=last) as (temporary,), named(target, temporary):
        temporary.write_bytes(_packed(arrays))


def _packed(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as archive:
        for name, array in arrays.items():
            data = io.BytesIO()
            np.lib.format.write_array(data, np.ascontiguousarray(array), allow_pickle=False)
            member = zipfile.ZipInfo(f"{name}.npy", _NO_DATE)
            archive.writestr(member, data.getvalue(), zipfile.ZIP_DEFLATED)
    return held.getvalue()


def _read(path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of a .npz file, none of them of Python objects, all of them small."""
    try:
        size = path.stat().st_size
        if size > _MOST_BYTES:
            raise InputError(f"it has {size} bytes, more than the limit of {_MOST_BYTES}")
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"it cannot be read ({reason_of(error)})") from None
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len(members) > _MOST_ARRAYS or sum(member.file_size for member in members) > _MOST_BYTES:
                raise InputError(f"it unpacks to more than the limit of {_MOST_BYTES} bytes")
            return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in members}
    except InputError:
        raise
    except Exception:  # noqa: BLE001 - whatever a damaged archive makes a reader stumble over
        raise InputError("it is no .npz file, or damaged") from None


def _array(data: bytes) -> NDArray[Any]:
    stream = io.BytesIO(data)
    array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    return array
