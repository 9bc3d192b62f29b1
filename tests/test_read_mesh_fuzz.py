"""Damaged mesh files: each gives a valid mesh or a one-line error, and no reader fails in an unforeseen way."""

import re

import mesh_files as files
import numpy as np
import pytest
from mesh_files import FACES, VERTICES

from nmaptool.core.errors import NmaptoolError
from nmaptool.io.meshes.headers import identify_mesh_file
from nmaptool.io.meshes.reader import _READERS, read_mesh

# what readers may raise for a damaged file besides our own errors; `read_mesh` adds the message
FORESEEN = (NmaptoolError, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
POLYGONS = [*FACES.tolist(), [0, 1, 2, 3], [3, 2, 1, 0, 1]]
CASES = {
    **{f"a.{ending}": data for ending, data in files.good().items()},
    "b.stl": files.ascii_stl(),
    "b.ply": files.ply(VERTICES, POLYGONS, kind="ascii"),
    "c.ply": files.ply(VERTICES, POLYGONS, kind="binary_big_endian"),
    "b.off": files.off(VERTICES, POLYGONS),
    "b.obj": files.obj(VERTICES, POLYGONS) + b"f -1/2/3 -2//1 -3\\\n -4 # note\nv 0 nan 1 1 1\nf 1 5 -1\n",
}
WORDS = [b"0", b"-1", b"-0", b"4", b"nan", b"-inf", b"1e400", b"9" * 25, b"x", b"", b"1.5", b"#", b"/", b"\\\n", b"\r"]
WORDS += [b"v", b"f", b"vertex", b"endfacet", b"endsolid", b"null", b"[]", b"{}", b'"a"', b"\xb2", b"\0", b"\f"]


def damaged(data, rng):
    """Damage data by one to three of: truncation, a flipped bit, a replaced word, lines or bytes lost or doubled."""
    for _ in range(rng.integers(1, 4)):
        at, length = int(rng.integers(max(len(data), 1))), int(rng.integers(1, 30))
        lines = data.split(b"\n")
        kind = rng.integers(7)
        if kind == 0:
            data = data[:at]
        elif kind == 1 and data:
            data = data[:at] + bytes([data[at] ^ 1 << int(rng.integers(8))]) + data[at + 1 :]
        elif kind in (2, 3) and (word := re.compile(rb"[^\s,:/\[\]{}]+").search(data, at)):
            data = data[: word.start()] + WORDS[rng.integers(len(WORDS))] + data[word.end() :]
        elif kind == 4:
            lines[at % len(lines)] *= int(rng.integers(2))
            data = b"\n".join(lines + lines[at % len(lines) :][: rng.integers(2)])
        else:
            data = data[: at + length * (kind == 5)] + data[at + length * (kind == 6) :]
    return data


@pytest.mark.parametrize("name", CASES)
def test_damaged_files_give_a_mesh_or_an_error(tmp_path, name):
    rng = np.random.default_rng(sum(name.encode()))
    path = tmp_path / name
    outcomes = set()
    for _ in range(120):
        path.write_bytes(damaged(CASES[name], rng))
        try:
            mesh = read_mesh(path, max_faces=50)
        except NmaptoolError as error:
            assert re.fullmatch(rf"{re.escape(str(path))}: [^\n]+", str(error))
            outcomes.add("error")
        else:
            assert len(mesh.faces) <= 50
            assert mesh.faces.min() >= 0
            assert mesh.faces.max() < len(mesh.vertices)
            outcomes.add("mesh")
        with np.errstate(all="ignore"):
            try:
                _READERS[name[2:]](identify_mesh_file(path), 50)
            except FORESEEN:
                outcomes.add("refused")
    assert outcomes == {"error", "mesh", "refused"}
