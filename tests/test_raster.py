"""Which face each pixel shows: OpenGL against NumPy, and both against known results."""

import os
import subprocess
import sys

import numpy as np
import pytest
from mesh_cases import joined, sheet, sphere

import nmaptool as nm
from nmaptool.render import gl, numpy_raster
from nmaptool.render.camera import frame_camera

ROWS, COLS = 90, 110


def projected(mesh, **options):
    made = nm.BakeOptions(**{"size": f"{COLS}x{ROWS}", **options})
    return frame_camera(mesh, made, 20, 10).project(mesh.vertices)


def edge_distance(points, faces, shown):
    """(H, W) distance in px from each pixel's centre to the nearest edge of the face it should show."""
    row, col = np.nonzero(shown >= 0)
    at = np.column_stack([col, row]) + 0.5
    out = np.full(shown.shape, np.inf)
    for k in range(3):
        a, b = (points[faces[shown[row, col], j], :2] for j in (k, (k + 1) % 3))
        along = (((at - a) * (b - a)).sum(1) / np.maximum(((b - a) ** 2).sum(1), 1e-30)).clip(0, 1)
        out[row, col] = np.minimum(out[row, col], np.hypot(*(at - a - along[:, None] * (b - a)).T))
    return out


@pytest.fixture(scope="module")
def draw():
    with gl.drawing() as (draw, _):
        yield draw


@pytest.mark.parametrize("fov", [0.0, 40.0])
@pytest.mark.parametrize(
    "mesh",
    [
        sphere(12),
        sphere(60),
        joined(sphere(10), sphere(6, 1.3), sheet(lambda x, y: 0.2 * x, 5, 5, 0.6)),
        sheet(lambda x, y: np.sin(3 * x) * np.cos(2 * y), 30, 30, 0.2),
    ],
    ids=["facets", "fine", "nested", "waves"],
)
def test_opengl_and_numpy_show_the_same_faces_except_at_edges(draw, mesh, fov):
    points = projected(mesh, fov=fov)
    by_gl, by_numpy = (d(points, mesh.faces, ROWS, COLS) for d in (draw, numpy_raster.visible_faces))
    differ = by_gl != by_numpy
    assert differ.mean() < 0.02
    near = np.minimum(edge_distance(points, mesh.faces, by_numpy), edge_distance(points, mesh.faces, by_gl))
    assert near[differ].max(initial=0) < 0.02  # OpenGL positions have a resolution of 1/256 px
    assert ((by_gl >= 0) == (by_numpy >= 0)).mean() > 0.999


def test_a_pixel_shows_the_face_under_its_centre():
    points = np.array([[1.5, 1.5, 0], [4.5, 1.5, 0], [1.5, 5.5, 0]])
    shown = numpy_raster.visible_faces(points, np.array([[0, 1, 2]], np.int32), 7, 6)
    y, x = np.mgrid[0:7, 0:6] + 0.5
    inside = (x >= 1.5) & (y >= 1.5) & ((x - 1.5) / 3 + (y - 1.5) / 4 <= 1)
    assert np.array_equal(shown == 0, inside)


@pytest.mark.parametrize("which", ["gl", "numpy"])
def test_the_nearer_face_hides_the_other_whatever_their_order_or_winding(draw, which):
    one = draw if which == "gl" else numpy_raster.visible_faces
    points = np.array([[0, 0, 0], [8, 0, 0], [0, 8, 0], [0, 0, 1], [8, 0, 1], [0, 8, 1]], float)
    for near, far in (([3, 4, 5], [0, 1, 2]), ([5, 4, 3], [0, 1, 2]), ([3, 4, 5], [2, 1, 0])):
        for faces, front in (([near, far], 0), ([far, near], 1)):
            shown = one(points, np.array(faces, np.int32), 8, 8)
            assert set(np.unique(shown)) == {-1, front}


