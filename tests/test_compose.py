"""Layers on a canvas: order, coverage, modes, groups, positions, soft edges."""

import numpy as np
import pytest
from compose_cases import FLAT, angles_deg, as_map, bump_map, flat_map, random_normals

import nmaptool as nm
from nmaptool.composition.blend_vectors import blend_normals as blend


@pytest.fixture
def ground():
    return as_map(random_normals(60, 80, seed=1), pitch_mm=0.5, name="ground")


@pytest.fixture
def sticker():
    """A disc of random normals, transparent outside."""
    disc = np.hypot(*(np.mgrid[0:20, 0:30] - np.array([9.5, 14.5])[:, None, None])) < 9
    return as_map(random_normals(20, 30, seed=2), disc, pitch_mm=0.5, name="sticker")


def laid(normal_map, mask=None, **how):
    return nm.Layer(normal_map, nm.LayerOptions(**how), mask)


def paste(background, *layers, **how):
    return nm.paste(background, layers, **how)


def test_a_layer_changes_only_what_it_covers(ground, sticker):
    out = paste(ground, laid(sticker, at="10px,5px", anchor="top-left"))
    window = np.s_[5:25, 10:40]
    on = sticker.coverage == 1
    expected = ground.normals.copy()
    expected[window][on] = sticker.normals[on]
    assert np.array_equal(out.normal_map.normals, expected)
    assert np.array_equal(out.placed[window], sticker.coverage)
    assert out.placed.sum() == on.sum()
    assert (out.normal_map.coverage == 1).all()
    assert out.report.layers[0]["share"] == pytest.approx(on.sum() / ground.coverage.size)


@pytest.mark.parametrize("mode", ["over", "rnm", "pd", "whiteout", "udn", "linear", "overlay"])
def test_strength_zero_and_an_uncovered_layer_change_nothing(ground, sticker, mode):
    assert np.array_equal(paste(ground, laid(sticker, mode=mode, strength=0)).normal_map.normals, ground.normals)


@pytest.mark.parametrize("mode", ["rnm", "pd", "whiteout", "udn"])
def test_pasting_a_detail_equals_blending_it(ground, mode):
    detail = as_map(random_normals(60, 80, seed=3), np.random.default_rng(4).random((60, 80)), name="detail")
    out = paste(ground, laid(detail, mode=mode, strength=0.7))
    expected = blend(ground.normals, detail.normals, mode, detail.coverage * np.float32(0.7))
    assert np.array_equal(out.normal_map.normals, expected)
    blended = nm.blend(ground, detail, nm.BlendOptions(mode, 0.7))
    assert np.array_equal(blended.normal_map.normals, expected)
    assert np.array_equal(blended.normal_map.coverage, ground.coverage)


def test_with_mode_over_the_topmost_layer_wins(ground, sticker):
    other = as_map(random_normals(20, 30, seed=5), name="other")
    out = paste(ground, laid(sticker), laid(other)).normal_map.normals
    assert np.array_equal(out, paste(ground, laid(other)).normal_map.normals)
    assert not np.array_equal(out, paste(ground, laid(other), laid(sticker)).normal_map.normals)


def test_coverage_accumulates_as_with_translucent_sheets():
    below, above = (as_map(random_normals(8, 9, seed=s), np.full((8, 9), c)) for s, c in ((6, 0.5), (7, 0.25)))
    out = nm.compose([nm.Layer(below), nm.Layer(above)]).normal_map
    assert np.allclose(out.coverage, 1 - 0.5 * 0.75)
    share = 0.25 / out.coverage[..., None]
    mixed = below.normals + share * (above.normals - below.normals)
    assert angles_deg(out.normals, mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)).max() < 1e-3


def test_every_pixel_stays_a_unit_normal_under_soft_edges(ground, sticker):
    out = paste(ground, laid(sticker, rotate=33, scale=1.7, feather="5px")).normal_map
    assert np.abs(np.linalg.norm(out.normals, axis=-1) - 1).max() < 1e-5
    assert out.coverage.min() == 1


def test_a_feather_fades_in_from_the_outline_inwards():
    plate, square = flat_map(60, 60), as_map(random_normals(40, 40, seed=8))
    soft = paste(plate, laid(square, feather="8px")).placed
    assert (soft[:10] == 0).all()
    middle = soft[30, 10:20]
    assert (np.diff(middle[:8]) > 0).all()
    assert middle[0] < 0.03 and middle[8] == 1
    assert np.allclose(soft, soft[::-1], atol=1e-6) and np.allclose(soft, soft.T, atol=1e-6)
    # a layer cut off by the canvas has no edge there
    beyond = paste(plate, laid(square, feather="8px", at="0,30px")).placed
    assert beyond[30, 0] == 1
    assert np.array_equal(paste(plate, laid(square, feather="0")).placed, paste(plate, laid(square)).placed)


