"""Heights larger than memory as BigTIFF, tiles of PNG and NumPy arrays."""

from __future__ import annotations

import json
import tracemalloc

import numpy as np
import pytest
import tifffile

import nmaptool as nm
from nmaptool.io.stores.export import check_export, export_heights
from nmaptool.io.stores.height_windows import ArrayHeights, HeightRange, height_window


def waves(rows=300, cols=420, gaps=False, kind=np.float32):
    y, x = np.mgrid[:rows, :cols]
    z_mm = (np.sin(x / 31) * np.cos(y / 23) * 3).astype(kind)
    return np.where(np.hypot(x - cols / 2, y - rows / 2) < 0.45 * rows, z_mm, np.nan).astype(kind) if gaps else z_mm


@pytest.mark.parametrize("ending", [".tif", ".npy"])
@pytest.mark.parametrize("gaps", [False, True])
@pytest.mark.parametrize("at", ["centers", "corners"])
def test_files_are_read_back_as_what_was_written(at, gaps, ending, tmp_path):
    source = ArrayHeights(waves(gaps=gaps), 0.25, at)
    found = export_heights(source, tmp_path / f"z{ending}")
    assert found == HeightRange(float(np.nanmin(source.z_mm)), float(np.nanmax(source.z_mm)), gaps)
    back = nm.read_height(tmp_path / f"z{ending}", pitch_mm=0.25, with_gaps=True)
    less = 1 if at == "corners" else 0
    assert back.frame == nm.Frame(300 - less, 420 - less, 0.25)
    if at == "corners":
        expected = height_window(source, slice(0, 299), slice(0, 419))
        assert expected is not None
        assert np.array_equal(back.domain, expected.domain)
        assert np.array_equal(back.z_mm, expected.z_mm)
    else:
        assert np.array_equal(back.domain, ~np.isnan(source.z_mm))
        inner = ~np.isnan(source.z_mm)
        means = (source.z_mm[:-1, :-1] + source.z_mm[1:, 1:] + source.z_mm[:-1, 1:] + source.z_mm[1:, :-1]) / 4
        whole = inner[:-1, :-1] & inner[1:, 1:] & inner[:-1, 1:] & inner[1:, :-1]
        assert np.abs(back.z_mm[1:-1, 1:-1] - means)[whole].max() < 1e-5


def test_a_tiff_is_big_has_tiles_and_states_its_pitch(tmp_path):
    export_heights(ArrayHeights(waves(), 0.25), tmp_path / "z.tif", tile_px=128)
    with tifffile.TiffFile(tmp_path / "z.tif") as tiff:
        page = tiff.pages[0]
        assert tiff.is_bigtiff
        assert (page.tilewidth, page.tilelength, page.dtype) == (128, 128, np.float32)
    image = nm.read_raster(tmp_path / "z.tif")
    assert image.frame.pitch_mm == 0.25
    assert image.depth_facts is not None
    assert image.depth_facts.kind == "height"
    assert np.array_equal(image.pixels[..., 0], waves())


@pytest.mark.parametrize("gaps", [False, True])
def test_all_tiles_have_one_range_of_heights(gaps, tmp_path):
    z_mm = waves(gaps=gaps)
    export_heights(ArrayHeights(z_mm, 0.25), tmp_path / "tiles", tile_px=128)
    index = json.loads((tmp_path / "tiles" / "tiles.json").read_text())
    assert (index["tile_rows"], index["tile_cols"], index["rows"], index["cols"]) == (3, 4, 300, 420)
    assert (index["black_mm"], index["white_mm"]) == (float(np.nanmin(z_mm)), float(np.nanmax(z_mm)))
    span = index["white_mm"] - index["black_mm"]
    joined = np.full(z_mm.shape, np.nan)
    for row in range(3):
        for col in range(4):
            tile = nm.read_raster(tmp_path / "tiles" / f"tile_{row}_{col}.png")
            assert (tile.bits, tile.channels) == (16, ("Y", "A") if gaps else ("Y",))
            assert tile.depth_facts is not None
            assert (tile.depth_facts.black_mm, tile.depth_facts.white_mm) == (index["black_mm"], index["white_mm"])
            assert (tile.attributes["top_px"], tile.attributes["left_px"]) == (str(row * 128), str(col * 128))
            heights = index["black_mm"] + tile.pixels[..., 0] / 65535 * span
            if gaps:
                heights = np.where(tile.pixels[..., 1] > 0, heights, np.nan)
            joined[row * 128 : (row + 1) * 128, col * 128 : (col + 1) * 128] = heights
    assert np.array_equal(np.isnan(joined), np.isnan(z_mm))
    assert np.nanmax(np.abs(joined - z_mm)) <= span / 65535


