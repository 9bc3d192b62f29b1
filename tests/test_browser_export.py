"""Exports, presets and the controls' words in a browser."""

import numpy as np
import pytest
from browser_windows import eventually
from stack_cases import write_maps

import nmaptool as nm


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def open_dialog(page):
    page.page.locator("#export").click()
    page.waits_for("document.querySelector('#export-facts dd')")


def choose(page, format_):
    page.page.locator("#export-format").select_option(format_)
    page.waits_for("document.querySelector('#export-facts dd')")
    return dict(
        zip(*(page.page.locator(f"#export-facts {tag}").all_inner_texts() for tag in ("dt", "dd")), strict=True)
    )


def download(page, path):
    with page.page.expect_download() as found:
        page.page.locator("#export-start").click()
    found.value.save_as(path / found.value.suggested_filename)
    eventually(lambda: page.text("export-said"), lambda said: "your browser saves it" in said)
    return path / found.value.suggested_filename


def test_the_dialog_says_beforehand_what_the_file_is(folder, serve, window):
    page = window(serve(folder / "bunny.exr")).ready()
    page.type("base", "2mm")
    page.type("height", "3mm")
    eventually(lambda: page.js("studio.document.values.height"), lambda found: found == "3mm")
    open_dialog(page)
    facts = choose(page, "stl")
    page.shot("dialog")
    assert facts["Kind"] == "closed solid"
    path = download(page, folder / "made")
    mesh = nm.read_mesh(path)
    assert facts["Triangles"] == f"{len(mesh.faces):,}"
    assert facts["File"] == f"{max(1, round(path.stat().st_size / 1e3))} kB"
    size = [float(number) for number in facts["Size"].removesuffix(" mm").split(" x ")]
    assert size == pytest.approx(np.ptp(mesh.vertices, axis=0), rel=1e-3)
    page.shot("done")
    facts = choose(page, "npy")
    assert facts["Pixels"] == "30 x 40"
    assert page.page.locator("#export-at").is_visible()
    page.page.locator("#export-at").select_option("corners")
    eventually(lambda: choose(page, "npy")["Pixels"], lambda found: found == "31 x 41")
    assert np.load(download(page, folder / "made"))["z_mm"].shape == (41, 31)
    page.page.keyboard.press("Escape")
    assert page.page.locator("#export-dialog").is_hidden()


def test_an_export_is_cancelled(folder, serve, window, monkeypatch):
    from test_studio_export import Slow

    slow = Slow(monkeypatch)
    page = window(serve(folder / "bunny.exr")).ready()
    open_dialog(page)
    page.page.locator("#export-start").click()
    eventually(lambda: page.text("export-said"), lambda said: said == "solving 25 %")
    page.shot("running")
    page.page.locator("#export-close").click()
    page.type("delta", "80")  # the work goes on meanwhile
    eventually(lambda: page.js("studio.document.values.delta"), lambda found: found == 80)
    page.page.locator("#export").click()
    page.page.locator("#export-cancel").click()
    eventually(lambda: page.text("export-said"), lambda said: said == "cancelled; no file was made")
    slow.go_on.set()
    assert page.page.locator("#export-start").is_enabled()


def test_a_refused_export_says_why(folder, serve, window):
    page = window(serve(folder / "bunny.exr")).ready()
    page.type("delta", "-300")
    page.type("base", "1mm")
    eventually(lambda: page.js("studio.document.values.base"), lambda found: found == "1mm")
    open_dialog(page)
    eventually(lambda: page.text("export-facts"), lambda found: "base" in found)
    page.page.locator("#export-start").click()
    eventually(lambda: page.text("export-said"), lambda said: "base" in said)
    page.shot("refused")


def test_a_preset_is_applied_kept_and_deleted(folder, serve, window):
    page = window(serve(folder / "bunny.exr")).ready()
    page.page.locator("#preset").select_option(label="cameo")
    assert page.text("preset-about").startswith("oval; the motif stands on its ground with a sharp edge")
    assert page.page.locator("#plate").is_hidden()
    page.page.locator("#preset-apply").click()
    eventually(lambda: page.value("height"), lambda found: found == "5%")
    eventually(lambda: page.heights().z, lambda z: abs(np.ptp(z) - 0.05 * 20) < 1e-3)
    assert eventually(lambda: page.text("plate"), bool).startswith("Exported files have a plate (oval) with a frame. ")
    page.shot("cameo")
    page.type("beta", "0.002")
    page.page.locator("#preset-name").fill("Mine")
    page.page.locator("#preset-name").press("Enter")
    eventually(lambda: page.text("preset-about"), lambda found: "beta 0.002" in found)
    page.page.locator("#undo").click()
    page.page.locator("#undo").click()
    eventually(lambda: page.page.locator("#plate").is_hidden(), bool)
    eventually(lambda: page.value("beta"), lambda found: found == "0.001")
    page.page.locator("#preset-apply").click()
    eventually(lambda: page.value("beta"), lambda found: found == "0.002")
    assert page.js("document.getElementById('value-edge').value") == "wall"
    page.page.locator("#preset-delete").click()
    eventually(lambda: page.page.locator("#preset-delete").is_hidden(), bool)


def test_controls_say_what_they_do_and_why_they_cannot(folder, serve, window):
    page = window(serve(folder / "bunny.exr")).ready()
    assert page.text("note-mu") == "has no effect without a detail map"
    assert page.page.locator("#value-mu").is_disabled()
    assert page.page.locator("#value-fit").is_disabled()
    page.type("height", "3")
    eventually(lambda: page.page.locator("#value-fit").is_enabled(), bool)
    # a length for the reach sets beta, and back
    page.page.locator("#reach").fill("4mm")
    page.page.locator("#reach").press("Enter")
    beta = eventually(lambda: page.js("studio.document.values.beta"), lambda found: found != 0.001)
    shape = nm.read_normal_map(folder / "bunny.exr")
    report = nm.relief(shape, options=nm.ReliefOptions(beta=beta)).report
    assert report.reach_mm == pytest.approx(4, rel=1e-3)
    assert page.js("document.getElementById('reach').value") == "4mm"
    # arrow keys, and a key back to the default
    field = page.page.locator("#value-delta")
    field.focus()
    for key in ("ArrowUp", "Shift+ArrowUp", "ArrowDown"):
        page.page.keyboard.press(key)
    eventually(lambda: page.js("studio.document.values.delta"), lambda found: found == 40)
    reset = page.page.get_by_role("button", name="delta: back to 30")
    reset.focus()
    page.page.keyboard.press("Enter")
    eventually(lambda: page.js("studio.document.values.delta"), lambda found: found == 30)
    # an angle, and a height in mm for delta
    page.type("slope_cap", "45°")
    eventually(lambda: page.js("studio.document.values.slope_cap"), lambda found: found == 1)
    page.type("delta", "2mm")
    px_per_delta = report.px_per_delta * report.pitch_mm
    eventually(lambda: page.js("studio.document.values.delta"), lambda found: abs(found * px_per_delta - 2) < 1e-4)
    # a value in the folded part that excludes another
    page.page.locator("#advanced summary").click()
    page.type("max_error", "0.01mm")
    eventually(lambda: page.page.locator("#value-triangles").is_disabled(), bool)
    page.type("shell", "9 miles")
    eventually(lambda: page.text("note-shell"), lambda found: "expected a number with a unit" in found)
    assert page.value("shell") == ""
    page.shot("advanced")
