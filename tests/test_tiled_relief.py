"""Reliefs of large maps equal those in memory."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core.grid import touching_vertices
from nmaptool.options import ReliefFiles, ReliefOptions, TilingOptions
from tests.tiled_cases import COLS, ROWS, WIDTH, Case, store

pytest.importorskip("zarr")
import zarr

# what differs by its nature: the solver, its iterations, and the times
_OWN = ("solver", "iterations", "residual", "history", "planned_bytes", "seconds", "options")


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """The stores of the case."""
    return Case(tmp_path_factory.mktemp("case"))


def _tiled(case: Case, output: Path, options: ReliefOptions, **more: Any) -> tuple[Any, Any]:
    settings: dict[str, Any] = {"tiling": TilingOptions(tile=128, workers=0), "at": "corners", **more}
    report = nm.tiled.relief(case.original, str(output), options, settings.pop("files", case.files), **settings)
    return report, zarr.open_array(str(output))[:]


@pytest.mark.parametrize(
    "values",
    [
        {"background": "plane"},
        {"background": "cut", "height": nm.length("3mm")},
        {"background": "free", "height": nm.length("2mm"), "energy": "eq4"},
        {"background": "plane", "height": nm.length("6mm"), "fit": "delta"},
        {"background": "cut", "height": nm.length("1mm"), "fit": "slope"},
        {"background": "cut", "beta": 0.0, "height": nm.length("3mm")},
        {"background": "cut", "outline_round": nm.length("0.3mm"), "delta": -20},
    ],
    ids=lambda values: "-".join(str(value) for value in values.values()),
)
def test_tiles_give_the_heights_and_the_report_of_the_whole(case: Case, tmp_path: Path, values: dict[str, Any]) -> None:
    options = ReliefOptions(width=WIDTH, **values)
    found, z = _tiled(case, tmp_path / "heights.zarr", options)
    whole = case.in_memory(dataclasses.replace(options, tolerance=1e-11))
    inside = touching_vertices(whole.mask)
    np.testing.assert_array_equal(np.isfinite(z), inside)
    span = whole.report.height_range_mm
    assert np.abs(z - whole.z_mm)[inside].max() < 3e-7 * span
    # no seam shows in the second differences either: float32 rounds heights to about 1e-7 of their range
    for axis in (0, 1):
        bend = np.diff(np.where(inside, z - whole.z_mm, 0), 2, axis=axis)
        assert np.abs(bend).max() < 6e-7 * span
    for field in dataclasses.fields(whole.report):
        if field.name not in _OWN:
            ours, theirs = getattr(found.relief, field.name), getattr(whole.report, field.name)
            assert ours == (pytest.approx(theirs, rel=1e-6) if isinstance(theirs, float) else theirs), field.name
    assert found.relief.residual <= options.tolerance
    assert found.tiles == 20
    assert found.sweeps <= 8
    assert sorted(path.name for path in tmp_path.iterdir()) == ["heights.zarr"]


def test_a_curved_background_is_kept(case: Case, tmp_path: Path) -> None:
    y, x = np.mgrid[0 : ROWS + 1, 0 : COLS + 1]
    base = (3 * np.sin(x / 90) + 2 * np.cos(y / 70)).astype(np.float32)
    pitch_mm = 54 / COLS
    facts = {"kind": "height", "unit": "mm", "at": "corners"}
    surface = store(tmp_path / "base.zarr", base, ("Y",), pitch_mm=pitch_mm, attributes=facts)
    options = ReliefOptions(background="surface", width=WIDTH, height=nm.length("2mm"))
    files = dataclasses.replace(case.masked, surface=surface)
    found, z = _tiled(case, tmp_path / "heights.zarr", options, files=files)
    frame = nm.Frame(ROWS, COLS, pitch_mm=pitch_mm)
    ground = nm.Height(base.astype(np.float64), np.ones((ROWS, COLS), bool), frame)
    original = nm.NormalMap.from_array(case.normals)
    tight = dataclasses.replace(options, tolerance=1e-11)
    whole = nm.relief(original, mask=case.grey["mask"], surface=ground, options=tight)
    np.testing.assert_allclose(z, whole.z_mm, atol=2e-6)
    assert found.relief.relief_range_mm == pytest.approx(2, rel=1e-9)
    assert found.relief.height_range_mm == pytest.approx(whole.report.height_range_mm, rel=1e-6)


def test_heights_at_centers_are_the_means_of_the_corners(case: Case, tmp_path: Path) -> None:
    options = ReliefOptions(background="cut", width=WIDTH)
    _, z = _tiled(case, tmp_path / "heights.zarr", options, files=case.masked, at="centers")
    whole = case.in_memory(dataclasses.replace(options, tolerance=1e-11), mask_only=True)
    np.testing.assert_allclose(z, whole.height.at_pixels(), atol=2e-6)


def test_a_whole_rectangle_with_beta_zero_has_mean_zero(case: Case, tmp_path: Path) -> None:
    options = ReliefOptions(background="free", beta=0.0, width=WIDTH)
    found, z = _tiled(case, tmp_path / "heights.zarr", options, files=ReliefFiles())
    assert abs(z.astype(np.float64).mean()) < 1e-6
    assert any("heights have mean 0" in warning for warning in found.relief.warnings)
    np.testing.assert_allclose(
        z, nm.relief(nm.NormalMap.from_array(case.normals), options=options).z_mm, atol=1e-5 * np.ptp(z)
    )


def test_the_cut_does_not_change_the_heights(case: Case, tmp_path: Path) -> None:
    options = ReliefOptions(width=WIDTH)
    z = [
        _tiled(case, tmp_path / f"{tile}.zarr", options, tiling=TilingOptions(tile=tile, workers=0))[1]
        for tile in (64, 192, 448)
    ]
    for other in z[1:]:
        np.testing.assert_allclose(other, z[0], atol=1e-6)


def test_two_workers_give_the_bytes_of_one_process(case: Case, tmp_path: Path) -> None:
    options = ReliefOptions(width=WIDTH, height=nm.length("3mm"))
    first, z = _tiled(case, tmp_path / "here.zarr", options)
    second, other = _tiled(case, tmp_path / "workers.zarr", options, tiling=TilingOptions(tile=128, workers=2))
    assert z.tobytes() == other.tobytes()
    assert first.relief.history == second.relief.history
    assert second.workers == 2
