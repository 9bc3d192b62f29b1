"""Large depth pictures become normals by tiles as whole pictures do."""

from __future__ import annotations

import numpy as np
import pytest
from tiled_scenes import HERE, disc, grey_store, pixels

import nmaptool as nm
from nmaptool.core.errors import InputError, OutputError, UsageError
from nmaptool.core.vectors import angles_deg
from nmaptool.io.stores.zarr_pictures import ZarrPicture

pytest.importorskip("zarr")
ROWS, COLS = 330, 410
FLOAT = nm.WriteOptions(bits="float")


def forms(rows=ROWS, cols=COLS):
    """A smooth surface with two steps, in px."""
    y, x = np.mgrid[:rows, :cols].astype(np.float64)
    z = 14 * np.sin(x / 31) * np.cos(y / 43) + 0.03 * x
    z += 30 * (np.hypot(x - 210, y - 160) < 75) + 25 * (x > 340)
    return (z - z.min()).astype(np.float32)


def compared(tmp_path, values, options, mask=None, tiling=HERE):
    name = grey_store(values, tmp_path / "depth.zarr")
    mask_name = None if mask is None else grey_store(mask, tmp_path / "mask.zarr")
    done = nm.tiled.depth(name, str(tmp_path / "out.zarr"), options, mask=mask_name, writing=FLOAT, tiling=tiling)
    image = ZarrPicture(name).read(slice(None), slice(None))
    expected = nm.depth_to_normals(image, options, mask=mask)
    return done, pixels(done.output), expected


@pytest.mark.parametrize(
    "options",
    [
        {"unit": "1px"},
        {"background": "none", "jump": "none"},
        {"jump": "4px", "background": "flat"},
        {"depth_scale": "5%"},
        {"values": "distance", "fov": 40.0, "empty": "none"},
    ],
)
def test_clean_heights_give_the_same_normals(tmp_path, options):
    words = {"jump", "depth_scale"}
    chosen = {key: nm.length(value) if key in words and value != "none" else value for key, value in options.items()}
    chosen.pop("unit", None)
    values = forms()
    if options.get("values") == "distance":
        values = 900 - values
    done, stored, expected = compared(tmp_path, values, nm.DepthOptions(**chosen))
    assert np.array_equal(stored[..., 3], expected.normal_map.coverage)
    assert np.abs(stored[..., :3] - expected.normal_map.normals).max() < 2e-6
    report, other = done.report, expected.report
    assert (report.jumps, report.mixed_pixels) == (other.jumps, other.mixed_pixels)
    for word in ("scale_px", "scale_from", "values", "step_px", "noise_px", "tolerance_px", "jump_px", "background"):
        assert getattr(report, word) == getattr(other, word), word
    assert report.range_px == pytest.approx(other.range_px)
    assert report.background_share == pytest.approx(other.background_share)


def test_the_ground_is_found_across_tiles(tmp_path):
    values = np.where(disc(ROWS, COLS, 120, 1) > 0, 10 + forms(), 0).astype(np.float32)
    values[3:6, 3:6] = 5  # a speck on the ground
    for background in ("auto", "flat"):
        done, stored, expected = compared(tmp_path, values, nm.DepthOptions(background=background))
        assert done.report.background == expected.report.background == ("cut" if background == "auto" else "flat")
        assert np.array_equal(stored[..., 3], expected.normal_map.coverage)
        assert np.abs(stored[..., :3] - expected.normal_map.normals).max() < 2e-6
        for place in (tmp_path / "out.zarr", tmp_path / "depth.zarr"):
            place.rename(tmp_path / f"{background}_{place.name}")


def test_holes_are_filled_across_tiles(tmp_path):
    values = forms()
    values[62:67, 100:103] = np.nan
    values[190:193, 126:131] = np.nan
    done, stored, expected = compared(tmp_path, values, nm.DepthOptions(background="none"))
    assert done.report.filled_pixels == expected.report.filled_pixels == 30
    assert np.array_equal(stored[..., 3], expected.normal_map.coverage)
    assert np.abs(stored[..., :3] - expected.normal_map.normals).max() < 1e-4