def test_a_layer_contributes_its_motif_not_its_flat_background(ground):
    inside = np.zeros((20, 20), bool)
    inside[5:15, 5:15] = True
    normals = np.where(inside[..., None], random_normals(20, 20, seed=9), FLAT)
    out = paste(ground, laid(as_map(normals, foreground=inside), at="0,0", anchor="top-left"))
    assert np.array_equal(out.placed[:20, :20] > 0, inside)
    assert np.array_equal(out.normal_map.normals[:5], ground.normals[:5])


def test_the_pasted_layer_is_the_motif_of_a_plate(sticker):
    out = paste(flat_map(60, 80), laid(sticker))
    assert np.array_equal(out.normal_map.foreground, out.placed >= 0.5)
    assert out.normal_map.foreground.sum() == (sticker.coverage == 1).sum()


@pytest.mark.parametrize(
    ("anchor", "at", "corner"),
    [
        ("top-left", "0,0", (0, 0)),
        ("center", None, (25, 20)),
        ("bottom-right", None, (50, 40)),
        ("top", "50%,10px", (25, 10)),
        ("left", "5mm,50%", (10, 20)),  # 0.5 mm per pixel
        ("bottom", "40px,-10%", (25, -26)),
    ],
)
def test_layers_are_placed_by_anchors_and_units(ground, anchor, at, corner):
    square = as_map(random_normals(20, 30, seed=10))
    if corner[1] < 0:
        with pytest.raises(
            nm.InputError, match="map: its area from 25,-26 to 55,-6 px is outside the canvas of 80 x 60 px; move"
        ):
            paste(ground, laid(square, anchor=anchor, at=at))
        return
    out = paste(ground, laid(square, anchor=anchor, at=at))
    assert out.report.layers[0]["box_px"][:2] == list(corner)
    left, top = corner
    assert np.array_equal(out.normal_map.normals[top : top + 20, left : left + 30], square.normals)


def test_placing_rotates_normals_as_transforming_does(ground):
    bump = bump_map(40, 40)
    how = {"rotate": 25.0, "flip_h": True}
    turned = nm.transform(bump, nm.TransformOptions(**how)).normal_map
    pasted = paste(flat_map(80, 80), laid(bump, **how))
    first = nm.compose([nm.Layer(turned)], nm.CanvasOptions(size="80x80")).normal_map
    full = (pasted.placed == 1) & (first.coverage == 1)
    assert full.sum() > 1000
    assert angles_deg(pasted.normal_map.normals, first.normals)[full].max() < 1.0


def test_a_width_in_mm_sets_the_scale(ground, sticker):
    assert paste(ground, laid(sticker, scale="30mm")).report.layers[0]["box_px"][2] in (60, 61, 62)
    bare = as_map(ground.normals)
    with pytest.raises(nm.UsageError, match="`scale='30mm'`: the size of a pixel is not known"):
        paste(bare, laid(sticker, scale="30mm"))
    with pytest.raises(nm.UsageError, match="sticker: 5mm: the size of a pixel is not known; give `width='100mm'`"):
        paste(bare, laid(sticker, at="5mm,0"))
    assert paste(bare, laid(sticker, at="5mm,5mm"), width=nm.length("40mm")).normal_map.frame.pitch_mm == 0.5


def test_pixels_of_another_size_are_reported(ground, sticker):
    coarse = as_map(sticker.normals, sticker.coverage, pitch_mm=1.0, name="coarse")
    (warning,) = paste(ground, laid(coarse)).report.warnings
    assert warning == (
        "coarse: its pixels are 1 mm, those of the canvas 0.5 mm; to keep its size in mm, set its scale to 2"
    )
    assert not paste(ground, laid(coarse, scale=2)).report.warnings


def test_a_stretched_layer_gives_a_warning(ground, sticker):
    (warning,) = paste(ground, laid(sticker, scale="0.4,0.5")).report.warnings
    assert warning == (
        "sticker: is stretched unevenly and keeps its heights, so its slopes are multiplied by 2.5 across and 2 down; "
        "a height factor of 0.447 keeps them on average"
    )
    assert not paste(ground, laid(sticker, scale="0.4,0.5", height_factor=0.447)).report.warnings


def test_masks_hide_and_must_have_the_right_size(ground, sticker):
    mask = np.zeros((20, 30), np.float32)
    mask[:, :15] = 1
    shown = paste(ground, laid(sticker, mask, at="0,0", anchor="top-left")).placed[:20, :30]
    assert np.array_equal(shown, sticker.coverage * mask)
    for bad, message in (
        (np.zeros((20, 30), np.float32), "the mask of sticker is entirely black"),
        (np.ones((5, 6), np.float32), "the mask of sticker is 6 x 5, expected 30 x 20"),
        (np.full((20, 30), np.nan, np.float32), "the mask of sticker must lie between 0 and 1"),
    ):
        with pytest.raises(nm.InputError, match=message):
            laid(sticker, bad)


