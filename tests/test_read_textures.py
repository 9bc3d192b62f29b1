"""TGA, WebP, HDR, PFM and PGM/PPM files, compared with Pillow, OpenCV and formulas; truncations of these and DDS."""

import struct

import cv2
import numpy as np
import pytest
from PIL import Image
from test_read_dds import dds

import nmaptool as nm

RNG = np.random.default_rng(6)
COLOR = RNG.integers(0, 256, (12, 16, 3)).astype(np.uint8)
COLOR[2:6, 3:12] = COLOR[2, 3]  # runs
ALPHA = RNG.integers(0, 256, (12, 16, 1)).astype(np.uint8)
FLOATS = RNG.normal(size=(12, 16, 3)).astype(np.float32)


def tga(pixels, bits, flags, kind=2, table=b"", entries=0, entry_bits=0):
    rows, cols = pixels.shape[:2]
    head = struct.pack("<BBBHHB4xHHBB", 0, bool(table), kind, 0, entries, entry_bits, cols, rows, bits, flags)
    return head + table + pixels.tobytes()


@pytest.mark.parametrize("runs", [None, "tga_rle"])
@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "P"])
@pytest.mark.parametrize("origin", [-1, 1])
def test_a_tga_is_as_pillow_wrote_it(tmp_path, runs, mode, origin):
    picture = Image.fromarray(np.dstack([COLOR, ALPHA])).convert("RGB" if mode == "P" else mode)
    picture = picture.quantize(16) if mode == "P" else picture
    picture.save(tmp_path / "a.tga", compression=runs, orientation=origin)
    image = nm.read_raster(tmp_path / "a.tga")
    expected = np.asarray(picture.convert("RGB") if mode == "P" else picture)
    assert np.array_equal(image.pixels, expected.reshape(12, 16, -1))
    assert image.channels == {"L": ("Y",), "RGBA": ("R", "G", "B", "A")}.get(mode, ("R", "G", "B"))
    assert image.notes == (("its colours are a palette of 16",) if mode == "P" else ())


@pytest.mark.parametrize(("flags", "turn"), [(0x20, (1, 1)), (0x00, (-1, 1)), (0x30, (1, -1)), (0x10, (-1, -1))])
def test_a_tga_may_begin_at_any_corner(tmp_path, flags, turn):
    (tmp_path / "a.tga").write_bytes(tga(COLOR[..., ::-1], 24, flags))
    assert np.array_equal(nm.read_raster(tmp_path / "a.tga").pixels, COLOR[:: turn[0], :: turn[1]])


def test_a_tga_of_16_bits_has_5_per_channel(tmp_path):
    values = RNG.integers(0, 2**15, (12, 16)).astype("<u2")
    (tmp_path / "a.tga").write_bytes(tga(values, 16, 0x20))
    image = nm.read_raster(tmp_path / "a.tga")
    expected = np.dstack([(values >> shift & 31) / 31 * 255 for shift in (10, 5, 0)])
    assert np.abs(image.pixels - expected).max() <= 1
    assert image.notes == ("has only 5 bits per channel",)


def test_the_last_byte_of_a_tga_that_declares_no_alpha_counts_only_if_it_varies(tmp_path):
    for spare, channels in ((ALPHA * 0, ("R", "G", "B")), (ALPHA, ("R", "G", "B", "A"))):
        (tmp_path / "a.tga").write_bytes(tga(np.dstack([COLOR[..., ::-1], spare]), 32, 0x20))
        assert nm.read_raster(tmp_path / "a.tga").channels == channels
    (tmp_path / "a.tga").write_bytes(tga(np.dstack([COLOR[..., 0], ALPHA]), 16, 0x28, kind=3))
    assert nm.read_raster(tmp_path / "a.tga").channels == ("Y", "A")


def test_a_tga_is_known_by_its_ending_or_by_its_footer(tmp_path):
    data = tga(COLOR[..., ::-1], 24, 0x20)
    (tmp_path / "map").write_bytes(data)
    with pytest.raises(nm.InputError, match=r"is not a picture in a supported format"):
        nm.read_raster(tmp_path / "map")
    (tmp_path / "map").write_bytes(data + bytes(8) + b"TRUEVISION-XFILE.\0")
    assert np.array_equal(nm.read_raster(tmp_path / "map").pixels, COLOR)
    (tmp_path / "text.tga").write_text("this is a text and no picture", encoding="utf-8")
    with pytest.raises(nm.InputError, match=r"text\.tga: is not a picture in a supported format"):
        nm.read_raster(tmp_path / "text.tga")


