"""Overviews and pyramids: area averages that do not depend on the windows."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from large_maps import ROWS, as_zarr, codes_of, encodings, picture, rounded, surface

import nmaptool as nm
from nmaptool.core.errors import UsageError
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores import reducing, zarr_output
from nmaptool.io.stores.opening import create_picture, open_picture
from nmaptool.tiled import pyramid
from nmaptool.types.picture import RasterImage

zarr = pytest.importorskip("zarr")
EVERYTHING = (slice(None), slice(None))


def squares(values, factor):
    """Means of squares, one by one; those at the edges are smaller."""
    rows, cols = -(-values.shape[0] // factor), -(-values.shape[1] // factor)
    out = np.empty((rows, cols, *values.shape[2:]))
    for row in range(rows):
        for col in range(cols):
            part = values[row * factor : (row + 1) * factor, col * factor : (col + 1) * factor]
            out[row, col] = part.reshape(-1, *values.shape[2:]).mean(axis=0)
    return out


@pytest.fixture(autouse=True)
def small_windows(monkeypatch):
    monkeypatch.setattr(reducing, "_SIDE_PX", 16)
    monkeypatch.setattr(pyramid, "_AT_ONCE_PX", 48)
    monkeypatch.setattr(zarr_output, "_SMALLEST_PX", 60)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("longest", [1, 9, 60, 105])
def test_an_overview_is_the_mean_of_squares(tmp_path, dtype, longest):
    values = (np.random.default_rng(1).random((ROWS, 187, 3)) * 200).astype(dtype)
    small = nm.tiled.overview(as_zarr(picture(values), tmp_path / "map.zarr"), longest)
    expected = squares(values.astype(np.float64), -(-ROWS // longest))
    assert small.pixels.dtype == dtype
    assert small.pixels.shape == expected.shape
    assert max(small.frame.shape) <= longest
    if dtype != np.float32:
        expected = np.floor(expected + 0.5)
    np.testing.assert_allclose(small.pixels, expected, rtol=1e-6)


def test_a_small_picture_is_returned_as_it_is():
    whole = nm.read_raster("samples/medal_original.png")
    small = nm.tiled.overview("samples/medal_original.png", 248)
    assert np.array_equal(small.pixels, whole.pixels)


def test_the_pitch_grows_with_the_pixels(tmp_path):
    values = np.zeros((100, 80, 1), np.uint8)
    store = create_picture(f"{tmp_path}/a.zarr", 100, 80, ("Y",), np.uint8, chunk=64, inner=16, pitch_mm=0.25)
    store.write(0, 0, values)
    assert nm.tiled.overview(store.name, 25).frame.pitch_mm == 1.0


def test_colours_are_weighted_by_alpha(tmp_path):
    values = np.zeros((2, 2, 4), np.uint8)
    values[0, 0] = 100, 50, 10, 255
    values[1, 1] = 200, 90, 30, 85
    values[0, 1, :3] = 255
    small = nm.tiled.overview(as_zarr(picture(values, ("R", "G", "B", "A")), tmp_path / "a.zarr"), 1)
    assert small.pixels[0, 0].tolist() == [125, 60, 15, 85]


def test_heights_outside_the_surface_do_not_count(tmp_path):
    heights = np.arange(36, dtype=np.float32).reshape(6, 6, 1)
    heights[:4, :3] = np.nan
    small = nm.tiled.overview(as_zarr(RasterImage(heights, ("Y",), bits=32), tmp_path / "z.zarr"), 2).pixels[..., 0]
    assert np.isnan(small[0, 0])
    assert small[1, 0] == np.nanmean(heights[3:, :3])
    assert small[1, 1] == heights[3:, 3:].mean()


@pytest.mark.parametrize("bits", ["8", "16", "half", "float"])
def test_the_vectors_of_own_maps_are_averaged_and_of_unit_length(tmp_path, bits):
    n, _ = surface()
    image = encodings()["white in 16 bits"][0]
    nm.tiled.convert(as_zarr(image, tmp_path / "in.zarr"), f"{tmp_path}/map.zarr", writing=nm.WriteOptions(bits=bits))
    small = nm.tiled.overview(f"{tmp_path}/map.zarr", 30)
    read = nm.decode_normal_map(small)
    inside = read.coverage == 1
    expected = squares(n, 7)
    expected /= np.linalg.norm(expected, axis=2, keepdims=True)
    off = np.linalg.norm(read.normals - expected, axis=2)[inside]
    # next to the outline, vectors were repaired
    assert off.max() < (0.012 if bits == "8" else 0.003)
    assert np.median(off) < {"8": 0.006, "16": 5e-5, "half": 5e-4, "float": 1e-5}[bits]
    assert np.abs(np.linalg.norm(read.normals, axis=2) - 1).max() < 1e-3


def test_a_pyramid_halves_until_it_is_small(tmp_path):
    image = picture(rounded(codes_of(surface()[0])))
    name = as_zarr(image, tmp_path / "in.zarr")
    nm.tiled.convert(name, f"{tmp_path}/map.zarr", tile=64, pyramid=True)
    group = zarr.open_group(f"{tmp_path}/map.zarr", mode="r")
    assert {name: array.shape for name, array in group.arrays()} == {
        "0": (210, 190, 3), "1": (105, 95, 3), "2": (53, 48, 3),
    }  # fmt: skip
    assert group.attrs["nmaptool"] == {"pyramid": ["0", "1", "2"]}
    whole = open_picture(f"{tmp_path}/map.zarr").read(*EVERYTHING)
    nm.tiled.convert(name, f"{tmp_path}/plain.zarr", tile=64)
    assert np.array_equal(whole.pixels, open_picture(f"{tmp_path}/plain.zarr").read(*EVERYTHING).pixels)
    assert whole.notes == ()
    second = open_picture(f"{tmp_path}/map.zarr:1").read(*EVERYTHING)
    assert np.array_equal(second.pixels, nm.tiled.overview(f"{tmp_path}/plain.zarr", 105).pixels)


def test_heights_have_pyramids_too(tmp_path):
    heights = np.random.default_rng(2).random((131, 100, 1)).astype(np.float32)
    heights[:20] = np.nan
    store = create_picture(
        f"{tmp_path}/z.zarr", 131, 100, ("Y",), np.float32, chunk=64, inner=16, pitch_mm=0.5,
        attributes={"kind": "height", "unit": "mm", "at": "corners"},
    )  # fmt: skip
    store.write(0, 0, heights)
    nm.tiled.copy(store.name, f"{tmp_path}/levels.zarr", tile=64, pyramid=True)
    first, last = (open_picture(f"{tmp_path}/levels.zarr:{level}") for level in (0, 2))
    assert np.array_equal(first.read(*EVERYTHING).pixels, heights, equal_nan=True)
    assert (first.attributes["at"], "at" in last.attributes) == ("corners", False)
    assert (last.rows, last.cols, last.pitch_mm, last.attributes["kind"]) == (33, 25, 2.0, "height")
    np.testing.assert_allclose(
        last.read(slice(6, 32), slice(0, 25)).pixels, squares(heights.astype(float), 4)[6:32], rtol=1e-5
    )


def test_what_is_not_possible_is_refused(tmp_path):
    name = as_zarr(encodings()["8 bits"][0], tmp_path / "in.zarr")
    with pytest.raises(UsageError, match="`longest_px=0`: must be at least 1"):
        nm.tiled.overview(name, 0)
    for output in ("out.tif", "tiles", "out.png"):
        with pytest.raises(UsageError, match="`pyramid`: smaller versions are written into Zarr stores; name one"):
            nm.tiled.convert(name, f"{tmp_path}/{output}", pyramid=True)


def test_a_window_of_a_huge_store_takes_the_memory_of_the_window(tmp_path):
    """A map of 200000 x 200000, of which one shard is written."""
    side = 200_000
    store = create_picture(
        f"{tmp_path}/map.zarr", side, side, ("R", "G", "B"), np.uint8, chunk=512, inner=128,
        attributes={"absent_chunks": "fill"},
    )  # fmt: skip
    store.write(512 * 100, 512 * 200, np.full((512, 512, 3), 9, np.uint8))
    tracemalloc.start()
    try:
        picture_ = open_picture(store.name)
        window = picture_.read(slice(512 * 100 - 8, 512 * 100 + 500), slice(512 * 200 - 8, 512 * 200 + 500))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert (window.pixels[8:, 8:] == 9).all()
    assert not window.pixels[:8].any()
    assert most < 20e6


def test_an_overview_takes_the_memory_of_a_few_windows(tmp_path, monkeypatch):
    monkeypatch.setattr(reducing, "_SIDE_PX", 256)
    monkeypatch.setattr(pyramid, "_AT_ONCE_PX", 512)
    y, x = np.mgrid[0:2100, 0:2000]
    write_image(((y + x) // 20).astype(np.float32)[..., None], tmp_path / "grey.exr", ("Y",), {})
    nm.tiled.copy(f"{tmp_path}/grey.exr", f"{tmp_path}/grey.zarr", tile=256)
    nm.tiled.overview(f"{tmp_path}/grey.zarr", 100)  # loads what is loaded once
    tracemalloc.start()
    try:
        nm.tiled.overview(f"{tmp_path}/grey.zarr", 100)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 6e6 < 4 * 2100 * 2000
