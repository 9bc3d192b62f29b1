"""What a picture that is written by windows is like."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

# makes the (h, w, C) pixels of a window
Make: TypeAlias = Callable[[slice, slice], NDArray[Any]]


@dataclass(frozen=True)
class PicturePlan:
    """A picture to write.

    Parameters
    ----------
    rows, cols : int
    channels : tuple of str
    dtype : dtype
        uint8, uint16, float32, or float16, which is stored as half.
    pitch_mm : float or None
    attributes : mapping of str
        As in `nmaptool.RasterImage`.
    """

    rows: int
    cols: int
    channels: tuple[str, ...]
    dtype: np.dtype[Any]
    pitch_mm: float | None = None
    attributes: Mapping[str, str] = field(default_factory=dict)

    @property
    def file_attributes(self) -> dict[str, str]:
        """The attributes with the pitch, as text, for files."""
        pitch = {} if self.pitch_mm is None else {"pitch_mm": repr(self.pitch_mm)}
        return {**self.attributes, **pitch}
