"""Layers with soft outlines: a detail along the outline that it shares with its base."""

import numpy as np
import pytest
from compose_cases import as_map, bump_map, flat_map, random_normals

import nmaptool as nm
from nmaptool.maps.detail import encode_detail

ROWS, COLS = 40, 50


@pytest.fixture
def soft():
    """Coverage of a disc with an anti-aliased outline."""
    y, x = np.mgrid[0:ROWS, 0:COLS] + 0.5
    return (15.5 - np.hypot(x - 25, y - 20)).clip(0, 1).astype(np.float32)


@pytest.fixture
def parts(soft):
    """Original, base and detail with the same outline, as bake writes them."""
    original, base = random_normals(ROWS, COLS, 1), random_normals(ROWS, COLS, 2)
    detail = encode_detail(original, base, "rotation")
    return tuple(as_map(normals, soft) for normals in (original, base, detail))


def laid(normal_map, mask=None, **how):
    return nm.Layer(normal_map, nm.LayerOptions(**how), mask)


def test_a_detail_restores_the_original_along_its_soft_outline(parts, soft):
    original, base, detail = parts
    assert ((soft > 0) & (soft < 1)).sum() > 50
    group = nm.LayerGroup((laid(base), laid(detail, mode="rnm")))
    for out in (
        nm.blend(base, detail),
        nm.paste(base, [laid(detail, mode="rnm")]),
        nm.compose([laid(base), laid(detail, mode="rnm", at="0px,0px", anchor="top-left")]),
        nm.compose([group]),
    ):
        assert np.abs(out.normal_map.normals - original.normals).max() < 1e-5
        assert np.array_equal(out.normal_map.coverage, soft)


def test_a_mask_acts_equally_inside_and_along_the_outline(parts, soft):
    _, base, detail = parts
    whole, mask = as_map(detail.normals), np.full(soft.shape, 0.5, np.float32)
    for one in (whole, detail):
        blended = nm.blend(base, one, mask=mask).normal_map
        expected = nm.blend(base, whole, nm.BlendOptions(strength=0.5)).normal_map.normals
        inside = soft > 0
        assert np.abs(blended.normals - expected)[inside].max() < 1e-6
        pasted = nm.paste(base, [laid(one, mask, mode="rnm")]).normal_map
        assert np.array_equal(pasted.normals[inside], blended.normals[inside])


def test_a_detail_that_ends_within_its_base_fades_as_it_ends(parts, soft):
    _, _, detail = parts
    base = bump_map(ROWS, COLS)
    out = nm.blend(base, detail, nm.BlendOptions("pd")).normal_map.normals
    p, q = (-out[..., axis] / out[..., 2] + base.normals[..., axis] / base.normals[..., 2] for axis in (0, 1))
    gentle = detail.normals[..., 2] > 0.3
    for slope, axis in ((p, 0), (q, 1)):
        expected = -soft * detail.normals[..., axis] / detail.normals[..., 2]
        assert np.abs(slope - expected)[gentle].max() < 1e-3


@pytest.mark.parametrize("mode", ["over", "rnm", "pd", "whiteout", "udn", "linear", "overlay"])
@pytest.mark.parametrize("clip", ["auto", "yes", "no"])
def test_strength_zero_does_not_change_a_half_covered_ground(parts, soft, mode, clip):
    ground = as_map(random_normals(ROWS, COLS, 3), 0.4 * np.ones_like(soft))
    out = nm.paste(ground, [laid(parts[2], mode=mode, strength=0, clip=clip)])
    for name in ("normals", "coverage", "foreground"):
        assert np.array_equal(getattr(out.normal_map, name), getattr(ground, name))
    assert not out.placed.any()


@pytest.mark.parametrize(
    "place",
    [{"at": "0px,0px", "anchor": "top-left"}, {"at": "50%,100%", "anchor": "bottom"}, {"scale": "1.0"}],
)
def test_a_plate_is_the_ground_however_its_position_is_written(place):
    plate = flat_map(ROWS, COLS)
    motif = laid(bump_map(10, 12), at="20px,20px")
    assert (nm.compose([laid(plate, **place), motif]).normal_map.coverage == 1).all()
    with pytest.raises(
        nm.InputError, match=r"plate: covers no pixel of the canvas; .* flat background is not part of a layer"
    ):
        nm.compose([laid(plate, at="30px,20px"), motif])


