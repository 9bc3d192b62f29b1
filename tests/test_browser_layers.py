"""Dropped files and layers in the browser: maps, pictures and recipes come in; layers are shown, ordered and moved."""

import re

import numpy as np
import pytest
from browser_windows import eventually
from relief_cases import normal_map
from stack_cases import write_maps

import nmaptool as nm

LAYERS = "studio.document.layers.map((one) => one.label)"


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


@pytest.fixture
def ridge(tmp_path):
    """A plate, and a layer with an upright ridge right of its middle, where it rises to the right."""
    zero = np.zeros((120, 120))
    nm.write_normal_map(normal_map(zero, zero), tmp_path / "flat.exr")
    u = np.pi * (np.arange(60) + 0.5) / 60
    rise = np.tile(np.cos(u) - np.cos(2 * u), (60, 1))
    nm.write_normal_map(normal_map(0.5 * rise, 0 * rise), tmp_path / "ridge.exr")
    return tmp_path


def test_files_are_dropped_on_an_empty_studio(folder, serve, window):
    page = window(serve())
    page.waits_for("window.studio?.document")
    page.shot("empty")
    page.drop(folder / "plate.exr")
    page.ready()
    page.shot("map")
    assert page.heights().z.shape == (61, 81)
    page.drop(folder / "bunny.exr", folder / "leaf.png")
    eventually(lambda: page.js(LAYERS), lambda found: len(found) == 3)
    names = page.page.locator("#layers .name").all_inner_texts()
    assert [re.sub(r"\W.*", "", name) for name in names] == ["leaf", "bunny", "plate"]  # topmost first
    page.shot("layers")


def test_a_recipe_is_dropped_with_its_files(folder, serve, window):
    (folder / "scene.toml").write_text('[[layer]]\nfile = "plate.exr"\n[relief]\ndelta = 55\n', encoding="utf-8")
    page = window(serve())
    page.waits_for("window.studio?.document")
    page.drop(folder / "scene.toml", folder / "plate.exr")
    page.ready()
    eventually(lambda: page.value("delta"), lambda found: found == "55")
    assert page.heights().z.shape == (61, 81)


def test_a_grey_picture_is_asked_about(folder, png, serve, window):
    ramp = np.tile(np.linspace(0, 255, 80).astype(np.uint8), (60, 1))
    png(folder / "hill.png", ramp)
    page = window(serve(folder / "plate.exr")).ready()
    page.drop(folder / "hill.png")
    page.page.locator("#grey-dialog").wait_for()
    page.shot("asked")
    page.page.keyboard.press("Escape")
    page.page.locator("#grey-dialog").wait_for(state="hidden")
    assert len(page.js(LAYERS)) == 1
    page.drop(folder / "hill.png")
    page.page.locator("#grey-dialog button[value=use]").click()
    eventually(lambda: page.js(LAYERS), lambda found: len(found) == 2)


def test_a_dropped_header_of_100000_px_is_refused_in_one_line(folder, png, serve, window):
    huge = png(folder / "huge.png", np.zeros((4, 4, 3), np.uint8), size=(100_000, 100_000))
    (folder / "text.png").write_text("hello", encoding="utf-8")
    page = window(serve(folder / "plate.exr")).ready()
    page.expected.append("400 .Bad Request.")
    page.drop(huge)
    said = eventually(lambda: page.text("error"), bool)
    assert re.match(r"huge\.png: .*100000 x 100000", said), said
    page.shot("refused")
    page.drop(folder / "text.png")
    said = eventually(lambda: page.text("error"), lambda found: found.startswith("text.png"))
    assert "\n" not in said
    assert len(page.js(LAYERS)) == 1
    page.type("beta", "0.01")  # the studio goes on
    eventually(lambda: page.js("studio.document.values.beta"), lambda found: found == 0.01)


