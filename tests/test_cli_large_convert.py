"""nmap compose convert to and from Zarr stores, folders of tiles and large TIFF files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from large_maps import as_zarr, encodings

import nmaptool as nm
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.opening import open_picture

pytest.importorskip("zarr")
EVERYTHING = (slice(None), slice(None))


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The working folder of the commands, with a map as a file and as a store, and a mask."""
    monkeypatch.chdir(tmp_path)
    image, _ = encodings()["white"]
    write_image(image.pixels, tmp_path / "map.png", image.channels, {"green": "up"})
    as_zarr(image, tmp_path / "map.zarr")
    write_image(image.pixels[..., :1].copy(), tmp_path / "mask.png", ("Y",), {})
    return tmp_path


@pytest.fixture
def convert(run):
    """``convert("map.zarr", "out.zarr")``: exit code, standard output and error."""

    def call(*words):
        made = run("compose", "convert", *words)
        return made.code, made.out, made.err

    return call


def pixels(name):
    return open_picture(name).read(*EVERYTHING).pixels


def test_a_file_becomes_a_store_tiles_a_tiff_and_a_file_again(convert, place):
    for source, output in (("map.png", "a.zarr"), ("a.zarr", "tiles/"), ("tiles", "b.tif"), ("b.tif", "c.png")):
        tile = [] if "." in output else ["--tile", "64"]
        code, out, err = convert(source, "-o", output, *tile)
        assert (code, out) == (0, "")
        assert f"wrote {output.rstrip('/')}" in err
    nm.convert("map.png", "whole.png")
    assert np.array_equal(pixels("a.zarr"), pixels("whole.png"))
    assert np.array_equal(pixels("c.png"), pixels("whole.png"))
    assert (place / "tiles/tile_3_2.png").is_file()


def test_the_messages_and_the_report_are_those_of_a_conversion(convert, place):
    code, out, err = convert("map.zarr", "out.zarr", "--bits", "8", "--report", "report.json")
    assert (code, out) == (0, "")
    assert "map.zarr: 190 x 210, background white, 67% covered, green up" in err
    assert "was: 8 bit, zero at 127.5, green up; now: 8 bit, zero at 127.5, green up" in err
    assert "background white: coverage is stored in alpha" in err
    report = json.loads((place / "report.json").read_text())
    assert (report["command"], report["output"], report["cols"]) == ("convert", "out.zarr", 190)
    code, out, _ = convert("map.zarr", "other.zarr", "--json")
    assert json.loads(out)["target"]["alpha"] is True


def test_a_large_tiff_is_converted_by_windows(convert, place):
    convert("map.png", "map.tif")
    code, out, _ = convert("map.tif", "out.tif", "--max-megapixels", "0.01", "--tile", "64")
    assert (code, out) == (0, "")
    assert np.array_equal(pixels("out.tif"), pixels("map.tif"))
    code, _, err = convert("map.tif", "out.png", "--max-megapixels", "0.01")
    assert code == 4
    assert "190 x 210 does not fit in one .png file; write a .tif, a .zarr, or tiles into a folder" in err


def test_a_grey_picture_is_copied(convert, place):
    code, out, err = convert("mask.png", "mask.zarr")
    assert (code, out) == (0, "")
    assert "mask.png: 190 x 210, a grey picture: copied as it is" in err
    assert np.array_equal(pixels("mask.zarr"), pixels("mask.png"))
    code, _, err = convert("mask.png", "other.zarr", "--bits", "8")
    assert code == 2
    assert "is a grey picture, which is copied as it is; leave out --bits" in err


def test_what_is_not_for_large_maps_has_one_clear_line(convert, place):
    for words, code, text in (
        (["map.zarr", "out.zarr", "--curl", "curl.png"], 2, "curl.png: the curl is not drawn for a map"),
        (["map.zarr", "-"], 2, "-: a map is converted by windows from and to files and stores; give a name"),
        (["map.png", "out.png", "--tile", "64"], 2, "--tile 64: applies to Zarr stores, folders of tiles"),
        (["map.zarr", "map.zarr"], 2, "is also the output; give another name"),
        (["none.zarr", "out.zarr"], 3, "none.zarr: no such file or folder"),
        (["map.zarr", "out.zarr", "--background-color", "flat"], 2, "--background-color flat: needs the whole picture"),
        (["map.zarr", "out.gif"], 2, "out.gif"),
    ):
        found, _, err = convert(*words)
        assert (found, err.count("\n")) == (code, 1)
        assert text in err
    convert("map.zarr", "out.zarr")
    code, _, err = convert("map.zarr", "out.zarr")
    assert (code, "already exists; give another name, or --overwrite" in err) == (5, True)
    assert convert("map.zarr", "out.zarr", "--overwrite")[0] == 0
