"""Stores that cannot be opened, created or replaced: one clear line each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nmaptool.core.errors import InputError, OutputError, UsageError
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.opening import create_picture, open_picture, open_writable

zarr = pytest.importorskip("zarr")


def pixels_of(dtype, rows=150, cols=130):
    values = np.random.default_rng(5).random((rows, cols, 3)) * 250
    return values.astype(dtype)


def stored(path):
    writer = create_picture(str(path), 150, 130, ("R", "G", "B"), "uint8", chunk=64, inner=16)
    writer.write(0, 0, pixels_of("uint8"))
    return writer.name


def test_what_is_not_a_store_has_one_clear_line(tmp_path):
    with pytest.raises(InputError, match="no such file or folder"):
        open_picture(str(tmp_path / "none.zarr"))
    (tmp_path / "empty.zarr").mkdir()
    with pytest.raises(InputError, match=r"is not a Zarr array or group; give the folder that holds zarr.json"):
        open_picture(str(tmp_path / "empty.zarr"))
    (tmp_path / "empty.zarr/zarr.json").write_text("{")
    with pytest.raises(InputError, match="the metadata of the Zarr store is damaged"):
        open_picture(str(tmp_path / "empty.zarr"))
    zarr.create_group(tmp_path / "group.zarr")
    with pytest.raises(InputError, match="is a Zarr group without arrays"):
        open_picture(str(tmp_path / "group.zarr"))
    zarr.create_array(tmp_path / "volume.zarr", shape=(9, 9, 9), dtype="uint8")
    with pytest.raises(InputError, match=r"is an array of shape \(9, 9, 9\); a picture has 1 to 4 channels"):
        open_picture(str(tmp_path / "volume.zarr"))
    zarr.create_array(tmp_path / "line.zarr", shape=(9,), dtype="uint8")
    with pytest.raises(InputError, match=r"is an array of shape \(9,\); expected \(H, W\)"):
        open_picture(str(tmp_path / "line.zarr"))
    with pytest.raises(InputError, match="is a URL that fsspec does not know"):
        open_picture("nowhere://a/map.zarr")
    with pytest.raises(InputError, match=r"is a folder without tiles; tiles are called tile_0_0.png"):
        open_picture(str(tmp_path))


def test_a_missing_extra_has_one_clear_line(tmp_path, monkeypatch):
    name = stored(tmp_path / "map.zarr")
    monkeypatch.setitem(__import__("sys").modules, "zarr", None)
    with pytest.raises(
        InputError, match=r'need the package zarr; install it with: pip install "nmaptool-relief\[cluster\]"'
    ):
        open_picture(name)


def save_tiles(folder: Path, **shapes):
    for place, shape in shapes.items():
        write_image(pixels_of("uint8", rows=shape[0], cols=shape[1]), folder / f"tile{place}.png", ("R", "G", "B"), {})


def test_tiles_that_do_not_fit_are_named(tmp_path):
    save_tiles(tmp_path, _0_0=(32, 32), _0_1=(32, 32), _1_0=(32, 32), _1_1=(32, 32))
    everything = (slice(None), slice(None))
    assert open_picture(str(tmp_path)).read(*everything).frame.shape == (64, 64)
    save_tiles(tmp_path, _1_0=(32, 30))
    with pytest.raises(InputError, match=r"tile_1_0.png: is 30 x 32 px, but the other tiles make this one 32 x 32"):
        open_picture(str(tmp_path)).read(*everything)
    (tmp_path / "tile_1_0.png").unlink()
    with pytest.raises(InputError, match="1 tile of them is missing, such as tile_1_0; add them"):
        open_picture(str(tmp_path))
    write_image(pixels_of("uint16", rows=32, cols=32), tmp_path / "tile_1_0.png", ("R", "G", "B"), {})
    with pytest.raises(
        InputError, match="has channels R, G, B in 16-bit codes, but tile_0_0 has channels R, G, B in 8"
    ):
        open_picture(str(tmp_path)).read(*everything)
    save_tiles(tmp_path, _1_0=(32, 32))
    (tmp_path / "tile_1_0.png").write_bytes((tmp_path / "tile_1_0.png").read_bytes()[:200])
    with pytest.raises(InputError, match="the PNG file is truncated or damaged"):
        open_picture(str(tmp_path)).read(*everything)
    write_image(pixels_of("float32"), tmp_path / "tile_0_1.exr", ("R", "G", "B"), {})
    with pytest.raises(InputError, match="holds both tile_0_1"):
        open_picture(str(tmp_path))


def test_an_existing_store_is_replaced_only_on_request(tmp_path):
    name = stored(tmp_path / "map.zarr")
    with pytest.raises(OutputError, match="already exists; give another name, or `overwrite`"):
        create_picture(name, 8, 8, ("Y",), "uint8")
    create_picture(name, 8, 8, ("Y",), "uint8", overwrite=True)
    assert open_picture(name).rows == 8
    (tmp_path / "other").mkdir()
    with pytest.raises(OutputError, match="is not a Zarr store, so it is not replaced"):
        create_picture(str(tmp_path / "other"), 8, 8, ("Y",), "uint8", overwrite=True)
    with pytest.raises(OutputError, match=r"the folder .* does not exist; create it first"):
        create_picture(str(tmp_path / "none/map.zarr"), 8, 8, ("Y",), "uint8")
    with pytest.raises(UsageError, match="`chunk=100`: must be a multiple of the inner chunk of 16 px"):
        create_picture(str(tmp_path / "b.zarr"), 8, 8, ("Y",), "uint8", chunk=100, inner=16)
    with pytest.raises(InputError, match="no such Zarr array; create it first"):
        open_writable(str(tmp_path / "b.zarr"))


def test_writing_other_pixels_than_those_of_the_store_is_refused(tmp_path):
    writer = create_picture(str(tmp_path / "map.zarr"), 64, 64, ("R", "G", "B"), "uint16", chunk=64, inner=16)
    with pytest.raises(UsageError, match="is written as uint16 with 3 channels, found uint8"):
        writer.write(0, 0, np.zeros((9, 9, 3), np.uint8))
    with pytest.raises(UsageError, match="does not lie in a picture of 64 x 64"):
        writer.write(60, 0, np.zeros((9, 9, 3), np.uint16))
