"""The filter that comes with the package; ``samples/train_filter.py`` trains it."""

from __future__ import annotations

import functools
import io
from importlib.resources import files

import numpy as np

from nmaptool.filters.learned.arrays import filter_from_arrays
from nmaptool.filters.learned.model import FilterModel

NAME = "filter.npz"


@functools.cache
def shipped_filter() -> FilterModel:
    """Load the learned filter that comes with the package, which is the default model.

    Returns
    -------
    FilterModel
        The same object on every call.

    Raises
    ------
    InputError
        If its file in the package is damaged.

    Examples
    --------
    >>> len(nm.shipped_filter().stages)
    3
    """
    data = files("nmaptool.filters.learned").joinpath(NAME).read_bytes()
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return filter_from_arrays(dict(arrays))
