"""DDS textures: blocks as Pillow reads them, signed blocks by formulas, plain numbers, what is refused."""

import struct

import numpy as np
import pytest
from PIL import Image

import nmaptool as nm

RNG = np.random.default_rng(16)
COLOR = RNG.integers(0, 256, (12, 16, 3)).astype(np.uint8)
ALPHA = RNG.integers(0, 256, (12, 16, 1)).astype(np.uint8)


def dds(number, blocks, rows=12, cols=16, caps=0):
    head = struct.pack("<4s7I44x", b"DDS ", 124, 0x1007, rows, cols, len(blocks), 0, 1)
    head += struct.pack("<II4s5I", 32, 4, b"DX10", 0, 0, 0, 0, 0) + struct.pack("<5I", 0x1000, caps, 0, 0, 0)
    return head + struct.pack("<5I", number, 3, 0, 1, 0) + blocks


BLOCKS = {"BC1": (71, 8), "BC2": (74, 16), "BC3": (77, 16), "BC4": (80, 8), "BC5": (83, 16), "BC7": (98, 16)}


@pytest.mark.parametrize("name", BLOCKS)
def test_block_compressed_textures_are_as_pillow_reads_them(tmp_path, name):
    number, size = BLOCKS[name]
    (tmp_path / "a.dds").write_bytes(dds(number, RNG.integers(0, 256, 12 * size, np.uint8).tobytes()))
    image = nm.read_raster(tmp_path / "a.dds")
    with Image.open(tmp_path / "a.dds") as other:
        expected = np.asarray(other).reshape(12, 16, -1)[..., : len(image.channels)]
    assert np.abs(image.pixels.astype(int) - expected).max() <= 2  # decoders round differently
    assert len(image.channels) == {"BC4": 1, "BC5": 2}.get(name, 4)
    assert image.lossy
    assert image.notes == (f"is block-compressed ({name})",)


@pytest.mark.parametrize("number", [84, 81])
def test_signed_blocks_hold_their_ends_and_the_steps_between(tmp_path, number):
    count = {84: 2, 81: 1}[number]
    index = sum((code % 8) << (3 * code) for code in range(16))
    block = struct.pack("<bb", 127, -128) + index.to_bytes(6, "little")
    (tmp_path / "a.dds").write_bytes(dds(number, block * count * 12))
    image = nm.read_raster(tmp_path / "a.dds")
    steps = [1, -1, *((7 - n - 2 * n + n) / 7 for n in range(1, 7))]
    expected = np.array([steps[code % 8] for code in range(16)]).reshape(4, 4)
    assert image.pixels.shape == (12, 16, count)
    assert np.abs(image.pixels[:4, :4] - expected[..., None]).max() < 1e-6
    few = struct.pack("<bb", -127, 127) + index.to_bytes(6, "little")
    (tmp_path / "a.dds").write_bytes(dds(number, few * count * 12))
    assert np.allclose(nm.read_raster(tmp_path / "a.dds").pixels[0, :4, 0], [-1, 1, -0.6, -0.2])


@pytest.mark.parametrize(
    ("number", "kind", "count"),
    [(2, "f4", 4), (10, "f2", 4), (11, "u2", 4), (34, "f2", 2), (41, "f4", 1), (56, "u2", 1)],
)
def test_plain_numbers_in_a_texture_keep_their_values(tmp_path, number, kind, count):
    values = (RNG.random((12, 16, count)) * 60).astype(kind)
    (tmp_path / "a.dds").write_bytes(dds(number, values.tobytes()))
    image = nm.read_raster(tmp_path / "a.dds")
    assert np.array_equal(image.pixels, values)
    assert (image.bits, image.lossy) == (8 * values.dtype.itemsize, False)


def old_dds(bits, masks, flags, data, rows=12, cols=16):
    head = struct.pack("<4s7I44x", b"DDS ", 124, 0x1007, rows, cols, len(data), 0, 1)
    return (
        head
        + struct.pack("<II4s5I", 32, flags, b"\0" * 4, bits, *masks)
        + struct.pack("<5I", 0x1000, 0, 0, 0, 0)
        + data
    )


def test_older_textures_state_bits_and_masks(tmp_path):
    path, words = tmp_path / "a.dds", RNG.integers(0, 2**16, (12, 16, 1)).astype("<u2")
    path.write_bytes(old_dds(16, (0xFFFF, 0, 0, 0), 0x20000, words.tobytes()))
    assert np.array_equal(nm.read_raster(path).pixels, words)
    signed = RNG.integers(-127, 128, (12, 16, 2)).astype("i1")
    path.write_bytes(old_dds(16, (0xFF, 0xFF00, 0, 0), 0x80000, signed.tobytes()))
    assert np.allclose(nm.read_raster(path).pixels, signed / 127)
    bgra = np.dstack([COLOR[..., ::-1], ALPHA])
    path.write_bytes(old_dds(32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000), 0x41, bgra.tobytes()))
    assert np.array_equal(nm.read_raster(path).pixels, np.dstack([COLOR, ALPHA]))
    path.write_bytes(dds(87, bgra.tobytes()))
    assert np.array_equal(nm.read_raster(path).pixels, np.dstack([COLOR, ALPHA]))
    path.write_bytes(old_dds(32, (0x3FF, 0xFFC00, 0x3FF00000, 0xC0000000), 0x41, bgra.tobytes()))
    with pytest.raises(nm.InputError, match=r"is a DDS in 10 bits per channel; save it as BC5, BC7 or uncompressed"):
        nm.read_raster(path)


@pytest.mark.parametrize(("number", "kind"), [(31, "i1"), (13, "i2")])
def test_signed_integers_in_a_texture_are_shares_of_one(tmp_path, number, kind):
    values = np.zeros((12, 16, 4), kind)
    values[0, 0] = np.iinfo(kind).max, np.iinfo(kind).min, -np.iinfo(kind).max, 0
    (tmp_path / "a.dds").write_bytes(dds(number, values.tobytes()))
    assert nm.read_raster(tmp_path / "a.dds").pixels[0, 0].tolist() == [1, -1, -1, 0]


def test_textures_that_are_no_picture_are_refused(tmp_path):
    cases = {
        dds(83, bytes(192))[:112]
        + struct.pack("<I", 0x200)
        + dds(83, bytes(192))[116:]: "is a cube map, volume or array",
        dds(26, bytes(768)): "is a DDS in DXGI format 26; save it as BC5, BC7 or uncompressed, or as PNG",
        dds(83, bytes(192), 100_000, 100_000): "100000 x 100000 is 10000 megapixels",
    }
    for data, text in cases.items():
        (tmp_path / "a.dds").write_bytes(data)
        with pytest.raises((nm.InputError, nm.LimitError), match=text):
            nm.read_raster(tmp_path / "a.dds")


def test_a_two_channel_texture_is_a_normal_map(tmp_path, dome, codes):
    d = dome()
    Image.fromarray(codes(d.normals)).save(tmp_path / "a.dds", pixel_format="BC5")
    back = nm.read_normal_map(tmp_path / "a.dds")
    assert back.decoding.components == "xy"
    assert np.abs(back.normals - d.normals)[d.inside].mean() < 0.03
