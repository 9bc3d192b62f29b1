"""Meshes in the studio: read, shown, and baked to the maps of the command line."""

import json
import re
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from bake_cases import write_plate
from mesh_cases import sphere
from studio_cases import ask, running, until

import nmaptool as nm
from nmaptool.core.errors import RendererError
from nmaptool.render import rendering
from nmaptool.studio.document import Document, opened
from nmaptool.studio.server import Studio

QUICK = {"camera": {"size": "60x50", "margin": "2px", "renderer": "numpy"}, "filter": {"sigma_s": "4"}}


def studio(folder, *meshes, maps=()):
    """A client of a studio with meshes."""
    document = opened([str(file) for file in maps]) if maps else Document(folder=folder)
    return running(Studio(document, root=folder / "state", meshes=meshes))


@pytest.fixture
def plate(tmp_path):
    return write_plate(tmp_path / "plate.obj")


def ready(live):
    """Wait until all meshes are read; the entry of the first in the list."""
    found = [{"state": "reading"}]
    while any(one["state"] == "reading" for one in found):
        found = until(live, "meshes")["meshes"]
    return found[0]


def ended(live, kind="bake"):
    """The messages of a job until it has ended, the last of each kind."""
    seen = {}
    while seen.get(kind, {}).get("state") not in ("done", "failed", "cancelled"):
        message = live.recv(timeout=30)
        if not isinstance(message, bytes):
            found = json.loads(message)
            assert found["kind"] != "error", found
            seen[found["kind"]] = found
    return seen


def post(client, path, body):
    """Send bytes, or a value as JSON, as the page does."""
    headers = {**client.cookie, "Origin": f"http://{client.host}"}
    return client.get(path, headers, "POST", body if isinstance(body, bytes) else json.dumps(body))


def shown(body):
    """Header, corners, positions and triangles of a display mesh."""
    length = int.from_bytes(body[:4], "little")
    header = json.loads(body[4 : 4 + length])
    corners = np.frombuffer(body, "<f8", 3 * header["corners"], 4 + length).reshape(-1, 3)
    at = 4 + length + corners.nbytes
    positions = np.frombuffer(body, "<f4", 3 * header["vertices"], at).reshape(-1, 3)
    triangles = np.frombuffer(body, "<u4", 3 * header["triangles"], at + positions.nbytes).reshape(-1, 3)
    assert at + positions.nbytes + triangles.nbytes == len(body)
    return header, corners, positions, triangles


def undated(path):
    """The bytes of an EXR file without the time at which it was written."""
    found = path.read_bytes()
    dates = re.findall(rb"\d{4}:\d\d:\d\d \d\d:\d\d:\d\d", found)
    assert len(dates) == 1
    return found.replace(dates[0], b"")


def test_a_mesh_of_the_command_opens_the_camera_of_the_first_window(tmp_path, plate):
    with studio(tmp_path, plate) as client:
        with client.live() as live:
            assert until(live, "mesh") == {"kind": "mesh", "id": "1", "name": "plate.obj"}
        with client.live() as live:
            assert ready(live) == {"id": "1", "name": "plate.obj", "state": "ready", "text": "625 vertices, 1152 faces"}
        header, corners, positions, triangles = shown(client.get("/mesh/1").body)
        mesh = nm.read_mesh(plate)
        assert np.array_equal(triangles, mesh.faces)
        assert np.allclose(positions + header["origin"], mesh.vertices, atol=1e-5)
        assert header["all_triangles"] == 1152
        assert {tuple(corner) for corner in corners} <= {tuple(vertex) for vertex in mesh.vertices}
        assert client.get("/mesh/2").status == 400
        assert client.get("/mesh/1", {}).status == 403


def test_a_bake_writes_the_files_of_the_command_line_and_is_one_step(tmp_path, plate, run):
    with studio(tmp_path, plate) as client, client.live() as live:
        ready(live)
        ask(live, do="bake", id="1", values=QUICK)
        seen = ended(live)
        assert "of the surface is detail, rendered by numpy" in seen["bake"]["text"]
        (layer,) = seen["state"]["layers"]
        assert layer["label"] == "plate"
        assert seen["state"]["undo"] == 1
        words = ("--size", "60x50", "--margin", "2px", "--renderer", "numpy", "--sigma-s", "4")
        done = run("bake", plate, "-o", tmp_path / "maps", *words)
        assert done.code == 0, done.err
        original = tmp_path / layer["file"]
        for name in ("original", "base", "detail"):
            made = original.with_name(f"plate-{name}.exr")
            assert undated(made) == undated(tmp_path / "maps" / f"{name}.exr")
        assert seen["state"]["files"]["detail"].endswith("/plate-detail.exr")
        assert until(live, "frame")[0]["is_full"]
        ask(live, do="undo")
        state = until(live, "state")
        assert (state["layers"], state["files"]["detail"]) == ([], None)


