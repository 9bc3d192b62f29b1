"""TIFF files of every kind of number and packing, compared with tifffile."""

import struct

import cv2
import numpy as np
import pytest
import tifffile

import nmaptool as nm

RNG = np.random.default_rng(5)
GREY = RNG.integers(0, 200, (20, 30)).astype(np.uint8)
COLOR = RNG.integers(0, 256, (20, 30, 3)).astype(np.uint8)


def write(path, values, **more):
    tifffile.imwrite(path, values, **more)
    return path


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "u4", "u8", "f2", "f4", "f8"])
@pytest.mark.parametrize("byteorder", ["<", ">"])
def test_every_type_of_number_keeps_its_values(tmp_path, kind, byteorder):
    values = (RNG.normal(size=(20, 30)) * 100).round().astype(kind)
    image = nm.read_raster(write(tmp_path / "a.tif", values, byteorder=byteorder), holds="depth")
    assert np.array_equal(image.pixels[..., 0], values.astype(np.float32))
    assert image.bits == (16 if kind == "f2" else 32)
    assert bool(image.notes) == (kind[0] in "iu")
    assert image.channels == ("Y",)


def test_integers_that_floats_cannot_hold_are_named(tmp_path):
    values = np.full((4, 5), 16777217, np.int32)
    notes = nm.read_raster(write(tmp_path / "a.tif", values)).notes
    assert notes == ("stores 32-bit signed integers, read as numbers; those beyond 16777216 are rounded to floats",)


def test_complex_numbers_are_refused(tmp_path):
    with pytest.raises(nm.InputError, match=r"stores complex numbers; save their real part or their magnitude"):
        nm.read_raster(write(tmp_path / "a.tif", np.zeros((4, 5), np.complex64)))


@pytest.mark.parametrize("packing", ["lzw", "deflate", "packbits", "zstd", "lerc", "lzma", "png", "webp", "jpeg2000"])
def test_lossless_packings_are_read(tmp_path, packing):
    path = write(tmp_path / "a.tif", COLOR, compression=packing, photometric="rgb")
    assert np.array_equal(nm.read_raster(path).pixels, COLOR)
    assert np.array_equal(tifffile.imread(path), COLOR)


@pytest.mark.parametrize("packing", ["lzw", "deflate", "zstd", "lzma"])
@pytest.mark.parametrize(
    ("kind", "predictor"), [("u1", 2), ("u2", 2), ("i2", 2), ("i4", 2), ("f2", 3), ("f4", 3), ("f8", 3)]
)
def test_predictors_are_undone(tmp_path, packing, kind, predictor):
    values = GREY.astype(kind)
    image = nm.read_raster(write(tmp_path / "a.tif", values, compression=packing, predictor=predictor))
    assert np.array_equal(image.pixels[..., 0], values)


