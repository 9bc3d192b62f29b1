"""Read learned filters and unfinished trainings from NumPy's .npz files; nothing in them is ever executed."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, reason_of
from nmaptool.filters.learned.arrays import filter_from_arrays, training_from_arrays
from nmaptool.filters.learned.model import FilterModel, TrainingState

# limit of a file and of its unpacked arrays; the shipped filters take a hundredth of it
_MOST_BYTES = 64_000_000
_MOST_ARRAYS = 4000
# a fixed date instead of the current time, so that the same arrays give the same bytes
_NO_DATE = (1980, 1, 1, 0, 0, 0)


def read_filter_model(path: str | Path) -> FilterModel:
    """Read a learned filter, such as one made by `nmaptool.train`.

    Parameters
    ----------
    path : str or Path
        A .npz file.

    Returns
    -------
    FilterModel

    Raises
    ------
    InputError
        If the file cannot be read or is not a learned filter. No code in it is ever run.

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


def read_training(path: str | Path) -> TrainingState:
    """Read an unfinished training.

    Parameters
    ----------
    path : str or Path
        A .npz file, written by `nmaptool.write_training`.

    Returns
    -------
    TrainingState
        For ``state`` of `nmaptool.train`.

    Raises
    ------
    InputError
        If the file cannot be read or is not an unfinished training.

    Examples
    --------
    >>> nm.write_training(nm.TrainingState("0123456789ab"), "begun.npz")
    >>> nm.read_training("begun.npz").fingerprint
    '0123456789ab'
    """
    try:
        return replace(training_from_arrays(_read(Path(path))), name=str(path))
    except InputError as error:
        raise _about(path, "an unfinished training", error) from None


def _about(path: str | Path, what: str, error: InputError) -> InputError:
    return InputError(f"{path}: cannot be used as {what}: {error}")


def _read(path: Path) -> dict[str, NDArray[Any]]:
    """Read the arrays of a .npz file; Python objects and large files are refused."""
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
            if len(members) > _MOST_ARRAYS:
                raise InputError(f"it has {len(members)} arrays, more than the limit of {_MOST_ARRAYS}")
            if sum(member.file_size for member in members) > _MOST_BYTES:
                raise InputError(f"it unpacks to more than the limit of {_MOST_BYTES} bytes")
            return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in members}
    except InputError:
        raise
    except Exception:  # noqa: BLE001 - a damaged archive may raise anything
        raise InputError("it is not a .npz file, or it is damaged") from None


def _array(data: bytes) -> NDArray[Any]:
    stream = io.BytesIO(data)
    array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    return array


def packed(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return the bytes of a .npz file of the arrays: the same arrays always give the same bytes."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as archive:
        for name, array in arrays.items():
            data = io.BytesIO()
            np.lib.format.write_array(data, np.ascontiguousarray(array), allow_pickle=False)
            member = zipfile.ZipInfo(f"{name}.npy", _NO_DATE)
            archive.writestr(member, data.getvalue(), zipfile.ZIP_DEFLATED)
    return held.getvalue()
