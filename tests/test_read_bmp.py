"""BMP files with every header, packing and set of channel masks, compared with Pillow, OpenCV and formulas."""

import struct

import cv2
import numpy as np
import pytest
from PIL import Image

import nmaptool as nm

RNG = np.random.default_rng(7)
COLOR = RNG.integers(0, 256, (7, 10, 4)).astype(np.uint8)
RGBA_MASKS = (0xFF, 0xFF00, 0xFF0000, 0xFF000000)


def bmp(data, bits, rows=7, cols=10, packing=0, size=40, masks=(), table=b"", entries=0):
    """A file with the header of the given size; masks follow a plain header, and are part of a larger one."""
    packed = struct.pack(f"<{len(masks)}I", *masks)
    head = struct.pack("<IiiHHIIiiII", size, cols, rows, 1, bits, packing, len(data), 2835, 2835, entries, 0)
    head = (head + packed).ljust(size, b"\0") if size > 40 else head + packed
    start = 14 + len(head) + len(table)
    return b"BM" + struct.pack("<IHHI", start + len(data), 0, 0, start) + head + table + data


def packed_rows(values):
    rows = values.reshape(len(values), -1).view(np.uint8)
    return np.pad(rows, ((0, 0), (0, -rows.shape[1] % 4)))[::-1].tobytes()


@pytest.mark.parametrize("mode", ["RGB", "L", "1", "P"])
def test_a_bmp_is_as_pillow_wrote_it(tmp_path, mode):
    picture = Image.fromarray(COLOR[..., :3])
    picture = picture.quantize(200) if mode == "P" else picture.convert(mode)
    picture.save(tmp_path / "a.bmp")
    expected = np.asarray(picture.convert("RGB" if mode in ("P", "RGB") else "L")).reshape(7, 10, -1)
    image = nm.read_raster(tmp_path / "a.bmp")
    assert np.array_equal(image.pixels, expected)
    assert bool(image.notes) == (mode in ("P", "1"))


@pytest.mark.parametrize("size", [40, 52, 56, 108, 124])
@pytest.mark.parametrize("packing", [3, 6])
@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 1, 0, 3), (3, 2, 1, 0), (1, 0, 3, 2)])
@pytest.mark.parametrize("rows", [7, -7])
def test_channel_masks_say_where_the_channels_are(tmp_path, size, packing, order, rows):
    alpha = packing == 6 or size >= 56
    masks = [RGBA_MASKS[place] for place in order]
    stored = np.zeros_like(COLOR)
    for channel, place in enumerate(order):
        stored[..., place] = COLOR[..., channel]
    data = packed_rows(stored) if rows > 0 else stored.tobytes()
    path = tmp_path / "a.bmp"
    path.write_bytes(bmp(data, 32, rows, packing=packing, size=size, masks=masks[: 4 if alpha else 3]))
    image = nm.read_raster(path)
    assert image.channels == (("R", "G", "B", "A") if alpha else ("R", "G", "B"))
    assert np.array_equal(image.pixels, COLOR if alpha else COLOR[..., :3])


@pytest.mark.parametrize(
    ("masks", "packing"), [((0x7C00, 0x3E0, 0x1F), 0), ((0xF800, 0x7E0, 0x1F), 3), ((0xF00, 0xF0, 0xF), 3)]
)
def test_16_bit_colours_are_widened_and_named(tmp_path, masks, packing):
    values = RNG.integers(0, 2**16, (7, 10)).astype("<u2")
    (tmp_path / "a.bmp").write_bytes(bmp(packed_rows(values), 16, packing=packing, masks=masks if packing else ()))
    image = nm.read_raster(tmp_path / "a.bmp")
    shifts = [(mask & -mask).bit_length() - 1 for mask in masks]
    expected = np.dstack([(values & m) >> s for m, s in zip(masks, shifts, strict=True)]).astype(float)
    expected *= [255 / (m >> s) for m, s in zip(masks, shifts, strict=True)]
    assert np.abs(image.pixels - expected).max() <= 0.5
    assert "bits per channel" in image.notes[0]
    if masks[0] != 0xF00:
        with Image.open(tmp_path / "a.bmp") as other:
            assert np.abs(image.pixels.astype(int) - np.asarray(other)).max() <= 1


def test_ten_bits_per_channel_are_kept_in_16(tmp_path):
    values = RNG.integers(0, 2**30, (7, 10)).astype("<u4")
    masks = (0x3FF00000, 0xFFC00, 0x3FF)
    (tmp_path / "a.bmp").write_bytes(bmp(packed_rows(values), 32, packing=3, masks=masks))
    image = nm.read_raster(tmp_path / "a.bmp")
    assert image.bits == 16
    assert np.abs(image.pixels[..., 0] - (values >> 20) * (65535 / 1023)).max() <= 0.5


