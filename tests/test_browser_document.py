"""A document in the browser: two windows, saving, exporting, reloading, and a studio that goes away and comes back."""

import secrets

import numpy as np
import pytest
from browser_cases import nmap, running
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
    page.page.keyboard.press("Control+s")
    page.page.locator("#save-name").fill("relief.toml")
    page.page.keyboard.press("Enter")
    eventually(lambda: page.text("saved"), lambda found: found == "saved")
    assert page.text("name") == "relief.toml"
    page.shot("saved")
    page.page.locator("#export").click()
    for ending in ("stl", "ply", "3mf"):
        page.page.locator("#export-format").select_option(ending)
        with page.page.expect_download() as download:
            page.page.locator("#export-start").click()
        assert download.value.suggested_filename == f"relief.{ending}"
        download.value.save_as(folder / "page" / f"relief.{ending}")
        nmap("relief", folder / "relief.toml", "-o", folder / f"relief.{ending}")
        assert (folder / "page" / f"relief.{ending}").read_bytes() == (folder / f"relief.{ending}").read_bytes()
    assert np.ptp(nm.read_mesh(folder / "page" / "relief.stl").vertices[:, 2]) == pytest.approx(3.5, abs=1e-4)


def test_a_reloaded_page_shows_the_document(folder, serve, window):
    page = window(serve(folder / "bunny.exr")).ready()
    page.type("mu", "0.7")
    page.slide("delta", 0.9)
    delta = page.value("delta")
    eventually(lambda: page.js("studio.document.undo"), lambda found: found == 2)
    before = page.heights().z
    page.page.reload()
    page.ready()
    eventually(lambda: page.value("delta"), lambda found: found == delta)
    assert page.value("mu") == "0.7"
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
    page.type("mu", "0.9")
    eventually(lambda: page.text("error"), lambda found: "does not answer; start nmap studio again" in found)
    page.shot("waiting")
    with running(folder / "bunny.exr", root=tmp_path / "state", port=studio.port):
        eventually(lambda: page.value("mu"), lambda found: found == "0.1")
        page.type("mu", "0.4")
        eventually(lambda: page.js("studio.document.values.mu"), lambda found: found == 0.4)
        assert page.text("error") == ""
        page.shot("again")
