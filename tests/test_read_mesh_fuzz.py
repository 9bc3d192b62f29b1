"""Damaged mesh files: each gives a valid mesh or a one-line error, and no reader fails in an unforeseen way."""

import json
import re

import mesh_files as files
import numpy as np
import pytest
from gltf_cases import Builder
from mesh_files import FACES, VERTICES
from package_cases import threemf
from test_read_dae import dae
from test_read_usd import HEAD, MESH

from nmaptool.core.errors import NmaptoolError
from nmaptool.io.meshes.headers import identify_mesh_file
from nmaptool.io.meshes.reader import _READERS, read_mesh

# what readers may raise for a damaged file besides our own errors; `read_mesh` adds the message
FORESEEN = (NmaptoolError, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
POLYGONS = [*FACES.tolist(), [0, 1, 2, 3], [3, 2, 1, 0, 1]]


def rich_scene():
    """A scene with sparse, normalised and skinned positions, morph targets, instances, a fan and a strip."""
    made = Builder()
    indices = made.add(FACES.ravel(), "u1")
    targets = [{"POSITION": made.sparse(4, [1, 2], VERTICES[:2])}]
    sparse = {"attributes": {"POSITION": made.sparse(4, [0, 3], VERTICES[2:], VERTICES)}, "indices": indices}
    codes = made.add(VERTICES * 30, "i1", normalized=True)
    joints = {
        "JOINTS_0": made.add(np.zeros((4, 4)), "u1"),
        "WEIGHTS_0": made.add(np.eye(4) * 255, "u1", normalized=True),
    }
    inverse = made.add(np.tile(np.eye(4), (2, 1, 1)).reshape(2, 4, 4))
    meshes = [
        {"primitives": [{**sparse, "targets": targets}], "weights": [0.5]},
        {"primitives": [{"attributes": {"POSITION": codes, **joints}, "indices": indices}]},
        {
            "primitives": [
                {"attributes": {"POSITION": codes}, "mode": 6},
                {"attributes": {"POSITION": codes}, "mode": 5},
            ]
        },
    ]
    places = {"TRANSLATION": made.add(VERTICES), "ROTATION": made.add(np.eye(4))}
    nodes = [
        {"children": [1, 2, 3, 4], "scale": [1, 2, -1]},
        {"mesh": 0, "weights": [1]},
        {"mesh": 1, "skin": 0},
        {"mesh": 2, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": places}}},
        {"rotation": [0, 0, 0.6, 0.8]},
    ]
    skins = [{"joints": [0, 4], "inverseBindMatrices": inverse}]
    return made.content(nodes, meshes=meshes, skins=skins)


CASES = {
    **{f"a.{ending}": data for ending, data in files.good().items()},
    "b.stl": files.ascii_stl(),
    "b.ply": files.ply(VERTICES, POLYGONS, kind="ascii"),
    "c.ply": files.ply(VERTICES, POLYGONS, kind="binary_big_endian"),
    "b.off": files.off(VERTICES, POLYGONS),
    "r.glb": files.glb(rich_scene()),
    "r.gltf": files.gltf(rich_scene()),
    "w.ply": files.ply(VERTICES, POLYGONS, kind="ascii")
    .replace(b"\n3 ", b"\n3 0 1 2 9\n3 ", 1)
    .replace(b"\n4 ", b" 7 7\n4 "),
    "a.3mf": threemf(),
    "a.dae": dae(),
    "a.usd": (HEAD + MESH).encode(),
    "b.obj": files.obj(VERTICES, POLYGONS) + b"f -1/2/3 -2//1 -3\\\n -4 # note\nv 0 nan 1 1 1\nf 1 5 -1\n",
}
WORDS = [b"0", b"-1", b"-0", b"4", b"nan", b"-inf", b"1e400", b"9" * 25, b"x", b"", b"1.5", b"#", b"/", b"\\\n", b"\r"]
WORDS += [b"1,5", b"1d5", b"1.#IND", b"99999", b"true", b"4294967295"]
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
    assert outcomes - {"refused"} == {"error", "mesh"}


def damaged_value(value, rng):
    """Another value for one number, list or name in the JSON of a scene."""
    other = [0, 1, -1, 3, 2**31, 10**18, 1.5, float("nan"), None, True, "x", [], {}, [0], value, [value, value]]
    return other[rng.integers(len(other))]


def places_in(tree):
    """Every place in some JSON, as the container and the key."""
    keys = range(len(tree)) if isinstance(tree, list) else list(tree)
    for key in keys:
        yield tree, key
        if isinstance(tree[key], dict | list):
            yield from places_in(tree[key])


def test_damaged_scenes_give_a_mesh_or_an_error(tmp_path, trials):
    rng = np.random.default_rng(11)
    path = tmp_path / "a.glb"
    outcomes = set()
    content, data = rich_scene()
    for _ in range(trials(8000)):
        tree = json.loads(json.dumps(content))
        for _ in range(rng.integers(1, 3)):
            places = list(places_in(tree))
            container, key = places[rng.integers(len(places))]
            container[key] = damaged_value(container[key], rng)
        path.write_bytes(files.glb((tree, data[: rng.integers(len(data))] if rng.integers(9) == 0 else data)))
        try:
            mesh = read_mesh(path, max_faces=50)
        except NmaptoolError as error:
            assert re.fullmatch(rf"{re.escape(str(path))}: [^\n]+", str(error))
            outcomes.add("error")
        else:
            assert 0 < len(mesh.faces) <= 50
            outcomes.add("mesh")
        with np.errstate(all="ignore"):
            try:
                _READERS["glb"](identify_mesh_file(path), 50)
            except FORESEEN:
                outcomes.add("refused")
    assert outcomes == {"error", "mesh", "refused"}


def test_buffers_beside_a_scene_truncated_at_any_byte_are_refused(tmp_path, trials):
    content, data = rich_scene()
    content["buffers"] = [{"uri": "a.bin", "byteLength": len(data)}]
    (tmp_path / "a.gltf").write_text(json.dumps(content), encoding="utf-8")
    for length in range(0, len(data) + 1, len(data) // trials(len(data))):
        (tmp_path / "a.bin").write_bytes(data[:length])
        try:
            read_mesh(tmp_path / "a.gltf")
            assert length == len(data)
        except NmaptoolError as error:
            assert f"a.bin is truncated: it should hold {len(data)} bytes but holds {length}" in str(error)
