"""Conversion of normal maps by windows: the same as in memory, in both directions, all or nothing."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
import tifffile
from large_maps import COLS, ROWS, as_zarr, codes_of, encodings, picture, rounded, shrink_sample, surface

import nmaptool as nm
from nmaptool.core.errors import InputError, LimitError, OutputError, UsageError
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.stores.opening import create_picture, open_picture
from nmaptool.tiled.conversion import convert
from nmaptool.tiled.copying import copy

pytest.importorskip("zarr")
ENCODINGS = encodings()
EVERYTHING = (slice(None), slice(None))
WRITING = [
    nm.WriteOptions(),
    nm.WriteOptions(bits="8", write_green="down"),
    nm.WriteOptions(bits="8", write_zero_code="128"),
]


@pytest.fixture(autouse=True)
def small_sample(monkeypatch):
    shrink_sample(monkeypatch)


def in_memory(image, tmp_path, options, writing):
    """What nm.convert makes of the same picture."""
    ending = "exr" if image.is_float else "png"
    write_image(
        image.pixels,
        tmp_path / f"in.{ending}",
        image.channels,
        image.attributes,
        half=image.bits == 16 and image.is_float,
    )
    out = tmp_path / ("whole.exr" if writing.bits in ("half", "float") else "whole.png")
    result = nm.convert(tmp_path / f"in.{ending}", out, options, writing)
    return nm.read_raster(out), result.report


@pytest.mark.parametrize("writing", WRITING)
@pytest.mark.parametrize("name", [name for name in ENCODINGS if name != "two channels"])
def test_a_store_is_converted_as_a_file_is(tmp_path, name, writing):
    image, options = ENCODINGS[name]
    reading = nm.ReadOptions(**options)
    whole, expected = in_memory(image, tmp_path, reading, writing)
    report = convert(as_zarr(image, tmp_path / "in.zarr"), f"{tmp_path}/out.zarr", reading, writing, tile=64)
    got = open_picture(f"{tmp_path}/out.zarr").read(*EVERYTHING)
    assert got.channels == whole.channels
    assert np.array_equal(got.pixels, whole.pixels)
    for key in ("green", "zero_code", "kind"):
        assert got.attributes[key] == whole.attributes[key]
    for key in ("vectors", "off_length", "rim_pixels", "target"):
        assert getattr(report, key) == getattr(expected, key)
    for key in ("off_length_largest", "curl_before", "curl_after"):
        assert getattr(report, key) == pytest.approx(getattr(expected, key), rel=1e-5)


OUTPUTS = {
    "out.zarr": ("8", "16", "half", "float"),
    "tiles": ("8", "16", "half", "float"),
    "tiles/": ("16",),
    "out.tif": ("8", "16", "float"),
    "out.png": ("8", "16"),
    "out.exr": ("half", "float"),
}


@pytest.mark.parametrize(("output", "bits"), [(name, bits) for name, all_bits in OUTPUTS.items() for bits in all_bits])
def test_every_output_holds_the_same_map_and_its_metadata(tmp_path, output, bits):
    image, _ = ENCODINGS["white in 16 bits"]
    writing = nm.WriteOptions(bits=bits)
    whole, _ = in_memory(image, tmp_path, nm.ReadOptions(), writing)
    source = create_picture(
        f"{tmp_path}/in.zarr", ROWS, COLS, image.channels, "uint16", chunk=64, inner=16, pitch_mm=0.125,
        attributes={"artist": "Ada", "recipe": '{"command": "bake"}'},
    )  # fmt: skip
    source.write(0, 0, image.pixels)
    tile = None if output in ("out.png", "out.exr") else 64
    convert(source.name, f"{tmp_path}/{output}", writing=writing, tile=tile)
    got = open_picture(f"{tmp_path}/{output}").read(*EVERYTHING)
    assert (got.channels, got.bits, got.is_float) == (whole.channels, whole.bits, whole.is_float)
    assert np.array_equal(got.pixels, whole.pixels)
    assert got.frame.pitch_mm == 0.125
    assert got.attributes["artist"] == "Ada"
    recipe = json.loads(got.attributes["recipe"])
    assert (recipe["command"], recipe["before"]) == ("convert", {"command": "bake"})
    back = nm.read_normal_map(f"{tmp_path}/{output}") if output.startswith("out.") and "zarr" not in output else None
    assert back is None or back.decoding.green_from == "file"


def test_files_become_stores_and_stores_files(tmp_path):
    """png -> zarr -> tiles -> tif -> zarr keeps every code."""
    n, _ = surface()
    write_image(rounded(codes_of(n, 16), 16), tmp_path / "map.png", ("R", "G", "B"), {})
    names = [f"{tmp_path}/{name}" for name in ("map.png", "a.zarr", "tiles", "b.tif", "c.zarr")]
    for source, output in itertools.pairwise(names):
        convert(source, output, tile=64)
    first, last = (open_picture(name).read(*EVERYTHING) for name in (names[1], names[-1]))
    assert np.array_equal(first.pixels, last.pixels)
    assert json.loads(last.attributes["recipe"])["before"]["before"]["before"]["command"] == "convert"


def test_a_tiff_that_needs_64_bit_offsets_is_a_bigtiff(tmp_path, monkeypatch):
    from nmaptool.io.stores import picture_output

    source = as_zarr(ENCODINGS["8 bits"][0], tmp_path / "in.zarr")
    convert(source, f"{tmp_path}/small.tif", tile=64)
    monkeypatch.setattr(picture_output, "_CLASSIC_BYTES", 100_000)
    convert(source, f"{tmp_path}/big.tif", tile=64)
    for name, is_big in (("small", False), ("big", True)):
        with tifffile.TiffFile(tmp_path / f"{name}.tif") as tiff:
            assert tiff.is_bigtiff is is_big
            assert (tiff.pages[0].tilewidth, tiff.pages[0].is_tiled) == (64, True)
        assert np.array_equal(
            nm.read_raster(tmp_path / f"{name}.tif").pixels, nm.read_raster(tmp_path / "small.tif").pixels
        )


def test_a_zero_code_that_only_flat_pixels_suggest_is_checked_by_lengths(tmp_path):
    """Rounding writers store flat as 128 although zero lies at 127.5."""
    n, _ = surface()
    n[80:110, 70:130] = 0, 0, 1
    image = picture(rounded(codes_of(n)))
    whole, expected = in_memory(image, tmp_path, nm.ReadOptions(), nm.WriteOptions())
    report = convert(as_zarr(image, tmp_path / "in.zarr"), f"{tmp_path}/out.zarr", tile=64)
    assert expected.source["zero_code"] == report.source["zero_code"] == "127.5"
    assert np.array_equal(open_picture(f"{tmp_path}/out.zarr").read(*EVERYTHING).pixels, whole.pixels)


@pytest.mark.parametrize("output", ["copy.zarr", "tiles", "copy.tif"])
@pytest.mark.parametrize("kind", ["mask", "weights", "heights"])
def test_other_pictures_are_copied_as_they_are(tmp_path, output, kind):
    random = np.random.default_rng(1)
    values = random.random((ROWS, COLS)).astype(np.float32)
    if kind == "mask":
        values = (values * 255).astype(np.uint8)
    if kind == "heights":
        values[:50] = np.nan
    name = f"{tmp_path}/in.zarr"
    attributes = {"kind": "height", "at": "centers"} if kind == "heights" else {}
    store = create_picture(
        name, ROWS, COLS, ("Y",), values.dtype, chunk=64, inner=16, pitch_mm=0.5, attributes=attributes
    )
    store.write(0, 0, values)
    copy(name, f"{tmp_path}/{output}", tile=48)
    got = open_picture(f"{tmp_path}/{output}").read(*EVERYTHING)
    assert np.array_equal(got.pixels[..., 0], values, equal_nan=kind == "heights")
    assert got.frame.pitch_mm == 0.5
    assert got.attributes.get("kind") == attributes.get("kind")


def broken_store(tmp_path):
    name = as_zarr(ENCODINGS["white"][0], tmp_path / "in.zarr")
    chunk = tmp_path / "in.zarr/c/2/1/0"
    chunk.write_bytes(chunk.read_bytes()[:-30])
    return name


@pytest.mark.parametrize("output", ["out.zarr", "tiles", "out.tif", "out.png"])
def test_a_conversion_that_fails_leaves_nothing(tmp_path, output):
    name = broken_store(tmp_path)
    (tmp_path / "place").mkdir()
    with pytest.raises(InputError, match="the chunk c/2/1/0 is damaged"):
        convert(name, f"{tmp_path}/place/{output}", tile=None if output == "out.png" else 64)
    assert list((tmp_path / "place").iterdir()) == []


@pytest.mark.parametrize("output", ["out.zarr", "tiles", "out.tif", "out.png"])
def test_an_output_is_replaced_only_on_request_and_only_by_a_whole_one(tmp_path, output):
    sound = as_zarr(ENCODINGS["white"][0], tmp_path / "sound.zarr")
    place, tile = f"{tmp_path}/{output}", None if output == "out.png" else 64
    convert(sound, place, tile=tile)
    before = open_picture(place).read(*EVERYTHING).pixels
    with pytest.raises(OutputError, match=r"already exists|is not empty"):
        convert(sound, place, tile=tile)
    with pytest.raises(InputError, match="is damaged"):
        convert(broken_store(tmp_path), place, tile=tile, overwrite=True)
    assert np.array_equal(open_picture(place).read(*EVERYTHING).pixels, before)
    convert(sound, place, writing=nm.WriteOptions(write_green="down"), tile=tile, overwrite=True)
    after = open_picture(place).read(*EVERYTHING).pixels
    assert not np.array_equal(after, before)
    assert sorted(one.name for one in tmp_path.iterdir()) == sorted([output, "in.zarr", "sound.zarr"])


def test_tiles_of_a_larger_picture_are_not_mixed_with_new_ones(tmp_path):
    name = as_zarr(ENCODINGS["white"][0], tmp_path / "in.zarr")
    convert(name, f"{tmp_path}/tiles", tile=64)
    with pytest.raises(OutputError, match=r"holds tiles of another picture, such as tile_0_2.png; remove them first"):
        convert(name, f"{tmp_path}/tiles", tile=128, overwrite=True)


def test_what_cannot_be_written_has_one_clear_line(tmp_path):
    name = as_zarr(ENCODINGS["8 bits"][0], tmp_path / "in.zarr")
    with pytest.raises(UsageError, match="is also the output; give another name"):
        convert(name, name, overwrite=True)
    with pytest.raises(UsageError, match="`bits='half'` is not supported for it; use 16 or 8 or float"):
        convert(name, f"{tmp_path}/out.tif", writing=nm.WriteOptions(bits="half"))
    with pytest.raises(UsageError, match=r"ending|\.jpg"):
        convert(name, f"{tmp_path}/out.jpg")
    with pytest.raises(UsageError, match="`tile=50`: must be a multiple of 16 for a TIFF"):
        convert(name, f"{tmp_path}/out.tif", tile=50)
    with pytest.raises(LimitError, match=r"190 x 210 does not fit in one \.png file; write a .tif, a .zarr, or tiles"):
        convert(name, f"{tmp_path}/out.png", nm.ReadOptions(max_megapixels=0.01))
    with pytest.raises(UsageError, match="names an array in a group; give a store of its own"):
        convert(name, f"{tmp_path}/out.zarr:detail")
    with pytest.raises(OutputError, match=r"the folder .* does not exist"):
        convert(name, f"{tmp_path}/none/out.zarr")
    with pytest.raises(UsageError, match="a picture is copied to a Zarr store"):
        copy(name, f"{tmp_path}/out.png")


def test_progress_ends_at_1(tmp_path):
    seen = []
    name = as_zarr(ENCODINGS["8 bits"][0], tmp_path / "in.zarr")
    convert(name, f"{tmp_path}/out.zarr", tile=64, progress=lambda word, share: seen.append((word, share)))
    assert seen[-1] == ("writing", 1.0)
    assert [share for _, share in seen] == sorted(share for _, share in seen)


def test_urls_are_outputs_too(tmp_path):
    image, _ = ENCODINGS["8 bits"]
    name = as_zarr(image, tmp_path / "in.zarr")
    for _ in range(2):
        convert(name, "memory://converted/out.zarr", tile=64, overwrite=True)
    assert open_picture("memory://converted/out.zarr").read(*EVERYTHING).frame.shape == (ROWS, COLS)
    with pytest.raises(OutputError, match="already exists; give another name"):
        convert(name, "memory://converted/out.zarr", tile=64)
