"""The view of the relief in the browser: light, shadows, materials, overlays, zoom, orbit, section and comparison."""

import numpy as np
import pytest
from browser_windows import eventually
from relief_cases import dome

import nmaptool as nm

SIDE = 120


@pytest.fixture
def show(tmp_path, serve, window):
    """What opens a window on a dome on a plate."""
    nm.write_normal_map(dome(SIDE, base=2.5)[0], tmp_path / "dome.exr")
    text = '[[layer]]\nfile = "dome.exr"\n[relief]\nwidth = "60mm"\nbeta = 0.0003\n'
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    studio = serve(tmp_path / "scene.toml")
    return lambda **more: window(studio, **more).ready()


def sides(picture):
    """Mean brightness of the left and right, upper and lower part of the dome, without its rim and the middle."""
    rows, cols = picture.shape
    across, down = slice(cols // 3, -cols // 3), slice(rows // 3, -rows // 3)
    left, right = picture[down, cols // 6 : cols // 3], picture[down, -cols // 3 : -cols // 6]
    upper, lower = picture[rows // 6 : rows // 3, across], picture[-rows // 3 : -rows // 6, across]
    return left.mean(), right.mean(), upper.mean(), lower.mean()


def move_light(page, u, v):
    """Drag the knob of the first light to a place on the canvas, right and up from its middle, in half sides."""
    knob = page.page.locator("#light-1").bounding_box()
    box = page.page.locator("#view").bounding_box()
    x, y, half = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, min(box["width"], box["height"]) / 2
    page.drag((knob["x"] + knob["width"] / 2, knob["y"] + knob["height"] / 2), (x + u * half, y - v * half))


def test_a_low_light_casts_a_shadow_and_a_second_light_brightens_it(show):
    shown = show()
    shown.type("height", "15mm")
    move_light(shown, -0.8, 0)

    def behind():
        """Brightness of the plate on the far side of the dome."""
        picture = shown.relief(pad=0.02)
        rows, cols = picture.shape
        return picture[rows * 2 // 5 : rows * 3 // 5, cols * 9 // 10 :].mean()

    dark = behind()
    shown.shot("shadow")
    shown.page.locator("#shadows").uncheck()
    assert behind() > dark + 0.1
    shown.page.locator("#shadows").check()
    assert abs(behind() - dark) < 0.01
    shown.page.locator("#add-light").click()
    assert behind() > dark + 0.03
    shown.shot("second")
    shown.page.locator("#remove-light").click()
    assert abs(behind() - dark) < 0.01


def test_materials_and_overlays_change_the_picture_and_have_a_legend(show):
    shown = show()
    pictures = {}
    for name in ("plaster", "bronze", "walnut", "marble"):
        shown.page.locator("#material").select_option(name)
        pictures[name] = shown.relief()
        shown.shot(name)
    names = list(pictures)
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            assert np.abs(pictures[one] - pictures[other]).mean() > 0.01, (one, other)
    plain = pictures["marble"]
    labels = shown.page.locator("#overlay option").all_inner_texts()
    assert len(labels) >= 5
    for label in labels[1:]:
        shown.page.locator("#overlay").select_option(label=label)
        if label == "draft angle":
            shown.page.locator("#draft").fill("70")  # nearly all of the dome is too steep
        eventually(shown.relief, lambda now: np.abs(now - plain).mean() > 0.01, label)
        shown.page.locator("#legend").wait_for()
        shown.shot(label)


def test_zoom_fit_one_to_one_and_pan(show):
    shown = show()
    zoom = "studio.stage.view.camera.zoom"
    fitted = shown.js(zoom)
    whole = shown.picture()
    point = shown.place(0.25, 0.25, "window")
    shown.page.mouse.move(*point)
    shown.page.mouse.wheel(0, -600)
    eventually(lambda: shown.js(zoom), lambda found: found > 1.5 * fitted)
    assert np.allclose(shown.place(0.25, 0.25, "window"), point, atol=1)  # what is under the pointer stays
    shown.drag((300, 300), (360, 340))
    assert np.allclose(shown.place(0.25, 0.25, "window"), np.add(point, (60, 40)), atol=1)
    shown.page.locator("#one-to-one").click()
    assert shown.js(zoom) * shown.js("devicePixelRatio") == pytest.approx(1)
    shown.page.locator("#fit-view").click()
    assert shown.js(zoom) == pytest.approx(fitted)
    assert np.abs(shown.picture() - whole).mean() < 0.01