def test_the_fourth_byte_without_masks_counts_only_if_it_varies(tmp_path):
    for spare, count in ((COLOR[..., 3] * 0, 3), (COLOR[..., 3] * 0 + 255, 3), (COLOR[..., 3], 4)):
        stored = np.dstack([COLOR[..., 2::-1], spare])
        (tmp_path / "a.bmp").write_bytes(bmp(packed_rows(stored), 32))
        image = nm.read_raster(tmp_path / "a.bmp")
        assert np.array_equal(image.pixels, np.dstack([COLOR[..., :3], spare])[..., :count])
    assert np.array_equal(cv2.imread(str(tmp_path / "a.bmp"))[..., ::-1], COLOR[..., :3])


@pytest.mark.parametrize("bits", [1, 2, 4, 8])
def test_a_palette_of_few_colours_is_expanded(tmp_path, bits):
    table = RNG.integers(0, 256, (2**bits, 4)).astype(np.uint8)
    index = RNG.integers(0, 2**bits, (7, 10)).astype(np.uint8)
    places = np.unpackbits(index[..., None], axis=-1)[..., 8 - bits :].reshape(7, -1)
    path = tmp_path / "a.bmp"
    path.write_bytes(bmp(packed_rows(np.packbits(places, axis=1)), bits, table=table.tobytes(), entries=2**bits))
    image = nm.read_raster(path)
    assert np.array_equal(image.pixels, table[index][..., 2::-1])
    assert image.notes == (f"its colours are a palette of {2**bits}",)
    path.write_bytes(bmp(packed_rows(np.packbits(places, axis=1)), bits, table=table[:1].tobytes(), entries=1))
    with pytest.raises(nm.InputError, match=r"a\.bmp: the BMP file is truncated or damaged"):
        nm.read_raster(path)


def test_an_os2_header_is_read(tmp_path):
    data = packed_rows(COLOR[..., 2::-1].copy())
    head = struct.pack("<IHHHH", 12, 10, 7, 1, 24)
    (tmp_path / "a.bmp").write_bytes(b"BM" + struct.pack("<IHHI", 26 + len(data), 0, 0, 26) + head + data)
    assert np.array_equal(nm.read_raster(tmp_path / "a.bmp").pixels, COLOR[..., :3])


RUNS = bytes([5, 7, 3, 9, 0, 0, 0, 4, 1, 2, 3, 4, 4, 6, 0, 0, 0, 2, 2, 1, 6, 5, 0, 1])
RUN_ROWS = [[7, 7, 7, 7, 7, 9, 9, 9], [1, 2, 3, 4, 6, 6, 6, 6], [0] * 8, [0, 0, 5, 5, 5, 5, 5, 5]]


def test_run_lengths_are_unpacked(tmp_path):
    table = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 4, axis=1)
    path = tmp_path / "a.bmp"
    path.write_bytes(bmp(RUNS, 8, 4, 8, packing=1, table=table.tobytes(), entries=256))
    assert np.array_equal(nm.read_raster(path).pixels[::-1, :, 0], RUN_ROWS)
    with Image.open(path) as other:
        assert np.array_equal(np.asarray(other)[::-1], RUN_ROWS)
    four = bytes([8, 0x12, 0, 0, 0, 5, 0x34, 0x56, 0x70, 0, 3, 0x99, 0, 1])
    path.write_bytes(bmp(four, 4, 2, 8, packing=2, table=table[:16].tobytes(), entries=16))
    expected = [[3, 4, 5, 6, 7, 9, 9, 9], [1, 2, 1, 2, 1, 2, 1, 2]]
    assert np.array_equal(nm.read_raster(path).pixels[..., 0], expected)


def test_every_truncation_and_overrun_is_refused(tmp_path):
    table = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 4, axis=1).tobytes()
    runs = bmp(RUNS, 8, 4, 8, packing=1, table=table, entries=256)
    masked = bmp(packed_rows(COLOR), 32, packing=6, size=124, masks=RGBA_MASKS)
    path = tmp_path / "a.bmp"
    for data in (runs, masked):
        for size in [*range(2, 60), *range(60, len(data), 11), len(data) - 1]:
            path.write_bytes(data[:size])
            with pytest.raises(nm.InputError, match=r"a\.bmp: the BMP file is truncated or damaged"):
                nm.read_raster(path)
    path.write_bytes(bmp(bytes([9, 1, 0, 1]), 8, 4, 8, packing=1, table=table, entries=256))
    with pytest.raises(nm.InputError, match=r"a\.bmp: the BMP file is truncated or damaged"):
        nm.read_raster(path)


def test_what_no_bmp_should_hold_is_refused(tmp_path):
    path = tmp_path / "a.bmp"
    path.write_bytes(bmp(bytes(100), 24, packing=5))
    with pytest.raises(nm.InputError, match=r"is a BMP around a PNG; export it as PNG"):
        nm.read_raster(path)
    for masks in ((0xFF, 0xFF00, 0), (0xF0F, 0xFF0000, 0xFF000000)):
        path.write_bytes(bmp(packed_rows(COLOR), 32, packing=3, masks=masks))
        with pytest.raises(nm.InputError, match=r"a\.bmp: the BMP file is truncated or damaged"):
            nm.read_raster(path)
