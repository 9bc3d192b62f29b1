"""Presets: each is a valid set of options, the same for the command line and the studio; the user's own are files."""

import dataclasses
import json

import pytest
from stack_cases import write_maps
from studio_cases import ask, served, until

import nmaptool as nm
from nmaptool.options.relief_presets import COVERED, RELIEF_PRESETS
from nmaptool.studio.document import opened
from nmaptool.studio.forms.presets import Presets

WITH_PLATES = ["coin", "medal", "cameo", "plaque", "pendant", "tile", "box-lid"]
NAMES = [*WITH_PLATES, "wood-panel", "lithograph-stone", "game-prop"]


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


@pytest.fixture
def document(folder):
    return opened([str(folder / "bunny.exr")])


def test_the_presets_cover_every_option_that_shapes_a_relief():
    assert list(RELIEF_PRESETS) == NAMES
    every = {f.name for options in (nm.ReliefOptions, nm.SolidOptions) for f in dataclasses.fields(options)}
    assert [name for name, preset in RELIEF_PRESETS.items() if preset.plate] == WITH_PLATES
    left = every - set(COVERED)
    assert left == {"width", "outline", "one_piece", "solver", "tolerance", "max_iterations", "memory_limit"}


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_gives_the_same_relief_on_the_command_line_and_in_the_studio(name, document, folder, run):
    document = document.changed({"width": "40mm", "edge": "auto", "shell": "2mm"})
    presets = Presets(folder / "presets")
    document = document.changed(presets.values(name, is_own=False))
    document = dataclasses.replace(document, plate=presets.plate(name, None, is_own=False))
    nm.write_recipe(document.recipe, folder / "scene.toml")
    for number, arguments in enumerate((["scene.toml"], ["bunny.exr", "--preset", name, "--width", "40mm"])):
        done = run("relief", folder / arguments[0], *arguments[1:], "-o", folder / f"{number}.stl")
        assert done.code == 0, done.err
    assert (folder / "0.stl").read_bytes() == (folder / "1.stl").read_bytes()


def test_presets_differ_as_the_work_does(document):
    scene = nm.read_scene(document.recipe)
    height, steep = {}, {}
    for name, preset in RELIEF_PRESETS.items():
        report = nm.relief(**{**scene.inputs, "options": nm.ReliefOptions(**preset.options)}).report
        height[name], steep[name] = report.height_range_mm / (report.pitch_mm * 40), report.reach_mm
    assert height["lithograph-stone"] < height["coin"] < height["medal"] < height["plaque"] < height["wood-panel"]
    assert steep["lithograph-stone"] < steep["coin"] < steep["medal"] < steep["wood-panel"] < steep["game-prop"]


def test_flags_change_a_preset_and_a_preset_changes_a_recipe(document, folder, run):
    nm.write_recipe(document.changed({"beta": 0.05, "width": "30mm"}).recipe, folder / "scene.toml")
    done = run("relief", folder / "scene.toml", "--preset", "coin", "--mu", "0.9", "--dry-run", "--json")
    assert done.code == 0, done.err
    said = json.loads(done.out)
    assert (said["options"]["mu"], said["options"]["beta"]) == (0.9, 0.002)
    assert (said["plate"]["width_mm"], said["plate"]["shape"]) == (pytest.approx(30), "round")
    assert said["height_range_mm"] == pytest.approx(0.02 * 30, rel=1e-6)


def test_own_presets_are_saved_read_and_deleted(document, tmp_path):
    presets = Presets(tmp_path / "settings" / "presets")
    assert not any(one["is_own"] for one in presets.listed())
    kept = document.changed({"mu": 0.7, "height": "2.5mm", "width": "60mm", "base": "2mm", "solver": "multigrid"})
    presets.save("Brooch", kept)
    (one,) = [one for one in presets.listed() if one["is_own"]]
    assert one["name"] == "Brooch"
    assert one["description"] == "mu 0.7, height 2.5mm, width 60mm, base 2mm"
    values = presets.values("Brooch", is_own=True)
    applied = document.changed({"edge": "wall", "beta": 0.5, "solver": "amg"}).changed(values)
    assert applied.options == dataclasses.replace(kept.options, solver="amg")  # how it is solved is no matter of looks
    with pytest.raises(nm.InputError, match="Brooch: there is a preset with this name"):
        presets.save("Brooch", document)
    presets.save("Brooch", document.changed({"mu": 0.2}), overwrite=True)
    assert presets.values("Brooch", is_own=True)["mu"] == 0.2
    presets.delete("Brooch")
    assert not any(one["is_own"] for one in presets.listed())
    with pytest.raises(nm.InputError, match="no preset of yours"):
        presets.delete("Brooch")


@pytest.mark.parametrize("name", ["", "   ", "a" * 61, "a\nb", "..", "what?"])
def test_names_that_no_file_can_have_are_refused(document, tmp_path, name):
    presets = Presets(tmp_path / "presets")
    with pytest.raises(nm.InputError):
        presets.save(name, document)
    assert not (tmp_path / "presets").exists()


def test_a_name_does_not_lead_out_of_the_folder(document, tmp_path):
    presets = Presets(tmp_path / "presets")
    presets.save("../../outside", document)
    assert [path.name for path in (tmp_path / "presets").iterdir()] == ["outside.toml"]
    with pytest.raises(nm.InputError, match="coin: is the name of a preset that comes with nmaptool"):
        presets.save("coin", document)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[relief]\nmu = -3\n", "mu = -3: must be zero or more"),
        ("[relief]\nmuh = 3\n", "unknown key 'muh'; did you mean 'mu'?"),
        ("[relief", "bad.toml"),
        ('[[layer]]\nfile = "a.png"\n[relief]\nmu = 1\n', "unknown key 'layer'; use one of relief"),
    ],
)
def test_a_preset_that_cannot_be_used_says_why(tmp_path, text, said):
    (tmp_path / "bad.toml").write_text(text, encoding="utf-8")
    presets = Presets(tmp_path)
    (one,) = [one for one in presets.listed() if one["is_own"]]
    assert said in one["description"]
    with pytest.raises(nm.InputError) as found:
        presets.values("bad", is_own=True)
    assert said in str(found.value)


def test_a_preset_is_one_step_and_every_window_hears_of_a_new_one(folder):
    with served(folder / "bunny.exr") as client, client.live() as one, client.live() as other:
        assert [each["name"] for each in until(other, "presets")["presets"]] == NAMES
        steps = until(other, "state")["undo"]
        ask(one, do="apply-preset", name="cameo")
        state = until(other, "state")
        assert (state["values"]["edge"], state["values"]["height"], state["undo"]) == ("wall", "5%", steps + 1)
        ask(one, do="save-preset", name="Mine")
        assert until(other, "presets")["presets"][-1]["name"] == "Mine"
        ask(one, do="undo")
        assert until(other, "state")["values"]["edge"] == "blend"
        ask(one, do="apply-preset", name="Mine", is_own=True)
        assert until(other, "state")["values"]["edge"] == "wall"
        ask(one, do="delete-preset", name="Mine")
        assert until(other, "presets")["presets"][-1]["is_own"] is False
        ask(one, do="apply-preset", name="penny")
        assert "there is no such preset; use one of coin, medal" in until(one, "error")["text"]
        ask(one, do="save-preset")
        assert "named no preset" in until(one, "error")["text"]
    assert list((folder / "state" / "presets").iterdir()) == []
