"""The vectors as stored, which reading returns besides the map; codes and signs."""

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.composition.conversion import convert_image
from nmaptool.core.vectors import unit
from nmaptool.maps import codec, decoding
from nmaptool.maps.decoding import decode_image, decode_normal_map

SHAPE = (40, 52)


def hemisphere():
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    x, y = (x - 25.5) / 40, (19.5 - y) / 40
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)], axis=-1).astype(np.float32)


def raster(normals, length=1.0, signs=(1, 1, 1), order=(0, 1, 2), alpha=None):
    """A float image of normals of ``length``, with channels and signs as in some files."""
    stored = np.empty_like(normals)
    stored[..., list(order)] = normals * np.float32(length) * np.array(signs, np.float32)
    channels = ("R", "G", "B") if alpha is None else ("R", "G", "B", "A")
    pixels = stored if alpha is None else np.dstack([stored, alpha])
    return nm.RasterImage(pixels, channels, bits=32)


def test_stored_vectors_are_in_eye_space_and_keep_their_lengths():
    normals = hemisphere()
    for options, signs, order in (
        (nm.ReadOptions(), (1, 1, 1), (0, 1, 2)),
        (nm.ReadOptions(green="down"), (1, -1, 1), (0, 1, 2)),
        (nm.ReadOptions(swizzle="-g,r,b"), (-1, 1, 1), (1, 0, 2)),
        (nm.ReadOptions(swizzle="-g,r,b", green="down"), (-1, -1, 1), (1, 0, 2)),
    ):
        decoded = decode_image(raster(normals, 0.9, signs, order), options)
        assert np.abs(decoded.stored - 0.9 * normals).max() < 1e-6
        assert np.abs(decoded.normal_map.normals - normals).max() < 1e-6


def test_stored_vectors_ignore_the_background():
    alpha = np.ones(SHAPE, np.float32)
    alpha[:, :9] = 0
    image = raster(hemisphere(), alpha=alpha)
    decoded = decode_image(image)
    assert decoded.background.kind == "alpha"
    assert np.array_equal(decoded.background.mask, alpha == 0)
    assert np.array_equal(decoded.stored, hemisphere())
    assert (decoded.normal_map.normals[alpha == 0] == (0, 0, 1)).all()


@pytest.mark.parametrize("components", ["xyz", "xy", "octahedral"])
def test_decoding_an_image_gives_the_same_map_as_reading_it(components):
    codes = codec.encode_map(hemisphere(), None, 8, green="down", zero_code="128")
    image = nm.RasterImage(codes, ("R", "G", "B"))
    options = nm.ReadOptions(components=components, green="down")
    decoded, read = decode_image(image, options), decode_normal_map(image, options)
    for name in ("normals", "coverage", "foreground"):
        assert np.array_equal(getattr(decoded.normal_map, name), getattr(read, name))
    assert decoded.normal_map.decoding == read.decoding
    assert np.array_equal(unit(decoded.stored), read.normals)


@pytest.mark.parametrize("verb", [nm.inspect_map, lambda image: convert_image(image, "16")])
def test_an_image_is_decoded_once(monkeypatch, verb):
    decoded = []
    original = decoding.decode_map
    monkeypatch.setattr(decoding, "decode_map", lambda *args: decoded.append(1) or original(*args))
    verb(nm.RasterImage(codec.encode_map(hemisphere(), None, 16), ("R", "G", "B"), bits=16))
    assert len(decoded) == 1


@pytest.mark.parametrize("bits", [8, 16, 32])
@pytest.mark.parametrize("green", ["up", "down"])
def test_encoding_then_decoding_gives_the_same_normals(bits, green):
    normals, coverage = hemisphere(), np.ones(SHAPE, np.float32)
    pixels = codec.encode_map(normals, coverage, bits, green=green)
    assert pixels.shape == (*SHAPE, 4)
    assert pixels.dtype == {8: np.uint8, 16: np.uint16, 32: np.float32}[bits]
    is_float = bits == 32
    coding = codec.Coding(1 if is_float else 2**bits - 1, signed=is_float, is_float=is_float)
    back = codec.apply_signs(codec.decode_map(pixels[..., :3], coding), codec.signs_of(green=green))
    assert np.abs(back - normals).max() <= (0 if is_float else coding.step / 2 + 1e-7)
    assert np.array_equal(normals, hemisphere())


def test_signs_never_make_a_negative_zero():
    flat = np.array([[0.0, -0.0, 1.0]], np.float32)
    turned = codec.apply_signs(flat, (1, -1, -1))
    assert turned.tolist() == [[0, 0, -1]]
    assert not np.signbit(turned[0, :2]).any()
    assert np.signbit(flat[0, 1])  # the argument is unchanged
    assert codec.apply_signs(flat, (-1, 1, 1), out=flat) is flat
    assert not np.signbit(flat).any()


def test_one_colour_decodes_like_an_image_of_it():
    for coding, color in (
        (codec.Coding(255, "128"), (3, 200, 255)),
        (codec.Coding(65535, "127"), (3, 20000, 65000)),
        (codec.Coding(1, signed=True, is_float=True), (-0.25, 0.5, 1.0)),
        (codec.Coding(1, is_float=True), (0.25, 0.5, 1.0)),
    ):
        kind = np.float32 if coding.is_float else (np.uint8 if coding.max_code == 255 else np.uint16)
        picture = codec.decode_map(np.array(color, kind).reshape(1, 1, 3), coding)
        assert np.abs(picture[0, 0] - codec.decode_color(color, coding)).max() < 2e-7
