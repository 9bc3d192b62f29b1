"""Plates of `nmap relief`: flags, presets, recipes and machines, and the recipe that a run saves."""

import json
import shutil
from pathlib import Path

import matplotlib
import pytest
from motif_cases import MOTIFS

import nmaptool as nm

FONT = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans-Bold.ttf"
SHIELD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 50"><path d="M0,0 H40 V25 L20,50 L0,25 Z"/></svg>'
OGEE = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 8 9"><path d="M0,9 V3 H3 V0 H6 L8,9"/></svg>'
COIN = """[relief]
width = "20mm"
height = "0.5mm"
base = "1mm"

[plate]
shape = "oval"
aspect = "1:1"
margin = "1mm"
hole = "1.5mm@50%,4mm"

[frame]
width = "1mm"
height = "0.6mm"

[[text]]
text = "ANNO"
path = "arc"
size = "2mm"

[[text]]
text = "MMXXVI"
path = "arc"
side = "bottom"
size = "1.5mm"

[[layer]]
file = "dome.exr"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the map of a dome and a recipe of a coin, which is the current one."""
    nm.write_normal_map(MOTIFS["dome"](), tmp_path / "dome.exr")
    (tmp_path / "coin.toml").write_text(COIN, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def reported(run):
    """``reported("dome.exr", "--preset", "coin")``: the JSON report of a run that writes nothing."""

    def call(*words):
        done = run("relief", *words, "--json", "--dry-run")
        assert done.code == 0, done.err
        return json.loads(done.out)

    return call


@pytest.fixture
def saved(run):
    """``saved("dome.exr", "--preset", "coin")``: the recipe of a run."""

    def call(*words):
        done = run("relief", *words, "--save-recipe", "-")
        assert done.code == 0, done.err
        assert done.err == ""
        return done.out

    return call


def tables(text):
    """Lines of the tables of a recipe, by their heading; those of several texts together."""
    found = {}
    for part in text.split("\n\n"):
        heading, *lines = part.splitlines()
        found.setdefault(heading, []).extend(sorted(lines))
    return found


def test_flags_make_a_plate(folder, run, reported):
    words = ("--shape", "rect", "--aspect", "2:1", "--corner", "2mm", "--width", "40mm", "--frame", "2mm")
    words += ("--frame-height", "1mm", "--frame-profile", "bevel", "--hole", "3mm@4mm,4mm", "--height", "1mm")
    words += ("--text", "ANNO", "--text-size", "2mm", "--text-height", "0.3mm", "--text-at", "82%,50%")
    plate = reported("dome.exr", *words)["plate"]
    assert (plate["width_mm"], plate["height_mm"], plate["shape"]) == (pytest.approx(40), pytest.approx(20), "rect")
    assert plate["area_mm2"] == pytest.approx(800 - (4 - 3.14159265) * 4 - 3.14159265 * 1.5**2, abs=0.02)
    assert plate["frame"] == {"width_mm": 2, "height_mm": 1, "profile": "bevel"}
    assert plate["texts"][0]["text"] == "ANNO"
    assert plate["texts"][0]["size_mm"] == 2
    assert plate["holes"][0]["diameter_mm"] == 3
    assert plate["design"]["plate"]["corner"] == "2mm"
    done = run("relief", "dome.exr", *words, "-o", "plate.stl", "--base", "2mm", "--max-error", "0.02mm")
    assert done.code == 0, done.err
    for line in (
        "  rect plate 40 x 20 mm, ",
        "  frame bevel, 2 mm wide and 1 mm high",
        "  text 'ANNO': capitals 2 mm, ",
        "  hole of 3 mm, rim 0.6 mm",
        "  1 closed body, 40 x 20 x 3 mm, ",
    ):
        assert line in done.err, done.err
    mesh = nm.read_mesh("plate.stl")
    assert mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0) == pytest.approx([40, 20, 3], abs=1e-3)


def test_a_preset_is_the_recipe_that_it_saves(folder, saved):
    text = saved("dome.exr", "--preset", "cameo", "--width", "30mm")
    assert tables(text) == {
        "[relief]": [
            'base = "3%"',
            "beta = 0.0008",
            "delta = 40",
            'edge = "wall"',
            'height = "5%"',
            "mu = 0.2",
            "slope_cap = 4",
            'width = "30mm"',
        ],
        "[plate]": ['aspect = "3:4"', 'margin = "3%"', 'shape = "oval"'],
        "[frame]": ['height = "4%"', 'profile = "round"', 'width = "5%"'],
        "[[layer]]": ['file = "dome.exr"'],
    }


