"""Exports of the studio: what is said before, during and after them, and that they equal those of the command line."""

import threading
import time

import numpy as np
import pytest
from stack_cases import write_maps
from studio_cases import ask, exported, served, until

import nmaptool as nm
from nmaptool.options.formats import HEIGHT_FORMATS, MESH_FORMATS
from nmaptool.studio.document import opened
from nmaptool.studio.engine import Engine
from nmaptool.studio.files import export as exporting
from nmaptool.studio.files.estimates import estimate
from nmaptool.studio.files.export import Wanted, export, formats
from nmaptool.studio.files.exports import Exports
from nmaptool.studio.files.store import Store

MESHES = [ending[1:] for ending in MESH_FORMATS]


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


@pytest.fixture
def document(folder):
    return opened([str(folder / "bunny.exr")])


def solid_document(document, **more):
    return document.changed({"height": "2mm", "base": "1mm", **more})


def test_every_format_of_the_command_line_is_offered():
    offered = {one["format"] for one in formats()}
    tables = {ending[1:] for ending in (*MESH_FORMATS, *HEIGHT_FORMATS)}
    assert offered == (tables | {"preview"}) - {"tiff"}  # the same as tif
    with pytest.raises(nm.UsageError, match="'zip': a relief is written as stl, ply, "):
        Wanted("zip")


@pytest.mark.parametrize("format_", [*MESHES, "exr", "tif", "npy", "png"])
def test_an_export_holds_what_the_command_line_writes(document, folder, run, format_):
    document = solid_document(document) if format_ in MESHES else document
    nm.write_recipe(document.recipe, folder / "scene.toml")
    made, wanted = folder / "made", folder / f"scene.{format_}"
    made.mkdir()
    export(document, made / wanted.name, Wanted(format_))
    done = run("relief", folder / "scene.toml", "-o", wanted)
    assert done.code == 0, done.err
    if format_ in MESHES or format_ == "npy":
        assert (made / wanted.name).read_bytes() == wanted.read_bytes()
    else:  # the command line also names the files that it read
        both = [nm.read_height(path) for path in (made / wanted.name, wanted)]
        assert np.array_equal(both[0].z_mm, both[1].z_mm)


def test_the_preview_is_that_of_the_command_line(document, folder, run):
    nm.write_recipe(document.recipe, folder / "scene.toml")
    export(document, folder / "own.png", Wanted("preview"))
    done = run("relief", folder / "scene.toml", "--preview", folder / "scene.png")
    assert done.code == 0, done.err
    own, other = (nm.read_raster(folder / name).pixels for name in ("own.png", "scene.png"))
    assert np.array_equal(own, other)


@pytest.mark.parametrize("base", [None, "1mm"])
@pytest.mark.parametrize("format_", ["stl", "ply", "npy"])
def test_the_estimate_is_exact_where_it_says_so(document, folder, format_, base):
    document = document.changed({"base": base})
    path = folder / f"made.{format_}"
    for at in ("centers", "corners") if format_ == "npy" else ("centers",):
        said = estimate(Engine(document), document, Wanted(format_, at))
        export(document, path, Wanted(format_, at))
        assert said["precision"] == "exact"
        assert said["bytes"] == path.stat().st_size
        if format_ != "npy":
            assert said["is_closed"] is (base is not None)
            assert said["triangles"] == len(nm.read_mesh(path).faces)
        path.unlink()


def test_the_estimate_of_a_thinned_mesh_is_an_upper_limit(document, folder):
    whole = estimate(Engine(document), document, Wanted("stl"))
    document = document.changed({"triangles": "300"})
    said = estimate(Engine(document), document, Wanted("stl"))
    assert (said["triangles"], said["precision"], said["at_most"]) == (300, "at most", True)
    assert said["bytes"] < whole["bytes"]
    made = export(document, folder / "made.stl", Wanted("stl"))
    assert len(nm.read_mesh(folder / "made.stl").faces) <= 300
    assert any("from the full grid" in note for note in made.notes)


def test_what_the_command_line_warns_of_is_told(document, folder):
    made = export(document.changed({"beta": 0.9}), folder / "flat.stl", Wanted("stl"))
    assert any("flattens shapes" in warning for warning in made.warnings)
    assert "the mesh is an open surface; add `base='2mm'` for a solid" in made.notes
    made = export(solid_document(document, hollow="9mm"), folder / "hollow.stl", Wanted("stl"))
    assert any("nothing to hollow" in warning for warning in made.warnings)


