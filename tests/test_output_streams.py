"""Output to open streams: the same bytes as in files, and all or nothing."""

import io
import json
import re
import tempfile

import numpy as np
import pytest
from compose_cases import as_map, bump_map, random_normals
from learned_cases import small_filter
from workspace_cases import random_workspace

import nmaptool as nm
from nmaptool.core.errors import OutputError, UsageError


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """The folder of temporary files; nothing may remain in it."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []


@pytest.fixture(scope="module")
def relief():
    return nm.relief(bump_map(20, 30), options=nm.ReliefOptions(width=nm.length("30mm")))


WRITERS = {
    "map.exr": lambda place: nm.write_normal_map(bump_map(8, 9), place),
    "map.png": lambda place: nm.write_normal_map(bump_map(8, 9), place, nm.WriteOptions(bits="8")),
    "mesh.obj": lambda place: nm.write_mesh(nm.Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32)), place),
    "work.psd": lambda place: nm.write_workspace(random_workspace(), place),
    "work.ora": lambda place: nm.write_workspace(random_workspace(), place),
    "filter.npz": lambda place: nm.write_filter_model(small_filter(), place),
    "training.npz": lambda place: nm.write_training(nm.TrainingState("a"), place),
    "layers.exr": lambda place: nm.write_layers(nm.split(bump_map(20, 30)), place),
    "blend.tif": lambda place: nm.write_composition(nm.blend(bump_map(8, 9), bump_map(8, 9)), place),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_stream_gets_the_bytes_of_a_file(name, tmp_path, temporary):
    WRITERS[name](tmp_path / name)
    stream = io.BytesIO(b"before ")
    stream.seek(0, 2)
    WRITERS[name](nm.OutputStream(stream, name[name.index(".") :]))
    assert not stream.closed
    # image files contain the time of writing
    found, expected = (
        re.sub(rb"\d{4}:\d\d:\d\d \d\d:\d\d:\d\d", b"now", data)
        for data in (stream.getvalue(), (tmp_path / name).read_bytes())
    )
    assert found == b"before " + expected


def test_a_relief_is_written_to_streams_and_files_at_once(relief, tmp_path, temporary):
    streams = [nm.OutputStream(io.BytesIO(), ending) for ending in (".stl", ".npy", ".png", ".json")]
    *surfaces, preview, report = streams
    nm.write_relief(relief, *surfaces, tmp_path / "a.stl", preview=preview, report=report)
    stl, npy, png, facts = (each.stream.getvalue() for each in streams)
    assert stl == (tmp_path / "a.stl").read_bytes()
    assert np.load(io.BytesIO(npy)).shape == (20, 30)
    assert png.startswith(b"\x89PNG")
    assert json.loads(facts)["options"]["width"] == "30mm"


def test_a_conversion_is_written_to_a_stream(tmp_path, temporary):
    nm.write_normal_map(bump_map(8, 9), tmp_path / "a.exr")
    stream, report = io.BytesIO(), io.BytesIO()
    to = nm.OutputStream(stream, ".png", "the response")
    nm.convert(tmp_path / "a.exr", to, report=nm.OutputStream(report, ".json"))
    (tmp_path / "b.png").write_bytes(stream.getvalue())
    assert nm.read_normal_map(tmp_path / "b.png").frame == nm.Frame(8, 9)
    assert json.loads(report.getvalue())["outputs"] == ["the response", "stream"]


def test_nothing_is_written_to_a_stream_if_a_later_target_fails(relief, tmp_path, temporary, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("nmaptool.figures.preview.preview", full)
    stream = io.BytesIO()
    with pytest.raises(OutputError, match=r"p\.png: cannot be written \(No space left on device\)"):
        nm.write_relief(relief, nm.OutputStream(stream, ".stl"), tmp_path / "a.exr", preview=tmp_path / "p.png")
    assert stream.getvalue() == b""
    assert sorted(path.name for path in tmp_path.iterdir()) == ["temporary"]


def test_nothing_is_written_to_a_stream_if_a_file_cannot_be_renamed(relief, tmp_path, temporary, monkeypatch):
    written = nm.solid

    def late(relief):
        (tmp_path / "a.npy").write_text("another program's", encoding="utf-8")
        return written(relief)

    monkeypatch.setattr("nmaptool.solids.solid.solid", late)
    stream = io.BytesIO()
    with pytest.raises(OutputError, match=r"a\.npy: already exists"):
        nm.write_relief(relief, nm.OutputStream(stream, ".stl"), tmp_path / "a.npy")
    assert stream.getvalue() == b""
    assert (tmp_path / "a.npy").read_text(encoding="utf-8") == "another program's"


class Failing(io.RawIOBase):
    """A stream that accepts only a few bytes, and fails when it is flushed."""

    def __init__(self, error=None):
        super().__init__()
        self.taken, self.error = b"", error

    def writable(self):
        return True

    def write(self, data):
        self.taken += bytes(data[:100])
        return min(len(data), 100)

    def flush(self):
        error, self.error = self.error, None  # only once: closing also flushes
        if error is not None:
            raise error


@pytest.mark.parametrize(
    ("error", "expected", "message"),
    [
        (OSError(28, "No space left on device"), OutputError, r"the page: cannot be written \(No space left"),
        (BrokenPipeError(32, "Broken pipe"), BrokenPipeError, "Broken pipe"),
        (KeyboardInterrupt("now"), KeyboardInterrupt, "now"),
    ],
    ids=["full", "closed", "interrupted"],
)
def test_a_failing_stream_undoes_the_files(tmp_path, temporary, error, expected, message):
    mesh = nm.Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    (tmp_path / "old.stl").write_text("precious", encoding="utf-8")
    with pytest.raises(expected, match=message):
        nm.write_mesh(
            mesh,
            tmp_path / "new.ply",
            tmp_path / "old.stl",
            nm.OutputStream(Failing(error), ".glb", "the page"),
            overwrite=True,
        )
    assert not (tmp_path / "new.ply").exists()
    assert (tmp_path / "old.stl").read_text(encoding="utf-8") == "precious"


def test_a_stream_with_partial_writes_gets_everything(tmp_path, temporary):
    normal_map, stream = as_map(random_normals(20)), Failing()
    nm.write_normal_map(normal_map, tmp_path / "a.png")
    nm.write_normal_map(normal_map, nm.OutputStream(stream, ".png"))
    assert stream.taken == (tmp_path / "a.png").read_bytes()


def test_streams_that_cannot_be_written_are_refused(tmp_path):
    closed = io.BytesIO()
    closed.close()
    read_only = io.BufferedReader(io.BytesIO())
    for error, message, stream in (
        (UsageError, "^stream: is a text stream; give a binary stream$", io.StringIO()),
        (OutputError, "^stream: is not open for writing$", closed),
        (OutputError, "^stream: is not open for writing$", read_only),
    ):
        with pytest.raises(error, match=message):
            nm.write_normal_map(bump_map(8, 9), nm.OutputStream(stream, ".png"))
    shared = io.BytesIO()
    with pytest.raises(UsageError, match=r"^again: is named twice as an output$"):
        first, again = nm.OutputStream(shared, ".png"), nm.OutputStream(shared, ".png", "again")
        nm.write_composition(nm.blend(bump_map(8, 9), bump_map(8, 9)), first, curl=again)
    with pytest.raises(UsageError, match=r"^stream: ends in \.jpg; normal maps are written as \.png, \.exr"):
        nm.write_normal_map(bump_map(8, 9), nm.OutputStream(shared, ".jpg"))
    with pytest.raises(UsageError, match=r"^stream: layers are written into a folder"):
        nm.write_layers(nm.split(bump_map(20, 30)), nm.OutputStream(shared, ".png"))
    with pytest.raises(UsageError, match=r"^page: the extension 'png' must begin with a dot, such as \.png$"):
        nm.OutputStream(shared, "png", "page")
    assert shared.getvalue() == b""


def test_standard_output_stays_empty_if_an_image_fails(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    nm.write_normal_map(bump_map(8, 9), "a.exr")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("nmaptool.io.output.map_pictures.curl_picture", full)
    done = run("compose", "transform", "a.exr", "-o", "-", "--curl", "c.png")
    assert (done.code, done.out) == (5, "")
    assert "c.png: cannot be written (No space left on device)" in done.err
