"""The base layer by rolling guidance in the image: exact sums, what is kept, removed and ignored."""

import threading

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core import parallel
from nmaptool.core.vectors import unit
from nmaptool.filters import image
from nmaptool.filters.image import rolling_guidance_image

FLAT = np.float32([0, 0, 1])


def exact(normals, coverage, sigma_s, sigma_r, iterations, reach=np.inf):
    """The filter over all pairs of pixels, in float64; later passes skip those farther than ``reach`` sigmas."""
    y, x = np.indices(coverage.shape).reshape(2, -1)
    apart2 = (y[:, None] - y) ** 2 + (x[:, None] - x) ** 2
    weight = np.exp(-apart2 / (2 * sigma_s**2)) * coverage.ravel()
    found = normals.reshape(-1, 3).astype(float)
    guide = np.zeros_like(found)
    for iteration in range(iterations):
        unlike2 = ((guide[:, None] - guide) ** 2).sum(axis=-1)
        counts = (apart2 <= (reach * sigma_s) ** 2) | (iteration == 0)
        guide = (weight * np.exp(-unlike2 / (2 * sigma_r**2)) * counts) @ found
        length = np.linalg.norm(guide, axis=-1, keepdims=True)
        guide /= np.where(length > 0, length, 1)
    return np.where(coverage[..., None] > 0, guide.reshape(normals.shape), FLAT)


def angle_deg(a, b):
    return 2 * np.degrees(np.arcsin(np.linalg.norm(a.astype(float) - b, axis=-1).clip(0, 2) / 2))


def from_slopes(p, q):
    return unit(np.dstack([-p, -q, np.ones_like(p)]))


def rough(rows=44, cols=37, seed=0):
    """A crease with waves and noise, covered in a disc with a soft edge."""
    y, x = np.indices((rows, cols)) / 10
    noise = np.random.default_rng(seed).normal(size=(2, rows, cols)) * 0.15
    normals = from_slopes(np.where(x > 1.7, 0.7, -0.5) + noise[0], 0.4 * np.sin(3 * y) + noise[1])
    cover = (min(rows, cols) * 0.46 - np.hypot(y * 10 - rows / 2, x * 10 - cols / 2)).clip(0, 3) / 3
    return normals, cover.astype(np.float32)


def rolling_guidance(normals, coverage, sigma_s=4.0, sigma_r=0.4, iterations=4):
    return rolling_guidance_image(normals, coverage, sigma_s_px=sigma_s, sigma_r=sigma_r, iterations=iterations)


@pytest.mark.parametrize("sigma_s", [0.7, 2.0, 3.5])
@pytest.mark.parametrize("sigma_r", [0.15, 0.5])
def test_narrow_filters_equal_the_definition_within_three_sigmas(sigma_s, sigma_r):
    normals, cover = rough()
    error = angle_deg(
        rolling_guidance(normals, cover, sigma_s, sigma_r), exact(normals, cover, sigma_s, sigma_r, 4, reach=3)
    )
    assert error.max() < 0.01


@pytest.mark.parametrize("sigma_s", [2.0, 5.0, 8.0, 15.0, 60.0])
@pytest.mark.parametrize("sigma_r", [0.25, 0.5])
def test_every_filter_is_close_to_the_definition(sigma_s, sigma_r):
    normals, cover = rough()
    expected = exact(normals, cover, sigma_s, sigma_r, 4)
    error = angle_deg(rolling_guidance(normals, cover, sigma_s, sigma_r), expected)[cover > 0]
    assert angle_deg(normals, expected)[cover > 0].mean() > 5
    assert error.mean() < 0.3
    assert np.percentile(error, 99) < 1.5


@pytest.mark.parametrize("sigma_s", [0.01, 1.0, 6.0, 100.0])
def test_one_pass_equals_a_gaussian(sigma_s):
    normals, cover = rough()
    assert (
        angle_deg(rolling_guidance(normals, cover, sigma_s, 0.3, 1), exact(normals, cover, sigma_s, 0.3, 1)).max()
        < 0.02
    )


@pytest.mark.parametrize("sigma_s", [3.0, 9.0, 40.0])
def test_a_constant_map_is_unchanged(sigma_s):
    normals = np.broadcast_to(np.float32([0.48, -0.6, 0.64]), (40, 50, 3)).copy()
    cover = rough(40, 50)[1]
    expected = np.where(cover[..., None] > 0, normals, FLAT)
    assert np.abs(rolling_guidance(normals, cover, sigma_s) - expected).max() < 1e-6


