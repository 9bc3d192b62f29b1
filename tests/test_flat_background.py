"""A flat background is an attribute of the map; how its file was read does not affect results."""

import dataclasses

import numpy as np
import pytest
from relief_cases import normal_map, solve

import nmaptool as nm
from nmaptool.core.grid import height_slopes

SIDE = 96


def letter():
    """The map of a ring on a plate, with the ring as motif."""
    row, col = np.mgrid[0 : SIDE + 1, 0 : SIDE + 1]
    r = np.hypot(row - SIDE / 2, col - SIDE / 2)
    ring = normal_map(*height_slopes(4 * np.clip(np.minimum(r - 14, 34 - r) / 4, 0, 1)))
    motif = np.hypot(*(np.mgrid[0:SIDE, 0:SIDE] + 0.5 - SIDE / 2)) < 35
    return dataclasses.replace(ring, foreground=motif)


def test_a_shallow_surface_that_rounding_makes_flat_in_places_has_no_background():
    y, x = np.mgrid[0:180, 0:240]
    codes = stored(8 * np.exp(-((x - 120) ** 2 + (y - 90) ** 2) / 3200) + 0.5 * np.sin(x / 40))
    flat = (codes == (128, 128, 255)).all(axis=2) | (codes == (127, 127, 255)).all(axis=2)
    assert flat.mean() > 0.04
    read = nm.decode_normal_map(codes)
    assert (read.decoding.background, read.coverage.min(), read.foreground.all()) == ("none", 1, True)


def stored(heights):
    """Codes of a surface: heights in px."""
    down, across = np.gradient(heights)
    normals = np.dstack([-across, down, np.ones_like(down)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return np.floor((normals + 1) / 2 * 255 + 0.5).astype(np.uint8)


def test_flat_areas_of_a_texture_are_no_missing_background():
    """Plateaus between stones fill a third of the edge, but none reaches three sides."""
    decoding = nm.decode_normal_map(stored(-np.minimum(distances(160), 14) * 0.6)).decoding
    assert (decoding.background, decoding.warnings) == ("none", ())


def distances(side):
    """(side, side): distance to the nearest of 40 points."""
    y, x = np.mgrid[0:side, 0:side].astype(float)
    points = np.random.default_rng(7).random((40, 2)) * side
    return np.min([np.hypot(x - a, y - b) for a, b in points], axis=0)


@pytest.mark.parametrize(
    "record",
    [
        nm.Decoding(background="flat"),
        nm.Decoding(green="down", swizzle="-g,r,b", zero_code="128", encoding="signed", components="xy"),
    ],
)
def test_reading_details_do_not_change_the_relief(record):
    plain = letter()
    read = dataclasses.replace(plain, decoding=record)
    assert np.array_equal(solve(read, delta=20.0).z_mm, solve(plain, delta=20.0).z_mm)
    assert np.array_equal(nm.split(read).base.normals, nm.split(plain).base.normals)
    turned = nm.TransformOptions(rotate=30.0)
    assert np.array_equal(nm.transform(read, turned).normal_map.normals, nm.transform(plain, turned).normal_map.normals)


def test_a_flat_background_changes_the_relief():
    plain = letter()
    assert not plain.flat_background
    on_plate = dataclasses.replace(plain, flat_background=True)
    difference = np.abs(solve(on_plate, delta=20.0).z_mm - solve(plain, delta=20.0).z_mm).max()
    assert difference > 0.05 * np.ptp(solve(plain, delta=20.0).z_mm)


def test_files_keep_whether_their_background_is_flat(tmp_path):
    plate, disc = letter(), letter()
    disc = dataclasses.replace(disc, coverage=disc.foreground.astype(np.float32))
    for source, expected in ((plate, True), (disc, False)):
        path = tmp_path / f"{expected}.png"
        nm.write_normal_map(source, path)
        back = nm.read_normal_map(path)
        assert back.flat_background is expected
        assert (back.decoding.background == "flat") is expected
        everything = nm.read_normal_map(path, nm.ReadOptions(background_color="none"))
        assert not everything.flat_background


def test_a_flat_background_is_kept_by_edits():
    on_plate = dataclasses.replace(letter(), flat_background=True)
    small = dataclasses.replace(letter(), coverage=letter().foreground.astype(np.float32))
    layer = nm.Layer(small, nm.LayerOptions(scale="0.3"))
    assert nm.transform(on_plate, nm.TransformOptions(rotate=90.0)).normal_map.flat_background
    assert nm.transform(small, nm.TransformOptions(ground="flat")).normal_map.flat_background
    assert not nm.transform(small, nm.TransformOptions(rotate=90.0)).normal_map.flat_background
    assert nm.blend(on_plate, small).normal_map.flat_background
    assert not nm.blend(small, on_plate).normal_map.flat_background
    assert nm.paste(on_plate, [layer]).normal_map.flat_background
    assert not nm.paste(letter(), [layer]).normal_map.flat_background
    assert nm.compose([nm.Layer(on_plate), layer]).normal_map.flat_background
    assert nm.compose([layer], nm.CanvasOptions(ground="flat")).normal_map.flat_background
    layers = nm.split(on_plate)
    assert layers.base.flat_background
    assert layers.detail.flat_background


def test_a_depth_image_on_a_plate_has_a_flat_background():
    row, col = np.mgrid[0:SIDE, 0:SIDE]
    r = np.hypot(row - SIDE / 2, col - SIDE / 2)
    image = nm.RasterImage(np.clip(40 - r, 0, 20).astype(np.float32)[..., None], ("Y",), bits=32)
    plate = nm.depth_to_normals(image, nm.DepthOptions(background="flat")).normal_map
    assert plate.flat_background
    assert not nm.depth_to_normals(image).normal_map.flat_background
