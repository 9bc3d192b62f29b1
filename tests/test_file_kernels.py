"""The compiled loops of files of triangles and their twins: equal bytes and sums, and numbers as Python writes them."""

from __future__ import annotations

import numpy as np
import pytest

from nmaptool import kernels
from nmaptool.io.solids.text import decimals_as_text, wholes_as_text, words_of
from nmaptool.kernels import face_twins, text_twins, triangle_twins

needs_compiler = pytest.mark.skipif(not kernels.IS_COMPILED, reason="built without a C compiler")
LOOPS = [
    pytest.param(kernels, marks=needs_compiler, id="compiled"),
    pytest.param(triangle_twins, id="numpy"),
]
TEXT_LOOPS = [pytest.param(kernels, marks=needs_compiler, id="compiled"), pytest.param(text_twins, id="numpy")]
WORDS = words_of("a#b#c#\n")


def rng():
    return np.random.default_rng(5)


def triangles(count=1003, points=400):
    """Vertices and faces, three of which have two equal corners."""
    random = rng()
    faces = np.stack([random.permutation(points)[:3] for _ in range(count)]).astype(np.int32)
    faces[[3, 500, 1002], 1] = faces[[3, 500, 1002], [0, 2, 0]]
    return random.normal(size=(points, 3)), faces


def sums_of(loops, points, records, stride, offset, is_closed=True, counted=True):
    sums, counts = np.array([np.inf] * 3 + [-np.inf] * 3 + [0.0]), np.zeros(2, np.int64)
    edges = np.zeros((records.size // stride if counted else 0, 3), np.int64)
    middle = np.array([0.1, -0.2, 0.3])
    lost = loops.triangle_sums(points, records, stride, offset, middle, is_closed, edges, sums, counts)
    return lost, sums, counts, edges


@needs_compiler
def test_records_of_stl_match_their_twin_byte_for_byte():
    points, faces = triangles()
    points[faces[7]] = [0.0, -0.0, 1e-30]  # no area: the normal is 0
    found, twin = (np.full((len(faces), 50), 255, np.uint8) for _ in range(2))
    kernels.stl_records(points, faces, found)
    triangle_twins.stl_records(points, faces, twin)
    assert np.array_equal(found, twin)
    assert not found[:, 48:].any()
    numbers = np.ascontiguousarray(found[:, :48]).view("<f4").reshape(-1, 4, 3)
    assert np.array_equal(numbers[:, 1:], points[faces].astype(np.float32))
    # unit normals, by the right-hand rule
    a, b, c = np.moveaxis(points[faces], 1, 0)
    cross = np.cross(b - a, c - a)
    length = np.linalg.norm(cross, axis=1)
    good = length > 1e-3
    assert np.abs(numbers[good, 0] - cross[good] / length[good, None]).max() < 1e-3
    assert np.array_equal(numbers[7, 0], [0, 0, 0])


@needs_compiler
@pytest.mark.parametrize("counted", [True, False])
@pytest.mark.parametrize("form", ["stl", "float32", "float64", "ply"])
def test_sums_over_triangles_match_their_twin(form, counted):
    points, faces = triangles()
    stl = np.empty((len(faces), 50), np.uint8)
    kernels.stl_records(points, faces, stl)
    ply = np.empty(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    ply["corners"] = faces
    arguments = {
        "stl": (np.empty((0, 3)), stl, 50, 12),
        "float32": (points.astype(np.float32), faces.view(np.uint8), 12, 0),
        "float64": (points, faces.view(np.uint8), 12, 0),
        "ply": (points.astype(np.float32), ply.view(np.uint8).reshape(-1, 13), 13, 1),
    }[form]
    found, twin = (sums_of(loops, *arguments, counted=counted) for loops in (kernels, triangle_twins))
    assert found[0] == twin[0] == 0
    assert np.array_equal(found[1][:6], twin[1][:6])
    assert found[1][6] == pytest.approx(twin[1][6], rel=1e-12)
    assert found[2].tolist() == twin[2].tolist()
    assert found[2][0] == 3
    assert np.array_equal(found[3], twin[3])


def tetrahedron():
    points = np.array([[0, 0, 0], [3, 0, 0], [0, 2, 0], [0, 0, 1]], np.float32)
    return points, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)


@pytest.mark.parametrize("loops", LOOPS)
def test_sums_of_a_tetrahedron(loops):
    points, faces = tetrahedron()
    lost, sums, (collapsed, edge_sum), edges = sums_of(loops, points, faces.view(np.uint8), 12, 0)
    assert (lost, collapsed, edge_sum) == (0, 0, 0)
    assert sums[:6].tolist() == [0, 0, 0, 3, 2, 1]
    assert sums[6] == pytest.approx(1)
    _, counts = np.unique(edges, return_counts=True)
    assert counts.tolist() == [2] * 6
    # -0 is 0; a face the other way round, or one too few, is noticed
    points[points == 0] = -0.0
    assert sums_of(loops, points, faces[[1, 2, 3, 0]].view(np.uint8), 12, 0)[2].tolist() == [0, 0]
    assert sums_of(loops, points, faces[1:].view(np.uint8), 12, 0)[2][1] != 0
    faces[2] = faces[2, ::-1]
    assert sums_of(loops, points, faces.view(np.uint8), 12, 0)[2][1] != 0


@pytest.mark.parametrize("loops", LOOPS)
def test_wrong_corners_and_coordinates_are_noticed(loops):
    points, faces = tetrahedron()
    faces[1, 2], faces[3, 0] = 4, -1
    lost, sums, _, _ = sums_of(loops, points, faces.view(np.uint8), 12, 0)
    assert lost == 2
    assert sums[:6].tolist() == [0, 0, 0, 3, 2, 1]
    for wrong in (np.nan, np.inf, -np.inf):
        points, faces = tetrahedron()
        points[3, 1] = wrong
        assert np.isnan(sums_of(loops, points, faces.view(np.uint8), 12, 0, is_closed=False)[1][:6]).all()


@pytest.mark.parametrize("loops", LOOPS)
def test_corners_are_marked(loops):
    marked = np.zeros(6, bool)
    loops.mark_corners(np.array([[1, 4, 2], [2, 4, 5]], np.int32), marked)
    assert marked.tolist() == [False, True, True, False, True, True]


@needs_compiler
@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (1, 2), (2, 1), (2, 3), (9, 14), (70, 33)])
def test_faces_of_pixels_match_their_twin(rows, cols):
    random = rng()
    z, inside = random.normal(size=(rows + 1, cols + 1)), random.random((rows, cols)) < 0.7
    z[random.random(z.shape) < 0.3] = 0  # ties
    for before, end in ((0, rows), (1, rows), (0, max(1, rows - 1))):
        if before >= end:
            continue
        above = z[: min(end + 2, rows + 1)]
        found, twin = (np.zeros((end - before, cols), bool) for _ in range(2))
        kernels.falling_diagonals(above, cols + 1, before, found)
        face_twins.falling_diagonals(above, cols + 1, before, twin)
        assert np.array_equal(found, twin)
    falls, count = random.random((rows, cols)) < 0.5, np.count_nonzero(inside)
    for is_back in (False, True):
        found, twin = (np.zeros((2 * count, 3), np.int32) for _ in range(2))
        assert kernels.pixel_faces(inside, falls, cols + 1, is_back, found) == count
        assert face_twins.pixel_faces(inside, falls, cols + 1, is_back, twin) == count
        assert np.array_equal(found, twin)
        # every triangle has the area of half a pixel, and the sign of its side
        y, x = np.divmod(found, cols + 1)
        area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
        assert (area == (1 if is_back else -1)).all()


