"""The view of the studio: its modules under node, where they need no browser."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import nmaptool as nm

STAGE = Path(nm.__file__).parent / "studio" / "page" / "stage"
pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


@pytest.fixture
def node(tmp_path):
    """A function that runs a script beside the modules of the stage and returns what it prints as JSON."""
    page = tmp_path / "page"
    shutil.copytree(STAGE.parent, page)
    (page / "package.json").write_text('{"type": "module"}', encoding="utf-8")

    def run(script):
        (page / "stage" / "run.js").write_text(script, encoding="utf-8")
        done = subprocess.run(["node", "stage/run.js"], cwd=page, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


CAMERA = """
import { Camera } from "./camera.js";
const camera = new Camera();
camera.full = [400, 300];
camera.resize(900, 600);
const seen = {};
for (const orbits of [false, true]) {
  camera.orbits = orbits;
  camera.reset();
  camera.orbit(35, 10);
  const corners = [[0, 0], [400, 0], [0, 300], [400, 300]];
  camera.fit();
  const fitted = corners.map(([x, y]) => camera.toScreen(x, y));
  const before = camera.onPlane(200, 250);
  camera.zoomAt(200, 250, 3);
  const after = camera.onPlane(200, 250);
  camera.pan(31, -17);
  const moved = camera.toScreen(before.x, before.y);
  const back = corners.map(([x, y]) => {
    const { x: u, y: v } = camera.toScreen(x, y);
    return camera.onPlane(u, v);
  });
  seen[orbits] = { fitted, before, after, moved, back };
}
console.log(JSON.stringify(seen));
"""


@pytest.mark.parametrize("view", ["false", "true"])
def test_the_camera_goes_from_the_map_to_the_screen_and_back(node, view):
    seen = node(CAMERA)[view]
    xs, ys = ([place[axis] for place in seen["fitted"]] for axis in "xy")
    assert min(xs) >= 0
    assert max(xs) <= 900
    assert min(ys) >= 0
    assert max(ys) <= 600
    assert max((max(xs) - min(xs)) / 900, (max(ys) - min(ys)) / 600) > 0.85  # the map fills the picture
    for place, corner in zip(seen["back"], [[0, 0], [400, 0], [0, 300], [400, 300]], strict=True):
        assert [place["x"], place["y"]] == pytest.approx(corner, abs=1e-6)
    if view == "false":  # what is under the pointer stays there while it zooms
        assert seen["after"] == pytest.approx(seen["before"])
        assert seen["moved"] == pytest.approx({"x": 231, "y": 233})


def test_the_turned_view_finds_the_surface_and_the_matrix_agrees(node):
    found = node("""
import { Camera } from "./camera.js";
const camera = new Camera();
camera.full = [400, 300];
camera.orbits = true;
camera.resize(900, 600);
const heightAt = (x, y) => (x > 150 && x < 250 && y > 100 && y < 200 ? 60 : 0);
const top = camera.toScreen(200, 150, 60);
const place = camera.onSurface(top.x, top.y, heightAt, 0, 60);
const plane = camera.onPlane(top.x, top.y, 0);
const m = camera.matrix();
const clip = [0, 1, 2, 3].map((row) => m[row] * 200 + m[4 + row] * 150 + m[8 + row] * 60 + m[12 + row]);
const drawn = { x: 450 + (450 * clip[0]) / clip[3], y: 300 - (300 * clip[1]) / clip[3] };
console.log(JSON.stringify({ place, plane, top, drawn, depth: clip[2] / clip[3] }));
""")
    assert found["place"] == pytest.approx({"x": 200, "y": 150}, abs=0.01)
    assert abs(found["plane"]["y"] - 150) > 30  # on the plate the same line of sight is elsewhere
    assert found["drawn"] == pytest.approx(found["top"], abs=0.01)
    assert -1 < found["depth"] < 1


def test_a_light_is_where_its_knob_is(node):
    found = node("""
import { Camera } from "./camera.js";
import { anglesOf, another, directionAt } from "./lights.js";
import { dot } from "./camera.js";
import { toLight } from "./view.js";
const camera = new Camera();
camera.full = [400, 300];
const turned = [];
for (const orbits of [false, true]) {
  camera.orbits = orbits;
  const axes = camera.axes();
  for (const light of [{ azimuth: 135, elevation: 30 }, { azimuth: 300, elevation: 60 }]) {
    const direction = toLight(light);
    const place = [dot(axes.right, direction), dot(axes.up, direction)];
    const near = toLight({ azimuth: light.azimuth + 20, elevation: light.elevation - 10 });
    turned.push(anglesOf(directionAt(...place, axes, near)));
  }
}
const low = anglesOf(directionAt(0, -5, camera.axes(), [0, 0, 1]));
const up = toLight({ azimuth: 90, elevation: 0 });
console.log(JSON.stringify({ turned, low, up, second: another([{ azimuth: 300 }]) }));
""")
    for angles, wanted in zip(found["turned"], [(135, 30), (300, 60)] * 2, strict=True):
        assert (angles["azimuth"], angles["elevation"]) == pytest.approx(wanted, abs=1e-6)
    assert found["low"]["elevation"] >= 3
    assert found["up"] == pytest.approx([0, -1, 0])
    assert 0 <= found["second"]["azimuth"] < 360


def test_heights_are_read_in_mm_at_places_of_the_full_map(node):
    found = node("""