@pytest.mark.parametrize(
    ("flags", "table", "line"),
    [
        (["--margin", "1mm"], "[plate]", 'margin = "1mm"'),
        (["--hole", "2mm@50%,30%"], "[plate]", 'hole = "2mm@50%,30%"'),
        (["--loop", "3mm"], "[plate]", 'loop = "3mm"'),
        (["--engrave"], "[plate]", "engrave = true"),
        (["--draft", "5"], "[plate]", "draft = 5"),
        (["--shape", "oval", "--aspect", "2:3"], "[plate]", 'aspect = "2:3"'),
        (["--frame-height", "1mm"], "[frame]", 'height = "1mm"'),
        (["--frame-profile", "rope"], "[frame]", 'profile = "rope"'),
        (["--frame", "2mm"], "[frame]", 'width = "2mm"'),
        (["--text", "ANNO", "--text-path", "circle"], "[[text]]", 'path = "circle"'),
        (["--pitch", "0.1mm"], "[machine]", 'pitch = "0.1mm"'),
        (["--hollow", "0.5mm"], "[relief]", 'hollow = "0.5mm"'),
        (["--shell", "1mm"], "[relief]", 'shell = "1mm"'),
        (["--triangles", "5k"], "[relief]", 'triangles = "5k"'),
        (["--mu", "0.2"], "[relief]", "mu = 0.2"),
        (["--fit", "slope"], "[relief]", 'fit = "slope"'),
    ],
)
def test_flags_change_a_preset(folder, saved, flags, table, line):
    before, after = tables(saved("dome.exr", "--preset", "coin")), tables(saved("dome.exr", "--preset", "coin", *flags))
    assert line in after[table]
    assert line not in before.get(table, [])
    if "--shell" in flags:  # takes the place of the base
        assert not any(each.startswith("base") for each in after["[relief]"])


def test_what_a_preset_says_counts_before_a_recipe_and_after_flags(folder, saved):
    assert tables(saved("coin.toml")) == tables(COIN)
    found = tables(saved("coin.toml", "--preset", "medal", "--frame-height", "0.4mm", "--base", "2mm"))
    assert found["[plate]"] == ['margin = "3%"', 'shape = "round"']  # neither the aspect nor the hole of the recipe
    assert found["[frame]"] == ['height = "0.4mm"', 'profile = "bead"', 'width = "5%"']
    assert found["[[text]]"] == tables(COIN)["[[text]]"]
    assert {'height = "4%"', 'width = "20mm"', 'base = "2mm"', "mu = 0.3"} < set(found["[relief]"])


def test_a_preset_for_work_without_a_plate_leaves_that_of_a_recipe_out(folder, run):
    done = run("relief", "coin.toml", "--preset", "game-prop", "-o", "prop.stl", "--save-recipe", "prop.toml")
    assert done.code == 0, done.err
    assert "  the plate of coin.toml is left out: the preset game-prop is for work without one\n" in done.err
    assert "round plate" not in done.err
    assert set(tables(Path("prop.toml").read_text(encoding="utf-8"))) == {"[relief]", "[[layer]]"}
    done = run("relief", "coin.toml", "--preset", "wood-panel", "--shape", "round", "-o", "panel.npy")
    assert done.code == 0, done.err
    assert "  round plate 20 x 20 mm, " in done.err


def test_flags_of_texts_change_all_texts_of_a_recipe_or_replace_them(folder, saved, reported):
    every = tables(saved("coin.toml", "--text-size", "1.8mm", "--text-height", "0.2mm"))["[[text]]"]
    assert every.count('size = "1.8mm"') == every.count('height = "0.2mm"') == 2
    assert 'text = "ANNO"' in every
    assert 'side = "bottom"' in every
    one = tables(saved("coin.toml", "--text", "LIBERTAS"))["[[text]]"]
    assert one == ['text = "LIBERTAS"']
    texts = reported("coin.toml", "--text-size", "1.8mm")["plate"]["texts"]
    assert [(each["text"], each["size_mm"]) for each in texts] == [("ANNO", 1.8), ("MMXXVI", 1.8)]


def test_embossing_replaces_engraving_of_a_recipe(folder, saved, reported):
    (folder / "sunk.toml").write_text(COIN.replace('hole = "1.5mm@50%,4mm"', "engrave = true"), encoding="utf-8")
    assert "engrave = true" in saved("sunk.toml")
    assert "engrave" not in saved("sunk.toml", "--emboss")
    assert reported("sunk.toml")["plate"]["lowest_mm"] == pytest.approx(-0.5, abs=1e-6)
    assert reported("sunk.toml", "--emboss")["plate"]["lowest_mm"] > -0.1


def test_the_frame_of_a_sunk_motif_is_as_high_as_the_motif_is_deep(folder, reported):
    words = ("--shape", "round", "--width", "20mm", "--height", "0.5mm", "--frame", "1mm", "--pitch", "0.1mm")
    for more in ((), ("--engrave",)):
        assert reported("dome.exr", *words, *more)["plate"]["frame"]["height_mm"] == pytest.approx(0.5, abs=0.02)