@needs_compiler
def test_sizes_that_do_not_match_are_refused():
    points, faces = triangles()
    wrong = "the sizes of the arrays do not match"
    with pytest.raises(ValueError, match=wrong):
        kernels.stl_records(points, faces, np.empty((len(faces) - 1, 50), np.uint8))
    with pytest.raises(ValueError, match=wrong):
        kernels.stl_records(points[:-1], faces, np.empty((len(faces), 50), np.uint8))
    with pytest.raises(ValueError, match=wrong):
        kernels.falling_diagonals(np.zeros((3, 4)), 4, 0, np.zeros((3, 3), bool))
    with pytest.raises(ValueError, match=wrong):
        kernels.pixel_faces(np.ones((2, 3), bool), np.ones((1, 3), bool), 4, False, np.zeros((12, 3), np.int32))
    with pytest.raises(ValueError, match=wrong):
        kernels.mark_corners(faces, np.zeros(len(points) - 1, bool))
    with pytest.raises(ValueError, match=wrong):
        sums_of(kernels, points, faces.view(np.uint8), 13, 0)
    with pytest.raises(ValueError, match=wrong):
        kernels.decimal_rows(points, b"a\0b\0c\0", 8, np.empty(9999, np.uint8), np.zeros(2, np.int64))
    with pytest.raises(ValueError, match=wrong):
        kernels.read_whole_rows(b"a1b2c3\n", WORDS, 0, np.empty((1, 3), np.int32), np.array([8, 0]))
    with pytest.raises(TypeError, match=r"array 1: expected numbers of kind 'i'"):
        kernels.stl_records(points, faces.astype(np.int64), np.empty((len(faces), 50), np.uint8))


