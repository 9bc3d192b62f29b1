"""The studio's server on this machine: who may speak to it, and what it answers."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from stack_cases import write_maps
from studio_cases import ask, exported, served, until
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import nmaptool as nm
from nmaptool.studio.document import opened
from nmaptool.studio.server import Studio

PAGE = Path(nm.__file__).parent / "studio" / "page"


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


@pytest.fixture
def client(folder):
    with served(folder / "bunny.exr", root=folder / "state") as found:
        yield found


def test_the_token_opens_the_page(client):
    answer = client.get(f"/?token={client.token}", {})
    assert (answer.status, answer.getheader("location")) == (303, "/")
    cookie = answer.getheader("set-cookie")
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    page = client.get("/")
    assert page.status == 200
    assert b"nmap studio" in page.body
    assert "script-src 'self'" in page.getheader("content-security-policy")
    assert page.getheader("x-content-type-options") == "nosniff"
    for path in (path for path in PAGE.rglob("*") if path.is_file()):
        assert client.get(f"/page/{path.relative_to(PAGE).as_posix()}").status == 200


@pytest.mark.parametrize("headers", [{}, {"Cookie": "nmap-studio=guess"}, {"Cookie": "=;"}])
@pytest.mark.parametrize("path", ["/", "/page/main.js", "/export/stl", "/?token=guess"])
def test_nothing_is_served_without_the_token(client, path, headers):
    answer = client.get(path, headers)
    assert answer.status == 403
    assert b"it holds the token" in answer.body


def test_other_hosts_and_origins_are_refused(client):
    for host in ("evil.example", "evil.example:80", f"127.0.0.1.evil.example:{client.host[10:]}"):
        assert client.get("/", {**client.cookie, "Host": host}).status == 403
    assert client.get("/", {**client.cookie, "Origin": "http://evil.example"}).status == 403
    assert client.get("/", {**client.cookie, "Origin": f"http://{client.host}"}).status == 200
    assert client.get("/", client.cookie, "POST").status == 403
    for origin in ("http://evil.example", "null", "http://127.0.0.1"):
        with pytest.raises(InvalidStatus, match="403"):
            client.live(origin)
    with pytest.raises(InvalidStatus, match="403"):
        client.live(headers={})


def test_files_outside_the_page_are_not_served(client):
    for path in ("/page/../server.py", "/page/%2e%2e/server.py", "/page/..%2fserver.py", "/etc/passwd", "/nothing"):
        assert client.get(path).status == 404


def test_a_window_gets_the_document_and_its_heights(client, folder):
    with client.live() as live:
        assert len(until(live, "controls")["controls"]) > 8
        state = until(live, "state")
        assert state["values"]["mu"] == 0.1
        assert state["is_saved"] is False
        header, fields, surface = until(live, "frame")
        assert (header["rows"], header["cols"]) == (41, 31)
        assert header["is_full"] is True
        assert set(fields) == {"first", "second"}
        assert surface.any()


def test_a_new_beta_gives_new_heights_and_a_new_height_none(client):
    with client.live() as live:
        before = until(live, "frame")[1]["first"]
        ask(live, do="set", values={"height": "3mm", "delta": 50})
        assert until(live, "state")["values"]["height"] == "3mm"
        ask(live, do="set", values={"beta": 0.05})
        header, fields, _ = until(live, "frame")
        assert header["request"] == 2  # the height needed no request
        assert fields["first"].max() < 0.8 * before.max()


def test_steps_are_undone_in_every_window(client):
    with client.live() as one, client.live() as other:
        for live in (one, other):
            until(live, "state")
        for step in range(1, 6):
            ask(one, do="set", values={"mu": 0.1 * step}, moving=True)
        ask(one, do="set", values={"mu": 0.5}, moving=False)
        until(other, "state", lambda found: found["values"]["mu"] == 0.5)
        ask(other, do="set", values={"beta": 0.02})
        for live in (one, other):
            while (state := until(live, "state"))["values"]["beta"] != 0.02:
                assert state["undo"] >= 1
        ask(one, do="undo")
        ask(one, do="undo")
        while until(other, "state")["values"]["mu"] != 0.1:
            pass
        ask(other, do="redo")
        assert until(one, "state")["kind"] == "state"


def test_wrong_values_and_messages_are_answered_in_one_line(client):
    with client.live() as live:
        ask(live, do="set", values={"mu": -3})
        assert until(live, "error")["text"].startswith("mu = -3: must be zero or more")
        ask(live, do="dance")
        assert "does not know" in until(live, "error")["text"]
        live.send("[1, 2]")
        assert "does not know" in until(live, "error")["text"]
        live.send("{")
        assert "does not know" in until(live, "error")["text"]
        ask(live, do="set", values=3)
        assert "sent no values" in until(live, "error")["text"]
        ask(live, do="set", values={"mu": 0.2})
        assert until(live, "state")["values"]["mu"] == 0.2
    with client.live() as live:
        live.send(" " * (2 << 20))
        with pytest.raises(ConnectionClosed):
            for _ in range(20):
                live.recv(timeout=5)


def test_a_saved_recipe_makes_the_bytes_of_the_export(client, folder, run):
    with client.live() as live:
        ask(live, do="set", values={"height": "2mm", "beta": 0.01, "base": "1mm"})
        until(live, "state")
        ask(live, do="save")
        assert "give the recipe a name" in until(live, "error")["text"]
        ask(live, do="save", name="../relief")
        assert until(live, "state")["is_saved"] is True
        assert until(live, "saved")["path"] == str(folder / "relief.toml")
        (folder / "other.toml").write_text("mine", encoding="utf-8")
        ask(live, do="save", name="other.toml")
        assert "other.toml: exists already" in until(live, "error")["text"]
        assert (folder / "other.toml").read_text(encoding="utf-8") == "mine"
        made = exported(live, format="stl")
        assert (made["state"], made["name"]) == ("done", "relief.stl")
    file = client.get(f"/export/{made['id']}")
    assert file.status == 200
    assert 'filename="relief.stl"' in file.getheader("content-disposition")
    done = run("relief", folder / "relief.toml", "-o", folder / "relief.stl")
    assert done.code == 0, done.err
    assert file.body == (folder / "relief.stl").read_bytes()
    assert client.get(f"/export/{made['id']}").status == 404  # it is handed out once


def test_a_map_that_cannot_be_read_is_said_in_every_window(tmp_path):
    (tmp_path / "bad.png").write_bytes(b"no picture")
    with served(tmp_path / "bad.png", root=tmp_path / "state") as client:
        for _ in range(2):
            with client.live() as live:
                assert "bad.png" in until(live, "error")["text"]
        with client.live() as live:
            made = exported(live, format="stl")
            assert made["state"] == "failed"
            assert "bad.png" in made["text"]


# the shell of a test run may have made it ignore Ctrl-C
COMMAND = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from nmaptool_cli.start import run
sys.exit(run())
"""