def test_the_saved_recipe_makes_the_same_file(folder, run):
    words = ["dome.exr", "--preset", "coin", "--width", "20mm", "--text", "ANNO", "--text-path", "arc", "--mu", "0.5"]
    words += ["--for", "fdm-0.4", "--frame-profile", "bead", "--hole", "2mm@50%,5mm", "--green", "up"]
    done = run("relief", *words, "-o", "flags.stl", "--save-recipe", "saved.toml")
    assert done.code == 0, done.err
    assert "  wrote saved.toml" in done.err
    done = run("relief", "saved.toml", "-o", "recipe.stl")
    assert done.code == 0, done.err
    assert Path("flags.stl").read_bytes() == Path("recipe.stl").read_bytes()
    done = run("relief", "saved.toml", "--save-recipe", "again.toml")
    assert done.code == 0, done.err
    assert Path("again.toml").read_text(encoding="utf-8") == Path("saved.toml").read_text(encoding="utf-8")
    assert nm.read_scene("saved.toml").solve().height.range_mm == nm.read_scene("again.toml").solve().height.range_mm


def test_a_recipe_in_another_folder_names_its_files_from_there(folder, run, saved):
    (folder / "designs" / "parts").mkdir(parents=True)
    (folder / "shield.svg").write_text(SHIELD, encoding="utf-8")
    (folder / "ogee.svg").write_text(OGEE, encoding="utf-8")
    shutil.copy(FONT, folder / "designs" / "title.ttf")
    words = ["dome.exr", "--shape", "shield.svg", "--frame", "1mm", "--frame-profile", "ogee.svg", "--width", "20mm"]
    words += [
        "--height",
        "0.5mm",
        "--text",
        "A",
        "--text-at",
        "50%,50%",
        "--font",
        "designs/title.ttf",
        "--base",
        "1mm",
    ]
    done = run("relief", *words, "--max-error", "0.02mm", "--save-recipe", "designs/parts/new.toml", "-o", "a.stl")
    assert done.code == 0, done.err
    text = Path("designs/parts/new.toml").read_text(encoding="utf-8")
    for line in ('shape = "../../shield.svg"', 'profile = "../../ogee.svg"', 'font = "../title.ttf"'):
        assert line in text
    assert 'file = "../../dome.exr"' in text
    done = run("relief", "designs/parts/new.toml", "-o", "b.stl")
    assert done.code == 0, done.err
    assert Path("a.stl").read_bytes() == Path("b.stl").read_bytes()
    # flags are relative to the current folder, also over a recipe in another one
    changed = saved("designs/parts/new.toml", "--font", "designs/title.ttf", "--shape", "shield.svg")
    assert changed == text
    done = run("relief", "designs/parts/new.toml", "--font", "designs/title.ttf", "-o", "c.stl")
    assert done.code == 0, done.err
    assert Path("c.stl").read_bytes() == Path("a.stl").read_bytes()


def test_a_recipe_is_saved_only_where_nothing_is_lost(folder, run, refused):
    refused(5, r"coin\.toml: already exists", "relief", "dome.exr", "--preset", "coin", "--save-recipe", "coin.toml")
    done = run("relief", "dome.exr", "--preset", "coin", "--save-recipe", "coin.toml", "--overwrite")
    assert done.code == 0, done.err
    assert done.err == "wrote coin.toml\n"
    done = run("relief", "dome.exr", "--preset", "coin", "--save-recipe", "new.toml", "--dry-run")
    assert done.err == "nothing written (--dry-run)\n"
    assert run("relief", "dome.exr", "--preset", "coin", "--save-recipe", "new.toml", "-q").err == ""
    assert Path("new.toml").is_file()


def test_quiet_prints_nothing_and_the_report_of_a_file_has_the_plate(folder, run):
    done = run("relief", "coin.toml", "-o", "coin.stl", "--report", "coin.json", "-q")
    assert (done.code, done.err, done.out) == (0, "", "")
    plate = json.loads(Path("coin.json").read_text(encoding="utf-8"))["plate"]
    assert (plate["width_mm"], plate["shape"]) == (pytest.approx(20), "oval")
    assert plate["design"]["texts"][1] == {
        "text": "MMXXVI",
        "text_path": "arc",
        "text_side": "bottom",
        "text_size": "1.5mm",
    }
    assert plate["area_mm2"] == pytest.approx(3.14159265 * (100 - 0.75**2), rel=1e-4)


@pytest.mark.parametrize(
    ("words", "table", "gone"),
    [
        (["dome.exr", "--preset", "cameo", "--shape", "round"], "[plate]", "aspect"),
        (["dome.exr", "--preset", "plaque", "--shape", "oval"], "[plate]", "corner"),
        (["coin.toml", "--shape", "mask"], "[plate]", "aspect"),
        (["ring.toml", "--text-path", "line"], "[[text]]", "inset"),
        (["line.toml", "--text-path", "arc"], "[[text]]", "at"),
    ],
)
def test_a_flag_drops_what_its_shape_or_path_has_no_use_for(folder, saved, words, table, gone):
    text = '[[layer]]\nfile = "dome.exr"\n[plate]\nshape = "round"\n[[text]]\ntext = "A"\n'
    (folder / "ring.toml").write_text(f'{text}path = "ring"\ninset = "1mm"\n', encoding="utf-8")
    (folder / "line.toml").write_text(f'{text}at = "50%,80%"\nrotate = 3\n', encoding="utf-8")
    assert any(line.startswith(gone) for line in tables(saved(*words[:-2]))[table])
    assert not any(line.startswith(gone) for line in tables(saved(*words))[table])