def test_opengl_works_in_the_thread_of_each_bake(tmp_path, plate):
    values = {"camera": {"size": "60x50"}}
    try:
        with rendering.rendering("auto") as (_, platform):
            pass
    except RendererError:
        pytest.skip("no OpenGL")
    with studio(tmp_path, plate) as client, client.live() as live:
        ready(live)
        for count in range(1, 4):
            ask(live, do="bake", id="1", values=values)
            seen = ended(live)
            assert seen["bake"]["text"].startswith("plate.obj: ")
            assert f"rendered by {platform}" in seen["bake"]["text"]
            assert len(seen["state"]["layers"]) == count


def test_one_job_runs_at_a_time_and_can_be_cancelled(tmp_path, plate, monkeypatch):
    goes_on = threading.Event()

    def slow(mesh, options, filter, *, progress):
        progress("filtering", 0.1)
        goes_on.wait(20)
        return nm.bake(mesh, options, filter, progress=progress)

    monkeypatch.setattr("nmaptool.studio.meshes.bakes.baked", slow)
    with studio(tmp_path, plate) as client, client.live() as live:
        ready(live)
        ask(live, do="bake", id="1", values=QUICK)
        assert until(live, "bake")["state"] == "running"
        ask(live, do="bake", id="1", values=QUICK)
        text = until(live, "error")["text"]
        assert text == (
            "bake plate.obj: the studio is still at work (bake plate.obj); wait until it is done, or cancel it"
        )
        with client.live() as other:
            assert until(other, "meshes")["running"]["what"] == "bake plate.obj"
        ask(live, do="set", values={"mu": 0.3})
        assert until(live, "state")["values"]["mu"] == 0.3  # the document can be changed meanwhile
        ask(live, do="cancel-bake")
        time.sleep(0.1)
        goes_on.set()
        while (message := until(live, "bake"))["state"] == "running":
            pass
        assert message["state"] == "cancelled"
        assert list((tmp_path / "state").glob("*/*.exr")) == []
        ask(live, do="bake", id="1", values=QUICK)
        assert ended(live)["bake"]["state"] == "done"


def test_baking_again_replaces_the_map_of_the_layer_alone(tmp_path, plate):
    with studio(tmp_path, plate) as client, client.live() as live:
        ready(live)
        ask(live, do="bake", id="1", values=QUICK)
        before = ended(live)["state"]["layers"][0]
        placed = {"name": "left", "rotate": 20.0, "scale": "0.5", "at": "30%,50%"}
        brush = {"tool": "paint", "size": 16, "value": 0, "hardness": 1, "opacity": 1}
        until(live, "frame")
        ask(live, do="paint", role="layer-mask", place=[0], brush=brush, points=[[15, 20, 1]])
        mask = until(live, "state", lambda found: found["layers"][0]["mask"])["layers"][0]["mask"]
        ask(live, do="set-layer", place=[0], values=placed)
        again = {"camera": {**QUICK["camera"], "azimuth": 30.0}, "filter": {}}
        while until(live, "meshes")["layers"][0]["label"] != "left":
            pass
        ask(live, do="bake", id="1", values={"camera": {**again["camera"], "size": "70x50"}}, place=[0])
        assert "the layer has a mask of 60 x 50 px; keep this size" in until(live, "error")["text"]
        ask(live, do="bake", id="1", values=again, place=[0])
        seen = ended(live)
        (after,) = seen["state"]["layers"]
        assert after["file"] != before["file"]
        assert (after["options"]["name"], after["options"]["rotate"], after["mask"]) == ("left", 20.0, mask)
        assert seen["meshes"]["layers"][0]["values"] == again
        original = nm.read_normal_map(tmp_path / after["file"])
        made = nm.BakeOptions(size="60x50", margin=nm.length("2px"), renderer="numpy", azimuth=30.0)
        assert np.array_equal(original.normals, nm.bake(nm.read_mesh(plate), made).original.normals)
        ask(live, do="close-mesh", id="1")
        ask(live, do="bake", id="1", values=again, place=[0])
        assert "drop it again" in until(live, "error")["text"]


