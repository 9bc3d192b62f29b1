"""Pages of TIFF files: each has its own facts, whichever library decodes it."""

import numpy as np
import pytest
import tifffile

import nmaptool as nm

RNG = np.random.default_rng(8)
GREY = RNG.integers(0, 60000, (20, 30)).astype(np.uint16)
COLOR = RNG.integers(0, 256, (20, 30, 3)).astype(np.uint8)
# OpenImageIO decodes the first, tifffile the second
PACKINGS = ("lzw", "zstd")
NODATA, ORIENTATION, PAGE_NAME, PROFILE = 42113, 274, 285, 34675


def both(tmp_path, values, **more):
    """The same picture in both packings, as read."""
    images = []
    for packing in PACKINGS:
        path = tmp_path / f"{packing}.tif"
        tifffile.imwrite(path, values, compression=packing, **more)
        images.append(nm.read_raster(path, holds="depth"))
    return images


@pytest.mark.parametrize("packing", PACKINGS)
def test_a_later_page_has_its_own_facts(tmp_path, packing):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, COLOR, photometric="rgb", compression=packing)
    tag = (NODATA, "s", 0, "7", True)
    tifffile.imwrite(path, GREY, photometric="miniswhite", compression=packing, extratags=[tag], append=True)
    image = nm.read_raster(f"{path}:page 2")
    assert np.array_equal(image.pixels[..., 0], 65535 - GREY)
    assert image.nodata == 7
    assert any("0 is white" in note for note in image.notes)
    first = nm.read_raster(path)
    assert first.nodata is None
    assert first.notes == ("holds 2 pages, of which the first is read; another is a.tif:page 2",)


@pytest.mark.parametrize("packing", PACKINGS)
def test_a_page_of_floats_after_one_whose_zero_is_white_stays(tmp_path, packing):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, GREY, photometric="miniswhite", compression=packing)
    tifffile.imwrite(path, GREY.astype(np.float32), photometric="minisblack", compression=packing, append=True)
    assert np.array_equal(nm.read_raster(f"{path}:page 2").pixels[..., 0], GREY)


@pytest.mark.parametrize("packing", PACKINGS)
def test_inks_refuse_only_their_own_page(tmp_path, packing):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, COLOR, photometric="rgb", compression=packing)
    inks = np.dstack([COLOR, COLOR[..., :1]])
    tifffile.imwrite(path, inks, photometric="separated", compression=packing, append=True)
    assert np.array_equal(nm.read_raster(path).pixels, COLOR)
    with pytest.raises(nm.InputError, match=r"a\.tif: stores CMYK inks, which bends the vectors of a normal map"):
        nm.read_raster(f"{path}:page 2")


@pytest.mark.parametrize("packing", PACKINGS)
def test_a_page_is_found_by_its_name_and_by_its_number(tmp_path, packing):
    path = tmp_path / "a.tif"
    for number, name in enumerate(("base", "detail")):
        tag = (PAGE_NAME, "s", 0, name, True)
        tifffile.imwrite(path, GREY + number, compression=packing, extratags=[tag], append=bool(number))
    for name in ("detail", "page 2"):
        assert np.array_equal(nm.read_raster(f"{path}:{name}").pixels[..., 0], GREY + 1)
    with pytest.raises(nm.InputError, match=r"has no layer 'coat'; it holds: base, detail"):
        nm.read_raster(f"{path}:coat")


def test_a_palette_is_expanded_in_every_packing(tmp_path):
    colors = RNG.integers(0, 256, (3, 256)).astype(np.uint16) * 257
    places = RNG.integers(0, 256, (20, 30)).astype(np.uint8)
    for image in both(tmp_path, places, photometric="palette", colormap=colors):
        assert np.array_equal(image.pixels, (colors // 257).T[places])
        assert image.notes == ("its colours are a palette of 256",)


@pytest.mark.parametrize(
    ("alpha", "channels"), [("unassalpha", "RGBA"), ("assocalpha", "RGBA"), ("unspecified", "RGB")]
)
def test_the_fourth_channel_is_alpha_only_if_the_file_says_so(tmp_path, alpha, channels):
    values = np.dstack([COLOR, np.full((20, 30), 128, np.uint8)])
    for image in both(tmp_path, values, photometric="rgb", extrasamples=[alpha]):
        assert "".join(image.channels) == channels
        assert np.array_equal(image.pixels, values[..., : len(channels)])


@pytest.mark.parametrize("count", [2, 3])
def test_channels_without_a_meaning_are_red_green_and_blue(tmp_path, count):
    for image in both(tmp_path, COLOR[..., :count], photometric="minisblack", planarconfig="contig"):
        assert "".join(image.channels) == "RGB"[:count]


def test_orientation_profile_and_metadata_are_read_in_every_packing(tmp_path):
    tags = [(ORIENTATION, "H", 1, 6, True), (PROFILE, "B", 4, b"icc ", True)]
    lines = "nmaptool:kind=normal\nnmaptool:green=down\nnmaptool:pitch_mm=0.5"
    for image in both(tmp_path, COLOR, photometric="rgb", extratags=tags, description=lines, metadata=None):
        assert image.orientation == 6
        assert image.attributes == {"kind": "normal", "green": "down", "pitch_mm": "0.5"}
    assert image.color_chunks == ("ICC profile",)


def test_inks_in_a_packing_of_tifffile_are_refused_as_depth_too(tmp_path):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, np.dstack([COLOR, COLOR[..., :1]]), photometric="separated", compression="zstd")
    with pytest.raises(nm.InputError, match=r"stores CMYK inks packed as ZSTD; save it as RGB or grey with LZW or Def"):
        nm.read_raster(path, holds="depth")


def test_few_bits_beside_a_page_of_64_are_widened(tmp_path):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, GREY % 4096, bitspersample=12, photometric="minisblack")
    tifffile.imwrite(path, GREY.astype(np.int64), append=True)
    expected = np.rint((GREY % 4096) / 4095 * 65535)
    assert np.array_equal(nm.read_raster(path).pixels[..., 0], expected)


@pytest.mark.parametrize(
    ("values", "packing", "text"),
    [
        (GREY, "zstd", r"its page 1 is packed as ZSTD; save it with LZW or Deflate"),
        (GREY.astype(np.int64), None, r"its page 1 has 64 bits per channel; save it with 8, 16 or 32 bits"),
    ],
)
def test_unpack_names_pages_that_it_does_not_decode(tmp_path, values, packing, text):
    tifffile.imwrite(tmp_path / "a.tif", values, compression=packing)
    with pytest.raises(nm.InputError, match=rf"a\.tif: {text}$"):
        nm.read_workspace(tmp_path / "a.tif")
