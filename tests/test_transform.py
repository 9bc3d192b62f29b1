"""Maps transformed with their normals: exact where pixels map to pixels, elsewhere close to the true normals."""

import numpy as np
import pytest
from compose_cases import angles_deg, as_map, bump_map, flat_map, random_normals

import nmaptool as nm


def moved(normal_map, **how):
    return nm.transform(normal_map, nm.TransformOptions(**how)).normal_map


def same(first, second):
    return (
        np.array_equal(first.normals, second.normals)
        and np.array_equal(first.coverage, second.coverage)
        and np.array_equal(first.foreground, second.foreground)
        and first.frame == second.frame
    )


@pytest.fixture
def noise():
    coverage = np.random.default_rng(7).choice([0, 0.25, 0.5, 1], size=(31, 44))
    return as_map(random_normals(31, 44, seed=8), coverage, pitch_mm=0.2)


@pytest.mark.parametrize("degrees", [90, 180, 270, -90, 360, 450])
def test_quarter_turns_and_back_are_exact(noise, degrees):
    assert same(moved(moved(noise, rotate=degrees), rotate=-degrees), noise)


@pytest.mark.parametrize("how", [{"flip_h": True}, {"flip_v": True}])
def test_mirroring_twice_restores_the_map(noise, how):
    assert same(moved(moved(noise, **how), **how), noise)
    assert not same(moved(noise, **how), noise)


def test_two_mirrorings_equal_a_half_turn(noise):
    assert same(moved(noise, flip_h=True, flip_v=True), moved(noise, rotate=180))


def test_a_quarter_turn_moves_pixels_and_normals(noise):
    turned = moved(noise, rotate=90)
    expected = np.rot90(noise.normals)
    assert np.array_equal(turned.normals[..., 0], -expected[..., 1])
    assert np.array_equal(turned.normals[..., 1], expected[..., 0])
    assert np.array_equal(turned.coverage, np.rot90(noise.coverage))


@pytest.mark.parametrize("degrees", [30, -45, 7, 90, 213])
def test_rotating_a_map_equals_rotating_the_surface(degrees):
    turned = moved(bump_map(), rotate=degrees, keep_size=True)
    error = angles_deg(turned.normals, bump_map(turned_deg=degrees).normals)[turned.coverage == 1]
    assert error.size > 10_000
    assert error.mean() < 0.1
    assert error.max() < 0.7


def test_mirroring_a_map_equals_mirroring_the_surface():
    for how, stretch in (({"flip_h": True}, (-1, 1)), ({"flip_v": True}, (1, -1))):
        assert angles_deg(moved(bump_map(), **how).normals, bump_map(stretch=stretch).normals).max() < 1e-4


def test_uneven_resizing_keeps_heights_so_slopes_follow():
    wide = moved(bump_map(), resize="480x200")
    error = angles_deg(wide.normals, bump_map(200, 480, stretch=(2, 1)).normals)
    assert error.mean() < 0.05 and error.max() < 0.6
    narrow = moved(bump_map(), resize="240x120")
    error = angles_deg(narrow.normals, bump_map(120, 240, stretch=(1, 0.6)).normals)
    assert error.mean() < 0.1 and error.max() < 0.7


@pytest.mark.parametrize("how", [{"resize": "480x400"}, {"scale": 2}, {"scale": "480px"}])
def test_even_scaling_keeps_slopes(how):
    error = angles_deg(moved(bump_map(), **how).normals, bump_map(400, 480, stretch=(2, 2), height=2).normals)
    assert error.mean() < 0.05 and error.max() < 0.6


def test_a_height_factor_replaces_the_default():
    kept = moved(bump_map(), resize="480x400", height_factor=1.0)
    error = angles_deg(kept.normals, bump_map(400, 480, stretch=(2, 2)).normals)
    assert error.mean() < 0.05
    twice = moved(bump_map(), height_factor=2.0)
    assert angles_deg(twice.normals, bump_map(height=2).normals).max() < 1e-4
    assert angles_deg(moved(bump_map(), height_factor=-1.0).normals, bump_map(height=-1).normals).max() < 1e-4


def test_a_shear_maps_gradients_by_the_inverse_transpose():
    # h(x, y) = p x + q y under x' = x + y/2 (y down) becomes p x' + (q + p/2) y', y up
    p, q = 0.4, -0.3
    normals = np.float32([-p, -q, 1]) / np.sqrt(1 + p * p + q * q)
    plane = as_map(np.broadcast_to(normals.astype(np.float32), (40, 60, 3)).copy())
    sheared = moved(plane, affine="1,0.5,0,1")
    inside = sheared.coverage == 1
    assert inside.sum() > 1000
    x, y, z = sheared.normals[inside].T
    assert np.allclose(-x / z, p, atol=1e-5)
    assert np.allclose(-y / z, q + p / 2, atol=1e-5)