def test_ctrl_c_ends_the_command(folder):
    command = [sys.executable, "-c", COMMAND, "studio", str(folder / "bunny.exr"), "--no-browser"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        address = process.stderr.readline().strip()
        assert re.fullmatch(r"nmap studio: http://127\.0\.0\.1:\d+/\?token=\S{32}", address)
        host, _, token = address.removeprefix("nmap studio: http://").partition("/?token=")
        more = {"Cookie": f"nmap-studio={token}"}
        with connect(f"ws://{host}/live", origin=f"http://{host}", additional_headers=more, max_size=None) as live:
            until(live, "frame")
            process.send_signal(signal.SIGINT)
            with pytest.raises(ConnectionClosed):
                while True:
                    live.recv(timeout=10)
        assert process.wait(10) == 0
        assert process.stderr.read() == "  Ctrl-C ends it\n"
    finally:
        process.kill()
        process.communicate()


def test_a_taken_port_is_said(client, folder):
    port = int(client.host.rpartition(":")[2])
    with pytest.raises(nm.OutputError, match=rf"port {port} cannot be used \(.*\); choose another one with `port`"):
        Studio(opened([str(folder / "bunny.exr")]), port, root=folder / "state")


def test_another_address_of_this_machine_is_served_if_it_is_given(folder):
    for wrong in ("", "0.0.0.0", "::"):
        with pytest.raises(nm.UsageError, match="stands for every address; give one, such as"):
            Studio(opened([str(folder / "bunny.exr")]), host=wrong, root=folder / "state")
    with pytest.raises(
        nm.OutputError, match=r"192\.0\.2\.1, port 0, cannot be used \(.*\); choose another one with `host`"
    ):
        Studio(opened([str(folder / "bunny.exr")]), host="192.0.2.1", root=folder / "state")
    if sys.platform != "linux":  # others have no second address that is always there
        return
    with served(folder / "bunny.exr", root=folder / "state", host="127.0.0.2") as client:
        assert client.studio.address.startswith("http://127.0.0.2:")
        assert client.get("/").status == 200
        other = f"127.0.0.1:{client.studio.port}"
        assert client.get("/", {**client.cookie, "Host": other}).status == 403
