"""Heights by windows: the samples of each format of height files."""

from __future__ import annotations

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core.errors import InputError
from nmaptool.io.pictures.heights import write_height
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.export import export_heights
from nmaptool.io.stores.heights import create_heights, open_heights
from nmaptool.io.stores.opening import create_picture, open_writable
from nmaptool.types.height import Height
from nmaptool.types.picture import Frame

pytest.importorskip("zarr")
ROWS, COLS = 90, 70
WINDOWS = [(slice(None), slice(None)), (slice(10, 51), slice(33, 70)), (slice(0, 1), slice(69, 70))]


def dome():
    """A height field with a hole, and its corners with NaN outside."""
    y, x = np.mgrid[0 : ROWS + 1, 0 : COLS + 1].astype(float)
    domain = np.hypot(y[:-1, :-1] - 40, x[:-1, :-1] - 30) > 12
    corners = 3 + np.sin(y / 20) + np.cos(x / 15)
    touching = np.zeros(corners.shape, bool)
    for down in (0, 1):
        for right in (0, 1):
            touching[down : down + ROWS, right : right + COLS] |= domain
    return Height(np.where(touching, corners, 0), domain, Frame(ROWS, COLS, 0.25)), np.where(touching, corners, np.nan)


@pytest.mark.parametrize("at", ["centers", "corners"])
@pytest.mark.parametrize("ending", ["tif", "exr", "npy", "png"])
def test_a_window_holds_the_samples_of_the_file(tmp_path, ending, at):
    height, corners = dome()
    write_height(height, tmp_path / f"z.{ending}", {}, at=at)
    store = open_heights(str(tmp_path / f"z.{ending}"), pitch_mm=0.25)
    whole = corners if at == "corners" else np.where(height.domain, height.at_pixels(), np.nan)
    assert (store.at, store.pitch_mm, (store.rows, store.cols)) == (at, 0.25, whole.shape)
    tolerance = {"png": 5e-5, "npy": 0}.get(ending, 1e-6)
    for window in WINDOWS:
        np.testing.assert_allclose(store.window(*window), whole[window], rtol=0, atol=tolerance)


@pytest.mark.parametrize("at", ["centers", "corners"])
def test_a_zarr_store_of_heights_is_exported_and_read_back(tmp_path, at):
    height, corners = dome()
    values = (corners if at == "corners" else np.where(height.domain, height.at_pixels(), np.nan)).astype(np.float32)
    name = str(tmp_path / "z.zarr")
    create_heights(name, *values.shape, 0.25, at=at, chunk=64, inner=16).write(0, 0, values)
    store = open_heights(name)
    for window in WINDOWS:
        assert np.array_equal(store.window(*window), values[window], equal_nan=True)
    for output in ("z.tif", "tiles"):
        export_heights(store, tmp_path / output, tile_px=32)
        back = open_heights(str(tmp_path / output))
        assert back.at == at
        for window in WINDOWS:
            np.testing.assert_allclose(back.window(*window), values[window], rtol=0, atol=5e-5 * (output == "tiles"))
    assert nm.read_height(tmp_path / "z.tif", with_gaps=True).domain.shape == (ROWS, COLS)


def test_what_does_not_hold_heights_is_refused(tmp_path):
    write_image(np.zeros((9, 9, 3), np.uint8), tmp_path / "map.png", ("R", "G", "B"), {})
    with pytest.raises(InputError, match="has channels R, G, B; heights have one grey channel"):
        open_heights(str(tmp_path / "map.png"))
    write_image(np.zeros((9, 9, 1), np.uint8), tmp_path / "grey.png", ("Y",), {})
    with pytest.raises(InputError, match="does not state its height range in mm"):
        open_heights(str(tmp_path / "grey.png"), pitch_mm=1)
    values = np.zeros((9, 9, 1), np.float32)
    write_image(values, tmp_path / "z.exr", ("Y",), {})
    with pytest.raises(InputError, match="does not state the size of a pixel; give `pitch_mm`"):
        open_heights(str(tmp_path / "z.exr"))
    write_image(values, tmp_path / "odd.exr", ("Y",), {"kind": "height", "at": "edges"})
    with pytest.raises(InputError, match="declares heights at 'edges'; accepted values are centers and corners"):
        open_heights(str(tmp_path / "odd.exr"), pitch_mm=1)
    values[4, 5] = np.inf
    write_image(values, tmp_path / "z.exr", ("Y",), {})
    store = open_heights(str(tmp_path / "z.exr"), pitch_mm=1)
    assert not store.window(slice(0, 4), slice(0, 9)).any()
    with pytest.raises(InputError, match="holds infinite heights; use NaN"):
        store.window(slice(0, 9), slice(0, 9))
    np.save(tmp_path / "cube.npy", np.zeros((3, 3, 3)))
    with pytest.raises(InputError, match=r"must hold one \(rows, columns\) array of heights in mm"):
        open_heights(str(tmp_path / "cube.npy"), pitch_mm=1)
    (tmp_path / "cut.npy").write_bytes((tmp_path / "cube.npy").read_bytes()[:150].replace(b"(3, 3, 3)", b"(9, 9)   "))
    with pytest.raises(InputError, match="is not a NumPy array file, or is truncated; save it again"):
        open_heights(str(tmp_path / "cut.npy"), pitch_mm=1)


def test_chunks_of_a_flat_ground_are_stored(tmp_path):
    name = str(tmp_path / "h.zarr")
    create_picture(name, 64, 64, ("Y",), np.float32, chunk=32, inner=16, pitch_mm=0.5, attributes={"kind": "height"})
    z_mm = np.zeros((64, 64), np.float32)
    z_mm[20:28, 20:28] = 1
    for row in (0, 32):
        for col in (0, 32):
            open_writable(name).write(row, col, z_mm[row : row + 32, col : col + 32])
    assert np.array_equal(open_heights(name).window(slice(0, 64), slice(0, 64)), z_mm)
