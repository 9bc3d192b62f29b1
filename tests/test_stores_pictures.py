"""Pictures in Zarr arrays and folders of tiles, by windows."""

from __future__ import annotations

import importlib.util
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from nmaptool.core.errors import InputError, LimitError, OutputError, UsageError
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.opening import create_picture, is_store, open_picture, open_writable

zarr = pytest.importorskip("zarr")
ROWS, COLS = 150, 130
WINDOWS = [
    (slice(None), slice(None)),
    (slice(10, 100), slice(60, 130)),
    (slice(63, 65), slice(63, 65)),
    (slice(149, 150), slice(0, 1)),
]


def pixels_of(dtype, channels=3, rows=ROWS, cols=COLS):
    values = np.random.default_rng(5).random((rows, cols, channels)) * 250
    return values.astype(dtype)


def stored(path, values, channels=("R", "G", "B"), **more):
    writer = create_picture(str(path), *values.shape[:2], channels, values.dtype, chunk=64, inner=16, **more)
    for row in range(0, values.shape[0], 64):
        for col in range(0, values.shape[1], 64):
            writer.write(row, col, values[row : row + 64, col : col + 64])
    return str(path)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
def test_a_window_of_a_zarr_array_is_that_of_the_whole(tmp_path, dtype):
    values = pixels_of(dtype)
    name = stored(tmp_path / "map.zarr", values, pitch_mm=0.25, attributes={"kind": "normal", "green": "down"})
    store = pickle.loads(pickle.dumps(open_picture(name)))
    assert (store.rows, store.cols, store.chunk, store.pitch_mm) == (ROWS, COLS, (64, 64), 0.25)
    for window in WINDOWS:
        image = store.read(*window)
        assert np.array_equal(image.pixels, values[window].astype(image.pixels.dtype))
        assert image.bits == min(32, 8 * np.dtype(dtype).itemsize)
        assert image.attributes["green"] == "down"
        assert image.frame.pitch_mm == 0.25


def test_a_window_of_a_folder_of_tiles_is_that_of_the_whole(tmp_path):
    values = pixels_of("uint16")
    for row in range(3):
        for col in range(3):
            tile = values[64 * row : 64 * row + 64, 64 * col : 64 * col + 64]
            write_image(tile, tmp_path / f"tile_{row}_{col}.png", ("R", "G", "B"), {"pitch_mm": "0.5"})
    assert is_store(str(tmp_path))
    store = open_picture(str(tmp_path))
    assert (store.rows, store.cols, store.chunk, store.pitch_mm) == (ROWS, COLS, (64, 64), 0.5)
    for window in WINDOWS:
        assert np.array_equal(store.read(*window).pixels, values[window])


def test_an_ordinary_file_has_the_same_interface(tmp_path):
    values = pixels_of("uint8")
    write_image(values, tmp_path / "map.png", ("R", "G", "B"), {})
    store = open_picture(str(tmp_path / "map.png"))
    assert not is_store(store.name)
    for window in WINDOWS:
        assert np.array_equal(store.read(*window).pixels, values[window])


@pytest.mark.parametrize(
    "window", [(slice(0, 151), slice(None)), (slice(5, 5), slice(None)), (slice(None), slice(-1, 9))]
)
def test_a_window_beyond_the_picture_is_refused(tmp_path, window):
    name = stored(tmp_path / "map.zarr", pixels_of("uint8"))
    with pytest.raises(UsageError, match="does not lie in a picture of 130 x 150"):
        open_picture(name).read(*window)


def test_chunks_that_are_not_stored_are_an_error_and_not_black(tmp_path):
    values = pixels_of("uint8")
    values[:64, :64] = 0
    name = stored(tmp_path / "map.zarr", values)
    assert not open_picture(name).read(slice(0, 64), slice(0, 64)).pixels.any()
    (tmp_path / "map.zarr/c/0/0/0").unlink()
    store = open_picture(name)
    with pytest.raises(InputError, match=r"map.zarr: the chunk c/0/0/0 is missing; restore it"):
        store.read(slice(60, 70), slice(60, 70))
    assert store.read(slice(64, 70), slice(0, 70)).pixels.any()


