"""A mesh in the browser: dropped, turned before the camera, baked in the background, and a layer of the relief."""

from pathlib import Path

import numpy as np
from browser_cases import nmap
from browser_windows import eventually

import nmaptool as nm

SAMPLES = Path(__file__).parents[1] / "samples"


def field(page, form, name):
    return page.page.locator(f"#mesh-{form}").get_by_label(name, exact=True)


def seen(page):
    """Brightness of the canvas of the camera panel."""
    return page.picture("#mesh-canvas")


def test_a_sample_mesh_is_dropped_turned_and_baked(tmp_path, serve, window, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the folder of a new document
    page = window(serve())
    page.waits_for("window.studio?.document")
    page.drop(SAMPLES / "gate.ply")
    page.page.locator("#mesh-bake:enabled").wait_for()
    front = seen(page)
    assert np.std(front) > 0.05  # the mesh is seen
    page.shot("camera")
    page.page.locator("#mesh-views").get_by_role("button", name="left", exact=True).click()
    assert np.abs(seen(page)[:600, :700] - front[:600, :700]).mean() > 0.02
    page.page.locator("#mesh-views").get_by_role("button", name="front", exact=True).click()
    field(page, "camera", "azimuth").fill("20")
    field(page, "camera", "azimuth").press("Enter")
    field(page, "picture", "size").fill("200x160")
    field(page, "picture", "size").press("Enter")
    eventually(lambda: page.text("mesh-facts"), lambda found: "200 x 160 px" in found)
    page.shot("turned")
    page.page.locator("#mesh-bake:enabled").click()
    page.page.locator("#mesh-dialog").wait_for(state="hidden")
    page.ready()
    page.shot("baked")
    assert page.heights().z.shape == (161, 201)
    assert np.ptp(page.heights().z) > 1
    page.save("gate.toml")
    eventually(lambda: page.text("saved"), lambda found: found == "saved")
    (layer,) = nm.read_recipe(tmp_path / "gate.toml").layers
    nmap("bake", SAMPLES / "gate.ply", "-o", tmp_path / "maps", "--size", "200x160", "--azimuth", "20")
    ours, expected = (nm.read_normal_map(path) for path in (tmp_path / layer.file, tmp_path / "maps" / "original.exr"))
    assert np.array_equal(ours.coverage, expected.coverage)
    assert np.abs(ours.normals - expected.normals).max() < 1e-3


def test_a_bake_is_cancelled(tmp_path, serve, window, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = window(serve())
    page.waits_for("window.studio?.document")
    page.drop(SAMPLES / "vase.ply")
    page.page.locator("#mesh-bake:enabled").wait_for()
    field(page, "picture", "size").fill("3000x3000")
    field(page, "picture", "size").press("Enter")
    eventually(lambda: page.text("mesh-facts"), lambda found: "3000 x 3000 px" in found)
    page.page.locator("#mesh-bake:enabled").click()
    page.page.locator("#mesh-cancel").click()
    page.page.locator("#mesh-cancel").wait_for(state="hidden")
    page.page.locator("#mesh-bake:enabled").wait_for()
    assert page.js("studio.document.layers.length") == 0
    page.page.keyboard.press("Escape")
    page.page.locator("#mesh-dialog").wait_for(state="hidden")