def test_a_dropped_mesh_is_opened_by_its_name(tmp_path, plate):
    with studio(tmp_path) as client, client.live() as live:
        answer = post(client, "/files/plate.obj", plate.read_bytes())
        assert json.loads(answer.body) == {"file": "plate.obj", "kind": "mesh"}
        ask(live, do="open-mesh", file="plate.obj")
        assert until(live, "mesh") == {"kind": "mesh", "id": "1", "name": "plate.obj"}
        assert ready(live)["state"] == "ready"
        ask(live, do="open-mesh", file="../plate.obj")
        assert "was not dropped" in until(live, "error")["text"]


def test_faults_are_said_in_one_line(tmp_path, plate, monkeypatch):
    (tmp_path / "bad.ply").write_text("ply\nformat ascii 1.0\nelement vertex 2\nend_header\n", encoding="utf-8")
    with studio(tmp_path, tmp_path / "bad.ply", plate) as client, client.live() as live:
        bad = ready(live)
        assert bad["state"] == "failed"
        assert bad["text"].startswith("bad.ply: ")
        assert client.get("/mesh/1").status == 400
        for values, said in (
            ({"camera": {"size": "10"}}, "size = 10: expected columns x rows"),
            ({"camera": {"size": "20000x20000"}}, "megapixels"),
            ({"camera": {"view": "front,left"}}, "the camera shows one view"),
            ({"camera": {"roll": "much"}}, "roll = much: must be a number"),
            ({"camera": {"colour": 1}}, "colour: is not one of the options view, azimuth"),
            ({"camera": {"margin": "30px"}}, "leaves no room in 1000"),
            ({"filter": {"sigma_s": "4px"}}, "sigma s = 4px: a mesh has no pixels"),
            ({"filter": {"filter": "learned", "sigma_s": "4"}}, "a learned filter has no parameters"),
            ({"reading": {"unit": "mile"}}, "unit = mile: use one of mm, cm, m, in"),
            (3, "the page sent no options"),
        ):
            if said.startswith("leaves"):
                values["camera"] |= {"size": "1000x40"}
            answer = json.loads(post(client, "/mesh/2/check", values).body)
            assert said in answer["error"], answer
        assert post(client, "/mesh/2/check", " " * 200_000).status == 400
        assert client.get("/mesh/2/check", client.cookie, "POST").status == 403

        def none(_):
            raise RendererError("no OpenGL context is available; render without: `renderer='numpy'`")

        monkeypatch.setattr("nmaptool.baking.bake.rendering", none)
        ask(live, do="bake", id="2", values={})
        failed = ended(live)["bake"]
        assert failed["lacks_renderer"] is True
        assert failed["text"] == "no OpenGL context is available; render without: renderer = numpy"


def test_a_check_says_what_a_bake_gives(tmp_path):
    ball = nm.Mesh(sphere(6).vertices * 0.5, sphere(6).faces)
    nm.write_mesh(ball, tmp_path / "ball.ply")
    values = {
        "camera": {"size": "80x60", "margin": "5px", "azimuth": 20.0, "renderer": "numpy"},
        "filter": {"sigma_s": "3%"},
    }
    with studio(tmp_path, tmp_path / "ball.ply") as client:
        with client.live() as live:
            ready(live)
        for reading in ({}, {"unit": "cm"}):
            found = json.loads(post(client, "/mesh/1/check", {**values, "reading": reading}).body)
            options = nm.BakeOptions(size="80x60", margin=nm.length("5px"), azimuth=20.0, renderer="numpy")
            mesh = nm.read_mesh(tmp_path / "ball.ply", **reading)
            made = nm.bake(mesh, options, nm.FilterOptions(sigma_s=nm.length("3%")))
            assert found["size"] == [80, 60]
            assert found["pitch_mm"] == pytest.approx(made.frame.pitch_mm, rel=1e-9)
            assert found["sigma_s_px"] == pytest.approx(made.report.sigma_s_px, rel=1e-9)
            assert len(found["warnings"]) == len(made.report.warnings)
        wide = {**values, "camera": {**values["camera"], "width": "40mm"}}
        assert json.loads(post(client, "/mesh/1/check", wide).body)["pitch_mm"] == 0.5


def test_the_command_opens_meshes(tmp_path, run, monkeypatch, plate):
    served = []

    def no_run(self):
        served.append(self._room.now.folder)
        self._room.close()
        self._socket.close()

    monkeypatch.setattr("nmaptool.studio.server.Studio.run", no_run)
    monkeypatch.setattr("nmaptool.studio.server.user_state_path", lambda *_, **__: tmp_path / "home")
    done = run("studio", plate, "--no-browser")
    assert done.code == 0, done.err
    assert served == [Path(plate).parent]
    lacking = run("studio", tmp_path / "none.ply", "--no-browser")
    assert lacking.code == 3
    assert "none.ply: no such file" in lacking.err
