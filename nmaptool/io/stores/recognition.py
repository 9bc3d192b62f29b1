"""Whether a name is that of a large map."""

from __future__ import annotations

from pathlib import PurePosixPath

from nmaptool.io.stores.names import ZARR_ENDING, local_path, split_name

_TIFF_ENDINGS = (".tif", ".tiff", ".btf", ".tf8")


def is_large_map(name: str, max_megapixels: float) -> bool:
    """As `nmaptool.io.stores.opening.is_store`, but without loading what reads stores where the name rules them out."""
    place, _ = split_name(name)
    path = local_path(place)
    ending = PurePosixPath(place).suffix.lower()
    if path is not None and not path.is_dir() and ending not in (ZARR_ENDING, *_TIFF_ENDINGS):
        return False
    from nmaptool.io.stores.opening import is_store

    return is_store(name, max_megapixels)
