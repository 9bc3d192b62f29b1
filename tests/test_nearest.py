"""The nearest pixel of a mask: the same as by a distance transform, also where several are equally near."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from nmaptool.core.nearest import nearest_places


def by_distance_transform(sought, at):
    rows, cols = ndimage.distance_transform_edt(~sought, return_distances=False, return_indices=True)
    return rows[at], cols[at]


@pytest.mark.parametrize("share", [0.5, 0.1, 0.01, 0.001])
def test_the_same_pixels_as_by_a_distance_transform(share):
    random = np.random.default_rng(5)
    for _ in range(20):
        rows, cols = random.integers(1, 90, 2)
        sought = random.random((rows, cols)) < share
        sought[random.integers(rows), random.integers(cols)] = True
        at = random.random((rows, cols)) < 0.5
        assert np.array_equal(nearest_places(sought, at), by_distance_transform(sought, at))


def test_equally_near_pixels_on_a_circle():
    y, x = np.mgrid[-9:10, -9:10]
    sought = (x * x + y * y) == 25
    at = (x == 0) & (y == 0)
    assert np.array_equal(nearest_places(sought, at), by_distance_transform(sought, at))
    assert np.ravel(nearest_places(sought, at)).tolist() == [9, 4]


def test_pixels_farther_than_its_reach():
    sought = np.zeros((3, 200), bool)
    sought[1, 7] = True
    rows, cols = nearest_places(sought, ~sought)
    assert set(rows) == {1} and set(cols) == {7}