def test_mirroring_only_the_normals_repairs_a_map_mirrored_without_them(noise):
    wrong = as_map(noise.normals[:, ::-1], noise.coverage[:, ::-1], noise.frame.pitch_mm)
    assert same(moved(wrong, flip_h=True, vectors_only=True), moved(noise, flip_h=True))
    turned = as_map(np.rot90(noise.normals), np.rot90(noise.coverage), noise.frame.pitch_mm)
    assert same(moved(turned, rotate=90, vectors_only=True), moved(noise, rotate=90))


def test_crop_and_pad_are_exact_and_undo_each_other(noise):
    part = moved(noise, crop="4px,5px,20px,10px")
    assert np.array_equal(part.normals, noise.normals[5:15, 4:24])
    assert np.array_equal(moved(part, pad="4px,5px,20px,16px").coverage[5:15, 4:24], part.coverage)
    assert same(moved(moved(noise, pad="3px"), crop="3px,3px,44px,31px"), noise)
    in_mm = moved(noise, crop="0.8mm,1mm,4mm,2mm")  # 0.2 mm per pixel
    assert same(in_mm, part)


def test_new_ground_is_clear_or_flat_as_the_map_is():
    assert (moved(bump_map(), pad="5px").coverage[0] == 0).all()
    plate = flat_map(20, 30)
    assert (moved(plate, pad="5px").coverage == 1).all()
    assert (moved(plate, rotate=30).coverage == 1).all()
    assert not moved(plate, rotate=30).foreground.any()
    assert (moved(bump_map(), rotate=30, ground="flat").coverage == 1).all()


def test_pitch_follows_a_resize_and_stays_for_a_scale(noise):
    assert moved(noise, resize="88x62").frame.pitch_mm == pytest.approx(0.1)
    assert moved(noise, scale=2).frame.pitch_mm == 0.2
    assert moved(noise, resize="88x31").frame.pitch_mm == 0.2
    assert moved(noise, rotate=30).frame.pitch_mm == 0.2
    assert moved(noise, width="88mm", scale="44mm").frame == nm.Frame(16, 22, 2.0)


def test_a_soft_edge_stays_within_its_coverage():
    disc = np.hypot(*(np.mgrid[0:80, 0:80] - 39.5)) < 30
    turned = moved(as_map(bump_map(80, 80).normals, disc), rotate=33)
    assert ((turned.coverage >= 0) & (turned.coverage <= 1)).all()
    assert turned.coverage.sum() == pytest.approx(disc.sum(), rel=2e-3)
    assert (turned.normals[turned.coverage == 0] == (0, 0, 1)).all()


def test_a_jump_in_a_map_does_not_cause_ringing():
    step = np.where((np.arange(80) < 40)[None, :, None], [0.6, 0, 0.8], [-0.6, 0, 0.8])
    turned = moved(as_map(np.broadcast_to(step, (80, 80, 3)).astype(np.float32)), rotate=20, keep_size=True)
    steepest = np.degrees(np.arccos(turned.normals[turned.coverage == 1][:, 2].min()))
    assert steepest < np.degrees(np.arccos(0.8)) + 3


def test_a_reduced_map_is_averaged_not_sampled():
    checker = np.where((np.indices((64, 64)).sum(axis=0) % 2 == 0)[..., None], [0.6, 0, 0.8], [-0.6, 0, 0.8])
    small = moved(as_map(checker.astype(np.float32)), scale=0.25)
    assert angles_deg(small.normals, np.array([0, 0, 1])).max() < 1e-3


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"crop": "0,0,60px,10px"}, r"`crop='0,0,60px,10px'` is 60 x 10 px at 0,0, .* picture of 44 x 31 px; .*`pad`"),
        ({"crop": "0,0,1%,1%"}, r"is 0 x 0 px"),
        ({"scale": "0.001"}, None),
    ],
)
def test_transforms_that_do_not_fit_are_refused(noise, how, message):
    if message is None:
        assert moved(noise, **how).frame.shape == (1, 1)  # at least one pixel
        return
    with pytest.raises(nm.InputError, match=message):
        moved(noise, **how)


def test_millimetres_need_a_pitch_and_results_are_limited():
    with pytest.raises(nm.UsageError, match="3mm: the size of a pixel is not known; give `width='100mm'`"):
        moved(bump_map(), crop="3mm,0,3mm,3mm")
    with pytest.raises(nm.UsageError, match="`scale='3mm'`: the size of a pixel is not known"):
        moved(bump_map(), scale="3mm")
    with pytest.raises(nm.LimitError, match="the result of 24000 x 20000 px exceeds the limit of 270 megapixels"):
        moved(bump_map(), scale=100)


def test_stretching_a_map_gives_a_warning_about_its_slopes():
    stretched = nm.transform(bump_map(), nm.TransformOptions(resize="480x200")).report.warnings
    assert len(stretched) == 1
    assert "slopes are multiplied by 0.5 across and 1 down; `height_factor=1.41` keeps" in stretched[0]
    for how in ({"resize": "480x400"}, {"scale": "2,1", "height_factor": 1.0}, {"rotate": 20, "flip_h": True}):
        assert nm.transform(bump_map(), nm.TransformOptions(**how)).report.warnings == ()
