"""The studio's document is saved with what was dropped and painted, and comes back after a crash."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from stack_cases import write_maps
from studio_cases import Client, ask, exported, served, until

import nmaptool as nm
from nmaptool.studio.document import Document, History, opened
from nmaptool.studio.files import recovery
from nmaptool.studio.files.store import Store

BRUSH = {"tool": "paint", "size": 12, "value": 0, "hardness": 1, "opacity": 1}


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def paint(live, role="delta_map", x=15):
    ask(live, do="paint", role=role, brush=BRUSH, points=[[x, 20, 1]])
    return until(live, "state", lambda found: found["files"][role])["files"][role]


def test_dropped_and_painted_files_are_saved_beside_the_recipe(folder, tmp_path, run):
    home = tmp_path / "home"
    home.mkdir()
    shutil.copy(folder / "bunny.exr", home)
    with served(home / "bunny.exr", root=tmp_path / "state") as client, client.live() as live:
        until(live, "frame")
        client.drop(folder / "leaf.png")
        ask(live, do="add-layer", file="leaf.png")
        until(live, "state", lambda found: len(found["layers"]) == 2)
        paint(live)
        ask(live, do="set", values={"height": "2mm", "base": "1mm"})
        ask(live, do="save", name="scene")
        state = until(live, "state", lambda found: found["is_saved"])
        assert state["name"] == "scene.toml"
        assert [layer["file"] for layer in state["layers"]] == ["bunny.exr", "leaf.png"]
        assert state["files"]["delta_map"] == "scene-delta-map.png"
        assert until(live, "saved")["files"] == ["leaf.png", "scene-delta-map.png"]
        said = exported(live, format="stl")
        bytes_ = client.get(f"/export/{said['id']}").body
        assert run("relief", home / "scene.toml", "-o", home / "scene.stl").code == 0
        assert bytes_ == (home / "scene.stl").read_bytes()
        first = (home / "scene-delta-map.png").read_bytes()
        # painted again: the file of the recipe is replaced
        paint(live, x=25)
        ask(live, do="save")
        until(live, "state", lambda found: found["is_saved"])
        assert (home / "scene-delta-map.png").read_bytes() != first
        # under another name: its own files
        paint(live, x=5)
        ask(live, do="save", name="other.toml")
        state = until(live, "state", lambda found: found["is_saved"])
        assert state["files"]["delta_map"] == "other-delta-map.png"
        ask(live, do="undo")
        assert until(live, "state")["name"] == "other.toml"  # the file stays, the stroke is undone
    assert list((tmp_path / "state").iterdir()) != []  # not saved after the undo


def test_saving_replaces_no_other_file(folder, tmp_path):
    (folder / "scene-mask.png").write_bytes(b"mine")
    with served(folder / "bunny.exr", root=tmp_path / "state") as client, client.live() as live:
        until(live, "frame")
        paint(live, "mask")
        (folder / "leaf.png").rename(folder / "kept.png")
        (folder / "leaf.png").write_bytes(b"mine, too")
        client.drop(folder / "kept.png", "leaf.png")
        ask(live, do="add-layer", file="leaf.png")
        until(live, "state", lambda found: len(found["layers"]) == 2)
        ask(live, do="save", name="scene")
        assert until(live, "saved")["files"] == ["leaf-2.png", "scene-mask-2.png"]
    assert (folder / "scene-mask.png").read_bytes() == b"mine"
    assert (folder / "leaf.png").read_bytes() == b"mine, too"
    assert nm.read_recipe(folder / "scene.toml").relief.files.mask == "scene-mask-2.png"
    assert list((tmp_path / "state").iterdir()) == []  # everything was saved


def test_recipes_of_the_folder_are_opened_and_undone(folder, tmp_path):
    (folder / "one.toml").write_text('[[layer]]\nfile = "plate.exr"\n[relief]\nmu = 0.7\n', encoding="utf-8")
    with served(folder / "bunny.exr", root=tmp_path / "state") as client, client.live() as live:
        ask(live, do="recipes")
        found = until(live, "recipes")
        assert (found["names"], found["folder"]) == (["one.toml"], str(folder))
        ask(live, do="open", name="one.toml")
        state = until(live, "state", lambda found: found["name"] == "one.toml")
        assert (state["is_saved"], state["values"]["mu"]) == (True, 0.7)
        ask(live, do="undo")
        state = until(live, "state", lambda found: found["name"] == "bunny")
        assert state["path"] is None
        ask(live, do="open", name="../one.toml")
        assert until(live, "state")["name"] == "one.toml"  # folders of a name are not followed
        ask(live, do="open", name="none.toml")
        assert "none.toml: no such file" in until(live, "error")["text"]
        ask(live, do="open")
        assert "name the recipe to open" in until(live, "error")["text"]


def test_the_path_of_a_saved_document_holds_for_its_steps(tmp_path):
    document = Document.of(nm.parse_recipe({"layer": [{"file": "a.png"}]}))
    history = History(document)
    history.do(document.changed({"mu": 0.5}))
    history.moved(None, tmp_path / "a.toml")
    assert history.now.path == tmp_path / "a.toml"
    history.undo()
    assert history.now.path == tmp_path / "a.toml"


START = """
import sys
from pathlib import Path
from nmaptool.studio.document import opened
from nmaptool.studio.server import Studio
studio = Studio(opened(sys.argv[2:]), root=Path(sys.argv[1]))
print(studio.address, flush=True)
studio.run()
"""


class Killed:
    """The address of a studio in another process."""

    def __init__(self, process):
        self.address = process.stdout.readline().strip()
        self.port = int(self.address.partition("127.0.0.1:")[2].partition("/")[0])


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGKILL")
def test_work_is_recovered_after_a_kill(folder, tmp_path):
    root = tmp_path / "state"
    command = [sys.executable, "-c", START, str(root), str(folder / "bunny.exr")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        client = Client(Killed(process))
        with client.live() as live:
            until(live, "frame")
            file = paint(live)
            grey = nm.read_grey(folder / file)
            ask(live, do="set", values={"mu": 0.6})
            until(live, "state")
            facts = next(root.iterdir()) / "autosave.json"
            recipe = facts.with_suffix(".toml")
            while not (facts.exists() and "mu = 0.6" in recipe.read_text(encoding="utf-8")):
                time.sleep(0.05)
            # while it runs, its work is not offered to others
            assert recovery.found(root, root) == []
        process.send_signal(signal.SIGKILL)
        process.wait(10)
    with served(root=root) as client, client.live() as live:
        (item,) = until(live, "unsaved")["items"]
        assert item["name"] == "bunny"
        assert abs(item["time"] - time.time()) < 60
        ask(live, do="recover", id=item["id"])
        state = until(live, "state", lambda found: found["layers"])
        assert until(live, "unsaved")["items"] == []
        assert state["values"]["mu"] == 0.6
        assert state["layers"][0]["file"] == "bunny.exr"
        assert np.array_equal(nm.read_grey(folder / state["files"]["delta_map"]), grey)
        until(live, "frame")
        ask(live, do="save", name="back.toml")
        assert until(live, "saved")["path"] == str(folder / "back.toml")
    assert list(root.iterdir()) == []


def test_unsaved_work_is_discarded_or_gone(folder, tmp_path):
    store = Store(tmp_path / "state")
    recovery.keep(store, opened([str(folder / "bunny.exr")]))
    old = Store(tmp_path / "state")
    recovery.keep(old, opened([str(folder / "leaf.png")]))
    facts = json.loads((old.folder / "autosave.json").read_text(encoding="utf-8"))
    (old.folder / "autosave.json").write_text(json.dumps({**facts, "time": 1e9}), encoding="utf-8")
    broken = Store(tmp_path / "state")
    (broken.folder / "autosave.json").write_text("{", encoding="utf-8")
    with served(root=tmp_path / "state") as client, client.live() as live:
        (item,) = until(live, "unsaved")["items"]
        assert not old.folder.exists()  # older than a month
        ask(live, do="discard", id="../" + item["id"])
        assert "not there any more" in until(live, "error")["text"]
        ask(live, do="discard", id=item["id"])
        assert until(live, "unsaved")["items"] == []
        assert not store.folder.exists()
