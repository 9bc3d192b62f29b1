"""The controls of the page: every option of a relief once, why some cannot be used, and what is refused."""

import dataclasses
import json
import shutil
import subprocess

import numpy as np
import pytest
from stack_cases import write_maps
from studio_cases import ask, served, until
from test_studio_page import PAGE, needs_node

import nmaptool as nm
from nmaptool.options.fields import descriptions
from nmaptool.studio.document import opened
from nmaptool.studio.engine import Engine
from nmaptool.studio.forms.controls import controls
from nmaptool.studio.forms.reasons import reasons
from nmaptool.studio.frames import frame_of
from nmaptool.types.recipe import RELIEF_KEYS


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


@pytest.fixture
def document(folder):
    return opened([str(folder / "bunny.exr")])


def with_files(document, **files):
    relief = dataclasses.replace(document.relief, files=nm.ReliefFiles(**files))
    return dataclasses.replace(document, relief=relief)


def test_every_option_of_a_recipe_has_one_control_with_the_help_of_the_command_line():
    shown = {one["name"]: one for one in controls()}
    assert set(shown) == {*RELIEF_KEYS, *(f.name for f in dataclasses.fields(nm.SolidOptions))}
    assert len(shown) == len(controls())
    assert list(dict.fromkeys(one["group"] for one in controls())) == ["Shape", "Size", "Outline", "Solid", "Advanced"]
    told = {**descriptions(nm.ReliefOptions), **descriptions(nm.SolidOptions)}
    assert shown["mu"]["help"] == told["mu"]
    assert shown["edge_height"]["help"].startswith("Mean height of the wall of edge wall, such as 2mm.")
    for one in shown.values():
        if one["slider"] is not None and one["default"] is not None:
            assert one["slider"]["low"] <= one["default"] <= one["slider"]["high"]


def test_a_control_without_effect_says_why(document):
    found = reasons(document)
    assert found["controls"] == {
        "mu": "has no effect without a detail map",
        "energy": "has no effect without a detail map",
        "fit": "needs `height`, such as `height='3mm'`",
        "edge_height": "needs `edge='wall'`",
        "outline_round": "needs `background='cut'`, not plane",
        "hollow": "needs `base`, such as `base='3mm'`",
    }
    assert found["choices"] == {"background": {"surface": "needs the file of a curved background"}}


@pytest.mark.parametrize(
    ("values", "freed"),
    [
        ({"height": "3mm"}, {"fit"}),
        ({"edge": "wall"}, {"edge_height"}),
        ({"background": "cut"}, {"outline_round"}),
        ({"base": "2mm"}, {"hollow"}),
    ],
)
def test_a_control_is_free_once_its_reason_is_gone(document, values, freed):
    before, after = (set(reasons(each)["controls"]) for each in (document, document.changed(values)))
    assert before - after == freed


def test_files_free_their_controls(document):
    found = reasons(with_files(document, detail="detail.exr", surface="roll.exr"))
    assert not {"mu", "energy"} & set(found["controls"])
    assert found["choices"] == {}


def test_values_that_exclude_each_other_are_named(document):
    found = reasons(document.changed({"beta": 0, "shell": "2mm", "triangles": "1k", "background": "cut"}))
    assert found["controls"]["delta"] == "has no effect while `beta` is 0"
    assert found["controls"]["base"] == "`base` and `shell` are two kinds of back; give one of them"
    assert "give one of them" in found["controls"]["max_error"]
    assert found["choices"]["edge"] == {"wall": "needs a flat plate, `background='plane'`, not cut"}
    # what is set can be changed back
    found = reasons(document.changed({"edge": "wall", "edge_height": "1mm"}))
    assert "edge_height" not in found["controls"]
    assert found["choices"]["edge"] == {"blend": "needs `edge='wall'`"} or "edge" not in found["controls"]


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"mu": "much"}, 'mu = "much": expected a number, such as 0.1'),
        ({"mu": True}, "mu = true: expected a number, such as 0.1"),
        ({"mu": float("inf")}, "expected a number"),
        ({"max_iterations": 2.5}, "expected a whole number, such as 200"),
        ({"height": 3}, "height = 3: expected 3mm"),
        ({"one_piece": "yes"}, "expected True or False"),
        ({"fit": "slope"}, 'fit = "slope": needs height'),
        ({"edge": "wall", "background": "cut"}, 'needs a flat plate, background = "plane", not cut'),
    ],
)
def test_a_refused_value_is_said_beside_its_control(folder, values, said):
    with served(folder / "bunny.exr") as client, client.live() as live:
        ask(live, do="set", values=values)
        error = until(live, "error")
        assert error["names"] == sorted(values)
        assert said in error["text"]
        ask(live, do="set", values={"mu": 0.2})
        assert until(live, "state")["values"]["fit"] == "scale"


