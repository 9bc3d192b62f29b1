"""Masks and maps of weights by windows, with the values of `nm.read_grey`."""

from __future__ import annotations

import numpy as np
import pytest
from large_maps import as_zarr, picture

import nmaptool as nm
from nmaptool.core.errors import InputError
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores import grey, sampling
from nmaptool.io.stores.grey import open_grey
from nmaptool.types.picture import RasterImage

zarr = pytest.importorskip("zarr")
ROWS, COLS = 150, 130
EVERYTHING = (slice(None), slice(None))


@pytest.fixture(autouse=True)
def small_windows(monkeypatch):
    """The sample and the windows of a pass are small, compared with these pictures."""
    monkeypatch.setattr(sampling, "_SAMPLE_PX", 16)
    monkeypatch.setattr(grey, "_LOOK_PX", 64)


def grey_pixels(dtype, top):
    y, x = np.mgrid[0:ROWS, 0:COLS]
    share = ((np.hypot(y - 70, x - 60) - 20) / 30).clip(0, 1)
    return (share * top).astype(dtype)[..., None]


def kinds():
    codes = grey_pixels(np.uint8, 255)
    solid = np.full_like(codes, 200)
    small = np.zeros((ROWS, COLS, 1), np.uint8)
    small[57, 43] = 255
    return {
        "8 bits": (codes, ("Y",)),
        "16 bits": (grey_pixels(np.uint16, 65535), ("Y",)),
        "floats": (grey_pixels(np.float32, 3.5), ("Y",)),
        "three equal channels": (np.repeat(codes, 3, axis=2), ("R", "G", "B")),
        "only alpha varies": (np.dstack([solid, solid, solid, codes]), ("R", "G", "B", "A")),
        "alpha does not vary": (np.dstack([codes, solid]), ("Y", "A")),
        "both vary": (np.dstack([codes, 255 - codes]), ("Y", "A")),
        "neither varies": (np.dstack([solid, solid]), ("Y", "A")),
        "one pixel": (small, ("Y",)),
        "one pixel of alpha": (np.dstack([solid, small]), ("Y", "A")),
        "black": (np.zeros((ROWS, COLS, 1), np.uint8), ("Y",)),
    }


@pytest.mark.parametrize("kind", kinds())
def test_a_window_has_the_values_of_read_grey(tmp_path, kind):
    pixels, channels = kinds()[kind]
    ending = "exr" if pixels.dtype == np.float32 else "png"
    write_image(pixels, tmp_path / f"mask.{ending}", channels, {})
    whole = nm.read_grey(tmp_path / f"mask.{ending}")
    image = RasterImage(pixels, channels, bits=8 * pixels.dtype.itemsize)
    for name in (str(tmp_path / f"mask.{ending}"), as_zarr(image, tmp_path / "mask.zarr")):
        store = open_grey(name)
        for window in (EVERYTHING, (slice(50, 60), slice(40, 50)), (slice(140, 150), slice(0, 3))):
            part = store.window(*window)
            assert part.dtype == np.float32
            assert np.array_equal(part, whole[window])


def test_a_mask_of_0_and_1_is_read_from_zarr_and_refused_from_files(tmp_path):
    codes = (grey_pixels(np.uint8, 255) > 128).astype(np.uint8)
    mask = open_grey(as_zarr(RasterImage(codes, ("Y",)), tmp_path / "mask.zarr"))
    assert np.array_equal(mask.window(*EVERYTHING), codes[..., 0])
    array = zarr.create_array(tmp_path / "bool.zarr", shape=(ROWS, COLS), dtype="bool", chunks=(32, 32))
    array[:] = codes[..., 0] > 0
    array.attrs["nmaptool"] = {"absent_chunks": "fill"}
    assert np.array_equal(open_grey(str(tmp_path / "bool.zarr")).window(*EVERYTHING), codes[..., 0])
    write_image(codes, tmp_path / "mask.png", ("Y",), {})
    with pytest.raises(InputError, match="holds only the codes 0 and 1 of 255; save white as 255"):
        open_grey(str(tmp_path / "mask.png"))


def test_colours_and_nan_are_refused_in_the_window_that_holds_them(tmp_path):
    pixels = np.repeat(grey_pixels(np.uint8, 255), 3, axis=2)
    pixels[57, 43, 1] ^= 128
    store = open_grey(as_zarr(picture(pixels), tmp_path / "mask.zarr"))
    assert store.window(slice(0, 50), slice(0, 40)).any()
    with pytest.raises(InputError, match="is a colour picture; a mask or weight map must be grey"):
        store.window(slice(50, 60), slice(40, 50))
    floats = grey_pixels(np.float32, 2)
    floats[57, 43] = np.nan
    store = open_grey(as_zarr(RasterImage(floats, ("Y",), bits=32), tmp_path / "weights.zarr"))
    with pytest.raises(InputError, match="holds NaN or infinite values; repair them"):
        store.window(slice(50, 60), slice(40, 50))
