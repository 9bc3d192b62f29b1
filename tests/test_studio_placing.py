"""The page's geometry of layers under node: it gives the keys that put a layer where the library then finds it."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.composition.placing import matrix_of

PAGE = Path(nm.__file__).parent / "studio" / "page"
pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")

FRAME = nm.Frame(400, 600, 0.5)
COLS, ROWS = 90, 70
SCRIPT = """
import { readFileSync } from "node:fs";
import { keysFor, moved, snap, stretched, turned, shareAt, pointAt } from "./placing.mjs";
const cases = JSON.parse(readFileSync("cases.json"));
const acts = {
  move: (box, [dx, dy]) => moved(box, dx, dy),
  turn: (box, [x, y, degrees]) => turned(box, [x, y], degrees),
  stretch: (box, [x, y, across, down]) => stretched(box, [x, y], across, down),
};
const found = cases.map(({ box, options, act, by }) => {
  const after = acts[act](box, by);
  const keys = keysFor(box, after, options, { cols: 600, rows: 400 });
  return { matrix: after.matrix, keys, share: shareAt(after, ...pointAt(after, [0.2, 0.7])) };
});
const snaps = [snap([10, 20, 30], [0, 24, 40], 5), snap([10], [16], 5), snap([1, 39], [0, 40], 5)];
console.log(JSON.stringify({ found, snaps }));
"""


def box_of(options):
    """The box of a layer, as the server sends it."""
    flat = np.full((ROWS, COLS, 3), (0, 0, 1), np.float32)
    matrix = matrix_of(nm.Layer(flat, nm.LayerOptions(**options)), FRAME)
    return {"cols": COLS, "rows": ROWS, "matrix": matrix.tolist()}


STARTS = [
    {},
    {"at": "30%,40%", "rotate": 25.0},
    {"at": "100px,80px", "anchor": "top-left", "scale": "0.5,1.5", "rotate": -100.0},
    {"anchor": "bottom", "at": "50%,90%", "flip_h": True, "scale": "60mm", "rotate": 70.0},
    {"flip_v": True, "scale": "2", "anchor": "right"},
]
ACTS = [
    ("move", [12.5, -40.25]),
    ("turn", [0.5, 0.5, 33.0]),
    ("turn", [0, 1, -170.0]),
    ("stretch", [0, 0, 1.3, 1.3]),
    ("stretch", [0.5, 1, 1, 0.6]),
]


def test_the_keys_put_a_layer_where_its_frame_is(tmp_path):
    cases = []
    for start in STARTS:
        options = {"anchor": "center", "scale": "1", "rotate": 0.0, **start}
        cases += [{"box": box_of(start), "options": options, "act": act, "by": by} for act, by in ACTS]
    (tmp_path / "cases.json").write_text(json.dumps(cases), encoding="utf-8")
    shutil.copy(PAGE / "stage" / "placing.js", tmp_path / "placing.mjs")
    (tmp_path / "run.mjs").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run(["node", "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    said = json.loads(done.stdout)
    for case, found in zip(cases, said["found"], strict=True):
        start = {key: value for key, value in case["options"].items() if key in nm.LayerOptions.__dataclass_fields__}
        library = np.array(box_of({**start, **found["keys"]})["matrix"])
        page = np.array(found["matrix"])
        corners = np.array([[0, 0, 1], [COLS, 0, 1], [0, ROWS, 1], [COLS, ROWS, 1]]).T
        # rounded keys, and exact positions are rounded to whole px
        assert np.abs(library @ corners - page @ corners).max() < 0.75, (case, found["keys"])
        assert found["share"] == pytest.approx([0.2, 0.7])
        if case["act"] == "move":
            assert set(found["keys"]) == {"at"}
        if case["options"]["scale"] == "60mm" and case["by"] == [0, 0, 1.3, 1.3]:
            assert found["keys"]["scale"] == "78mm"
    assert said["snaps"] == [{"shift": 4, "target": 24}, None, {"shift": -1, "target": 0}]