def test_a_chunk_that_a_shard_does_not_hold_is_an_error(tmp_path):
    array = zarr.create_array(
        tmp_path / "map.zarr", shape=(64, 64), dtype="uint8", chunks=(16, 16), shards=(64, 64), fill_value=7
    )
    array[:] = np.broadcast_to(np.where(np.arange(64) < 16, 7, 9), (64, 64))
    with pytest.raises(InputError, match="the chunk 0/0 of c/0/0 is missing"):
        open_picture(str(tmp_path / "map.zarr")).read(slice(None), slice(None))
    array.attrs["nmaptool"] = {"absent_chunks": "fill"}
    assert open_picture(str(tmp_path / "map.zarr")).read(slice(0, 1), slice(0, 1)).pixels[0, 0, 0] == 7


def cut(data):
    return data[:-10]


def changed(data):
    return data[:40] + bytes(255 - byte for byte in data[40:60]) + data[60:]


@pytest.mark.parametrize("damage", [cut, changed, lambda data: b""])
@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_a_damaged_chunk_is_named(tmp_path, damage, dtype):
    name = stored(tmp_path / "map.zarr", pixels_of(dtype))
    chunk = tmp_path / "map.zarr/c/1/0/0"
    chunk.write_bytes(damage(chunk.read_bytes()))
    store = open_picture(name)
    assert store.read(slice(0, 64), slice(None)).pixels.any()
    with pytest.raises(InputError, match=r"the chunk .*c/1/0/0 is (damaged|missing); restore it"):
        store.read(slice(None), slice(None))


def test_the_stamp_changes_with_the_pixels(tmp_path):
    name = stored(tmp_path / "map.zarr", pixels_of("uint8"))
    before = open_picture(name).stamp()
    assert open_picture(name).stamp() == before
    open_writable(name).write(0, 0, np.zeros((64, 64, 3), np.uint8))
    assert open_picture(name).stamp() != before


def test_urls_open_through_fsspec():
    name = "memory://stores/map.zarr"
    values = pixels_of("uint8")
    stored(name, values, overwrite=True)
    store = open_picture(name)
    assert is_store(name)
    assert np.array_equal(store.read(slice(9, 80), slice(None)).pixels, values[9:80])
    before = store.stamp()
    open_writable(name).write(0, 0, np.zeros((64, 64, 3), np.uint8))
    assert store.stamp() != before


def test_the_arrays_of_a_group_are_layers(tmp_path):
    values = pixels_of("uint8")
    stored(f"{tmp_path}/plate.zarr:detail", values)
    stored(f"{tmp_path}/plate.zarr:normals", 250 - values)
    name = f"{tmp_path}/plate.zarr"
    image = open_picture(name).read(slice(None), slice(None))
    assert np.array_equal(image.pixels, 250 - values)
    assert image.notes == ("is read from normals; it also holds the layers detail",)
    assert np.array_equal(open_picture(name, "detail").read(slice(None), slice(None)).pixels, values)
    with pytest.raises(InputError, match="has no layer 'base'; it holds: detail, normals"):
        open_picture(f"{name}:base")


def test_an_array_with_channels_first_is_a_picture(tmp_path):
    values = pixels_of("uint8")
    array = zarr.create_array(tmp_path / "a.zarr", shape=(3, ROWS, COLS), dtype="uint8", chunks=(1, 32, 32))
    array[:] = values.transpose(2, 0, 1)
    for window in WINDOWS:
        assert np.array_equal(open_picture(str(tmp_path / "a.zarr")).read(*window).pixels, values[window])


