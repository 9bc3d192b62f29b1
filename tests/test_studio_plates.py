"""Plates in the studio: kept, saved, exported, set by presets, and named on the page, which does not show them."""

import dataclasses
import json
import shutil
import tomllib
from pathlib import Path

import matplotlib
import pytest
from stack_cases import write_maps
from studio_cases import ask, exported, served, until

import nmaptool as nm
from nmaptool.studio.document import Document, opened
from nmaptool.studio.engine import Engine
from nmaptool.studio.files import recovery
from nmaptool.studio.files.estimates import estimate
from nmaptool.studio.files.export import Wanted, export
from nmaptool.studio.files.store import Store
from nmaptool.studio.forms.plates import plate_line
from nmaptool.studio.forms.presets import Presets

FONT = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans-Bold.ttf"
COIN = """[relief]
height = "0.5mm"
width = "20mm"
base = "1mm"

[plate]
shape = "round"
hole = "2mm@50%,4mm"

[frame]
width = "1mm"
profile = "bead"

[machine]
for = "fdm-0.4"

[[text]]
text = "ANNO"
path = "arc"
size = "2mm"
font = "fonts/title.ttf"

[[layer]]
file = "bunny.exr"
"""


@pytest.fixture
def folder(tmp_path, png):
    """Maps, a font, and the recipe of a coin."""
    write_maps(tmp_path, png)
    (tmp_path / "fonts").mkdir()
    shutil.copy(FONT, tmp_path / "fonts" / "title.ttf")
    (tmp_path / "coin.toml").write_text(COIN, encoding="utf-8")
    return tmp_path


@pytest.fixture
def coin(folder):
    return opened([str(folder / "coin.toml")])


def test_a_plate_stays_when_the_document_changes_and_is_saved(folder):
    with served(folder / "coin.toml") as client, client.live() as live:
        until(live, "frame")
        ask(live, do="set", values={"mu": 0.5, "height": "0.6mm"})
        ask(live, do="save")
        state = until(live, "state", lambda found: found["is_saved"] and found["values"]["mu"] == 0.5)
        assert state["values"]["max_error"] == "0.02mm"  # of the machine
        assert state["values"]["base"] == "1mm"
    before = nm.parse_recipe(tomllib.loads(COIN))
    after = nm.read_recipe(folder / "coin.toml")
    assert after.plate == before.plate
    assert after.relief.options == {"height": nm.length("0.6mm"), "width": nm.length("20mm"), "mu": 0.5}
    assert after.relief.solid == {"base": nm.length("1mm")}  # the machine's values are not written down