@pytest.mark.parametrize("kind", ["steps", "noise"])
def test_a_fitted_surface_has_no_seams(tmp_path, kind):
    values = forms()
    if kind == "steps":
        values = np.round(values / values.max() * 255).astype(np.uint8)
    else:
        values += np.random.default_rng(3).normal(0, 0.3, values.shape).astype(np.float32)
    tiling = nm.TilingOptions(tile=128, workers=1)
    done, stored, expected = compared(tmp_path, values, nm.DepthOptions(background="none"), tiling=tiling)
    assert done.report.tolerance_px == expected.report.tolerance_px > 0
    angle = angles_deg(stored[..., :3].reshape(-1, 3), expected.normal_map.normals.reshape(-1, 3))
    assert np.mean(angle) < 0.01
    assert np.percentile(angle, 99.9) < 0.5


def test_a_mask_becomes_the_coverage(tmp_path):
    mask = disc(ROWS, COLS, 140, 5)
    done, stored, expected = compared(tmp_path, forms(), nm.DepthOptions(), mask)
    assert np.array_equal(stored[..., 3], expected.normal_map.coverage)
    assert np.abs(stored[..., :3] - expected.normal_map.normals).max() < 2e-6
    assert done.report.background == expected.report.background


def test_empty_values_are_left_out(tmp_path):
    values = (900 - forms()).astype(np.float32)
    values[:90] = 1e10
    values[300:, :60] = -9999
    done, stored, expected = compared(tmp_path, values, nm.DepthOptions(values="distance", fov=35.0))
    assert done.report.empty == expected.report.empty
    assert np.array_equal(stored[..., 3], expected.normal_map.coverage)
    assert np.abs(stored[..., :3] - expected.normal_map.normals).max() < 2e-6


def test_what_is_no_depth_picture_is_refused(tmp_path):
    output = str(tmp_path / "out.zarr")
    name = grey_store(forms(), tmp_path / "depth.zarr")
    with pytest.raises(InputError, match=r"is 410 x 330 pixels but the mask is 6 x 5"):
        nm.tiled.depth(name, output, mask=grey_store(np.full((5, 6), 255, np.uint8), tmp_path / "tiny.zarr"))
    black = grey_store(np.zeros((ROWS, COLS), np.uint8), tmp_path / "black.zarr")
    with pytest.raises(InputError, match=r"the mask selects no part of the picture: paint the motif white"):
        nm.tiled.depth(name, output, mask=black, tiling=HERE)
    assert not list(tmp_path.glob("out*"))
    with pytest.raises(InputError, match=r"no pixel has a depth: all are transparent, NaN or infinite"):
        nm.tiled.depth(grey_store(np.full((70, 70), np.nan, np.float32), tmp_path / "nan.zarr"), output, tiling=HERE)
    with pytest.raises(UsageError, match=r"disparities of a large picture are not converted; save it as distances"):
        nm.tiled.depth(name, output, nm.DepthOptions(values="disparity", unit=nm.length("1m"), fov=40.0), tiling=HERE)
    with pytest.raises(UsageError, match=r"out.png: a normal map is written to a Zarr store"):
        nm.tiled.depth(name, str(tmp_path / "out.png"))
    with pytest.raises(OutputError, match="already exists"):
        nm.tiled.depth(name, name)


def test_wider_holes_are_filled_with_a_wider_overlap(tmp_path):
    values = forms()
    values[100:150, 120:220] = np.nan
    chosen = nm.DepthOptions(background="none", fill=nm.length("60px"))
    done, stored, expected = compared(tmp_path, values, chosen, tiling=nm.TilingOptions(tile=128, workers=1))
    assert done.overlap == 192
    assert done.report.filled_pixels == expected.report.filled_pixels == 5000
    assert np.abs(stored[..., :3] - expected.normal_map.normals).max() < 1e-4
