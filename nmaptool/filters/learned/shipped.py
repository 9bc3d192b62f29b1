"""The filter that comes with the package; ``samples/train_filter.py`` makes it."""

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
    """The learned filter that is used where no other is given."""
    data = files("nmaptool.filters.learned").joinpath(NAME).read_bytes()
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return filter_from_arrays(dict(arrays))
