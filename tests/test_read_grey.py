"""Masks and weight maps from every kind of number; heights of a curved background that are none."""

import numpy as np
import pytest
import tifffile
from PIL import Image

import nmaptool as nm

RNG = np.random.default_rng(12)
MASK = RNG.random((12, 16)) > 0.4


@pytest.mark.parametrize("kind", ["?", "u1", "u2", "i4", "i8", "f4", "f8"])
def test_an_array_of_0_and_1_is_a_mask_in_every_type(tmp_path, kind):
    np.save(tmp_path / "mask.npy", MASK.astype(kind))
    assert np.array_equal(nm.read_grey(tmp_path / "mask.npy"), MASK)


@pytest.mark.parametrize("kind", ["u1", "i4", "i8", "f4", "f8"])
def test_an_array_of_0_to_255_is_a_mask_in_every_type(tmp_path, kind):
    codes = (MASK * 255).astype(kind)
    codes[0, 0] = 51
    np.save(tmp_path / "mask.npy", codes)
    assert np.array_equal(nm.read_grey(tmp_path / "mask.npy"), (codes / 255).astype(np.float32))


def test_weights_in_floats_keep_their_values(tmp_path):
    weights = RNG.uniform(0, 40, (12, 16)).astype(np.float32)
    np.save(tmp_path / "weights.npy", weights)
    assert np.array_equal(nm.read_grey(tmp_path / "weights.npy"), weights)
    np.save(tmp_path / "weights.npy", weights.round())
    assert np.array_equal(nm.read_grey(tmp_path / "weights.npy"), weights.round())


@pytest.mark.parametrize(("kind", "white"), [(np.uint8, 255), (np.uint16, 65535)])
def test_a_picture_of_the_codes_0_and_1_is_refused(tmp_path, kind, white):
    Image.fromarray(MASK.astype(kind)).save(tmp_path / "mask.png")
    with pytest.raises(nm.InputError, match=rf"holds only the codes 0 and 1 of {white}; save white as {white}$"):
        nm.read_grey(tmp_path / "mask.png")
    Image.fromarray(np.zeros((4, 5), kind)).save(tmp_path / "black.png")
    assert not nm.read_grey(tmp_path / "black.png").any()


def test_heights_of_a_surface_must_be_defined(tmp_path):
    heights = RNG.uniform(0, 5, (12, 16)).astype(np.float32)
    heights[3, 4] = -9999
    tifffile.imwrite(tmp_path / "dem.tif", heights, extratags=[(42113, "s", 0, "-9999", True)])
    with pytest.raises(nm.InputError, match=r"holds the value -9999 for no data; fill these pixels, since heights"):
        nm.read_height(tmp_path / "dem.tif", pitch_mm=1)
    heights[3, 4] = 2
    tifffile.imwrite(tmp_path / "dem.tif", heights, extratags=[(42113, "s", 0, "-9999", True)])
    assert nm.read_height(tmp_path / "dem.tif", pitch_mm=1).frame.shape == (12, 16)


def test_distances_are_no_heights(tmp_path, picture):
    values = RNG.uniform(3, 5, (12, 16, 4)).astype(np.float32)
    picture(tmp_path / "r.exr", values, ["R", "G", "B", "Z"])
    with pytest.raises(nm.InputError, match=r"r\.exr:Z: the name of its layer says that it holds distances from the"):
        nm.read_height(f"{tmp_path}/r.exr:Z", pitch_mm=1)
    np.savez(tmp_path / "a.npz", z=values[..., 0])
    assert nm.read_height(tmp_path / "a.npz", pitch_mm=1).frame.shape == (12, 16)