def test_webp_says_whether_it_is_lossy(tmp_path):
    picture = Image.fromarray(np.dstack([COLOR, ALPHA]))
    picture.save(tmp_path / "a.webp", lossless=True, exact=True)
    image = nm.read_raster(tmp_path / "a.webp")
    assert not image.lossy
    assert np.array_equal(image.pixels, np.dstack([COLOR, ALPHA]))
    for name, one in (("b", picture.convert("RGB")), ("c", picture)):
        one.save(tmp_path / f"{name}.webp", quality=90)
        image = nm.read_raster(tmp_path / f"{name}.webp")
        assert image.lossy
        with Image.open(tmp_path / f"{name}.webp") as other:
            assert np.array_equal(image.pixels, np.asarray(other))
    picture.save(tmp_path / "d.webp", save_all=True, append_images=[picture.rotate(90)])
    with pytest.raises(nm.InputError, match=r"d\.webp: is an animation; export one frame as PNG"):
        nm.read_raster(tmp_path / "d.webp")


@pytest.mark.parametrize("ending", ["jpg", "tif", "png", "webp"])
def test_an_exif_orientation_is_stated_and_the_pixels_stay(tmp_path, ending):
    exif = Image.Exif()
    exif[274] = 6
    more = {"lossless": True} if ending == "webp" else {"quality": 100} if ending == "jpg" else {}
    Image.fromarray(COLOR).save(tmp_path / f"a.{ending}", exif=exif, **more)
    image = nm.read_raster(tmp_path / f"a.{ending}")
    assert image.orientation == 6
    with Image.open(tmp_path / f"a.{ending}") as other:  # Pillow turns a TIFF by itself
        expected = COLOR if ending == "tif" else np.asarray(other)
    assert np.abs(image.pixels.astype(int) - expected).max() <= 2
    Image.fromarray(COLOR).save(tmp_path / f"b.{ending}")
    assert nm.read_raster(tmp_path / f"b.{ending}").orientation == 1


def test_palettes_and_few_bits_of_a_png_are_named(tmp_path):
    Image.fromarray(COLOR).quantize(16).save(tmp_path / "p.png")
    assert nm.read_raster(tmp_path / "p.png").notes == ("its colours are a palette of at most 16",)
    Image.fromarray(COLOR[..., 0] > 99).save(tmp_path / "1.png")
    assert nm.read_raster(tmp_path / "1.png").notes == ("has only 1 bit per channel",)


def test_inks_in_a_jpeg_are_refused_as_vectors(tmp_path):
    Image.fromarray(COLOR).convert("CMYK").save(tmp_path / "a.jpg")
    with pytest.raises(nm.InputError, match=r"stores CMYK inks, which bends the vectors of a normal map"):
        nm.read_raster(tmp_path / "a.jpg")
    assert nm.read_raster(tmp_path / "a.jpg", holds="depth").notes == ("stores CMYK inks, converted to RGB",)


