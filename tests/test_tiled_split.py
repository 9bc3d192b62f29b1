"""Large maps are split by tiles as whole maps are."""

from __future__ import annotations

import numpy as np
import pytest
from tiled_scenes import HERE, as_store, bumps, disc, pixels, whole

import nmaptool as nm
from nmaptool.core.errors import InputError, OutputError, UsageError
from nmaptool.filters.image_windows import WindowFilter, border_px

pytest.importorskip("zarr")
ROWS, COLS = 150, 210
FLOAT = nm.WriteOptions(bits="float")


def textured(motif=None):
    """Large forms with fine texture and a sharp crease."""
    large, fine = bumps(ROWS, COLS, 1), bumps(ROWS, COLS, 5)
    normals = nm.blend(large, fine, nm.BlendOptions(mode="pd", strength=0.4)).normal_map.normals.copy()
    normals[:, 101:, 0] -= 0.5
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return nm.NormalMap.from_array(normals, motif, 0.1)


@pytest.mark.parametrize(
    ("options", "motif"),
    [
        ({"sigma_s": "2px"}, None),
        ({"sigma_s": "5px", "filter": "grnf"}, disc(ROWS, COLS, 60)),
        ({"sigma_s": "9px", "iterations": 3, "detail_encoding": "slope"}, disc(ROWS, COLS, 60)),
        ({"sigma_s": "13px", "iterations": 2}, disc(ROWS, COLS, 30, center=(40, 50))),
        ({"sigma_s": "30px", "iterations": 1, "detail_encoding": "difference"}, None),
    ],
)
def test_base_and_detail_are_those_of_the_whole(tmp_path, options, motif):
    name = as_store(textured(motif), tmp_path / "map.zarr")
    chosen = nm.SplitOptions(**{**options, "sigma_s": nm.length(options["sigma_s"])})
    done = nm.tiled.split(name, str(tmp_path / "out.zarr"), chosen, writing=FLOAT, tiling=HERE)
    expected = nm.split(whole(name), chosen)
    for layer in ("base", "detail"):
        stored = pixels(f"{done.output}:{layer}")[..., :3]
        difference = np.abs(stored - getattr(expected, layer).normals)
        assert difference.max() < 2e-5, layer  # rounding, which the passes amplify where directions nearly cancel
        assert np.median(difference) < 1e-7
    assert done.report.mixture.theta == pytest.approx(expected.report.mixture.theta, rel=1e-4)
    assert done.report.detail_share == pytest.approx(expected.report.detail_share, abs=1e-3)
    assert done.report.detail_angle_deg == pytest.approx(expected.report.detail_angle_deg, rel=1e-4)
    assert done.overlap == max(done_filter(chosen).margin, done_filter(chosen).blur_margin)


def done_filter(options):
    return WindowFilter(options.sigma_s.value, options.sigma_r, (ROWS, COLS))


def test_the_overlap_is_about_three_sigmas_and_four_for_the_first_pass():
    for sigma in (2.0, 10.0, 40.0, 160.0):
        window = WindowFilter(sigma, 0.35, (100_000, 100_000))
        assert 2.7 * sigma <= window.margin <= 3.5 * sigma
        assert 4 * sigma <= window.blur_margin <= 4 * sigma + 1
        assert border_px(sigma) == (3 ** max(cell.level for cell in window.cells)) // 2


def test_a_smaller_margin_would_not_do(tmp_path, monkeypatch):
    name = as_store(textured(), tmp_path / "map.zarr")
    options = nm.SplitOptions(sigma_s=nm.length("5px"))
    monkeypatch.setattr(WindowFilter, "margin", property(lambda _: 4))
    nm.tiled.split(name, str(tmp_path / "out.zarr"), options, writing=FLOAT, tiling=HERE)
    expected = nm.split(whole(name), options).base.normals
    assert np.abs(pixels(f"{tmp_path / 'out.zarr'}:base")[..., :3] - expected).max() > 1e-3


def test_a_stopped_run_goes_on(tmp_path):
    name = as_store(textured(), tmp_path / "map.zarr")
    options = nm.SplitOptions(sigma_s=nm.length("4px"), iterations=3)

    def stop(stage, share):
        if stage == "pass 2 of 3" and share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nm.tiled.split(name, str(tmp_path / "out.zarr"), options, tiling=HERE, progress=stop)
    assert not (tmp_path / "out.zarr").exists()
    again = nm.tiled.split(name, str(tmp_path / "out.zarr"), options, tiling=HERE)
    assert again.resumed >= 15
    nm.tiled.split(name, str(tmp_path / "fresh.zarr"), options, tiling=HERE)
    for layer in ("base", "detail"):
        assert np.array_equal(pixels(f"{tmp_path}/out.zarr:{layer}"), pixels(f"{tmp_path}/fresh.zarr:{layer}"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fresh.zarr", "map.zarr", "out.zarr"]


def test_what_cannot_be_split_is_refused(tmp_path):
    name = as_store(bumps(ROWS, COLS, 1, pitch_mm=None), tmp_path / "map.zarr")
    output = str(tmp_path / "out.zarr")
    with pytest.raises(UsageError, match=r"`sigma_s='2mm'`: the size of a pixel in .*map.zarr is not known; give px"):
        nm.tiled.split(name, output, nm.SplitOptions(sigma_s=nm.length("2mm")), tiling=HERE)
    with pytest.raises(UsageError, match=r"`sigma_s='0.1px'`: is only 0.1 px here; use at least 0.3px"):
        nm.tiled.split(name, output, nm.SplitOptions(sigma_s=nm.length("0.1px")), tiling=HERE)
    with pytest.raises(UsageError, match=r"out.exr: a split map is written to a Zarr store"):
        nm.tiled.split(name, str(tmp_path / "out.exr"), tiling=HERE)
    with pytest.raises(OutputError, match="already exists"):
        nm.tiled.split(name, name, tiling=HERE)
    nothing = as_store(bumps(ROWS, COLS, 1, motif=np.zeros((ROWS, COLS), np.float32)), tmp_path / "nothing.zarr")
    with pytest.raises(InputError, match=r"nothing.zarr: no pixel is covered, so there is nothing to split"):
        nm.tiled.split(nothing, output, tiling=HERE)
    assert not list(tmp_path.glob("out*"))