@pytest.mark.parametrize("sigma_s", [4.0, 8.0])
def test_bumps_are_removed_and_the_crease_stays_sharp(sigma_s):
    y, x = np.indices((96, 96))
    planes = from_slopes(np.where(x < 48, 0.7, -0.7), np.zeros((96, 96)))
    p = np.where(x < 48, 0.7, -0.7) + 0.25 * np.sin(x * 1.6) * np.cos(y * 1.3)
    bumpy = from_slopes(p, 0.25 * np.cos(x * 1.6) * np.sin(y * 1.3))
    cover = np.ones((96, 96), np.float32)
    base = rolling_guidance(bumpy, cover, sigma_s, 0.35, 5)
    assert angle_deg(bumpy, planes).mean() > 7
    assert angle_deg(base, planes).mean() < 0.4
    assert angle_deg(base, planes)[:, 44:52].mean() < 1.5
    # a Gaussian smears the crease over several pixels
    assert angle_deg(rolling_guidance(bumpy, cover, sigma_s, 0.35, 1), planes)[:, 44:52].mean() > 15


@pytest.mark.parametrize("sigma_s", [3.0, 7.0, 20.0])
def test_pixels_outside_the_coverage_are_ignored(sigma_s):
    normals, cover = rough(seed=1)
    outside = cover == 0
    expected = rolling_guidance(np.where(outside[..., None], FLAT, normals), cover, sigma_s)
    assert (expected[outside] == FLAT).all()
    for seed in range(3):
        other = unit(np.random.default_rng(seed).normal(size=normals.shape))
        changed = np.where(outside[..., None], other, normals)
        assert np.array_equal(rolling_guidance(changed, cover, sigma_s), expected)
    wider = np.pad(cover, ((9, 2), (0, 5)))
    framed = np.pad(normals, ((9, 2), (0, 5), (0, 0)), mode="edge")
    assert np.array_equal(rolling_guidance(framed, wider, sigma_s)[9:-2, :-5], expected)


def test_coverage_is_a_weight():
    rng = np.random.default_rng(3)
    normals = rough(30, 30)[0]
    cover = rng.uniform(0.05, 1, (30, 30)).astype(np.float32)
    assert angle_deg(rolling_guidance(normals, cover, 3.0), exact(normals, cover, 3.0, 0.4, 4, reach=3)).max() < 0.01
    # only its proportions matter
    assert np.abs(rolling_guidance(normals, cover, 7.0) - rolling_guidance(normals, cover / 256, 7.0)).max() < 1e-5


TURNS = {
    "quarter turn": (np.rot90, lambda n: np.stack([-n[..., 1], n[..., 0], n[..., 2]], axis=-1)),
    "left to right": (np.fliplr, lambda n: n * np.float32([-1, 1, 1])),
    "top to bottom": (np.flipud, lambda n: n * np.float32([1, -1, 1])),
}


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("sigma_s", [3.0, 7.0, 18.0])
def test_rotating_the_map_rotates_the_result(turn, sigma_s):
    move, turned = TURNS[turn]
    normals, cover = rough(61, 48)
    expected = turned(move(rolling_guidance(normals, cover, sigma_s)))
    found = rolling_guidance(np.ascontiguousarray(turned(move(normals))), np.ascontiguousarray(move(cover)), sigma_s)
    assert np.abs(found - expected).max() < 1e-5


@pytest.mark.parametrize("shape", [(1, 1), (1, 23), (31, 1), (2, 3), (5, 70)])
@pytest.mark.parametrize("sigma_s", [0.5, 6.0, 500.0, 1e300])
def test_images_of_any_size_are_filtered(shape, sigma_s):
    normals = rough(*shape)[0]
    cover = np.ones(shape, np.float32)
    error = angle_deg(rolling_guidance(normals, cover, sigma_s), exact(normals, cover, min(sigma_s, 1e6), 0.4, 4))
    assert error.mean() < 0.3
    assert np.abs(np.linalg.norm(rolling_guidance(normals, cover, sigma_s), axis=-1) - 1).max() < 1e-6


def test_extreme_range_sigmas_blur_or_keep_everything():
    normals, cover = rough()
    covered = cover > 0
    assert (
        angle_deg(rolling_guidance(normals, cover, 3.0, 1e6), exact(normals, cover, 3.0, 1e6, 4, reach=3)).max() < 0.01
    )
    # no two normals of the first pass are alike, so nothing is averaged
    assert angle_deg(rolling_guidance(normals, cover, 3.0, 1e-300), normals)[covered].max() < 0.1


def test_opposite_normals_that_cancel_are_unchanged():
    normals = np.float32([[[1, 0, 0], [-1, 0, 0]]])
    assert np.array_equal(rolling_guidance(normals, np.ones((1, 2), np.float32), 1e9, 0.5, 1), normals)