def test_values_that_need_each_other_are_set_together(document):
    both = document.changed({"fit": "slope", "height": "3mm"})
    assert both.changed({"height": None, "fit": None}) == document
    assert both.changed(dict.fromkeys(("fit", "height"))) == document


def test_beta_per_pixel_looks_the_same_on_the_small_grid(tmp_path, dome):
    d = dome(120, 120)
    nm.write_normal_map(nm.NormalMap.from_array(d.normals, d.inside), tmp_path / "dome.exr")
    document = opened([str(tmp_path / "dome.exr")])
    engine = Engine(document)
    assert not engine.is_whole(60)
    options = nm.ReliefOptions(per_pixel=True, beta=0.01, delta=5)
    full, small = (engine.parts(options, longest=longest) for longest in (None, 60))
    assert small.px_per_delta == pytest.approx(0.5)
    high = [float(parts.z_mm(options.delta).max()) for parts in (full, small)]
    assert high[1] == pytest.approx(high[0], rel=0.05)


SCRIPT = """
import { readFileSync } from "node:fs";
import { betaFor, decode, inMillimetres, reachOf } from "./heights.mjs";
const bytes = readFileSync("frame.bin");
const frame = decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const found = JSON.parse(readFileSync("cases.json")).map(({ values, detail }) => {
  const reach = reachOf(frame, values, detail);
  return [reach, betaFor(reach, frame, values, detail)];
});
console.log(JSON.stringify({ found, lengths: ["3%", "4px", "1cm", "x"].map((text) => inMillimetres(text, frame)) }));
"""


@needs_node
def test_the_reach_beside_beta_is_that_of_the_report(tmp_path, dome):
    d = dome(40, 60)
    session = nm.ReliefSession(d.normals, d.normals, mask=d.inside)
    cases = [
        {"beta": 0.01, "mu": 0.5, "energy": "eq6", "width": "80mm"},
        {"beta": 0.0004, "mu": 2.0, "energy": "eq4", "width": None},
    ]
    parts = session.parts(nm.ReliefOptions())
    (tmp_path / "frame.bin").write_bytes(frame_of(parts, {"full": (120, 80)}))
    (tmp_path / "cases.json").write_text(json.dumps([{"values": values, "detail": True} for values in cases]))
    shutil.copy(PAGE / "heights.js", tmp_path / "heights.mjs")
    (tmp_path / "run.mjs").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run(["node", "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    said = json.loads(done.stdout)
    for values, (reach, beta) in zip(cases, said["found"], strict=True):
        width = None if values["width"] is None else nm.length(values["width"])
        report = session.solve(nm.ReliefOptions(**{**values, "width": width})).report
        assert reach == pytest.approx(report.reach_mm, rel=1e-9)
        assert beta == pytest.approx(values["beta"], rel=1e-9)
    longer = parts.pitch_mm * 60
    assert said["lengths"] == [pytest.approx(0.03 * longer), pytest.approx(4 * longer / 120), 10, None]


@needs_node
def test_heights_in_per_cent_are_those_of_the_library(tmp_path, dome):
    d = dome(40, 60)
    session = nm.ReliefSession(d.normals, mask=d.inside)
    (tmp_path / "frame.bin").write_bytes(frame_of(session.parts(), {"full": (60, 40)}))
    values = {"delta": 30, "height": "5%", "width": "90mm", "fit": "scale"}
    (tmp_path / "values.json").write_text(json.dumps(values))
    shutil.copy(PAGE / "heights.js", tmp_path / "heights.mjs")
    script = SCRIPT.split("const found")[0].replace("betaFor, decode, inMillimetres, reachOf", "combined, decode")
    script += 'console.log(combined(frame, JSON.parse(readFileSync("values.json"))).span);'
    (tmp_path / "run.mjs").write_text(script, encoding="utf-8")
    done = subprocess.run(["node", "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    options = nm.ReliefOptions(height=nm.length("5%"), width=nm.length("90mm"))
    assert float(done.stdout) == pytest.approx(session.solve(options).report.relief_range_mm, rel=1e-4)
    assert np.isclose(float(done.stdout), 4.5, rtol=1e-4)