def test_a_plate_is_restored_from_a_workspace(tmp_path, run, refused):
    plate = flat_map(ROWS, COLS, 0.5).normals.copy()
    plate[5:30, 5:30] = bump_map(25, 25).normals
    nm.write_normal_map(as_map(plate, pitch_mm=0.5), tmp_path / "plate.exr")
    nm.write_normal_map(bump_map(10, 12), tmp_path / "motif.exr")
    (tmp_path / "scene.toml").write_text(
        '[[layer]]\nfile = "plate.exr"\n[[layer]]\nfile = "motif.exr"\nat = "10px,20px"\n'
    )
    stack = nm.read_stack(tmp_path / "scene.toml")
    assert not stack.maps[0].foreground.all()  # its ground is recognised as flat
    expected = nm.compose(stack.layers, stack.canvas).normal_map
    assert (expected.coverage == 1).all()
    assert run("compose", "pack", tmp_path / "scene.toml", "-o", tmp_path / "work.exr").code == 0
    assert run("compose", "unpack", tmp_path / "work.exr", "-o", tmp_path / "parts").code == 0
    assert run("compose", "stack", tmp_path / "parts" / "recipe.toml", "-o", tmp_path / "again.exr").code == 0
    again = nm.read_normal_map(tmp_path / "again.exr")
    assert (again.coverage == 1).all()
    assert np.abs(again.normals - expected.normals).max() < 1e-6
    words = ("compose", "pack", tmp_path / "plate.exr", "-o", tmp_path / "work.psd")
    refused(2, 'must lie between 0 and 1 for the mode "over"', *words, "--strength", "5")


@pytest.mark.parametrize("size", ["100x80", "137x110", "51x40", "30x24"])
def test_a_resized_map_is_covered_to_its_edges(size):
    out = nm.transform(bump_map(ROWS, COLS), nm.TransformOptions(resize=size)).normal_map
    assert (out.coverage == 1).all()


def test_edges_on_pixel_borders_are_hard_and_others_soft():
    clear = nm.CanvasOptions("200x160")
    hard = nm.compose([laid(bump_map(ROWS, COLS), at="30px,20px", anchor="top-left", scale="2")], clear)
    coverage = np.zeros((160, 200), np.float32)
    coverage[20:100, 30:130] = 1
    assert np.array_equal(hard.normal_map.coverage, coverage)
    assert np.array_equal(np.unique(hard.normal_map.normals[coverage == 0]), (0, 1))
    soft = nm.compose([laid(bump_map(ROWS, COLS), at="30.5px,20px", anchor="top-left", scale="2")], clear)
    assert soft.normal_map.coverage[60, 30] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("turn", [{"rotate": 90}, {"flip_h": True}, {"rotate": 180, "flip_v": True}])
def test_hard_edges_rotate_with_the_map(turn):
    out = nm.transform(bump_map(ROWS, COLS), nm.TransformOptions(scale="2", **turn)).normal_map
    assert (out.coverage == 1).all()
    assert sorted(out.frame.shape) == [2 * ROWS, 2 * COLS]


def test_a_stretched_detail_acts_up_to_the_edge_of_the_map():
    base, small = flat_map(2 * ROWS, 2 * COLS), as_map(np.full((ROWS, COLS, 3), (0.6, 0, 0.8), np.float32))
    out = nm.blend(base, small, nm.BlendOptions(fit=True)).normal_map
    assert np.abs(out.normals - (0.6, 0, 0.8)).max() < 1e-6


@pytest.mark.parametrize(("scale", "wide"), [("0.5", 4), ("1", 8), ("2", 16)])
def test_a_feather_in_percent_refers_to_the_placed_layer(scale, wide):
    ground, layer = flat_map(160, 200), as_map(random_normals(60, 80, 4))
    by_share = nm.paste(ground, [laid(layer, scale=scale, feather="10%")])
    in_px = nm.paste(ground, [laid(layer, scale=scale, feather=f"{wide}px")])
    assert np.array_equal(by_share.placed, in_px.placed)


def test_a_detail_fitted_unevenly_gives_a_warning_about_its_slopes():
    fit = nm.BlendOptions(fit=True)
    even = nm.blend(flat_map(80, 100), bump_map(ROWS, COLS), fit).report.warnings
    uneven = nm.blend(flat_map(80, 200), bump_map(ROWS, COLS), fit).report.warnings
    assert even == ()
    assert len(uneven) == 1
    assert "slopes are multiplied by 0.25 across and 0.5 down" in uneven[0]