import { heightAt } from "./view.js";
const cols = 5, rows = 3;
const z = Float32Array.from({ length: 15 }, (_, i) => 2 * (i % cols) + 10 * Math.floor(i / cols));
const surface = new Uint8Array(15).fill(1);
const relief = { cols, rows, z, surface, pitch: 0.5, full: [40, 20] };
const inside = heightAt(relief, 25, 5);
surface[14] = 0;
console.log(JSON.stringify({ inside, hole: heightAt(relief, 39, 19), out: heightAt(relief, 41, 5) }));
""")
    assert found == {"inside": 0.5 * (2 * 2.5 + 10 * 0.5), "hole": None, "out": None}


@pytest.mark.parametrize(("span", "step"), [(12.0, 1), (0.7, 0.05), (90, 10), (1e-9, None)])
def test_contour_lines_are_at_round_heights(node, span, step):
    found = node(f'import {{ contourStep }} from "./scales.js"; console.log(JSON.stringify(contourStep({span})));')
    assert found > 0
    if step is not None:
        assert found == pytest.approx(step)
        assert 5 < span / found <= 15


def test_ticks_and_numbers_are_round(node):
    found = node("""
import { mmText, ticks } from "./scales.js";
console.log(JSON.stringify({ ticks: [ticks(-0.3, 1.02, 6), ticks(0, 61.2, 6), ticks(3, 3, 4)],
  texts: [mmText(1.23456, 0.01), mmText(-0.0001, 0.001), mmText(12, 5), mmText(0.5, 0.5)] }));
""")
    assert found["ticks"][0] == pytest.approx([0, 0.5, 1.0])
    assert found["ticks"][1] == [0, 20, 40, 60]
    assert found["ticks"][2] == [3]
    assert found["texts"] == ["1.23", "0.000", "12", "0.5"]


def test_a_section_has_the_heights_along_its_line(node):
    found = node("""
import { factorText, layout, pathOf, rangeOf, sampled } from "./section.js";
const { length, points } = sampled([10, 20], [40, 60], (x, y) => (x > 30 ? NaN : x / 10), 0.2, 101);
const range = rangeOf(points.map(({ height }) => height));
const plan = layout({ width: 560, height: 250, length, range });
console.log(JSON.stringify({ length, first: points[0], count: points.length, range, plan,
  ends: [plan.x(0), plan.x(length), plan.y(range[0]), plan.y(range[1])],
  path: pathOf([{ along: 0, height: 1 }, { along: 1, height: NaN }, { along: 2, height: 1 }, { along: 3, height: 2 }],
    (along) => along, (height) => height),
  nothing: rangeOf([NaN]), factors: [factorText(0.234), factorText(12.4)] }));
""")
    assert found["length"] == pytest.approx(50 * 0.2)
    assert found["first"] == {"x": 10, "y": 20, "along": 0, "height": 1}
    assert found["count"] == 101
    low, high = found["range"]
    assert low < 1
    assert high > 3
    assert found["ends"] == pytest.approx([46, 546, 218, 18])
    plan = found["plan"]
    assert plan["exaggeration"] == pytest.approx((200 / (high - low)) / (500 / found["length"]))
    assert [text for _, text in plan["lengths"]][:2] == ["0", "2"]
    assert found["path"] == "M0.00 1.00M2.00 1.00L3.00 2.00"
    assert found["nothing"] is None
    assert found["factors"] == ["0.23", "12"]


def test_legends_say_what_the_colours_mean(node):
    found = node("""
