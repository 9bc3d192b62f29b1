"""The page of the studio: its modules compute what the library does, and load nothing from elsewhere."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.studio.frames import frame_of

PAGE = Path(nm.__file__).parent / "studio" / "page"
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
SCRIPT = """
import { readFileSync } from "node:fs";
import { combined, decode, millimetres } from "./heights.mjs";
const bytes = readFileSync("frame.bin");
const frame = decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const wanted = JSON.parse(readFileSync("values.json"));
const found = wanted.map((values) => {
  const { z, span, pitch } = combined(frame, values);
  return { z: Array.from(z), span, pitch };
});
console.log(JSON.stringify({ found, lengths: ["3mm", " 2 cm", "0.5in", "3%", "", null].map(millimetres) }));
"""


@needs_node
def test_the_page_computes_the_heights_of_the_library(tmp_path, dome):
    d = dome(40, 60)
    session = nm.ReliefSession(d.normals, mask=d.inside)
    parts = session.parts(nm.ReliefOptions(beta=0.01))
    cases = [
        {"delta": 30, "height": None, "width": None, "fit": "scale"},
        {"delta": -80, "height": "3mm", "width": "120mm", "fit": "scale"},
        {"delta": 30, "height": "5mm", "width": "2in", "fit": "slope"},
        {"delta": 30, "height": "9mm", "width": None, "fit": "delta"},
        {"delta": -30, "height": "9mm", "width": None, "fit": "delta"},
    ]
    (tmp_path / "frame.bin").write_bytes(frame_of(parts, {}))
    (tmp_path / "values.json").write_text(json.dumps(cases), encoding="utf-8")
    shutil.copy(PAGE / "heights.js", tmp_path / "heights.mjs")
    (tmp_path / "run.mjs").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run(["node", "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    said = json.loads(done.stdout)
    assert said["lengths"][:3] == [3, 20, 12.7]
    assert said["lengths"][3:] == [None, None, None]  # NaN in JSON
    for values, found in zip(cases, said["found"], strict=True):
        given = {name: value for name, value in values.items() if value is not None}
        lengths = {name: nm.length(given[name]) for name in ("height", "width") if name in given}
        relief = session.solve(nm.ReliefOptions(**{**given, **lengths, "beta": 0.01}))
        z_mm = np.reshape(found["z"], relief.z_mm.shape) * found["pitch"]
        assert found["pitch"] == pytest.approx(relief.report.pitch_mm, rel=1e-9)
        assert found["span"] == pytest.approx(relief.report.relief_range_mm, rel=1e-4)
        assert np.abs(z_mm - relief.z_mm).max() < 2e-4 * relief.report.relief_range_mm


def test_the_page_loads_nothing_from_elsewhere():
    for path in (path for path in PAGE.rglob("*") if path.is_file()):
        text = path.read_text(encoding="utf-8")
        assert re.findall(r"(?:https?:)?//[\w.-]+\.\w{2,}", text) == [], path.name
        if path.suffix == ".js":
            for named in re.findall(r"from \"(.+?)\"", text):
                assert (path.parent / named).is_file()


def test_every_control_of_the_page_has_a_label():
    text = (PAGE / "index.html").read_text(encoding="utf-8")
    for tag in re.findall(r"<(?:select|canvas|div role|input)[^>]*>", text):
        own = re.search(r'id="(.+?)"', tag)
        if "hidden" in tag or re.search(rf"<label>{re.escape(tag)}", text):
            continue
        if own is not None and f'for="{own[1]}"' in text:
            continue
        assert "aria-label" in tag or re.search(rf"<label[^>]*>(?:(?!</label>).)*{own[0]}", text, re.DOTALL), tag
