"""The document of the studio, its controls and the bytes of its heights."""

import json

import numpy as np
import pytest
from stack_cases import waves, write_maps
from studio_cases import decoded

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError
from nmaptool.studio.document import MOST_STEPS, Document, History, opened
from nmaptool.studio.engine import PREVIEW_PX, Engine
from nmaptool.studio.forms.controls import GROUPS, controls
from nmaptool.studio.frames import frame_of


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def test_maps_are_opened_as_layers_beside_each_other(folder):
    document = opened([str(folder / "plate.exr"), str(folder / "bunny.exr")])
    assert [layer.file for layer in document.layers] == ["plate.exr", "bunny.exr"]
    assert document.folder == folder
    assert document.path is None
    assert document.options == nm.ReliefOptions()


def test_a_recipe_is_opened_with_its_options(folder):
    text = '[[layer]]\nfile = "plate.exr"\n[relief]\nmu = 0.3\nheight = "2mm"\nbase = "1mm"\n'
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    document = opened([str(folder / "scene.toml")])
    assert document.path == folder / "scene.toml"
    assert document.options == nm.ReliefOptions(mu=0.3, height=nm.length("2mm"))
    assert document.solid == nm.SolidOptions(base=nm.length("1mm"))


def test_faults_of_opening(folder):
    with pytest.raises(InputError, match="there is nothing to shape yet: drop a normal map"):
        _ = opened([]).recipe
    (folder / "scene.toml").write_text('[[layer]]\nfile = "plate.exr"\n', encoding="utf-8")
    with pytest.raises(UsageError, match=r"scene\.toml: a recipe is opened alone"):
        opened([str(folder / "scene.toml"), "more.png"])
    for name in ("none.toml", "none.png"):
        with pytest.raises(InputError, match=rf"{name}: no such file"):
            opened([str(folder / name)])


def test_values_are_checked_and_defaults_left_out():
    document = Document.of(nm.parse_recipe({"layer": [{"file": "a.png"}]}))
    changed = document.changed({"mu": 0.5, "height": "3mm", "base": "2mm"})
    assert changed.relief.options == {"mu": 0.5, "height": nm.length("3mm")}
    assert changed.relief.solid == {"base": nm.length("2mm")}
    assert changed.changed({"mu": 0.1, "height": None, "base": None}) == document
    assert document.relief.options == {}
    with pytest.raises(UsageError, match=r"`mu=-1`"):
        document.changed({"mu": -1})
    with pytest.raises(UsageError, match=r"`memory_limit`: is not an option of a relief"):
        document.changed({"memory_limit": "8GB"})


def test_steps_are_undone_and_redone():
    first = Document.of(nm.parse_recipe({"layer": [{"file": "a.png"}]}))
    history = History(first)
    for mu in (0.2, 0.3, 0.4):  # one drag of a slider is one step
        history.do(history.now.changed({"mu": mu}), joined=mu > 0.2)
    history.do(history.now.changed({"beta": 0.01}))
    history.do(history.now)  # no change, no step
    assert history.steps == (2, 0)
    assert history.undo()
    assert history.now.options.mu == 0.4
    assert history.undo()
    assert history.now == first
    assert not history.undo()
    assert history.redo()
    assert history.redo()
    assert not history.redo()
    assert history.now.options.beta == 0.01
    history.undo()
    history.do(history.now.changed({"delta": 5}))
    assert history.steps == (2, 0)
    for step in range(MOST_STEPS + 50):
        history.do(history.now.changed({"delta": step}))
    assert history.steps == (MOST_STEPS, 0)


def test_controls_describe_the_options():
    made = {control["name"]: control for control in controls()}
    assert list(made) == [name for names in GROUPS.values() for name in names]
    options = {**vars(nm.ReliefOptions()), **vars(nm.SolidOptions())}
    for name, control in made.items():
        assert control["default"] == options[name]
        assert "--" not in control["help"]
        assert control["help"].endswith(".")
        assert (control["kind"] == "choice") == bool(control["choices"])
    assert made["mu"]["kind"] == "number"
    assert made["height"]["kind"] == "length"
    assert made["background"]["choices"] == ["plane", "free", "cut", "surface"]
    json.dumps(controls())


