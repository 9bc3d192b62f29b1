"""Concave polygons read from files."""

import numpy as np
import pytest

from nmaptool.io.meshes.reader import read_mesh

ELL = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], float)
DART = np.array([(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)])
TURN = np.arange(14) * np.pi / 7
STAR = np.stack([np.cos(TURN), np.sin(TURN)], axis=1) * np.where(np.arange(14) % 2, 0.3, 1.0)[:, None]


def written(path, points, faces):
    """Write polygons to a file in the format of its ending."""
    rows = [" ".join(map(repr, map(float, point))) for point in points]
    numbers = [" ".join(map(str, face)) for face in faces]
    if path.suffix == ".obj":
        lines = [f"v {row}" for row in rows] + ["f " + " ".join(str(n + 1) for n in face) for face in faces]
    else:
        lists = [f"{len(face)} {text}" for face, text in zip(faces, numbers, strict=True)]
        head = ["OFF", f"{len(rows)} {len(lists)} 0"]
        if path.suffix == ".ply":
            head = ["ply", "format ascii 1.0", f"element vertex {len(rows)}"]
            head += [f"property double {axis}" for axis in "xyz"]
            head += [f"element face {len(lists)}", "property list uchar int vertex_indices", "end_header"]
        lines = [*head, *rows, *lists]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("kind", [".obj", ".ply", ".off"])
@pytest.mark.parametrize("outline", [ELL, DART, STAR], ids=["ell", "dart", "star"])
@pytest.mark.parametrize("shift", [0, 2])
def test_concave_polygons_are_cut_inside(tmp_path, kind, outline, shift):
    """No triangle is outside or flipped, whichever corner comes first in the file, in a tilted plane, too."""
    flat = np.roll(outline, shift, axis=0)
    n = len(flat)
    points = np.vstack([flat @ [[1, 0, 0.5], [0, 1, -2.0]], [[9, 9, 9], [10, 9, 9], [9, 10, 9]]])
    mesh = read_mesh(written(tmp_path / f"p{kind}", points, [range(n), range(n, n + 3)]))
    assert len(mesh.faces) == n - 1
    a, b, c = (mesh.vertices[mesh.faces[:-1, k]][:, :2] for k in range(3))
    twice = np.linalg.det(np.stack([b - a, c - a], axis=1))
    x, y = flat.T
    assert (twice > -1e-9).all()
    assert twice.sum() == pytest.approx(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert set(mesh.faces[:-1].ravel()) == set(range(n))
    assert mesh.faces[-1].tolist() == [n, n + 1, n + 2]


def test_polygons_without_a_valid_cut_become_fans(tmp_path):
    """A polygon that intersects itself, and polygons with a nonfinite corner."""
    points = [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1.5, 0], [np.nan, 0, 0], [np.inf, 1, 0]]
    mesh = read_mesh(written(tmp_path / "p.ply", points, [[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]]))
    assert len(mesh.faces) == 6
    assert mesh.faces[2:].tolist() == [[0, 1, 2], [0, 2, 4], [0, 1, 2], [0, 2, 5]]
