"""Errors in rebuilding a mesh, each in one clear line."""

import numpy as np
import pytest
from mesh_cases import sphere

import nmaptool as nm
from nmaptool.core.errors import ConvergenceError, InputError, LimitError, UsageError
from nmaptool.reconstruction import stitching


@pytest.fixture
def ball():
    return nm.clean_mesh(sphere(6))[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda n: n[1:], r"the normals are float64 \(287, 3\), expected float \(288, 3\): one per face of mesh"),
        (lambda n: n[:, :2], r"the normals are float64 \(288, 2\), expected"),
        (lambda n: n.astype(int), r"the normals are int64 \(288, 3\), expected float"),
        (
            lambda n: np.where(np.arange(288)[:, None] < 2, np.nan, n),
            r"the normals must be finite; NaN or infinite: 2$",
        ),
        (lambda n: n * np.inf, r"the normals must be finite; NaN or infinite: 288$"),
        (lambda n: n * 1.01, r"the normal of face \d+ has length 1\.01, expected 1; normalise the normals"),
        (lambda n: 0 * n, r"the normal of face 0 has length 0, expected 1"),
        (lambda n: -n, r"the normals would flip 100% of the area of mesh; .* negate them if they point inwards"),
    ],
)
def test_invalid_normals_are_refused(ball, change, message):
    with pytest.raises(InputError, match=message):
        nm.reconstruct(ball, change(ball.geometry.normals))


def test_meshes_that_are_not_clean_are_refused(ball):
    normals = ball.geometry.normals
    with pytest.raises(InputError, match="mesh: has no faces, so there is no surface to rebuild"):
        nm.reconstruct(nm.Mesh(ball.vertices, ball.faces[:0]), normals[:0])
    broken = ball.vertices.copy()
    broken[3] = np.nan
    with pytest.raises(InputError, match=r"mesh: has NaN or infinite vertices; clean it first: nm.clean_mesh"):
        nm.reconstruct(nm.Mesh(broken, ball.faces), normals)
    flat = ball.faces.copy()
    flat[5, 2] = flat[5, 1]
    with pytest.raises(InputError, match=r"mesh: has faces without area \(1\), which have no normal; clean it first"):
        nm.reconstruct(nm.Mesh(ball.vertices, flat), normals)


def test_a_system_that_cannot_be_solved_is_an_error(monkeypatch):
    monkeypatch.setattr(stitching, "_DIRECT", 0)
    monkeypatch.setattr(stitching, "_MOST_CYCLES", 1)
    ball = nm.clean_mesh(sphere(24))[0]
    flat = nm.Mesh(ball.vertices * [1, 1, 0.1], ball.faces)
    with pytest.raises(
        ConvergenceError,
        match=r"`scheme='poisson'`: the residual is .* use `scheme='gsfg-gradient'` or a larger `closeness`",
    ):
        nm.reconstruct(flat, ball.geometry.normals, nm.ReconstructOptions(scheme="poisson", steps=1))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: nm.ReconstructOptions(scheme="sfg"),
            r"`scheme='sfg'`: use one of gsfg-gradient, gsfg-shape, gsfg, p",
        ),
        (lambda: nm.ReconstructOptions(boundary="cut"), r"`boundary='cut'`: use one of hold, free"),
        (lambda: nm.ReconstructOptions(steps=0), r"`steps=0`: must lie between 1 and 10000, such as 20"),
        (lambda: nm.ReconstructOptions(closeness=0), r"`closeness=0`: must lie between 1e-08 and 10000, such as 0.01"),
        (lambda: nm.SmoothOptions(detail_gain=11), r"`detail_gain=11`: must lie between -10 and 10, such as 0 or 2"),
        (lambda: nm.SmoothOptions(detail_gain=float("nan")), r"`detail_gain=nan`: must lie between"),
        (lambda: nm.CompareOptions(view="up"), r"`view='up'`: use one of front, back"),
        (lambda: nm.CompareOptions(up="x"), r"`up='x'`: use one of y, z"),
        (lambda: nm.CompareOptions(renderer="metal"), r"`renderer='metal'`: use one of auto"),
        (lambda: nm.CompareOptions(size="9"), r"`size='9'`: expected columns x rows"),
        (lambda: nm.BakeOptions(geometry="new"), r"`geometry='new'`: use one of original, updated"),
    ],
)
def test_invalid_options_are_refused(make, message):
    with pytest.raises(UsageError, match=message):
        make()


def test_a_figure_that_is_too_large_is_refused():
    with pytest.raises(LimitError, match=r"`size='9000x9000'`: has more than 16000000 pixels"):
        nm.CompareOptions(size="9000x9000")
