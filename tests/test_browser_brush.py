"""Painting in the browser: strokes change the relief where they are drawn, and are undone like everything else."""

import numpy as np
import pytest
from browser_windows import eventually
from relief_cases import dome

import nmaptool as nm

SIDE = 120
MIDDLE = slice(SIDE // 2 - 6, SIDE // 2 + 6)


@pytest.fixture
def scene(tmp_path):
    """A dome that is pulled up to a height."""
    nm.write_normal_map(dome(SIDE, 0.5)[0], tmp_path / "dome.exr")
    text = '[[layer]]\nfile = "dome.exr"\n[relief]\nwidth = "60mm"\nbeta = 0.02\ndelta = 120\n'
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    return tmp_path / "scene.toml"


def use(page, role, tool):
    """Take a brush for a role into the hand."""
    page.tab("brushes")
    page.page.locator("#brush-role").select_option(role)
    page.page.locator(f"input[name=brush-tool][value={tool}]").check()
    page.page.locator("#brush-size").fill("30")
    if page.page.locator("#brush-on").get_attribute("aria-pressed") == "false":
        page.page.locator("#brush-on").click()
        page.page.locator("#brush-size").fill("30")


def near(z):
    return lambda now: np.abs(now.z - z).max() < 2e-3 * np.ptp(z)


def test_strokes_flatten_where_they_are_drawn_and_are_undone(scene, serve, window):
    page = window(serve(scene)).ready()
    before = page.heights().z
    page.shot("before")
    use(page, "delta_map", "paint")
    page.drag(page.place(0.4, 0.5, "window"), page.place(0.6, 0.5, "window"))
    painted = eventually(page.heights, lambda now: now.z[MIDDLE, MIDDLE].mean() < 0.6 * before[MIDDLE, MIDDLE].mean()).z
    above = slice(SIDE // 5, SIDE // 4), MIDDLE
    assert painted[above].mean() > 0.8 * before[above].mean()
    page.shot("flatter")
    use(page, "delta_map", "erase")
    page.drag(page.place(0.4, 0.5, "window"), page.place(0.6, 0.5, "window"))
    eventually(page.heights, lambda now: now.z[MIDDLE, MIDDLE].mean() > 0.9 * before[MIDDLE, MIDDLE].mean())
    assert page.js("studio.document.undo") == 2
    page.page.keyboard.press("Escape")  # puts the brush down
    assert page.page.locator("#brush-on").inner_text() == "Paint"
    page.page.keyboard.press("Control+z")
    eventually(page.heights, near(painted))
    page.page.keyboard.press("Control+z")
    eventually(page.heights, near(before))
    assert page.js("studio.document.files.delta_map") is None
    page.page.keyboard.press("Control+Shift+z")
    eventually(page.heights, near(painted))


def test_a_painted_mask_cuts_the_motif_and_is_saved_beside_the_recipe(scene, serve, window):
    page = window(serve(scene)).ready()
    before = page.heights().z
    use(page, "mask", "erase")
    page.drag(page.place(0.5, 0.2, "window"), page.place(0.5, 0.35, "window"))
    part = slice(SIDE // 4, SIDE // 4 + 8), MIDDLE
    eventually(page.heights, lambda now: np.abs(now.z[part]).max() < 0.02 * before[part].mean())
    page.shot("cut")
    page.page.keyboard.press("Escape")
    page.page.keyboard.press("Control+s")
    eventually(lambda: page.text("saved"), lambda found: found == "saved")
    recipe = nm.read_recipe(scene)
    assert (scene.parent / "scene-mask.png").is_file()
    assert recipe.relief.files.mask == "scene-mask.png"


def test_the_keyboard_paints(scene, serve, window):
    page = window(serve(scene)).ready()
    before = page.heights().z
    use(page, "delta_map", "paint")
    page.page.locator("#view").focus()
    page.page.keyboard.press("ArrowRight")
    page.page.keyboard.press("ArrowLeft")
    page.page.keyboard.press("Enter")
    eventually(page.heights, lambda now: now.z[MIDDLE, MIDDLE].mean() < 0.7 * before[MIDDLE, MIDDLE].mean())
    page.page.keyboard.press("Escape")
    page.page.keyboard.press("Control+z")
    eventually(page.heights, near(before))
