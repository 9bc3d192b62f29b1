"""gSfG and Poisson on the same targets: their figures, the fronts, the verdict and the plot."""

import json

import numpy as np
import pytest
from mesh_cases import sphere

import nmaptool as nm
from nmaptool.core.errors import OutputError, UsageError
from nmaptool.evaluate.sweep import CURVES, verdicts_of
from nmaptool.evaluate.verdict import compare_fronts, front, reached
from nmaptool.figures.comparison import comparison_figure
from nmaptool.meshes.distances import hausdorff

DRAWN = nm.CompareOptions(size="80x70", renderer="numpy")


@pytest.fixture(scope="module")
def mesh():
    ball = nm.clean_mesh(sphere(16))[0]
    x, y, z = ball.vertices.T
    radius = 1 + 0.04 * np.sin(14 * x) * np.sin(12 * y) * np.cos(10 * z)
    return nm.Mesh(ball.vertices * radius[:, None] + [9, 9, 9], ball.faces, 10.0, "given", "a/knob.ply")


@pytest.fixture(scope="module")
def compared(mesh):
    return nm.compare(mesh, DRAWN)


def test_deviations_are_those_of_the_rebuilt_meshes(mesh, compared):
    for name, each in compared.contenders.items():
        # the centroids coincide
        np.testing.assert_allclose(each.mesh.vertices.mean(axis=0), mesh.vertices.mean(axis=0))
        off = 10 * np.linalg.norm(each.mesh.vertices - mesh.vertices, axis=1)
        np.testing.assert_allclose(each.deviation_mm, off, atol=1e-12)
        assert each.rms_mm == pytest.approx(np.sqrt((off**2).mean()))
        assert (each.mean_mm, each.max_mm) == (pytest.approx(off.mean()), pytest.approx(off.max()))
        # no vertex is farther from the other surface than from its own position on it
        assert 0 < each.hausdorff_mm <= each.max_mm
        assert each.to_original_mm == pytest.approx(10 * hausdorff(each.mesh.vertices, mesh)[0])
        assert each.from_original_mm == pytest.approx(10 * hausdorff(mesh.vertices, each.mesh)[0])
        assert each.histogram.sum() == pytest.approx(1)
        assert each.options.scheme == {"gsfg": "gsfg-gradient", "poisson": "poisson"}[name]
    assert compared.diagonal_mm == pytest.approx(10 * np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def test_poisson_is_shown_with_its_closest_settings(compared):
    ours, rival = (compared.contenders[name] for name in ("gsfg", "poisson"))
    nearest = min(
        compared.curves["poisson, one solve"],
        key=lambda p: np.log(p.normal_deg / ours.normal_mean_deg) ** 2 + np.log(p.rms_mm / ours.rms_mm) ** 2,
    )
    assert rival.options.closeness == nearest.closeness
    assert (rival.normal_mean_deg, rival.rms_mm) == (pytest.approx(nearest.normal_deg), pytest.approx(nearest.rms_mm))


def test_stronger_closeness_is_nearer_to_the_mesh_and_farther_from_the_targets(compared):
    for name in ("gsfg-gradient, 20 steps", "gsfg-shape, 20 steps", "poisson, one solve", "poisson, 20 solves"):
        points = sorted(compared.curves[name], key=lambda p: -p.closeness)[:-1]
        assert [p.rms_mm for p in points] == sorted(p.rms_mm for p in points)
        assert [-p.normal_deg for p in points] == sorted(-p.normal_deg for p in points)


def test_json_contains_every_figure(compared):
    values = json.loads(json.dumps(compared.to_dict()))
    assert values["mesh"] == "a/knob.ply"
    ours = values["contenders"]["gsfg"]
    assert ours["rms_percent"] == pytest.approx(100 * ours["rms_mm"] / values["diagonal_mm"])
    assert ours["hausdorff_percent"] == pytest.approx(100 * ours["hausdorff_mm"] / values["diagonal_mm"])
    assert len(ours["histogram"]) == len(values["histogram_edges_deg"]) - 1
    assert list(values["curves"]) == list(CURVES)
    assert [verdict["holds"] in ("yes", "no", "in part") for verdict in values["verdicts"]] == [True] * 3
    assert all(verdict["summary"].startswith(("holds", "does not hold")) for verdict in values["verdicts"])


def test_fronts_are_found_and_interpolated():
    points = [(3.0, 1.0), (1.0, 4.0), (2.0, 2.0), (2.5, 3.0), (1.5, 4.0)]
    assert front(points) == [(1.0, 4.0), (2.0, 2.0), (3.0, 1.0)]
    assert reached([points], 0.9) is None
    assert reached([points], 1.0) == pytest.approx(4)
    assert reached([points], np.sqrt(2)) == pytest.approx(np.sqrt(8))  # halfway on a log scale
    assert reached([points], 50.0) == pytest.approx(1)
    assert reached([points, [(2.0, 1.5)]], 2.0) == pytest.approx(1.5)
    ratios = [(p.normal, p.ratio) for p in compare_fronts([points], [(0.5, 9.0), (2.0, 4.0), (3.0, 0.5)])]
    assert ratios == [(0.5, None), (2.0, pytest.approx(0.5)), (3.0, pytest.approx(2.0))]


@pytest.mark.parametrize(
    ("factor", "holds", "summary"),
    [
        (
            2.0,
            "yes",
            r"holds against poisson, one solve: gSfG has smaller .* at all points .* \(3\); .* 0.50 to 0.50 of",
        ),
        (0.5, "no", r"does not hold against poisson, one solve: .* at none of the points .* \(3\); .* 2.00 to 2.00 of"),
    ],
)
def test_the_verdict_states_the_result(factor, holds, summary):
    ours = tuple(nm.CurvePoint(0.1, 20, angle, 1 / angle, 0) for angle in (1.0, 2.0, 4.0))
    rival = tuple(nm.CurvePoint(0.1, 1, angle, factor / angle, 0) for angle in (1.0, 2.0, 4.0))
    found = verdicts_of(dict(zip(CURVES, (ours, ours, ours, rival, rival), strict=True)))[0]
    assert found.holds == holds
    with pytest.raises(ValueError, match=summary):
        raise ValueError(found.summary)


def test_a_partial_verdict_states_where_it_holds():
    ours = tuple(nm.CurvePoint(0.1, 20, angle, 1 / angle, 0) for angle in (1.0, 2.0, 4.0))
    rival = tuple(nm.CurvePoint(0.1, 1, *each, 0) for each in ((0.5, 9.0), (1.0, 1.5), (2.0, 0.4)))
    found = verdicts_of(dict(zip(CURVES, (ours, ours, ours, rival, rival), strict=True)))[1]
    assert (found.holds, found.points, found.held, found.held_deg) == ("in part", 3, 1, (1.0,))
    assert "at 1 of 3 points of Poisson's front (normal deviation in degrees: 1.00)" in found.summary
    assert "points at which no gSfG run reaches Poisson's normal deviation: 1" in found.summary


def test_the_figure_shows_both_on_one_scale(compared):
    picture = comparison_figure(compared)
    assert picture.dtype == np.uint8
    assert picture.shape == (1144, 1760, 3)
    # neither plot is empty: both halves on the left contain colours of the scale
    left = picture[:, 300:960].astype(int)
    colored = (left.max(axis=2) - left.min(axis=2)) > 60
    half = len(left) // 2
    assert colored[:half].mean() > 0.03
    assert colored[half:].mean() > 0.03
    shot = compared.rendered_views["gsfg"]
    assert shot.deviation_mm.shape == (140, 160)
    seen = np.isfinite(shot.deviation_mm)
    assert 0.3 < seen.mean() < 0.9
    assert (shot.shade[~seen] == 0).all()
    assert shot.deviation_mm[seen].max() <= compared.contenders["gsfg"].max_mm


def test_files_appear_together_or_not_at_all(compared, tmp_path, tree):
    nm.write_comparison(compared, tmp_path / "f.png", report=tmp_path / "f.json")
    assert sorted(tree()) == ["f.json", "f.png"]
    assert json.loads((tmp_path / "f.json").read_text(encoding="utf-8"))["version"] == nm.__version__
    with pytest.raises(OutputError, match=r"f\.json: already exists"):
        nm.write_comparison(compared, tmp_path / "g.png", report=tmp_path / "f.json")
    with pytest.raises(UsageError, match=r"g\.jpg: a figure is written as \.png"):
        nm.write_comparison(compared, tmp_path / "g.jpg")
    assert sorted(tree()) == ["f.json", "f.png"]


def test_poisson_is_not_compared_with_itself(mesh):
    with pytest.raises(UsageError, match=r"`scheme='poisson'`: Poisson is always compared; choose the gSfG scheme"):
        nm.compare(mesh, DRAWN, reconstruct_options=nm.ReconstructOptions(scheme="poisson"))
