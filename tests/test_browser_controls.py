"""The controls of the studio in a browser: sliders, typed values and keys change the heights and the picture."""

import re

import cv2
import numpy as np
import pytest
from browser_windows import eventually
from relief_cases import dome

import nmaptool as nm

SIDE = 120


@pytest.fixture
def scene(tmp_path):
    """A recipe of a smooth dome and a detail map of bumps."""
    _, smooth, detail = dome(SIDE, 1, base=2.5)
    nm.write_normal_map(smooth, tmp_path / "dome.exr")
    nm.write_normal_map(detail, tmp_path / "detail.exr")
    text = '[[layer]]\nfile = "dome.exr"\n[relief]\ndetail = "detail.exr"\nwidth = "60mm"\nbeta = 0.0003\n'
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    return tmp_path / "scene.toml"


@pytest.fixture
def library(scene):
    """``library(beta=0.01)``: the heights in mm that the library makes of the same recipe."""
    original, detail = (nm.read_normal_map(scene.parent / name) for name in ("dome.exr", "detail.exr"))
    given = {"width": nm.length("60mm"), "beta": 0.0003}
    return lambda **changes: nm.relief(original, detail, options=nm.ReliefOptions(**{**given, **changes})).z_mm


def number(text):
    return float(text.removesuffix("mm"))


def span(z):
    return np.ptp(z)


def roughness(values):
    """How much values in the middle of the motif differ from the mean of their neighbours."""
    inside = values[SIDE // 4 : -SIDE // 4, SIDE // 4 : -SIDE // 4]
    around = inside[:-2, 1:-1] + inside[2:, 1:-1] + inside[1:-1, :-2] + inside[1:-1, 2:]
    return np.std(inside[1:-1, 1:-1] - around / 4)


def contrast(window):
    return np.std(window.relief(pad=0.25))


def bumps(window):
    """Roughness on the screen, at one pixel for each of the map."""
    return roughness(cv2.resize(window.relief(pad=0), (SIDE, SIDE), interpolation=cv2.INTER_AREA))


# for an option: a place on its slider; a measure of the heights, the sign of its change, a measure of the screen alike
DRAGS = {
    "beta": (0.95, span, -1, contrast),
    "delta": (0.95, span, 1, contrast),
    "slope_cap": (0.0, span, -1, contrast),
    "height": (0.9, span, 1, contrast),
    "mu": (0.6, roughness, 1, bumps),
}


@pytest.mark.parametrize("name", DRAGS)
def test_a_slider_changes_heights_and_picture_in_its_direction(name, scene, library, serve, window):
    share, measure, sign, look = DRAGS[name]
    page = window(serve(scene)).ready()
    if name == "height":
        page.type("height", "2mm")
    start = number(page.value(name))
    before = page.heights(), look(page)
    page.shot("before")
    page.slide(name, share)
    text = page.value(name)
    assert (number(text) > start) == (share > 0.5)
    expected = library(**{name: nm.length(text) if name == "height" else number(text)})
    near = 2e-3 * np.ptp(expected)
    after = eventually(page.heights, lambda now: np.abs(now.z - expected).max() < near, "heights of the library")
    page.shot("after")
    assert sign * measure(after.z) > sign * measure(before[0].z) * 1.5**sign
    assert sign * look(page) > sign * before[1] * 1.2**sign


def test_typed_lengths_may_have_any_unit(scene, serve, window):
    page = window(serve(scene)).ready()
    for text, mm in (("3mm", 3), ("0.5cm", 5), ("0.1in", 2.54), ('0.2"', 5.08), ("4", 4)):
        page.type("height", text)
        eventually(lambda: np.ptp(page.heights().z), lambda found, mm=mm: abs(found - mm) < 1e-3 * mm, text)
        eventually(lambda: page.text("facts"), lambda found, mm=mm: f"{mm:.3f} mm high" in found)
    page.type("width", "2in")
    eventually(lambda: page.text("facts"), lambda found: found.startswith("50.8 x 50.8 mm"))
    page.type("width", "")  # as wide as the map says
    eventually(lambda: page.text("facts"), lambda found: found.startswith("100.0 x 100.0 mm"))
    page.shot("typed")


def test_a_wrong_value_is_answered_in_the_line_of_the_command(scene, serve, window):
    page = window(serve(scene)).ready()
    page.type("mu", "-3")
    eventually(lambda: page.text("note-mu"), lambda found: re.match(r"mu = -3: must be zero or more", found))
    assert page.value("mu") == "0.1"  # it goes back
    page.shot("wrong")
    page.type("mu", "0.5")
    eventually(lambda: page.js("studio.document.values.mu"), lambda found: found == 0.5)
    assert page.page.locator("#note-mu").is_hidden()


def test_keys_move_a_slider_and_a_double_click_resets_it(scene, serve, window):
    page = window(serve(scene)).ready()
    values = "studio.document.values"
    page.page.locator("#slide-mu").focus()
    for key, expected in (("ArrowRight", 0.11), ("ArrowRight", 0.12), ("ArrowLeft", 0.11), ("Home", 0), ("End", 4)):
        page.page.keyboard.press(key)
        eventually(lambda: page.js(f"{values}.mu"), lambda found, expected=expected: found == expected, key)
        assert page.value("mu") == str(expected)
    for name, default in (("mu", 0.1), ("beta", 0.001)):
        page.page.locator(f"#slide-{name}").dblclick()
        eventually(lambda name=name: page.js(f"{values}.{name}"), lambda found, default=default: found == default)
        assert page.value(name) == str(default)


def test_steps_are_undone_by_keys_and_buttons(scene, library, serve, window):
    page = window(serve(scene)).ready()
    keys = page.page.keyboard
    first = page.heights().z
    assert page.page.locator("#undo").is_disabled()
    page.slide("beta", 0.9)  # a drag is one step
    page.type("delta", "90")
    steps = "[studio.document.undo, studio.document.redo]"
    eventually(lambda: page.js(steps), lambda found: found == [2, 0])
    page.page.locator("#view").focus()
    keys.press("Control+z")
    eventually(lambda: page.js(steps), lambda found: found == [1, 1])
    keys.press("Control+z")
    eventually(lambda: page.js(steps), lambda found: found == [0, 2])
    back = eventually(page.heights, lambda now: np.abs(now.z - first).max() < 2e-4 * np.ptp(first))
    assert back.full
    eventually(lambda: page.value("beta"), lambda found: found == "0.0003")
    eventually(lambda: page.value("delta"), lambda found: found == "30")
    keys.press("Control+Shift+z")
    keys.press("Control+y")
    eventually(lambda: page.js(steps), lambda found: found == [2, 0])
    assert page.page.locator("#redo").is_disabled()
    page.page.locator("#undo").click()
    page.page.locator("#undo").click()
    eventually(lambda: page.js(steps), lambda found: found == [0, 2])
    page.page.locator("#redo").click()
    eventually(lambda: page.js("studio.document.values.beta"), lambda found: found > 0.01)
    page.shot("redone")
