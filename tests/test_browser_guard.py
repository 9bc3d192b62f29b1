"""Pages of others, in a real browser, get nothing from the studio; and its own page asks nobody else."""

import contextlib
import json
import re
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from browser_windows import TIMEOUT_MS, eventually
from stack_cases import write_maps

# what a hostile page tries; each entry is the answer, or the refusal
ATTACKS = """async ([host, token]) => {
  const tried = {};
  const of = async (name, act) => {
    try { tried[name] = await act(); } catch (error) { tried[name] = `refused: ${error.name}`; }
  };
  const url = `http://${host}`;
  await of("read", async () => (await fetch(`${url}/`, { credentials: "include" })).status);
  await of("read the export", async () => (await fetch(`${url}/export/stl`, { credentials: "include" })).status);
  await of("guess", async () => (await fetch(`${url}/?token=guess`, { credentials: "include" })).status);
  await of("blind", async () => (await fetch(`${url}/`, { mode: "no-cors", credentials: "include" })).type);
  await of("post", async () => (await fetch(`${url}/`, { method: "POST", credentials: "include", body: "x" })).status);
  await of("script", () => new Promise((done, failed) => {
    const script = Object.assign(document.createElement("script"), { src: `${url}/page/main.js` });
    script.onload = () => done("loaded");
    script.onerror = () => failed(new Error());
    document.head.append(script);
  }));
  await of("socket", () => new Promise((done, failed) => {
    const socket = new WebSocket(`ws://${host}/live`);
    socket.onmessage = () => done("heard something");
    socket.onopen = () => done("opened");
    socket.onerror = () => failed(new Error());
  }));
  return tried;
}"""
FORM = """<form method="post" action="http://{host}/" target="_self"><input name="do" value="undo"></form>"""


class Hostile(BaseHTTPRequestHandler):
    """A page of somebody else."""

    body = b"<!doctype html><title>Other</title><link rel=icon href=data:,><p>Somebody else's page"

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(self.body)

    def log_message(self, *_):
        pass


@pytest.fixture
def hostile():
    """The port of a server of somebody else on this machine."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), Hostile)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield server.server_address[1]
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture
def studio(serve, tmp_path, png):
    return serve(write_maps(tmp_path, png) / "bunny.exr")


def test_the_page_opens_with_its_token_alone(studio, browser, window):
    with contextlib.closing(browser.open()) as context:
        stranger = context.new_page()
        for path in ("", "?token=guess", "page/main.js", "export/stl"):
            answer = stranger.goto(f"http://127.0.0.1:{studio.port}/{path}")
            assert answer.status == 403
            assert "open the address that nmap studio printed: it holds the token" in stranger.inner_text("body")
    page = window(studio).ready()
    assert page.page.url == f"http://127.0.0.1:{studio.port}/"  # the token is not left in the address
    page.page.reload()
    page.ready()
    assert page.js("document.cookie") == ""  # out of reach of scripts


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost"])
def test_a_page_of_another_origin_gets_nothing(name, studio, hostile, window):
    own = window(studio).ready()
    context = own.page.context  # the browser holds the cookie
    other = context.new_page()
    other.goto(f"http://{name}:{hostile}/")
    tried = other.evaluate(ATTACKS, [f"127.0.0.1:{studio.port}", ""])
    assert len(tried) == 7
    assert [f"{what}: {found}" for what, found in tried.items() if not str(found).startswith("refused")] == []
    other.set_content(FORM.format(host=f"127.0.0.1:{studio.port}"))
    with other.expect_navigation() as moved:
        other.evaluate("document.forms[0].submit()")
    assert moved.value.status == 403
    assert own.js("[studio.document.undo, studio.document.redo]") == [0, 0]


def test_the_studio_is_not_shown_in_a_frame(studio, hostile, window):
    own = window(studio).ready()
    other = own.page.context.new_page()
    other.goto(f"http://127.0.0.1:{hostile}/")
    other.evaluate(
        """(url) => new Promise((done) => {
          const frame = Object.assign(document.createElement("iframe"), { src: url, onload: done });
          document.body.append(frame);
        })""",
        f"http://127.0.0.1:{studio.port}/",
    )
    assert all("nmap studio" not in frame.content() for frame in other.frames)


def test_another_name_of_this_machine_is_refused(studio, browser, window):
    """As when a name of somebody else's resolves to 127.0.0.1."""
    window(studio).ready()
    chromium = browser.launch("--host-resolver-rules=MAP evil.example 127.0.0.1")
    with contextlib.closing(chromium):
        page = chromium.new_page()
        answer = page.goto(studio.address.replace("127.0.0.1", "evil.example"))
        assert answer.status == 403
        assert "this address is not that of the studio" in page.inner_text("body")


def test_the_network_log_names_this_machine_alone(studio, browser, tmp_path):
    log = tmp_path / "network.json"
    with contextlib.closing(browser.launch(f"--log-net-log={log}")) as chromium:
        page = chromium.new_page()
        page.set_default_timeout(TIMEOUT_MS)
        page.goto(studio.address)
        page.wait_for_function("() => window.studio?.frame?.is_full")
        page.locator("#slide-beta").press("End")
        eventually(lambda: page.evaluate("studio.document.values.beta"), lambda found: found == 0.1)
        page.locator("#export").click()
        with page.expect_download():
            page.locator("#export-start").click()
    events = json.loads(log.read_text(encoding="utf-8"))["events"]
    # what Chromium asks on its own account, such as for updates, has "not an origin" for an initiator
    asked = {event["params"]["url"] for event in events if "://" in event.get("params", {}).get("initiator", "")}
    assert f"ws://127.0.0.1:{studio.port}/live" in asked
    assert sorted(url for url in asked if not re.match(r"(http|ws|blob:http)://127\.0\.0\.1:", url)) == []