def test_saved_beside_another_name_the_font_is_still_found(folder, run):
    with served(folder / "coin.toml") as client, client.live() as live:
        until(live, "frame")
        ask(live, do="save", name="other.toml")
        until(live, "saved")
    done = run("relief", folder / "other.toml", "-o", folder / "other.stl")
    assert done.code == 0, done.err
    assert "fonts/title.ttf" in (folder / "other.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("format_", ["stl", "3mf", "ply", "npy"])
def test_an_export_has_the_plate_and_the_bytes_of_the_command_line(coin, folder, run, format_):
    (folder / "made").mkdir()
    made, wanted = folder / "made" / f"coin.{format_}", folder / f"coin.{format_}"
    said = export(coin, made, Wanted(format_))
    done = run("relief", folder / "coin.toml", "-o", wanted)
    assert done.code == 0, done.err
    assert made.read_bytes() == wanted.read_bytes()
    assert any(text.startswith("round plate 20 x 20 mm, ") for text in said.notes)
    assert any("finer than the 0.4 mm of fdm-0.4" in text for text in said.warnings)


def test_an_export_without_a_plate_follows_the_machine(folder, run):
    text = COIN.partition("[plate]")[0] + '[machine]\nfor = "fdm-0.4"\n[[layer]]\nfile = "bunny.exr"\n'
    (folder / "bare.toml").write_text(text, encoding="utf-8")
    export(opened([str(folder / "bare.toml")]), folder / "own.stl", Wanted("stl"))
    done = run("relief", folder / "bare.toml", "-o", folder / "bare.stl")
    assert done.code == 0, done.err
    assert (folder / "own.stl").read_bytes() == (folder / "bare.stl").read_bytes()


def test_the_page_exports_the_plate(folder, run):
    with served(folder / "coin.toml") as client, client.live() as live:
        until(live, "frame")
        made = exported(live, format="stl")
        assert made["state"] == "done", made
        body = client.get(f"/export/{made['id']}").body
    done = run("relief", folder / "coin.toml", "-o", folder / "coin.stl")
    assert done.code == 0, done.err
    assert body == (folder / "coin.stl").read_bytes()


def test_a_fault_of_the_plate_ends_the_export_and_not_the_stage(folder):
    (folder / "coin.toml").write_text(COIN.replace("title.ttf", "none.ttf"), encoding="utf-8")
    with served(folder / "coin.toml") as client, client.live() as live:
        until(live, "frame")
        made = exported(live, format="stl")
        assert made["state"] == "failed"
        assert "none.ttf: no such file" in made["text"]


def test_no_size_is_promised_before_the_plate_is_made(coin):
    for format_ in ("stl", "npy", "preview"):
        said = estimate(Engine(coin), coin, Wanted(format_))
        assert said["text"] == "its size is known once it is made, with its plate or for its machine"
        assert "bytes" not in said
    bare = dataclasses.replace(coin, plate=None)
    assert "text" not in estimate(Engine(bare), bare, Wanted("stl"))


def test_a_preset_sets_the_plate_and_keeps_the_texts(coin, folder):
    presets = Presets(folder / "presets")
    medal = presets.plate("medal", coin.plate, is_own=False)
    assert medal.plate == {"shape": "round", "margin": nm.length("3%")}
    assert medal.frame["frame_profile"] == "bead"
    assert medal.texts == coin.plate.texts
    assert medal.machine == coin.plate.machine
    bare = presets.plate("wood-panel", coin.plate, is_own=False)
    assert (bare.plate, bare.frame, bare.texts, bare.machine) == ({}, {}, (), coin.plate.machine)
    assert presets.plate("wood-panel", nm.RecipePlate(medal.plate), is_own=False) is None
    assert presets.plate("wood-panel", None, is_own=False) is None
    presets.save("Mine", coin)
    assert presets.plate("Mine", coin.plate, is_own=True) is coin.plate


def test_a_plate_of_a_preset_is_saved_and_read_unchanged(coin, folder):
    for name in ("coin", "cameo", "pendant", "tile", "box-lid"):
        plate = Presets(folder / "presets").plate(name, coin.plate, is_own=False)
        document = dataclasses.replace(coin, plate=plate)
        nm.write_recipe(document.recipe, folder / "again.toml", overwrite=True)
        assert nm.read_recipe(folder / "again.toml").plate == plate


def test_the_page_says_that_exports_have_a_plate(folder):
    with served(folder / "bunny.exr") as client, client.live() as live:
        assert until(live, "state")["plate"] is None
        ask(live, do="apply-preset", name="pendant")
        state = until(live, "state")
        assert state["plate"] == (
            "Exported files have a plate (round) with a frame and a loop. The stage shows the motif without it; "
            "% refer to the plate in exported files. Edit the plate in the recipe."
        )
        steps = state["undo"]
        ask(live, do="apply-preset", name="tile")
        state = until(live, "state")
        assert "a plate (rect) with a frame." in state["plate"]
        assert state["undo"] == steps + 1
        ask(live, do="apply-preset", name="wood-panel")
        assert until(live, "state")["plate"] is None
        ask(live, do="undo")
        assert "(rect)" in until(live, "state")["plate"]


def test_what_the_line_names(coin):
    assert plate_line(coin).startswith("Exported files have a plate (round) with a frame, 1 text and holes. ")
    plain = nm.RecipePlate({"shape": "shield.svg"})
    assert plate_line(dataclasses.replace(coin, plate=plain)).startswith("Exported files have a plate (shield.svg). ")
    machine = nm.RecipePlate(machine={"for_": "fdm-0.4"})
    assert plate_line(dataclasses.replace(coin, plate=machine)) is None
    assert plate_line(Document()) is None


def test_a_change_of_the_plate_alone_needs_no_heights(coin, folder):
    before = Engine(coin)
    changed = dataclasses.replace(coin, plate=None)
    assert before.fits(dataclasses.replace(coin, plate=nm.RecipePlate({"shape": "round"}, machine={"pitch": "1mm"})))
    assert before.scene.design is None
    assert changed.files == ("bunny.exr",)
    assert coin.files == ("bunny.exr", "fonts/title.ttf")


def test_unsaved_work_keeps_its_plate(coin, folder):
    store = Store(folder / "state")
    recovery.keep(store, coin.changed({"mu": 0.5}))
    facts = json.loads((store.folder / "autosave.json").read_text(encoding="utf-8"))
    assert facts["name"] == "coin.toml"
    kept = nm.read_recipe(store.folder / "autosave.toml", folder=folder)
    assert kept.plate == coin.plate
