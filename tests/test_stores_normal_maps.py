"""Normal maps and masks by windows: decoding a window equals decoding the whole."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.io.stores.grey import open_grey
from nmaptool.io.stores.normal_maps import open_normal_map, reopen_normal_map
from nmaptool.io.stores.opening import create_picture

pytest.importorskip("zarr")
WINDOWS = [(slice(None), slice(None)), (slice(30, 110), slice(50, 99)), (slice(200, 224), slice(0, 5))]


def as_zarr(image, path):
    writer = create_picture(
        str(path), *image.frame.shape, image.channels, image.pixels.dtype, chunk=64, inner=16,
        pitch_mm=image.frame.pitch_mm, attributes=image.attributes,
    )  # fmt: skip
    writer.write(0, 0, image.pixels)
    return str(path)


@pytest.mark.parametrize("file", ["medal_original", "medal_base", "leaf_on_roll", "roll", "medal_detail", "shell"])
def test_windows_of_the_samples_are_decoded_as_the_whole(tmp_path, file):
    path = f"samples/{file}.png"
    whole = nm.read_normal_map(path)
    for name in (path, as_zarr(nm.read_raster(path), tmp_path / "map.zarr")):
        opened = open_normal_map(name)
        assert opened.decoding.green == whole.decoding.green
        store = reopen_normal_map(name, pickle.loads(pickle.dumps(opened.settled)))
        for window in WINDOWS:
            part = store.window(*window)
            assert np.array_equal(part.normals, whole.normals[window])
            assert np.array_equal(part.coverage, whole.coverage[window])
            assert np.array_equal(part.foreground, whole.foreground[window])


def test_a_mask_has_the_values_of_read_grey(tmp_path):
    whole = nm.read_grey("samples/leaf_mask.png")
    for name in ("samples/leaf_mask.png", as_zarr(nm.read_raster("samples/leaf_mask.png"), tmp_path / "mask.zarr")):
        store = open_grey(name)
        assert (store.rows, store.cols) == whole.shape
        for window in WINDOWS:
            assert np.array_equal(store.window(*window), whole[window])