class Slow:
    """Stands in for `export` where a test needs one that lasts until it is told to end."""

    def __init__(self, monkeypatch):
        self.started, self.go_on = threading.Event(), threading.Event()
        monkeypatch.setattr("nmaptool.studio.files.exports.export", self)

    def __call__(self, document, path, wanted, progress):
        path.write_bytes(b"half")
        self.started.set()
        while not self.go_on.wait(0.01):
            progress("solving", 0.25)
        return exporting.Exported((), ())


@pytest.fixture
def slow(monkeypatch):
    made = Slow(monkeypatch)
    yield made
    made.go_on.set()


def ended(said, thread_name="studio export"):
    for thread in threading.enumerate():
        if thread.name == thread_name:
            thread.join(10)
    return said[-1][1]


def test_one_export_at_a_time(document, tmp_path, slow):
    said = []
    exports = Exports(Store(tmp_path / "state"), lambda window, message: said.append((window, message)))
    begun = exports.begin("one", document, Wanted("stl"), "relief")
    assert (begun["state"], begun["name"]) == ("begun", "relief.stl")
    assert slow.started.wait(10)
    with pytest.raises(nm.UsageError, match="another export is under way"):
        exports.begin("other", document, Wanted("stl"), "relief")
    exports.cancel("other")  # is not its export
    assert exports.take(begun["id"]) is None
    slow.go_on.set()
    assert ended(said)["state"] == "done"
    job = exports.take(begun["id"])
    assert job.path.read_bytes() == b"half"
    assert exports.take("guess") is None
    slow.go_on.clear()
    exports.begin("other", document, Wanted("stl"), "relief")
    assert not job.path.exists()
    exports.close()
    assert list((tmp_path / "state").rglob("*.stl")) == []


def test_cancelling_ends_an_export_and_leaves_no_file(document, tmp_path, slow):
    said, store = [], Store(tmp_path / "state")
    exports = Exports(store, lambda window, message: said.append((window, message)))
    begun = exports.begin("one", document, Wanted("stl"), "relief")
    assert slow.started.wait(10)
    while not said:
        time.sleep(0.01)
    exports.cancel("one")
    assert ended(said)["state"] == "cancelled"
    assert {window for window, _ in said} == {"one"}
    assert said[0][1]["stage"] == "solving"
    assert list(store.folder.iterdir()) == []
    assert exports.take(begun["id"]) is None


def test_a_failure_is_said_and_the_next_export_can_begin(document, tmp_path):
    said = []
    exports = Exports(Store(tmp_path / "state"), lambda window, message: said.append((window, message)))
    exports.begin("one", document.changed({"base": "1mm", "delta": -300}), Wanted("stl"), "relief")
    last = ended(said)
    assert last["state"] == "failed"
    assert "base" in last["text"]
    exports.begin("one", document, Wanted("stl"), "relief")
    assert ended(said)["state"] == "done"


def test_an_estimate_that_a_newer_one_replaces_is_not_sent(document, tmp_path):
    said = []
    exports = Exports(Store(tmp_path / "state"), lambda window, message: said.append((window, message)))
    engine = Engine(document)
    exports.estimate("one", None, document, Wanted("stl"))
    assert said.pop()[1]["text"] == "the maps are being read"
    for format_ in ("stl", "ply", "npy"):
        exports.estimate("one", engine, document, Wanted(format_))
    last = ended(said, "studio estimate")
    assert last["format"] == "npy"


def test_only_the_window_that_asks_hears_of_its_export(folder):
    with served(folder / "bunny.exr") as client, client.live() as one, client.live() as other:
        for live in (one, other):
            until(live, "frame")
        ask(one, do="estimate", format="stl")
        assert until(one, "estimate")["precision"] == "exact"
        made = exported(one, format="png", at="corners")
        assert made["name"] == "bunny.png"
        assert made["bytes"] > 0
        ask(other, do="export", format="zip")
        assert "a relief is written as" in until(other, "error")["text"]
        with pytest.raises(TimeoutError):
            while True:
                assert "export" not in other.recv(timeout=0.2)
        assert client.get(f"/export/{made['id']}", {}).status == 403
        assert client.get(f"/export/{made['id']}").status == 200


def test_a_window_that_closes_ends_its_export(folder, slow):
    with served(folder / "bunny.exr") as client, client.live() as other:
        with client.live() as live:
            until(live, "frame")
            ask(live, do="export", format="stl")
            assert slow.started.wait(10)
        deadline = time.monotonic() + 10
        while any(thread.name == "studio export" for thread in threading.enumerate()):
            assert time.monotonic() < deadline
            time.sleep(0.01)
        slow.go_on.set()
        assert exported(other, format="stl")["state"] == "done"
