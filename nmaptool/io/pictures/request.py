"""What is asked of a picture file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.pictures.size_limit import check_size


@dataclass(frozen=True)
class Request:
    """What is asked of a picture file.

    Parameters
    ----------
    layer : str or None
        The layer, part, page or array to read; None for the obvious one.
    max_megapixels : float
    holds : str
        What the reader is about to do with it, ``normals``, ``depth`` or ``grey`` (a mask or weight map): decides
        which layer is the obvious one.
    """

    layer: str | None = None
    max_megapixels: float = 270.0
    holds: Holds = "normals"

    def check_size(self, path: Path, cols: int, rows: int) -> None:
        """Refuse a picture over the limit, before anything is allocated.

        Raises
        ------
        LimitError
        """
        check_size(path, cols, rows, self.max_megapixels)

    def refuse_layer(self, path: Path, kind: str) -> None:
        """Refuse a layer of a file of a format without layers.

        Raises
        ------
        InputError
        """
        if self.layer is not None:
            raise InputError(f"{path}: has no layer {self.layer!r}; a {kind} file holds one picture")


def damaged(path: Path, kind: str) -> InputError:
    """The error about a file that ends too early or holds nonsense."""
    return InputError(f"{path}: the {kind} file is truncated or damaged; export or download it again")
