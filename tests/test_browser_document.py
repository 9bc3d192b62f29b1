"""A document in the browser: two windows, saving, exporting, reloading, and a studio that goes away and comes back."""

import os
import secrets
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from browser_cases import COMMAND, nmap, running
from browser_windows import eventually
from stack_cases import write_maps

import nmaptool as nm


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def test_two_windows_show_each_others_changes(folder, serve, window):
    studio = serve(folder / "bunny.exr")
    one = window(studio).ready()
    other = window(studio, beside=one).ready()
    third = window(studio).ready()  # of another browser
    one.slide("beta", 0.9)
    beta = one.js("studio.values.beta")
    assert beta > 0.01
    for page in (other, third):
        eventually(lambda page=page: page.js("studio.document.values.beta"), lambda found: found == beta)
        assert page.value("beta") == one.value("beta")
        expected = one.heights().z
        eventually(page.heights, lambda now, z=expected: np.abs(now.z - z).max() < 1e-3 * np.ptp(z))
    third.type("delta", "-40")
    eventually(lambda: one.value("delta"), lambda found: found == "-40")
    other.page.locator("#undo").click()
    eventually(lambda: third.value("delta"), lambda found: found == "30")
    one.shot("one")
    other.shot("other")


def test_a_saved_relief_is_exported_to_the_bytes_of_the_command(folder, serve, window):
    page = window(serve(folder / "bunny.exr")).ready()
    page.type("height", "2mm")
    page.slide("beta", 0.7)
    page.type("base", "1.5")
    eventually(lambda: page.text("saved"), lambda found: found == "not saved")
    page.save("relief.toml")
    eventually(lambda: page.text("saved"), lambda found: found == "saved")
    assert page.text("name") == "relief.toml"
    page.shot("saved")
    for ending in ("stl", "3mf", "glb"):
        download = page.export(ending)
        assert download.suggested_filename == f"relief.{ending}"
        download.save_as(folder / "page" / f"relief.{ending}")
        nmap("relief", folder / "relief.toml", "-o", folder / f"relief.{ending}")
        assert (folder / "page" / f"relief.{ending}").read_bytes() == (folder / f"relief.{ending}").read_bytes()
    assert np.ptp(nm.read_mesh(folder / "page" / "relief.stl").vertices[:, 2]) == pytest.approx(3.5, abs=1e-4)


def test_a_reloaded_page_shows_the_document(folder, serve, window):
    page = window(serve(folder / "bunny.exr")).ready()
    page.type("slope_cap", "2.5")
    page.slide("delta", 0.9)
    delta = page.value("delta")
    eventually(lambda: page.js("studio.document.undo"), lambda found: found == 2)
    before = page.heights().z
    page.page.reload()
    page.ready()
    eventually(lambda: page.value("delta"), lambda found: found == delta)
    assert page.value("slope_cap") == "2.5"
    after = eventually(page.heights, lambda now: now.z.shape == before.shape)
    assert np.abs(after.z - before).max() < 1e-3 * np.ptp(before)
    page.page.locator("#undo").click()
    eventually(lambda: page.value("delta"), lambda found: found == "30")


def test_a_page_waits_for_its_studio_and_finds_it_again(folder, browser, window, monkeypatch, tmp_path):
    monkeypatch.setattr(secrets, "token_urlsafe", lambda _: "the-same-token")
    with running(folder / "bunny.exr", root=tmp_path / "state") as studio:
        page = window(studio).ready()
    page.expected.append("ERR_CONNECTION_REFUSED|WebSocket connection")
    eventually(lambda: page.text("status"), lambda found: found == "waiting for the studio")
    page.type("beta", "0.02")
    eventually(lambda: page.text("error"), lambda found: "does not answer; start nmap studio again" in found)
    page.shot("waiting")
    with running(folder / "bunny.exr", root=tmp_path / "state", port=studio.port):
        eventually(lambda: page.value("beta"), lambda found: found == "0.001")
        page.type("beta", "0.04")
        eventually(lambda: page.js("studio.document.values.beta"), lambda found: found == 0.04)
        assert page.text("error") == ""
        page.shot("again")


@pytest.fixture
def command(folder):
    """``command(*files)`` starts `nmap studio`, with its state in the folder, and gives the process and the address."""
    started = []
    places = ("HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME", "LOCALAPPDATA", "APPDATA")
    env = {**os.environ, **{name: str(folder / "home") for name in places}}

    def start(*files):
        words = [sys.executable, "-c", COMMAND, "studio", *map(str, files), "--no-browser"]
        process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, env=env)
        started.append(process)
        return process, SimpleNamespace(address=process.stderr.readline().partition("studio: ")[2].strip())

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stderr.close()


def test_unsaved_work_is_recovered_after_a_kill(folder, command, window):
    process, address = command(folder / "bunny.exr")
    page = window(address).ready()
    page.expected.append("ERR_CONNECTION_REFUSED|ERR_CONNECTION_RESET|WebSocket connection")
    page.type("height", "2.5mm")
    page.drop(folder / "leaf.png")
    eventually(lambda: page.js("studio.document.layers.length"), lambda found: found == 2)
    page.slide("beta", 0.8)
    beta = page.value("beta")
    kept = lambda: [path.read_text(encoding="utf-8") for path in (folder / "home").rglob("autosave.toml")]  # noqa: E731
    eventually(kept, lambda found: found and beta in found[0] and "leaf" in found[0])
    process.kill()
    process.wait()
    eventually(lambda: page.text("status"), lambda found: found == "waiting for the studio")
    _, address = command(folder / "plate.exr")
    again = window(address).ready()
    again.page.locator("#unsaved").get_by_text("was not saved when the studio ended").wait_for()
    again.shot("offered")
    again.page.get_by_role("button", name="Recover").click()
    eventually(lambda: again.value("height"), lambda found: found == "2.5mm")
    assert again.value("beta") == beta
    assert again.js("studio.document.layers.length") == 2
    eventually(lambda: again.text("facts"), lambda found: "2.500 mm high" in found)
    again.shot("recovered")
    again.page.locator("#unsaved").wait_for(state="hidden")