def test_an_uncovered_image_is_flat():
    normals = rough()[0]
    assert (rolling_guidance(normals, np.zeros(normals.shape[:2], np.float32)) == FLAT).all()


def test_arguments_are_not_changed_and_runs_agree():
    normals, cover = rough()
    kept = normals.copy(), cover.copy()
    first = rolling_guidance(nm.NormalMap(normals, cover, nm.Frame(*cover.shape)).normals, cover, 7.0)
    assert first.dtype == np.float32
    assert np.array_equal(first, rolling_guidance(normals, cover, 7.0))
    assert np.array_equal(normals, kept[0])
    assert np.array_equal(cover, kept[1])
    # the memory layout does not matter
    assert np.array_equal(first, rolling_guidance(np.asfortranarray(normals), np.asfortranarray(cover), 7.0))


@pytest.mark.parametrize("iterations", [1, 3])
def test_progress_ends_at_one(iterations):
    normals, cover = rough()
    seen = []
    rolling_guidance_image(
        normals, cover, sigma_s_px=7, sigma_r=0.4, iterations=iterations, progress=lambda *told: seen.append(told)
    )
    assert {stage for stage, _ in seen} == {"filtering"}
    shares = [share for _, share in seen]
    assert shares == sorted(shares)
    assert shares[-1] == 1


@pytest.mark.parametrize("cores", [1, 3])
def test_only_threads_of_the_project_filter(cores, monkeypatch):
    normals, cover = rough()
    expected = rolling_guidance(normals, cover, 7.0)
    monkeypatch.setattr(parallel, "cores", lambda: cores)
    monkeypatch.setattr(parallel, "_kept", parallel._Kept())
    monkeypatch.setattr(image, "BATCH", 256)
    weighted_sum, seen = image._weighted_sum, set()

    def watched(*given):
        seen.add(threading.current_thread())
        return weighted_sum(*given)

    monkeypatch.setattr(image, "_weighted_sum", watched)
    assert np.array_equal(rolling_guidance(normals, cover, 7.0), expected)
    others = seen - {threading.current_thread()}
    assert len(others) < cores
    assert all(thread.name.startswith("nmaptool") for thread in others)


def test_the_filtering_thread_reports_progress(monkeypatch):
    monkeypatch.setattr(parallel, "cores", lambda: 3)
    monkeypatch.setattr(image, "BATCH", 256)
    told_by = []
    rolling_guidance_image(
        *rough(),
        sigma_s_px=7,
        sigma_r=0.4,
        iterations=3,
        progress=lambda *_: told_by.append(threading.current_thread()),
    )
    assert set(told_by) == {threading.current_thread()}


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize("name", ["sigma_s_px", "sigma_r"])
def test_invalid_sigmas_are_refused(name, value):
    with pytest.raises(nm.UsageError, match=f"`{name}={value:g}`: must be finite and greater than zero"):
        rolling_guidance_image(*rough(), **{"sigma_s_px": 3.0, "sigma_r": 0.5, "iterations": 3, name: value})


def test_invalid_iterations_are_refused():
    with pytest.raises(nm.UsageError, match="`iterations=0`: must be at least 1"):
        rolling_guidance(*rough(), iterations=0)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 3e38, 0.9])
def test_vectors_that_are_not_normals_are_refused(bad):
    normals, cover = rough()
    normals[0, 0] = (0, 0, bad)
    with pytest.raises(nm.InputError, match="the normals must be finite and of unit length"):
        rolling_guidance(normals, cover)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -0.1, 1.1])
def test_invalid_coverage_is_refused(bad):
    normals, cover = rough()
    cover[3, 4] = bad
    with pytest.raises(nm.InputError, match=r"the coverage must be in \[0, 1\]"):
        rolling_guidance(normals, cover)


def test_arrays_of_wrong_shapes_are_refused():
    normals, cover = rough()
    with pytest.raises(nm.InputError, match=r"the normals must be float32 \(H, W, 3\); found float64 \(44, 37, 3\)"):
        rolling_guidance(normals.astype(float), cover)
    with pytest.raises(nm.InputError, match=r"the normals must be float32 \(H, W, 3\); found float32 \(44, 37, 2\)"):
        rolling_guidance(normals[..., :2], cover)
    with pytest.raises(nm.InputError, match=r"the coverage must be float32 \(44, 37\); found float32 \(37, 44\)"):
        rolling_guidance(normals, cover.T)
    with pytest.raises(nm.InputError, match="the normal map has no pixels"):
        rolling_guidance(normals[:0], cover[:0])
