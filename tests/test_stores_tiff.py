"""Pages of TIFF files by windows, with the values of the ordinary reader."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import tifffile

import nmaptool as nm
from nmaptool.core.errors import InputError
from nmaptool.io.stores.opening import is_store
from nmaptool.io.stores.tiff_files import TiffPicture

ROWS, COLS = 150, 130
WINDOWS = [
    (slice(None), slice(None)),
    (slice(10, 100), slice(60, 130)),
    (slice(63, 65), slice(63, 65)),
    (slice(149, 150), slice(0, 1)),
]
LAYOUTS = {
    "tiles": {"tile": (64, 48)},
    "tiles-deflate": {"tile": (64, 48), "compression": "deflate", "predictor": True},
    "tiles-lzw": {"tile": (32, 32), "compression": "lzw"},
    "bigtiff": {"tile": (64, 48), "bigtiff": True, "compression": "deflate"},
    "strips": {"rowsperstrip": 16},
    "strips-deflate": {"rowsperstrip": 7, "compression": "deflate"},
    "one-strip": {"rowsperstrip": ROWS, "compression": "deflate"},
    "zstd": {"tile": (64, 48), "compression": "zstd"},
    "zstd-strips": {"rowsperstrip": 7, "compression": "zstd", "predictor": True},
    "planes": {"tile": (64, 48), "planarconfig": "separate"},
    "zstd-planes": {"tile": (64, 48), "planarconfig": "separate", "compression": "zstd"},
}


def pixels_of(dtype, channels=3):
    values = np.random.default_rng(5).random((ROWS, COLS, channels)) * 250
    return values.astype(dtype)


def saved(path, values, **layout):
    if layout.get("planarconfig") == "separate":
        values = np.moveaxis(values, -1, 0)
    extra = {"extrasamples": ["unassalpha"]} if 4 in values.shape else {}
    tifffile.imwrite(path, values, photometric="rgb", description="nmaptool:pitch_mm=0.25", **layout, **extra)
    return str(path)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
def test_a_window_of_a_tiff_is_that_of_the_ordinary_reader(tmp_path, layout, dtype):
    if "zstd" in layout:
        pytest.importorskip("imagecodecs")
    name = saved(tmp_path / "map.tif", pixels_of(dtype, 4), **LAYOUTS[layout])
    whole = nm.read_raster(name)
    store = pickle.loads(pickle.dumps(TiffPicture(name)))
    assert (store.rows, store.cols, store.channels) == (ROWS, COLS, ("R", "G", "B", "A"))
    assert store.pitch_mm == whole.frame.pitch_mm == 0.25
    for window in WINDOWS:
        image = store.read(*window)
        assert np.array_equal(image.pixels, whole.pixels[window])
        assert (image.bits, image.channels, image.notes) == (whole.bits, whole.channels, whole.notes)


@pytest.mark.parametrize("values", [np.uint8, np.uint16, np.int32, np.float64, np.float16, bool])
def test_grey_numbers_are_those_of_the_ordinary_reader(tmp_path, values):
    numbers = (pixels_of("float64", 1)[..., 0] - (100 if values in (np.int32, np.float64) else 0)).astype(values)
    tifffile.imwrite(tmp_path / "grey.tif", numbers, tile=(32, 32), photometric="minisblack")
    whole = nm.read_raster(tmp_path / "grey.tif", holds="grey")
    store = TiffPicture(str(tmp_path / "grey.tif"), holds="grey")
    for window in WINDOWS:
        image = store.read(*window)
        assert np.array_equal(image.pixels, whole.pixels[window])
        assert (image.bits, image.notes) == (whole.bits, whole.notes)


def test_a_negative_and_a_palette_are_read_as_shown(tmp_path):
    codes = pixels_of("uint16", 1)[..., 0]
    tifffile.imwrite(tmp_path / "white.tif", codes, tile=(32, 32), photometric="miniswhite")
    palette = np.random.default_rng(1).integers(0, 256, (3, 256)).astype(np.uint16) * 257
    tifffile.imwrite(
        tmp_path / "palette.tif", codes.astype(np.uint8), tile=(32, 32), photometric="palette", colormap=palette
    )
    for name in ("white", "palette"):
        whole = nm.read_raster(tmp_path / f"{name}.tif")
        store = TiffPicture(str(tmp_path / f"{name}.tif"))
        for window in WINDOWS:
            assert np.array_equal(store.read(*window).pixels, whole.pixels[window])


def test_a_page_is_chosen_by_its_name(tmp_path):
    values = pixels_of("uint8")
    with tifffile.TiffWriter(tmp_path / "pages.tif") as tiff:
        tiff.write(values, tile=(64, 64), photometric="rgb")
        tiff.write(250 - values, tile=(64, 64), photometric="rgb")
    name = str(tmp_path / "pages.tif")
    assert np.array_equal(TiffPicture(f"{name}:page 2").read(slice(9), slice(9)).pixels, (250 - values)[:9, :9])
    assert "holds 2 pages, of which the first is read" in TiffPicture(name).read(slice(9), slice(9)).notes[0]
    with pytest.raises(InputError, match="has no layer 'page 3'"):
        TiffPicture(name, "page 3")


@pytest.mark.parametrize("layout", ["tiles-deflate", "zstd", "strips-deflate"])
def test_a_damaged_part_is_named_and_the_rest_is_read(tmp_path, layout):
    name = saved(tmp_path / "map.tif", pixels_of("uint16"), **LAYOUTS[layout])
    with tifffile.TiffFile(name) as tiff:
        place, size = tiff.pages[0].dataoffsets[-1], tiff.pages[0].databytecounts[-1]
    data = bytearray((tmp_path / "map.tif").read_bytes())
    data[place : place + size] = b"\xff" * size
    (tmp_path / "map.tif").write_bytes(data)
    store = TiffPicture(name)
    assert store.read(slice(0, 64), slice(0, 64)).pixels.any()
    with pytest.raises(InputError, match=r"map.tif: a part of rows .* to 150 is missing or damaged"):
        store.read(slice(None), slice(None))


@pytest.mark.parametrize("layout", ["tiles-deflate", "zstd"])
def test_a_missing_tile_is_an_error(tmp_path, layout):
    name = saved(tmp_path / "map.tif", pixels_of("uint16"), **LAYOUTS[layout])
    with tifffile.TiffFile(name, mode="r+b") as tiff:
        tags = tiff.pages[0].tags
        for code in (324, 325):
            values = list(tags[code].value)
            tags[code].overwrite([*values[:-1], 0])
    with pytest.raises(InputError, match="is missing or damaged"):
        TiffPicture(name).read(slice(None), slice(None))


def test_only_a_large_tiff_counts_as_a_store(tmp_path):
    name = saved(tmp_path / "map.tif", pixels_of("uint8"))
    assert not is_store(name)
    assert is_store(name, max_megapixels=0.01)
    (tmp_path / "text.tif").write_text("no picture")
    assert not is_store(str(tmp_path / "text.tif"), max_megapixels=0)
    assert not is_store(str(tmp_path / "none.tif"), max_megapixels=0)


def test_a_position_on_the_page_is_ignored_and_complex_numbers_are_refused(tmp_path):
    values = pixels_of("uint8")
    position = [(286, "2I", 1, (5, 1), True), (287, "2I", 1, (5, 1), True)]
    tifffile.imwrite(tmp_path / "placed.tif", values, photometric="rgb", resolution=(10, 10), extratags=position)
    for window in WINDOWS:
        assert np.array_equal(TiffPicture(str(tmp_path / "placed.tif")).read(*window).pixels, values[window])
    full = [(33300, "I", 1, 200, True), (33301, "I", 1, 200, True)]
    tifffile.imwrite(tmp_path / "placed.tif", values, photometric="rgb", extratags=full)
    with pytest.raises(InputError, match="is a part of a larger page; save it as a page of its own"):
        TiffPicture(str(tmp_path / "placed.tif"))
    tifffile.imwrite(tmp_path / "complex.tif", values[..., 0].astype(np.complex64))
    with pytest.raises(InputError, match="stores complex numbers"):
        TiffPicture(str(tmp_path / "complex.tif"))