def test_a_flat_map_is_black(tmp_path):
    export_heights(ArrayHeights(np.full((20, 30), 2.5), 0.5), tmp_path / "flat")
    assert nm.read_raster(tmp_path / "flat" / "tile_0_0.png").pixels.max() == 0


class Striped:
    """Heights that are made when they are read; no array holds them."""

    cols, pitch_mm, at = 700, 0.1, "centers"

    def __init__(self, rows):
        self.rows = rows
        self.largest = 0

    def window(self, rows, cols):
        found = np.add.outer(np.arange(rows.start, rows.stop) % 97, np.arange(cols.start, cols.stop) % 31)
        self.largest = max(self.largest, found.size)
        return found.astype(np.float32)


@pytest.mark.parametrize("name", ["z.tif", "z.npy", "tiles"])
def test_memory_does_not_grow_with_the_number_of_rows(name, tmp_path):
    peaks = []
    for number, rows in enumerate((1200, 6000)):
        source = Striped(rows)
        tracemalloc.start()
        export_heights(source, tmp_path / f"{number}{name}", tile_px=256)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert source.largest <= 512 * 700
    assert peaks[1] < 1.3 * peaks[0] + 2e6


def test_progress_reaches_the_end(tmp_path):
    told = []

    def tell(stage, share):
        told.append((stage, share))

    export_heights(ArrayHeights(waves(), 0.25), tmp_path / "z.tif", progress=tell)
    assert ("range", 1.0) in told
    assert told[-1] == ("writing", 1.0)


@pytest.mark.parametrize(
    ("name", "more", "error", "pattern"),
    [
        (
            "z.exr",
            {},
            nm.UsageError,
            r"ends in \.exr; heights of a large map are written as \.tif, \.tiff, \.npy, or",
        ),
        ("z.tif", {"tile_px": 100}, nm.UsageError, "`tile_px=100`: use a multiple of 16 for TIFF"),
        ("tiles", {"tile_px": 3}, nm.UsageError, "`tile_px=3`: use a multiple of 16 for TIFF, and at least 16"),
        ("there.tif", {}, nm.OutputError, r"there\.tif: already exists; give another name, or `overwrite`"),
        ("no/z.tif", {}, nm.OutputError, "the folder .*no does not exist; create it first"),
    ],
)
def test_wrong_files_are_refused_before_anything_is_read(name, more, error, pattern, tmp_path):
    (tmp_path / "there.tif").write_text("")

    class Unread(Striped):
        def window(self, rows, cols):
            raise AssertionError("read")

    with pytest.raises(error, match=pattern):
        export_heights(Unread(100), tmp_path / name, **more)
    if not more:
        with pytest.raises(error, match=pattern):
            check_export(tmp_path / name, overwrite=False)


def test_tiles_of_an_earlier_run_are_not_replaced(tmp_path):
    export_heights(ArrayHeights(waves(), 0.25), tmp_path / "tiles", tile_px=128)
    for again in (
        lambda: export_heights(Striped(300), tmp_path / "tiles"),
        lambda: check_export(tmp_path / "tiles", False),
    ):
        with pytest.raises(nm.OutputError, match="already exists; give another name, or `overwrite`"):
            again()
    check_export(tmp_path / "tiles", overwrite=True)
    check_export(tmp_path / "new", overwrite=False)


def test_nothing_is_left_of_an_export_that_fails(tmp_path):
    class Damaged(Striped):
        def window(self, rows, cols):
            if rows.start > 0:
                raise nm.InputError("chunk 1, 0 is damaged")
            return super().window(rows, cols)

    for name in ("z.tif", "z.npy", "tiles"):
        with pytest.raises(nm.InputError, match="chunk 1, 0 is damaged"):
            export_heights(Damaged(1500), tmp_path / name, found=HeightRange(0, 200, False), tile_px=256)
    assert list(tmp_path.iterdir()) == []