def test_details_are_clipped_to_the_layers_below(sticker):
    half = as_map(random_normals(20, 30, seed=11), np.arange(30)[None, :].repeat(20, 0) < 15, name="half")
    clipped = nm.compose([nm.Layer(half), laid(sticker, mode="rnm")]).normal_map
    assert np.array_equal(clipped.coverage, half.coverage)
    free = nm.compose([nm.Layer(half), laid(sticker, mode="rnm", clip="no")]).normal_map
    alone = (half.coverage == 0) & (sticker.coverage == 1)
    assert np.array_equal(free.normals[alone], sticker.normals[alone])
    assert np.array_equal(free.coverage, np.maximum(half.coverage, sticker.coverage))
    over = nm.compose([nm.Layer(half), laid(sticker, clip="yes")]).normal_map
    assert np.array_equal(over.coverage, half.coverage)
    with pytest.raises(nm.InputError, match='sticker: mode "rnm" needs a surface below it, found none'):
        nm.compose([laid(sticker, mode="rnm")])


def test_a_group_of_one_equals_its_layer_and_a_group_fades_as_one(ground, sticker):
    alone = paste(ground, laid(sticker))
    grouped = paste(ground, nm.LayerGroup((laid(sticker),)))
    assert np.array_equal(alone.normal_map.normals, grouped.normal_map.normals)
    assert np.array_equal(alone.placed, grouped.placed)
    details = nm.LayerGroup((laid(sticker, mode="rnm"),), nm.GroupOptions(mode="rnm", strength=0.5))
    expected = paste(ground, laid(sticker, mode="rnm", strength=0.5)).normal_map.normals
    assert np.array_equal(paste(ground, details).normal_map.normals, expected)


def test_details_in_a_group_change_only_its_own_layers(ground, sticker):
    base = as_map(random_normals(20, 30, seed=12), name="base")
    group = nm.LayerGroup((laid(base), laid(sticker, mode="rnm")), nm.GroupOptions(name="pair"))
    out = paste(ground, group)
    both = nm.blend(base, sticker).normal_map.normals
    assert np.array_equal(out.normal_map.normals[20:40, 25:55], both)
    assert [layer["name"] for layer in out.report.layers[0]["layers"]] == ["base", "sticker"]
    mask = np.zeros((60, 80), np.float32)
    mask[:30] = 1
    masked = paste(ground, nm.LayerGroup(group.layers, group.options, mask))
    assert np.array_equal(masked.normal_map.normals[30:], ground.normals[30:])
    with pytest.raises(nm.InputError, match="the mask of pair is 4 x 3, expected 80 x 60"):
        paste(ground, nm.LayerGroup(group.layers, group.options, np.ones((3, 4), np.float32)))
    with pytest.raises(nm.InputError, match="a group needs at least one layer"):
        nm.LayerGroup(())


def test_a_canvas_can_be_given_by_size(sticker):
    flat = nm.compose([laid(sticker)], nm.CanvasOptions(size="50x40", ground="flat", width="100mm"))
    assert flat.normal_map.frame == nm.Frame(40, 50, 2.0)
    assert (flat.normal_map.coverage == 1).all()
    clear = nm.compose([laid(sticker)], nm.CanvasOptions(size="50x40"))
    assert clear.normal_map.coverage.sum() == sticker.coverage.sum()
    assert not clear.placed.any()  # the lowest layer is the ground of the others
    with pytest.raises(nm.InputError, match="nothing to compose: give at least one layer"):
        nm.compose([])
    with pytest.raises(nm.LimitError, match="the canvas of 90000 x 90000 has 8100 megapixels"):
        nm.compose([laid(sticker)], nm.CanvasOptions(size="90000x90000"))


def test_blend_needs_equal_sizes_or_fit(ground, sticker):
    with pytest.raises(nm.InputError, match="sticker is 30 x 20, but ground is 80 x 60; stretch it with `fit`"):
        nm.blend(ground, sticker)
    fitted = nm.blend(bump_map(60, 80), bump_map(30, 40), nm.BlendOptions(fit=True)).normal_map
    assert fitted.frame.shape == (60, 80)
    mask = np.zeros((60, 80), np.float32)
    mask[:30] = 1
    masked = nm.blend(ground, ground, mask=mask).normal_map
    assert np.array_equal(masked.normals[30:], ground.normals[30:])
    with pytest.raises(nm.InputError, match="the mask of ground is 80 x 59, expected 80 x 60"):
        nm.blend(ground, ground, mask=mask[1:])
