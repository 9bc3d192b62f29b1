"""Convert one window of a normal map that is larger than memory."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nmaptool.composition.conversion import as_written, kept_where_sound, middle_fits_better
from nmaptool.core.vectors import inner_vertices, mean_abs_curl, unit
from nmaptool.io.stores.normal_maps import NormalMapStore
from nmaptool.io.stores.sampling import sample_of
from nmaptool.io.stores.windows import widened, within
from nmaptool.maps import codec
from nmaptool.maps.decoding import Decoded
from nmaptool.maps.windows import WINDOW_MARGIN_PX, decode_window_as_stored
from nmaptool.options import Bits, WriteOptions

Window: TypeAlias = tuple[slice, slice]


@dataclass
class Sums:
    """What the windows of a conversion add up to; as in `nmaptool.ConvertReport`, and the sums of curls."""

    vectors: int = 0
    off_length: int = 0
    off_length_largest: float = 0.0
    rim_pixels: int = 0
    curl_before: float = 0.0
    curl_after: float = 0.0
    vertices: int = 0

    def add(self, decoded: Decoded, off: NDArray[np.bool_], inner: Window) -> None:
        """Count the vectors of a window and those of odd length."""
        wrong = decoded.stored[inner][off[inner]].astype(np.float64)
        self.vectors += int(np.count_nonzero(decoded.normal_map.coverage[inner] > 0))
        self.off_length += len(wrong)
        largest = float(np.abs(np.sqrt(np.einsum("ij,ij->i", wrong, wrong)) - 1).max(initial=0))
        self.off_length_largest = max(self.off_length_largest, largest)


def converted_window(
    store: NormalMapStore, writing: WriteOptions, sums: Sums, has_alpha: bool, window: Window
) -> NDArray[Any]:
    """Return the codes of a window of the converted map.

    Parameters
    ----------
    store : NormalMapStore
    writing : WriteOptions
        With bits and zero code set.
    sums : Sums
        Gets what the window adds.
    has_alpha : bool
    window : (slice, slice)
        Both ends are given.

    Returns
    -------
    (h, w, 3 or 4) uint8, uint16, float16 or float32

    Raises
    ------
    InputError
    """
    shape = (store.rows, store.cols)
    rows, cols = (slice(part.start, min(part.stop + 1, size)) for part, size in zip(window, shape, strict=True))
    more = (rows, cols)  # a row and a column more, for the curl between windows
    around = widened(more, 0 if store.settled.background_color == "none" else WINDOW_MARGIN_PX, shape)
    image = store.picture.read(*around)
    whole, repaired = decode_window_as_stored(image, store.settled, store.decoding, (around[0].start, around[1].start))
    decoded = _cropped(whole, within(more, around))
    read = decoded.normal_map
    as_stored = unit(decoded.stored)
    untouched = (read.normals == as_stored).all(axis=-1)
    normals, off, _ = kept_where_sound(image, decoded, untouched)
    inner = (slice(window[0].stop - window[0].start), slice(window[1].stop - window[1].start))
    sums.add(decoded, off, inner)
    sums.rim_pixels += int(np.count_nonzero(repaired[within(window, around)]))
    count = int(np.count_nonzero(inner_vertices(read.foreground)))
    sums.vertices += count
    sums.curl_before += count * mean_abs_curl(as_stored, read.foreground)
    sums.curl_after += count * mean_abs_curl(as_written(normals, writing), read.foreground)
    codes = codec.encode_map(
        np.ascontiguousarray(normals[inner]),
        np.ascontiguousarray(read.coverage[inner]) if has_alpha else None,
        depth_of(writing.bits),
        green=writing.write_green,
        zero_code=writing.write_zero_code,
    )
    return codes.astype(np.float16) if writing.bits == "half" else codes


def _cropped(decoded: Decoded, place: Window) -> Decoded:
    """A part of a decoded window; its channels and its background stay those of the window."""
    read = decoded.normal_map
    coverage = np.ascontiguousarray(read.coverage[place])
    part = replace(
        read,
        normals=np.ascontiguousarray(read.normals[place]),
        coverage=coverage,
        foreground=np.ascontiguousarray(read.foreground[place]),
        frame=replace(read.frame, rows=coverage.shape[0], cols=coverage.shape[1]),
    )
    return replace(decoded, stored=np.ascontiguousarray(decoded.stored[place]), normal_map=part)


def with_checked_zero(store: NormalMapStore) -> NormalMapStore:
    """The store read with the zero code in the middle, if lengths contradict one that flat pixels suggested."""
    if store.decoding.zero_code_from != "found":
        return store
    sample, _ = sample_of(store.picture, lambda image, first: None)
    decoded, _ = decode_window_as_stored(sample, store.settled, store.decoding)
    if not middle_fits_better(decoded):
        return store
    middle = replace(store.decoding, zero_code="127.5")
    return NormalMapStore(store.picture, replace(store.settled, zero_code="127.5"), middle)


def depth_of(bits: Bits) -> int:
    """Bits of integer codes; 32 for floats."""
    return 32 if bits in ("half", "float") else int(bits)