import { legendOf, steepShare } from "./legend.js";
import { OVERLAYS } from "./materials.js";
const cols = 12, rows = 10;
// the left half is level, the right half rises by 2 px per px
const z = Float32Array.from({ length: cols * rows }, (_, i) => 2 * Math.max((i % cols) - 6, 0));
const relief = { z, surface: new Uint8Array(cols * rows).fill(1), cols, rows, low: -0.2, high: 7.1, pitch: 0.5 };
const legends = Object.fromEntries(Object.entries(OVERLAYS).map(([name, n]) => [name, legendOf(n, relief, 30)]));
console.log(JSON.stringify({ legends, share: steepShare(relief, Math.sqrt(3)) }));
""")
    legends = found["legends"]
    assert legends["none"] is None
    heights = legends["heights and contours"]
    assert "a line every 0.5 mm" in heights["title"]
    assert [text for _, text in heights["numbers"]] == ["0", "2", "4", "6"]
    assert heights["numbers"][1][0] == pytest.approx(2.2 / 7.3)
    assert legends["slope"]["numbers"][3] == [0.5, "45"]
    assert found["share"] == pytest.approx(0.4)
    assert "40.0 % of the surface has less than 30 degrees" in legends["draft angle"]["title"]
    assert legends["draft angle"]["marks"][0][1] == "steeper than 60 degrees"
    assert [text for _, text in legends["curl"]["numbers"]] == ["0.001", "0.01", "0.1", "1"]


def test_the_scales_rise_in_lightness(node):
    found = node("""
import { colourAt, palette, SCALES } from "./materials.js";
const lightness = (scale) => Array.from({ length: 30 }, (_, i) => {
  const [r, g, b] = colourAt(scale, i / 29).map((value) => (value / 255) ** 2.2);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
});
const { pixels } = palette();
const last = Array.from(pixels.slice(4 * 255, 4 * 256));
console.log(JSON.stringify({ scales: Object.keys(SCALES).map(lightness), last, white: colourAt("height", 2) }));
""")
    for lightness in found["scales"]:
        assert lightness == sorted(lightness)
    assert found["last"][:2] == [255, round(255 * (0xF7 / 255) ** 2.2)]
    assert found["white"] == [255, 247, 214]


def test_settings_that_are_not_sensible_are_left_out(node):
    found = node("""
import { read, sensible, write } from "./settings.js";
const light = { azimuth: 10, elevation: 40, strength: 1, more: 1 };
const blocked = read(); // there is no storage here
write({ material: "clay" });
const lights = [light, { azimuth: 3 }, light, light, light];
const wrong = sensible({ material: "gold", overlay: 99, draft: 200, lights: [] });
const right = sensible({ material: "bronze", overlay: 2, shadows: false, draft: 5, lights });
console.log(JSON.stringify([blocked, sensible(null), wrong, right]));
""")
    assert found[:3] == [{}, {}, {}]
    assert found[3] == {
        "material": "bronze",
        "overlay": 2,
        "shadows": False,
        "draft": 5,
        "lights": [{"azimuth": 10, "elevation": 40, "strength": 1}] * 3,
    }


def test_the_mesh_has_two_triangles_for_each_cell(node):
    found = node("""
import { triangles } from "./renderer.js";
console.log(JSON.stringify(Array.from(triangles(4, 3))));
""")
    assert len(found) == 3 * 2 * 3 * 2
    assert set(found) == set(range(12))
    corners = [found[i : i + 3] for i in range(0, len(found), 3)]
    sides = [((b % 4 - a % 4, b // 4 - a // 4), (c % 4 - a % 4, c // 4 - a // 4)) for a, b, c in corners]
    area = sum(abs(u[0] * v[1] - v[0] * u[1]) / 2 for u, v in sides)
    assert area == 6


def test_heights_off_the_surface_neither_bend_its_edge_nor_cast_shadows(node):
    found = node("""
import { close } from "./relief.js";
const z = Float32Array.from([5, 99, 99, 99, 7, 99, 99, 99]);
const surface = Uint8Array.from([1, 0, 0, 0, 1, 0, 0, 0]);
const closed = new Float32Array(8);
close({ z, surface, cols: 4, rows: 2, lowPx: -1 }, closed);
console.log(JSON.stringify(Array.from(closed)));
""")
    assert found == [5, 6, -1, -1, 7, 6, -1, -1]


def test_the_bytes_of_an_overlay_are_read(node):
    found = node("""
import { unpacked } from "./map_layers.js";
const bytes = new Uint8Array([3, 0, 0, 0, 2, 0, 0, 0, 1, 2, 3, 4, 5, 255]);
const { width, height, values } = unpacked(bytes.buffer);
console.log(JSON.stringify({ width, height, values: Array.from(values) }));
""")
    assert found == {"width": 3, "height": 2, "values": [1, 2, 3, 4, 5, 255]}


def test_every_uniform_of_a_shader_is_given_a_value():
    texts = {path.name: path.read_text(encoding="utf-8") for path in STAGE.glob("*.js")}
    shaders = "".join(texts[name] for name in ("passes.js", "shading.js", "shaders.js"))
    setters = texts["renderer.js"] + texts["relief.js"]
    for name in set(re.findall(r"uniform \w+ (\w+)", shaders)):
        assert re.search(rf"\b{name}\b", setters), name
