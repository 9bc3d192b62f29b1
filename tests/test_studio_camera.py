"""The camera panel of the page sees a mesh as a bake does."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mesh_cases import sheet, sphere

import nmaptool as nm
from nmaptool.options.bake import VIEWS
from nmaptool.render.camera import frame_camera, view_rotation
from nmaptool.studio.meshes.display_mesh import display_mesh, thinned
from nmaptool.studio.meshes.hull import hull

PAGE = Path(nm.__file__).parent / "studio" / "page"
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
SCRIPT = """
import { readFileSync } from "node:fs";
import { clipMatrix, frameCamera, lengthOf, sizeOf } from "./mesh/camera.js";
import { decodeMesh } from "./mesh/display.js";
import { dragged, wrapped } from "./mesh/orbit.js";
const bytes = readFileSync("mesh.bin");
const mesh = decodeMesh(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const cases = JSON.parse(readFileSync("cases.json"));
const found = cases.map(([options, mm]) => {
  const camera = frameCamera(mesh.corners, options, mm);
  return camera && { ...camera, clip: Array.from(clipMatrix(camera, mesh.header.origin)) };
});
const turned = [[0, 90, 0, 100, 0], [170, 0, 0, -50, 0], [0, 0, 90, 0, 100]].map(([azimuth, elevation, roll, x, y]) =>
  dragged({ azimuth, elevation, roll }, x, y));
const texts = [sizeOf("1000x900"), sizeOf("0x3"), sizeOf("wide"), lengthOf(" 4 %"), lengthOf("4")];
const around = [-190, 540, 359.96].map(wrapped);
console.log(JSON.stringify({ found, positions: Array.from(mesh.positions), turned, texts, around }));
"""
CASES = [
    {"view": "front"},
    {"view": "iso", "size": "60x90", "margin": "3px"},
    {"view": "top", "up": "z", "roll": 30.0},
    {"azimuth": -37.5, "elevation": 22.0, "roll": -75.0, "size": "120x40"},
    {"view": "back", "fov": 35.0, "size": "50x70"},
    {"azimuth": 110.0, "elevation": -50.0, "fov": 90.0, "up": "z", "margin": "10%"},
    {"view": "left", "pitch": "0.02mm", "target": "0.5,-0.2,0.1"},
    {"view": "left", "pitch": "0.02mm", "target": "0.5,-0.2,0.1", "fov": 50.0},
    {"view": "right", "width": "50mm"},
]


def page_options(case):
    """The options as the panel holds them."""
    default = {name: None if value is None else str(value) for name, value in vars(nm.BakeOptions()).items()}
    azimuth, elevation = VIEWS[case.get("view", "front")]
    numbers = {"azimuth": azimuth, "elevation": elevation, "roll": 0.0, "fov": 0.0}
    return {**default, **numbers, **case}


@needs_node
def test_the_page_frames_a_mesh_like_a_bake(tmp_path):
    ball = sphere(9)
    vertices = ball.vertices * (1.0, 1.6, 0.7) + (900.0, -20.0, 3.0) + 0.1 * np.sin(5 * ball.vertices[:, ::-1])
    mesh = nm.Mesh(vertices, ball.faces, mm_per_unit=2.0)
    cases = [{**case, "target": "900.5,-20.2,3.1"} if "target" in case else case for case in CASES]
    (tmp_path / "mesh.bin").write_bytes(display_mesh(mesh, {}, hull(vertices)))
    (tmp_path / "cases.json").write_text(json.dumps([(page_options(case), 2.0) for case in cases]), encoding="utf-8")
    shutil.copytree(PAGE / "mesh", tmp_path / "mesh")
    (tmp_path / "package.json").write_text('{"type": "module"}', encoding="utf-8")
    (tmp_path / "run.js").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run(["node", "run.js"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    local = np.reshape(said["positions"], (-1, 3)).astype(np.float64)
    assert np.abs(local + (low + high) / 2 - vertices).max() < 1e-6
    for case, found in zip(cases, said["found"], strict=True):
        lengths = {name: nm.length(case[name]) for name in ("margin", "pitch", "width") if name in case}
        options = nm.BakeOptions(**{**case, **lengths})
        camera = frame_camera(mesh, options, *options.directions[0])
        assert np.allclose(np.reshape(found["rotation"], (3, 3)), camera.rotation, atol=1e-12)
        assert np.allclose(found["center"], camera.center, rtol=1e-9, atol=1e-9)
        assert found["unitPerPx"] == pytest.approx(camera.unit_per_px, rel=1e-9)
        assert (found["distance"] is None) == (camera.distance is None)
        clip = np.column_stack([local, np.ones(len(local))]) @ np.reshape(found["clip"], (4, 4))
        at = camera.project(vertices)
        across = clip[:, :2] / clip[:, 3:]
        assert np.allclose(camera.cols * (1 + across[:, 0]) / 2, at[:, 0], atol=2e-3)
        assert np.allclose(camera.rows * (1 - across[:, 1]) / 2, at[:, 1], atol=2e-3)
        depth = clip[:, 2] / clip[:, 3]
        assert np.abs(depth).max() < 1
        assert np.array_equal(np.argsort(-depth)[:1], np.argsort(at[:, 2])[:1]) or np.ptp(at[:, 2]) < 1e-6
    assert said["texts"] == [{"cols": 1000, "rows": 900}, None, None, {"number": 4, "unit": "%"}, None]
    assert said["around"] == [170, -180, 0]
    assert said["turned"] == [
        {"azimuth": -40, "elevation": 90},
        {"azimuth": -170, "elevation": 0},
        {"azimuth": 40, "elevation": 0},
    ]


def test_the_hull_frames_a_mesh_from_everywhere():
    points = sheet(lambda x, y: np.sin(3 * x) * np.cos(2 * y), 20, 30, 0.2).vertices
    flat = points * (1, 1, 0) @ view_rotation(30, 40, 50, "y")
    line = flat * (1, 0, 0)
    for given, most in ((points, 200), (flat, 4), (line, len(line))):
        corners = hull(given)
        assert len(corners) <= most
        for azimuth in range(0, 360, 50):
            rotation = view_rotation(azimuth, azimuth / 3 - 60, 10, "y")
            for side in ("min", "max"):
                exact = getattr(given @ rotation.T, side)(axis=0)
                assert np.allclose(getattr(corners @ rotation.T, side)(axis=0), exact, atol=1e-9)


def test_the_hull_of_a_large_mesh_frames_it_nearly(monkeypatch):
    ball = sphere(60).vertices
    spiky = ball.copy()
    spiky[::50] *= 1.3
    monkeypatch.setattr("nmaptool.studio.meshes.hull._MANY", 10_000)
    monkeypatch.setattr("nmaptool.studio.meshes.hull._DIRECTIONS", 32)
    for points, error in ((ball, 4e-3), (spiky, 1e-12), (ball * (3, 1, 1), 0.012), (ball * (1, 1, 0), 1e-12)):
        corners = hull(points)
        assert len(corners) < 7000
        for azimuth in range(0, 360, 25):
            rotation = view_rotation(azimuth, azimuth / 3 - 60, 10, "y")
            exact = (points @ rotation.T).max(axis=0)
            assert np.abs((corners @ rotation.T).max(axis=0) - exact).max() <= error


def test_large_meshes_are_thinned_for_the_page():
    ball = sphere(60)
    assert thinned(ball.vertices, ball.faces, len(ball.faces))[1] is ball.faces
    for most in (20_000, 3_000, 200):
        vertices, faces = thinned(ball.vertices, ball.faces, most)
        assert 0.4 * most < len(faces) <= most
        assert len(np.unique(np.sort(faces, axis=1), axis=0)) == len(faces)
        assert faces.max() < len(vertices)
        if most > 1000:
            assert np.linalg.norm(vertices, axis=1).min() > 0.98
            areas = nm.Mesh(vertices, faces).geometry.areas
            assert areas.sum() == pytest.approx(ball.geometry.areas.sum(), rel=0.03)