@pytest.mark.parametrize("which", ["gl", "numpy"])
def test_crossing_faces_meet_in_the_expected_line(draw, which):
    one = draw if which == "gl" else numpy_raster.visible_faces
    points = np.array([[0, 0, 0], [20, 0, 1], [20, 20, 1], [0, 20, 0], [0, 0, 1], [20, 0, 0], [20, 20, 0], [0, 20, 1]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)
    shown = one(points.astype(float), faces, 20, 20)
    assert (shown[:, :10] >= 2).all()
    assert (shown[:, 10:] < 2).all()


def test_tiles_give_the_whole_image(draw, monkeypatch):
    mesh = sphere(20)
    points = projected(mesh)
    whole = draw(points, mesh.faces, ROWS, COLS)
    monkeypatch.setattr(gl, "TILE_PX", 32)
    tiled = draw(points, mesh.faces, ROWS, COLS)
    assert (whole == tiled).mean() > 0.999  # positions are rounded differently


def test_numpy_portions_give_the_whole_image(monkeypatch):
    mesh = joined(sphere(15), sheet(lambda x, y: 0 * x, 1, 1, 2.0))
    points = projected(mesh)
    whole = numpy_raster.visible_faces(points, mesh.faces, ROWS, COLS)
    monkeypatch.setattr(numpy_raster, "_PAIRS_AT_ONCE", 700)
    assert np.array_equal(whole, numpy_raster.visible_faces(points, mesh.faces, ROWS, COLS))


def test_slivers_and_large_triangles_show_what_each_pixel_shows_alone():
    rng = np.random.default_rng(5)
    corners = rng.uniform(-20, 130, (200, 3, 2))
    corners[::2, 2] = corners[::2, 0] + rng.normal(0, 0.6, (100, 2))  # thin and long
    corners[:20] = np.round(corners[:20]) + 0.5  # with corners and edges at pixel centres
    points = np.dstack([corners, rng.uniform(1, 9, (200, 3, 1))]).reshape(-1, 3)
    points[3:6] = points[:3]  # one lies on another
    faces = np.arange(600, dtype=np.int32).reshape(-1, 3)
    shown = numpy_raster.visible_faces(points, faces, ROWS, COLS)
    y, x = np.divmod(np.arange(ROWS * COLS), COLS)
    expected, nearest = np.full(ROWS * COLS, -1), np.full(ROWS * COLS, -np.inf)
    for number, face in enumerate(faces):
        near, inside = numpy_raster._covered(points, np.repeat(face[None], len(x), axis=0), x + 0.5, y + 0.5)
        better = inside & (near >= nearest)
        expected[better], nearest[better] = number, near[better]
    np.testing.assert_array_equal(shown.ravel(), expected)
    assert (expected >= 0).mean() > 0.5


def test_face_numbers_may_exceed_24_bits():
    numbers = np.array([[0, 255, 256, 2**24 - 2, 2**24 - 1, 2**24, 2**31 - 2]])
    code = (numbers + 1).astype("<u4").view(np.uint8).reshape(1, -1, 4)
    assert np.array_equal(gl.face_numbers(code), numbers)
    assert gl.face_numbers(np.array([[[0, 0, 0, 255]]], np.uint8)) == -1


def test_a_mesh_out_of_view_gives_an_empty_image(draw):
    points = np.array([[200, 200, 0], [220, 200, 0], [200, 220, 0]], float)
    for one in (draw, numpy_raster.visible_faces):
        assert (one(points, np.array([[0, 1, 2]], np.int32), 20, 30) == -1).all()


def test_twenty_drawings_leave_no_object_in_the_context():
    mesh = sphere(8)
    points = projected(mesh)
    with gl.drawing() as (draw, _):
        draw(points, mesh.faces, ROWS, COLS)
        from OpenGL import GL

        def held():
            kinds = (GL.glIsBuffer, GL.glIsVertexArray, GL.glIsFramebuffer, GL.glIsRenderbuffer, GL.glIsProgram)
            return [sum(bool(is_there(name)) for name in range(1, 400)) for is_there in kinds]

        after_one = held()
        for _ in range(20):
            draw(points, mesh.faces, ROWS, COLS)
        assert held() == after_one
        assert after_one[0] == 0  # no mesh is left


def test_a_drawing_does_not_end_another(draw):
    """A program that itself draws with pyrender keeps its context."""
    mesh = sphere(8)
    points = projected(mesh)
    before = draw(points, mesh.faces, ROWS, COLS)
    with gl.drawing() as (inner, _):
        assert np.array_equal(inner(points, mesh.faces, ROWS, COLS), before)
        assert np.array_equal(draw(points, mesh.faces, ROWS, COLS), before)
        assert np.array_equal(inner(points, mesh.faces, ROWS, COLS), before)
    assert np.array_equal(draw(points, mesh.faces, ROWS, COLS), before)


def test_many_contexts_can_be_created_in_turn():
    mesh = sphere(8)
    points = projected(mesh)
    shown = []
    for _ in range(20):
        with gl.drawing() as (draw, _):
            shown.append(draw(points, mesh.faces, ROWS, COLS))
    assert all(np.array_equal(shown[0], other) for other in shown[1:])


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux is sure to have OpenGL")
def test_two_processes_can_draw_at_once():
    script = (
        "import sys; sys.path.insert(0, 'tests')\nfrom mesh_cases import sphere\nimport nmaptool as nm\n"
        "print(nm.bake(sphere(30), nm.BakeOptions(size='200x200')).coverage.sum())"
    )
    command = [sys.executable, "-c", script]
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    stated = [process.communicate(timeout=120)[0] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert stated[0] == stated[1]
    assert float(stated[0]) > 20000


def test_a_missing_context_is_an_error_that_says_what_to_install(monkeypatch):
    monkeypatch.setattr(gl, "Offscreen", lambda platform: (_ for _ in ()).throw(OSError(f"no lib{platform}.so")))
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    expected = (
        r"egl: no libegl.so; osmesa: .*; window: .*apt-get install libegl1 libgl1 libgl1-mesa-dri libxrender1.*numpy"
    )
    with pytest.raises(nm.RendererError, match=expected), gl.drawing():
        pass
    monkeypatch.setenv("PYOPENGL_PLATFORM", "egl")
    with pytest.raises(nm.RendererError, match=r"\(egl: no libegl.so\)"), gl.drawing():
        pass


def test_the_next_platform_is_tried_after_a_failure(monkeypatch):
    real, asked = gl.Offscreen, []

    def first_fails(platform):
        asked.append(platform)
        if platform == "egl":
            raise OSError("no egl")
        made = real("egl")
        made.platform = platform
        return made

    monkeypatch.setattr(gl, "Offscreen", first_fails)
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    with gl.drawing() as (_, platform):
        assert platform == "osmesa"
    assert asked == ["egl", "osmesa"]
    assert "PYOPENGL_PLATFORM" not in os.environ