def test_a_frame_holds_the_parts_of_the_heights(folder):
    engine = Engine(opened([str(folder / "bunny.exr")]))
    options = nm.ReliefOptions(background="cut", beta=0.01)
    parts = engine.parts(options, longest=PREVIEW_PX)
    header, fields, surface = decoded(frame_of(parts, {"request": 7}))
    assert header["request"] == 7
    assert header["pitch_mm"] == 0.5
    inside = surface > 0
    delta = 40 * header["px_per_delta"]
    z = (fields["first"] + delta * fields["second"]) * header["pitch_mm"]
    exact = nm.relief(
        nm.read_normal_map(folder / "bunny.exr"), options=nm.ReliefOptions(**{**vars(options), "delta": 40})
    )
    assert np.abs(z - exact.z_mm)[inside].max() < 3e-4 * np.ptp(exact.z_mm[inside])


def test_large_maps_get_a_smaller_grid_while_a_control_moves(tmp_path, png):
    nm.write_normal_map(waves(400, 1000, 20, 0.1), tmp_path / "wide.exr")
    png(tmp_path / "mask.png", np.full((400, 1000), 255, np.uint8))
    text = '[[layer]]\nfile = "wide.exr"\n[relief]\nmask = "mask.png"\n'
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    engine = Engine(opened([str(tmp_path / "scene.toml")]))
    small, full = (engine.parts(nm.ReliefOptions(), longest=longest) for longest in (PREVIEW_PX, None))
    assert max(small.surface.shape) == PREVIEW_PX
    assert full.surface.shape == (400, 1000)
    # the same relief: mu, beta and delta refer to a picture of 1000 px
    one, other = (np.ptp(parts.z_mm(30)) for parts in (small, full))
    assert one == pytest.approx(other, rel=0.03)


@pytest.mark.parametrize("delta", [0, 30, -80])
def test_the_parts_of_a_session_add_up_to_its_solves(delta, dome):
    d = dome(80, 120)
    session = nm.ReliefSession(d.normals, mask=d.inside)
    options = nm.ReliefOptions(delta=delta, beta=0.01)
    parts = session.parts(nm.ReliefOptions(beta=0.01, height=nm.length("3mm")))
    solved = session.solve(options)
    assert solved.report.iterations <= 1  # from the parts
    accuracy = 1e-6 * np.ptp(solved.z_mm)
    assert np.allclose(parts.z_mm(delta), solved.z_mm, rtol=0, atol=accuracy)
    assert np.allclose(parts.z_mm(delta, scale=0.5), 0.5 * solved.z_mm, rtol=0, atol=accuracy)


def test_walls_have_no_parts(dome):
    d = dome(60, 60)
    with pytest.raises(UsageError, match=r"`edge='wall'`: the heights of walls are not linear in `delta`"):
        nm.ReliefSession(d.normals, mask=d.inside).parts(nm.ReliefOptions(edge="wall"))


def test_the_heights_of_walls_come_whole(folder):
    engine = Engine(opened([str(folder / "bunny.exr")]))
    options = nm.ReliefOptions(edge="wall", height=nm.length("2mm"))
    parts = engine.parts(options)
    expected = nm.relief(nm.read_normal_map(folder / "bunny.exr"), options=options)
    assert np.allclose(parts.z_mm(77), expected.z_mm)


def test_the_width_is_left_to_the_page_unless_lengths_depend_on_it(folder):
    engine = Engine(opened([str(folder / "bunny.exr")]))
    wide = nm.ReliefOptions(width=nm.length("90mm"))
    assert engine.parts(wide).pitch_mm == 0.5  # the map's own
    rounded = nm.ReliefOptions(width=nm.length("90mm"), background="cut", outline_round=nm.length("5mm"))
    assert engine.parts(rounded).pitch_mm == 3.0
