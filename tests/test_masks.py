"""The mask families used to benchmark solvers have their stated properties."""

import numpy as np
import pytest
from scipy import ndimage

from bench import masks
from bench.maps import scene

EIGHT = np.ones((3, 3), bool)


def islands_of(mask):
    return ndimage.label(mask, EIGHT)[1]


@pytest.mark.parametrize("name", masks.FAMILIES)
@pytest.mark.parametrize("side", [1, 17, 200])
def test_families_are_repeatable_masks_of_the_given_size(name, side):
    mask = masks.FAMILIES[name](side)
    assert mask.shape == (side, side)
    assert mask.dtype == np.float32
    assert set(np.unique(mask)) <= {0.0, 1.0}
    np.testing.assert_array_equal(mask, masks.FAMILIES[name](side))
    assert side < 200 or mask.any()


@pytest.mark.parametrize("name", ["tree", "lines 5%", "lines 20%", "spiral", "maze", "checkerboard"])
def test_thin_families_stay_thin(name):
    # no part of them covers a square of 8 px, except where lines cross
    mask = masks.FAMILIES[name](900)
    assert ndimage.binary_opening(mask, np.ones((8, 8))).sum() < 0.06 * mask.sum()


def test_families_have_the_documented_number_of_islands():
    for one in ("full", "comb", "bridge", "spiral", "maze", "checkerboard"):
        assert islands_of(masks.FAMILIES[one](240)) == 1, one
    assert islands_of(masks.gaps(240)) == 144
    assert islands_of(masks.islands(240)) == 400
    assert islands_of(masks.hair(240)) <= islands_of(masks.statue(240, 240)) + 3
    assert 0.55 < masks.noise(240).mean() < 0.65
    assert 0.15 < masks.lines(240).mean() < 0.25


def test_corridors_are_connected_and_have_no_loops():
    for width in (1, 2, 3):
        for mask in (masks.spiral(241, width), masks.maze(241, width)):
            inner = ndimage.label(mask)[0]
            assert inner.max() == 1
            # without loops, the walls are connected to the area around the image
            assert islands_of(np.pad(mask == 0, 1, constant_values=True)) == 1


def test_the_statue_mask_is_the_motif_of_the_scene():
    # except at the outline, where a rasterised circle is up to one pixel wider
    assert (masks.statue(450, 500).astype(bool) != scene(450, 500).motif).mean() < 0.008


@pytest.mark.parametrize(
    ("name", "span"), [("one", 1), ("span 1e4", 1e4), ("span 1e4, 16 px", 1e4), ("span 1e12", 1e12)]
)
def test_weights_have_their_stated_span(name, span):
    weights = masks.WEIGHTS[name]((200, 170))
    assert weights.shape == (200, 170)
    assert weights.max() == pytest.approx(1, rel=1e-5 if span == 1 else 0.7)
    assert weights.max() / weights.min() == pytest.approx(span, rel=0.7)


def test_a_noisy_mu_map_stays_near_its_mean():
    weights = masks.mu_map((50, 60))
    assert weights.max() <= 1
    assert weights.min() > 0.7