@pytest.mark.parametrize("progressive", [False, True])
def test_what_follows_a_jpeg_does_not_count(tmp_path, progressive):
    path = tmp_path / "a.jpg"
    Image.fromarray(COLOR).save(path, progressive=progressive)
    whole, pixels = path.read_bytes(), nm.read_raster(path).pixels
    path.write_bytes(whole + b"video \xff\xda with marks")  # as a phone appends it to a photograph
    assert np.array_equal(nm.read_raster(path).pixels, pixels)
    thumbnail = b"\xff\xe1\x00\x08" + b"\xff\xd8\xff\xda\xff\xd9"
    path.write_bytes(whole[:2] + thumbnail + whole[2:])
    assert np.array_equal(nm.read_raster(path).pixels, pixels)
    path.write_bytes(whole[:2] + thumbnail + whole[2 : len(whole) * 2 // 3])
    with pytest.raises(nm.InputError, match=r"the JPEG file is truncated or damaged"):
        nm.read_raster(path)


@pytest.mark.parametrize("channels", [1, 3])
def test_a_pfm_is_as_opencv_wrote_it(tmp_path, channels):
    values = FLOATS[..., :channels]
    cv2.imwrite(str(tmp_path / "a.pfm"), values[..., ::-1])
    image = nm.read_raster(tmp_path / "a.pfm")
    assert np.array_equal(image.pixels, values)
    big = f"P{'F' if channels == 3 else 'f'}\n16 12\n2.5\n".encode() + values[::-1].astype(">f4").tobytes()
    (tmp_path / "b.pfm").write_bytes(big)
    image = nm.read_raster(tmp_path / "b.pfm")
    assert np.array_equal(image.pixels, values)
    assert image.notes == ("states a scale of 2.5, which is not applied",)


def test_infinity_in_a_pfm_stays(tmp_path):
    values = FLOATS[..., :1].copy()
    values[0, 0] = np.inf
    (tmp_path / "a.pfm").write_bytes(b"Pf\n16 12\n-1.0\n" + values[::-1].tobytes())
    assert np.isinf(nm.read_raster(tmp_path / "a.pfm", holds="depth").pixels[0, 0, 0])


@pytest.mark.parametrize(("ending", "kind"), [("ppm", "u1"), ("ppm", "u2"), ("pgm", "u1"), ("pgm", "u2")])
def test_pgm_and_ppm_are_as_opencv_wrote_them(tmp_path, ending, kind):
    values = COLOR.astype(kind) * (1 if kind == "u1" else 257)
    values = values if ending == "ppm" else values[..., :1]
    cv2.imwrite(str(tmp_path / f"a.{ending}"), values[..., ::-1])
    assert np.array_equal(nm.read_raster(tmp_path / f"a.{ending}").pixels, values)


def test_a_pgm_with_another_largest_code_is_scaled(tmp_path):
    (tmp_path / "a.pgm").write_bytes(b"P5\n# a comment\n2 1\n1023\n" + struct.pack(">HH", 1023, 341))
    image = nm.read_raster(tmp_path / "a.pgm")
    assert image.pixels.ravel().tolist() == [65535, 21845]
    assert image.notes == ("its codes go to 1023 and are scaled to 65535",)


def test_an_hdr_is_as_opencv_reads_it(tmp_path):
    cv2.imwrite(str(tmp_path / "a.hdr"), np.abs(FLOATS))
    image = nm.read_raster(tmp_path / "a.hdr", holds="depth")
    assert np.array_equal(image.pixels, cv2.imread(str(tmp_path / "a.hdr"), cv2.IMREAD_UNCHANGED)[..., ::-1])
    assert "8 significant bits" in image.notes[0]
    data = (tmp_path / "a.hdr").read_bytes()
    (tmp_path / "a.hdr").write_bytes(data.replace(b"-Y 12 +X 16", b"+Y 12 +X 16"))
    assert nm.read_raster(tmp_path / "a.hdr").orientation == 4


def makers():
    picture = Image.fromarray(COLOR)
    yield "raw.tga", picture.save
    yield "runs.tga", lambda p: picture.save(p, compression="tga_rle")
    yield "lossless.webp", lambda p: picture.save(p, lossless=True)
    yield "lossy.webp", lambda p: picture.save(p, quality=90)
    yield "plain.dds", picture.save
    yield "bc1.dds", lambda p: Image.fromarray(np.dstack([COLOR, ALPHA])).save(p, pixel_format="DXT1")
    yield "bc5.dds", lambda p: picture.save(p, pixel_format="BC5")
    yield "float.dds", lambda p: p.write_bytes(dds(2, RNG.random((12, 16, 4)).astype("f4").tobytes()))
    yield "a.pfm", lambda p: cv2.imwrite(str(p), FLOATS)
    yield "a.ppm", lambda p: cv2.imwrite(str(p), COLOR)
    yield "a.hdr", lambda p: cv2.imwrite(str(p), np.abs(FLOATS))


@pytest.mark.parametrize(("name", "make"), list(makers()))
def test_every_truncation_is_refused(tmp_path, name, make):
    path = tmp_path / name
    make(path)
    data = path.read_bytes()
    # a TGA is complete without the footer that Pillow appends
    end = len(data) - (26 if name.endswith("tga") else 0)
    for size in [*range(1, end, max(1, end // 90)), *range(end - 8, end)]:
        path.write_bytes(data[:size])
        with pytest.raises(nm.InputError, match=rf"{name}: .*(export or download it again|supported format)") as caught:
            nm.read_raster(path)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "make"), list(makers()))
def test_a_damaged_header_gives_a_picture_or_one_line(tmp_path, name, make):
    path = tmp_path / name
    make(path)
    data = path.read_bytes()
    rng = np.random.default_rng(8)
    for _ in range(40):
        broken = bytearray(data)
        for _ in range(2):
            broken[int(rng.integers(0, min(160, len(data))))] = int(rng.integers(0, 256))
        path.write_bytes(bytes(broken))
        try:
            nm.read_raster(path, nm.ReadOptions(max_megapixels=1))
        except (nm.InputError, nm.LimitError) as error:
            assert str(error).startswith(str(path))


CLAIMS = {
    "a.pfm": b"PF\n60000 60000\n-1\n",
    "a.ppm": b"P6\n60000 60000\n255\n",
    "a.hdr": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n",
    "a.tga": struct.pack("<BBBHHB4xHHBB", 0, 0, 2, 0, 0, 0, 60000, 60000, 24, 0),
    "a.webp": b"RIFF\x50\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0" + 2 * (59999).to_bytes(3, "little"),
}


@pytest.mark.parametrize("name", CLAIMS)
def test_a_header_that_claims_too_many_pixels_is_refused(tmp_path, name):
    (tmp_path / name).write_bytes(CLAIMS[name] + bytes(64))
    with pytest.raises(nm.LimitError, match=r"60000 x 60000 is 3600 megapixels, more than the limit of 270"):
        nm.read_raster(tmp_path / name)
    with pytest.raises((nm.InputError, nm.LimitError), match=rf"{name}: "):
        nm.read_raster(tmp_path / name, nm.ReadOptions(max_megapixels=1e6))
