"""Maps from other programs: widened codes, codes as floats, companion maps with little information."""

import numpy as np
import pytest

import nmaptool as nm


@pytest.mark.parametrize("factor", [257, 256])
def test_8_bit_data_in_16_bits_is_decoded_as_8_bits(tmp_path, dome, codes, png, factor):
    d = dome(128, 128)
    vectors = np.where(d.inside[..., None], d.normals, (0, 0, 1))
    narrow = codes(vectors)
    small = nm.read_normal_map(png(tmp_path / "8.png", narrow))
    wide = nm.read_normal_map(png(tmp_path / "16.png", narrow.astype(np.uint16) * factor))
    assert np.array_equal(small.normals, wide.normals)
    assert (small.decoding.zero_code, small.decoding.background) == ("128", "flat")
    assert wide.decoding == small.decoding
    assert nm.inspect_map(nm.read_raster(tmp_path / "16.png")).eight_bit_data


def test_floats_that_were_8_bit_codes_are_decoded_as_codes(tmp_path, dome, codes, png, picture):
    d = dome(128, 128)
    narrow = codes(np.where(d.inside[..., None], d.normals, (0, 0, 1)))
    small = nm.read_normal_map(png(tmp_path / "8.png", narrow))
    floats = nm.read_normal_map(picture(tmp_path / "f.exr", (narrow / 255).astype(np.float32), ("R", "G", "B")))
    assert np.array_equal(small.normals, floats.normals)


def test_a_companion_map_is_read_like_its_original(tmp_path, dome, codes, png):
    d = dome(128, 128)
    down = nm.read_normal_map(png(tmp_path / "down.png", codes(d.normals * (1, -1, 1))))
    assert (down.decoding.green, down.decoding.green_from) == ("down", "found")
    ramp = np.dstack([np.full((128, 128), 0.3), np.full((128, 128), 0.2), np.full((128, 128), np.sqrt(0.87))])
    smooth = png(tmp_path / "smooth.png", codes(ramp))  # without curl, green cannot be detected
    assert nm.read_normal_map(smooth).normals[0, 0, 1] > 0
    assert nm.read_normal_map(smooth, like=down).normals[0, 0, 1] < 0
    assert nm.read_normal_map(smooth, nm.ReadOptions(green="up"), like=down).normals[0, 0, 1] > 0
    nm.write_normal_map(nm.read_normal_map(smooth), tmp_path / "own.png")  # its metadata state that green is up
    assert nm.read_normal_map(tmp_path / "own.png", like=down).normals[0, 0, 1] > 0