def test_the_eye_the_order_the_mode_and_the_strength_change_the_relief(folder, serve, window):
    page = window(serve(folder / "plate.exr", folder / "bunny.exr", folder / "leaf.png")).ready()
    first = page.heights().z

    def changed(z):
        return eventually(page.heights, lambda now: np.abs(now.z - z).max() > 0.02 * np.ptp(z)).z

    def is_first():
        return eventually(page.heights, lambda now: np.abs(now.z - first).max() < 1e-3 * np.ptp(first))

    page.tab("layers")
    layers = page.page.locator("#layers")
    layers.get_by_label(re.compile(r"Hide bunny")).click()
    changed(first)
    page.shot("hidden")
    layers.get_by_label(re.compile(r"Show bunny")).click()
    is_first()
    layers.get_by_label(re.compile(r"Move leaf.* down")).click()
    eventually(lambda: page.js(LAYERS)[1], lambda found: found.startswith("leaf"))
    changed(first)
    page.page.keyboard.press("Control+z")
    is_first()
    layers.locator("li").nth(1).drag_to(layers.locator("li").nth(0), target_position={"x": 80, "y": 4})
    eventually(lambda: page.js(LAYERS)[2], lambda found: found.startswith("bunny"))
    changed(first)
    page.page.keyboard.press("Control+z")
    is_first()
    if not page.js("studio.layers.chosen?.label.startsWith('bunny')"):
        layers.locator(".name").nth(1).click()
    form = page.page.locator("#layer-form")
    form.get_by_label("strength", exact=True).fill("0.4")
    form.get_by_label("strength", exact=True).press("Enter")
    weaker = changed(first)
    form.get_by_label("mode", exact=True).select_option("rnm")
    changed(weaker)
    page.shot("mode")
    assert page.js("studio.layers.chosen.options.mode") == "rnm"


def slopes(z, across, down):
    """Mean slopes to the right and downwards around a place, in shares of the map."""
    y, x = round(down * z.shape[0]), round(across * z.shape[1])
    part = z[y - 6 : y + 7, x - 6 : x + 7]
    return np.gradient(part, axis=1).mean(), np.gradient(part, axis=0).mean()


def test_a_layer_is_moved_and_turned_on_the_canvas_and_its_vectors_turn(ridge, serve, window):
    page = window(serve(ridge / "flat.exr", ridge / "ridge.exr")).ready()
    page.type("beta", "0.0001")
    page.tab("layers")
    page.page.locator("#layers .name").first.click()
    page.page.locator("#handles .frame").wait_for()
    eventually(lambda: page.js("studio.frame.request"), lambda found: found == 2)
    right, down = slopes(page.heights().z, 0.5, 0.5)
    assert right > 5 * abs(down)
    page.shot("before")
    page.drag(page.place(0.5, 0.5, "window"), page.place(0.3, 0.6, "window"))
    eventually(lambda: slopes(page.heights().z, 0.3, 0.6)[0], lambda found: found > 0.7 * right)
    assert abs(slopes(page.heights().z, 0.8, 0.3)[0]) < 0.05 * right
    page.shot("moved")
    knob = page.page.locator("#handles circle").bounding_box()
    x, y = page.place(0.3, 0.6, "window")
    page.drag((knob["x"] + knob["width"] / 2, knob["y"] + knob["height"] / 2), (x + 160, y), steps=12)
    eventually(lambda: page.js("studio.layers.chosen.options.rotate"), lambda found: abs(found) == 90)
    turned = eventually(lambda: slopes(page.heights().z, 0.3, 0.6), lambda found: abs(found[1]) > 5 * abs(found[0]))
    assert turned[1] > 0.5 * right  # turned clockwise, it rises downwards
    page.shot("turned")
    steps = page.js("studio.document.undo")
    page.page.keyboard.press("Control+z")
    page.page.keyboard.press("Control+z")
    eventually(lambda: slopes(page.heights().z, 0.5, 0.5)[0], lambda found: abs(found - right) < 0.05 * right)
    assert steps == 3  # each drag is one