def test_axes_of_length_1_do_not_count(tmp_path):
    """An OME-Zarr pyramid: time, channel, depth, rows, columns."""
    values = pixels_of("uint8")
    group = zarr.create_group(tmp_path / "scan.zarr", attributes={"ome": {"multiscales": []}})
    for level, step in enumerate((1, 2)):
        part = values[::step, ::step].transpose(2, 0, 1)[None, :, None]
        names = ("t", "c", "z", "y", "x")
        array = group.create_array(
            str(level), shape=part.shape, dtype="uint8", chunks=(1, 1, 1, 32, 32), dimension_names=names
        )
        array[:] = part
    store = open_picture(str(tmp_path / "scan.zarr"))
    assert (store.rows, store.cols, store.chunk) == (ROWS, COLS, (32, 32))
    for window in WINDOWS:
        assert np.array_equal(store.read(*window).pixels, values[window])
    (tmp_path / "scan.zarr/0/c/0/1/0/1/1").unlink()
    with pytest.raises(InputError, match="the chunk c/0/1/0/1/1 is missing"):
        open_picture(str(tmp_path / "scan.zarr")).read(slice(40, 50), slice(40, 50))


def test_whole_chunks_are_written_by_several_threads_at_once(tmp_path):
    values = pixels_of("uint16")
    writer = create_picture(str(tmp_path / "map.zarr"), ROWS, COLS, ("R", "G", "B"), "uint16", chunk=32, inner=16)
    places = [(row, col) for row in range(0, ROWS, 32) for col in range(0, COLS, 32)]

    def write(place):
        row, col = place
        pickle.loads(pickle.dumps(writer)).write(row, col, values[row : row + 32, col : col + 32])

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(write, places))
    assert np.array_equal(open_picture(writer.name).read(slice(None), slice(None)).pixels, values)


class Failing:
    """An array that cannot be reached."""

    def __init__(self, array, error):
        self._array, self._error = array, error

    def __getattr__(self, name):
        return getattr(self._array, name)

    def __getitem__(self, key):
        raise self._error

    def __setitem__(self, key, values):
        raise self._error


def test_a_store_that_cannot_be_reached_and_a_full_disk_have_one_clear_line(tmp_path):
    name = stored(tmp_path / "map.zarr", pixels_of("uint8"))
    store = open_picture(name)
    store._array = Failing(store._array, PermissionError(13, "Permission denied"))
    with pytest.raises(InputError, match=r"map.zarr: the chunk c/0/0/0 cannot be read \(Permission denied\)"):
        store.read(slice(0, 9), slice(0, 9))
    writer = open_writable(name)
    writer._array = Failing(writer._array, OSError(28, "No space left on device"))
    with pytest.raises(OutputError, match=r"map.zarr: cannot be written \(No space left on device\)"):
        writer.write(0, 0, np.zeros((64, 64, 3), np.uint8))


@pytest.mark.skipif(importlib.util.find_spec("s3fs") is not None, reason="with s3fs, it would be looked for")
def test_a_url_whose_file_system_is_not_installed_says_what_to_install():
    with pytest.raises(InputError, match=r"s3://bucket/map.zarr: cannot be reached \(Install s3fs"):
        open_picture("s3://bucket/map.zarr")


def test_a_file_over_the_limit_is_refused(tmp_path):
    write_image(pixels_of("uint8"), tmp_path / "map.png", ("R", "G", "B"), {})
    with pytest.raises(LimitError, match=r"more than the limit of 0\.01"):
        open_picture(str(tmp_path / "map.png"), max_megapixels=0.01)


def test_a_zarr_store_of_version_2_is_read(tmp_path):
    values = pixels_of("uint8")
    array = zarr.create_array(tmp_path / "a.zarr", shape=values.shape, dtype="uint8", chunks=(32, 32, 3), zarr_format=2)
    array[:] = values
    store = open_picture(str(tmp_path / "a.zarr"))
    assert np.array_equal(store.read(slice(3, 70), slice(None)).pixels, values[3:70])
    (tmp_path / "a.zarr/1.1.0").unlink()
    with pytest.raises(InputError, match=r"the chunk 1.1.0 is missing"):
        store.read(slice(3, 70), slice(None))