@pytest.mark.parametrize(
    "more",
    [
        {"tile": (16, 16)},
        {"tile": (16, 16), "compression": "zstd"},
        {"bigtiff": True},
        {"rowsperstrip": 3},
        {"planarconfig": "separate"},
        {"planarconfig": "separate", "compression": "zstd"},
        {"byteorder": ">"},
    ],
)
@pytest.mark.parametrize("kind", ["u1", "u2", "f4"])
def test_every_arrangement_is_read(tmp_path, more, kind):
    values = COLOR.astype(kind)
    stored = np.moveaxis(values, -1, 0) if "planarconfig" in more else values
    assert np.array_equal(nm.read_raster(write(tmp_path / "a.tif", stored, photometric="rgb", **more)).pixels, values)


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_few_bits_are_widened_and_named(tmp_path, bits):
    values = (GREY % 2**bits).astype(np.uint8)
    image = nm.read_raster(write(tmp_path / "a.tif", values, bitspersample=bits))
    assert np.array_equal(image.pixels[..., 0], values * np.uint8(255 // (2**bits - 1)))
    assert image.notes == (f"has only {bits} bit{'s' if bits > 1 else ''} per channel",)


def test_twelve_bits_are_widened_to_16(tmp_path):
    values = GREY.astype(np.uint16) * 20
    image = nm.read_raster(write(tmp_path / "a.tif", values, bitspersample=12))
    assert np.abs(image.pixels[..., 0] - values * (65535 / 4095)).max() <= 1
    assert image.notes == ("has 12 bits per channel, widened to 16",)


def test_numbers_of_24_bits_are_read(tmp_path):
    values = GREY.astype(np.uint32) * 80_000
    image = nm.read_raster(write(tmp_path / "a.tif", values, bitspersample=24))
    assert np.array_equal(image.pixels[..., 0], values)


@pytest.mark.parametrize("kind", ["u1", "u2"])
@pytest.mark.parametrize("packing", [None, "zstd"])
def test_white_is_zero_is_read_as_it_is_shown(tmp_path, kind, packing):
    values = GREY.astype(kind)
    image = nm.read_raster(write(tmp_path / "a.tif", values, photometric="miniswhite", compression=packing))
    assert np.array_equal(image.pixels[..., 0], np.iinfo(kind).max - values)
    assert "0 is white" in image.notes[0]
    if packing is None and kind == "u1":  # OpenCV shows 8-bit files so, too
        assert np.array_equal(cv2.imread(str(tmp_path / "a.tif"), 0), image.pixels[..., 0])


def test_white_is_zero_means_nothing_for_floats(tmp_path):
    image = nm.read_raster(write(tmp_path / "a.tif", GREY.astype(np.float32), photometric="miniswhite"))
    assert np.array_equal(image.pixels[..., 0], GREY)


def test_a_palette_is_expanded_and_named(tmp_path):
    table = RNG.integers(0, 256, (3, 256)).astype(np.uint16) * 257
    image = nm.read_raster(write(tmp_path / "a.tif", GREY, photometric="palette", colormap=table))
    assert np.array_equal(image.pixels, (table // 257).astype(np.uint8).T[GREY])
    assert image.notes == ("its colours are a palette of 256",)


def test_inks_are_refused_as_vectors_and_named_as_depth(tmp_path):
    path = write(tmp_path / "a.tif", np.dstack([COLOR, GREY]), photometric="separated")
    with pytest.raises(
        nm.InputError, match=r"stores CMYK inks, which bends the vectors of a normal map; export it as RGB"
    ):
        nm.read_raster(path)
    assert nm.read_raster(path, holds="depth").notes == ("stores CMYK inks, converted to RGB",)
    with pytest.raises(nm.InputError, match=r"stores CIELAB colours; export it as RGB"):
        nm.read_raster(write(tmp_path / "b.tif", COLOR, photometric="cielab"))


def test_jpeg_in_a_tiff_is_lossy(tmp_path):
    smooth = cv2.GaussianBlur(COLOR, (0, 0), 6)
    path = write(tmp_path / "a.tif", smooth, photometric="ycbcr", compression="jpeg", subsampling=(2, 2))
    image = nm.read_raster(path)
    assert image.lossy
    assert "packed as JPEG" in image.notes[0]
    assert np.abs(image.pixels.astype(int) - tifffile.imread(path)).max() <= 4
    assert not nm.read_raster(write(tmp_path / "b.tif", smooth, photometric="rgb")).lossy


def test_the_first_page_is_read_and_the_others_are_named(tmp_path):
    path = tmp_path / "a.tif"
    with tifffile.TiffWriter(path) as writer:
        for page in (COLOR, 255 - COLOR):
            writer.write(page, photometric="rgb")
    image = nm.read_raster(path)
    assert np.array_equal(image.pixels, COLOR)
    assert image.notes == ("holds 2 pages, of which the first is read; another is a.tif:page 2",)
    assert np.array_equal(nm.read_raster(f"{path}:page 2").pixels, 255 - COLOR)
    with pytest.raises(nm.InputError, match=r"has no layer 'page 3'; it holds: page 1, page 2"):
        nm.read_raster(f"{path}:page 3")


def test_smaller_versions_of_a_page_are_no_pages(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as writer:
        writer.write(GREY)
        writer.write(GREY[::2, ::2], subfiletype=1)
    image = nm.read_raster(tmp_path / "a.tif")
    assert image.notes == ()
    assert np.array_equal(image.pixels[..., 0], GREY)


@pytest.mark.parametrize(
    ("text", "number"), [("-9999", -9999.0), ("nan", np.nan), ("-1.7976931348623157e+308", -np.inf)]
)
def test_the_value_for_no_data_is_that_of_the_tag(tmp_path, text, number):
    tags = [(42113, "s", 0, text, True)]
    image = nm.read_raster(write(tmp_path / "a.tif", GREY.astype(np.float32), extratags=tags))
    assert np.array_equal(image.nodata, number, equal_nan=True)
    assert nm.read_raster(write(tmp_path / "b.tif", GREY.astype(np.int16), extratags=tags)).nodata is not None
    assert nm.read_raster(write(tmp_path / "c.tif", GREY)).nodata is None


@pytest.mark.parametrize(("model", "unit", "metres"), [(1, 9001, "30.0"), (2, 9001, None), (1, 9002, None)])
def test_the_metres_of_a_projected_pixel_are_stated(tmp_path, model, unit, metres):
    keys = (1, 1, 0, 2, 1024, 0, 1, model, 3076, 0, 1, unit)
    tags = [(33550, "d", 3, (30.0, 30.0, 0.0), True), (34735, "H", len(keys), keys, True)]
    image = nm.read_raster(write(tmp_path / "a.tif", GREY, extratags=tags))
    assert image.attributes.get("metres_per_px") == metres


def test_an_orientation_is_stated_and_the_pixels_stay(tmp_path):
    image = nm.read_raster(write(tmp_path / "a.tif", GREY, extratags=[(274, "H", 1, 6, True)]))
    assert image.orientation == 6
    assert np.array_equal(image.pixels[..., 0], GREY)


def test_too_many_channels_are_refused(tmp_path):
    with pytest.raises(nm.InputError, match=r"has 70 channels; a picture has 1 to 4"):
        nm.read_raster(write(tmp_path / "a.tif", np.zeros((4, 5, 70), np.int64), planarconfig="contig"))
    with pytest.raises(nm.InputError, match=r"a\.tif: holds a volume; save one slice of it"):
        nm.read_raster(
            write(
                tmp_path / "a.tif",
                np.zeros((5, 16, 16), np.int64),
                volumetric=True,
                tile=(1, 16, 16),
                photometric="minisblack",
            )
        )


@pytest.mark.parametrize("more", [{}, {"compression": "zstd"}, {"compression": "lerc"}, {"compression": "deflate"}])
@pytest.mark.parametrize("kind", ["i2", "i8", "f4"])
def test_every_truncation_is_refused(tmp_path, more, kind):
    if more.get("compression") == "lerc" and kind == "i8":
        kind = "u2"
    path = write(tmp_path / "a.tif", GREY.astype(kind), rowsperstrip=4, **more)
    data = path.read_bytes()
    for size in [*range(4, 400, 13), *range(400, len(data), 97), len(data) - 9]:
        path.write_bytes(data[:size])
        with pytest.raises(nm.InputError, match=r"a\.tif: the TIFF file (is truncated or damaged|cannot be decoded)"):
            nm.read_raster(path)


def test_what_a_damaged_header_declares_is_not_believed(tmp_path):
    path = write(tmp_path / "a.tif", GREY.astype(np.int64))
    data = path.read_bytes()
    width = (
        data.index(struct.pack("<HHI", 256, 3, 1))
        if struct.pack("<HHI", 256, 3, 1) in data
        else data.index(struct.pack("<HHI", 256, 4, 1))
    )
    rng = np.random.default_rng(3)
    for _ in range(60):
        broken = bytearray(data)
        broken[width + int(rng.integers(0, 120))] = int(rng.integers(0, 256))
        path.write_bytes(bytes(broken))
        try:
            nm.read_raster(path, nm.ReadOptions(max_megapixels=1))
        except (nm.InputError, nm.LimitError) as error:
            assert str(error).startswith(str(path))


@pytest.mark.parametrize(
    "layout", [{"tile": (32, 48)}, {"rowsperstrip": 16}, {"tile": (32, 48), "compression": "deflate"}]
)
def test_doubles_in_tiles_keep_their_numbers(tmp_path, layout):
    values = np.random.default_rng(2).random((70, 50))
    tifffile.imwrite(tmp_path / "heights.tif", values, **layout)
    assert np.array_equal(nm.read_raster(tmp_path / "heights.tif").pixels[..., 0], values.astype(np.float32))