def numbers_to_write():
    """Random numbers of all sizes, halves that round to even, and those around powers of ten."""
    random, powers = rng(), 10.0 ** np.arange(-14, 12)
    around = np.concatenate([powers * factor for factor in (1, 1 - 5e-10, 1 - 4.9e-10, 1 + 5e-9, 1 - 1e-16, 1 + 3e-16)])
    special = [0.0, -0.0, 0.5, 1.5, 2.5, 5e-9, 15e-9, np.nan, np.inf, -np.inf, 5e-324, 1e300, 2**53, 999999999.5, -1e22]
    every = [
        random.normal(size=6000) * 10.0 ** random.integers(-13, 13, 6000),
        random.integers(-(10**6), 10**6, 6000) / 10.0 ** random.integers(0, 12, 6000),
        np.ldexp(random.integers(-(2**20), 2**20, 6000).astype(float), -random.integers(0, 60, 6000)),
        around,
        special,
    ]
    return np.concatenate(every)[: sum(map(len, every)) // 3 * 3].reshape(-1, 3)


@pytest.mark.parametrize("digits", [None, 0, 8, 11, 19, 25])
def test_decimals_are_written_as_python_writes_them(digits):
    values = numbers_to_write()
    form = "%.9g" if digits is None else f"%.{digits}f"
    expected = "".join(f"a{form}b{form}c{form}\n" % tuple(row) for row in values.tolist())
    assert b"".join(decimals_as_text(values, WORDS, digits)).decode() == expected


def test_whole_numbers_are_written_as_python_writes_them():
    values = np.array([[0, 9, 10], [-1, 2**31 - 1, -(2**31)], [99, 100, 12345]], np.int32)
    expected = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in values.tolist())
    assert b"".join(wholes_as_text(values, words_of("f # # #\n"), 1)).decode() == expected


def read(loops, text, words, kind, first=0, begin=0, most=1000):
    out, state = np.full((most, 3), -7, kind), np.array([begin, 0])
    loop = loops.read_whole_rows if kind is np.int32 else loops.read_decimal_rows
    loop(text, words, first, out, state)
    return out[: state[1]].tolist(), int(state[0])


@pytest.mark.parametrize("loops", TEXT_LOOPS)
def test_rows_are_read_until_one_has_another_form(loops):
    text = b"<a1b2c-3>\n<a4b5c6>\nother\n<a7b8c9>\n"
    words = words_of("<a#b#c#>\n")
    assert read(loops, text, words, np.int32) == ([[1, 2, -3], [4, 5, 6]], 19)
    assert read(loops, text, words, np.int32, first=1, begin=10) == ([[3, 4, 5]], 19)
    assert read(loops, text, words, np.int32, begin=19) == ([], 19)
    assert read(loops, text, words, np.int32, most=1) == ([[1, 2, -3]], 10)
    numbers = b"<a1.5b-0.25c1e-05>\n<a-1.25e+02b0c12345678.125>\n"
    assert read(loops, numbers, words, np.float64) == ([[1.5, -0.25, 1e-5], [-125, 0, 12345678.125]], len(numbers))


@needs_compiler
@pytest.mark.parametrize("bad", ["", "-", ".5", "1.", "1e", "nan", "0x1", "1 ", "+1", "1e99", "1" * 30])
def test_what_the_loop_does_not_read_ends_the_rows(bad):
    text = f"a1b2c3\na1b{bad}c3\n".encode()
    assert read(kernels, text, WORDS, np.float64) == ([[1, 2, 3]], 7)


@needs_compiler
def test_decimals_come_back_to_the_last_place_but_two():
    values = rng().normal(size=(5000, 3)) * 10.0 ** rng().integers(-13, 13, (5000, 3))
    text = b"".join(decimals_as_text(values, WORDS))
    exact = np.array([[float(f"{value:.9g}") for value in row] for row in values.tolist()])
    found, end = read(kernels, text, WORDS, np.float64, most=5000)
    assert end == len(text)
    assert np.abs(np.array(found) / exact - 1).max() < 5e-16
    twin, _ = read(text_twins, text, WORDS, np.float64, most=5000)
    assert np.array_equal(twin, exact)
