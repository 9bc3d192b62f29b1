"""The view in a browser: lights, orbit, overlays, section, snapshot, and what it keeps for the next time."""

import numpy as np
import pytest
from browser_windows import eventually
from relief_cases import dome

import nmaptool as nm

SIDE = 120
REST = "!studio.stage.view.moves && !studio.stage.view.due"


@pytest.fixture
def studio(serve, tmp_path):
    """A studio that shows a smooth dome of 60 mm."""
    _, smooth, _ = dome(SIDE, 1, base=2.5)
    nm.write_normal_map(smooth, tmp_path / "dome.exr")
    text = '[[layer]]\nfile = "dome.exr"\n[relief]\nwidth = "60mm"\n'
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    return serve(tmp_path / "scene.toml")


def shown(studio, window):
    """A window that shows the relief and rests."""
    page = window(studio).ready()
    page.waits_for(REST)
    return page


def halves(picture):
    """Mean brightness of the left and the right half, and of the upper and the lower."""
    rows, cols = (size // 2 for size in picture.shape)
    return picture[:, :cols].mean() - picture[:, cols:].mean(), picture[:rows].mean() - picture[rows:].mean()


def middle_of(page, selector):
    box = page.page.locator(selector).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_a_dragged_light_brightens_the_side_that_it_shines_on(studio, window):
    page = shown(studio, window)
    left, top = page.place(0.02, 0.5, "window")
    page.drag(middle_of(page, "#light-1"), (left, top))
    page.waits_for(REST)
    across, down = halves(page.relief(pad=0.25))
    assert across > 0.02
    assert abs(down) < 0.3 * across
    page.page.locator("#light-1").focus()
    for _ in range(60):
        page.page.keyboard.press("ArrowRight")  # half a turn
    page.waits_for(REST)
    assert halves(page.relief(pad=0.25))[0] < -0.02
    page.page.locator("#add-light").click()
    page.page.locator("#add-light").click()
    assert page.page.locator("#add-light").is_disabled()
    assert page.page.locator(".light").count() == 3
    page.waits_for(REST)
    page.shot("lights")
    page.page.locator("#light-2").focus()
    page.page.keyboard.press("Delete")
    assert page.page.locator(".light").count() == 2


def test_the_plate_turns_in_the_orbit_view_and_comes_back(studio, window):
    page = shown(studio, window)
    flat, middle = page.picture(), page.relief(pad=0.3)
    page.page.locator("#orbit").click()
    page.waits_for(REST)
    turned = page.picture()
    page.shot("orbit")
    assert abs(turned - flat).mean() > 0.02
    x, y = middle_of(page, "#view")
    before = page.js("studio.stage.view.camera.turn")
    page.drag((x, y), (x + 120, y + 40))
    after = page.js("studio.stage.view.camera.turn")
    assert after["yaw"] > before["yaw"] + 20
    assert after["tilt"] < before["tilt"]
    top = page.js("studio.stage.view.toScreen(60, 60)")
    found = page.js("({ x, y }) => studio.stage.view.placeAt(x, y)", top)
    assert [found["x"], found["y"]] == pytest.approx([60, 60], abs=0.3)
    page.page.locator("#view").focus()
    page.page.keyboard.press("Home")
    page.page.keyboard.press("o")
    page.waits_for(REST)
    assert abs(page.relief(pad=0.3) - middle).mean() < 0.005


def test_two_fingers_zoom_about_the_place_between_them(studio, window):
    page = shown(studio, window)
    seen = page.js("""() => {
      const { canvas, camera } = studio.stage.view;
      canvas.setPointerCapture = () => {}; // there are no fingers
      const box = canvas.getBoundingClientRect();
      const touch = (kind, pointerId, x, y) => canvas.dispatchEvent(new PointerEvent(kind, {
        pointerId, pointerType: "touch", clientX: box.left + x, clientY: box.top + y, button: 0, bubbles: true }));
      const [zoom, middle] = [camera.zoom, camera.onPlane(300, 300)];
      touch("pointerdown", 11, 250, 300);
      touch("pointerdown", 12, 350, 300);
      for (let i = 1; i <= 50; i++) { touch("pointermove", 11, 250 - i, 300); touch("pointermove", 12, 350 + i, 300); }
      touch("pointerup", 11, 200, 300);
      touch("pointerup", 12, 400, 300);
      return { factor: camera.zoom / zoom, middle, now: camera.onPlane(300, 300) };
    }""")
    assert seen["factor"] == pytest.approx(2, rel=0.02)
    assert [seen["now"]["x"], seen["now"]["y"]] == pytest.approx([seen["middle"]["x"], seen["middle"]["y"]], abs=1)


@pytest.mark.parametrize(
    ("overlay", "said"),
    [
        ("heights and contours", "Height in mm"),
        ("slope", "Slope in degrees"),
        ("draft angle", "of the surface has less than 80 degrees"),
        ("background and coverage", "Coverage"),
        ("curl", "Curl"),
    ],
)
def test_overlays_change_the_picture_and_have_a_legend(overlay, said, studio, window):
    page = shown(studio, window)
    page.js("studio.stage.view.draft = 80; document.getElementById('draft').value = 80")  # the dome is flat
    before = page.relief()
    page.page.locator("#overlay").select_option(label=overlay)
    eventually(page.relief, lambda now: abs(now - before).mean() > 0.002, overlay)
    assert said in page.text("legend")
    page.shot(overlay.replace(" ", "-"))


def test_the_section_and_the_pointer_tell_the_heights_in_mm(studio, window):
    page = shown(studio, window)
    page.page.locator("#section-on").click()
    page.waits_for(REST)
    title = page.text("section")
    assert "Section A to B: 48.0 mm long" in title
    assert "times as large as lengths" in title
    path = page.page.locator("#section path.now")
    before = path.get_attribute("d")
    page.page.locator("#section-b").focus()
    for _ in range(5):
        page.page.keyboard.press("Shift+ArrowUp")
    assert path.get_attribute("d") != before
    page.shot("section")
    heights = page.heights()
    x, y = page.place(0.5, 0.25, "window")
    page.page.mouse.move(x, y)
    told = page.text("read-out")
    assert told.startswith("30.0, 15.0 mm: ")
    rows, cols = heights.z.shape
    assert float(told.split(": ")[1].split()[0]) == pytest.approx(heights.z[rows // 4, cols // 2], abs=0.03)


def test_a_snapshot_stays_on_its_side_of_the_bar(studio, window):
    page = shown(studio, window)
    page.page.locator("#snapshot").click()
    before = page.relief(pad=0.2)
    page.type("height", "12mm")
    page.waits_for("studio.stage.view.relief.high > 8")
    page.waits_for(REST)
    after = page.relief(pad=0.2)
    page.shot("compare")
    half = before.shape[1] // 2
    left, right = slice(0, half - 16), slice(half + 16, None)
    assert abs(after - before)[:, left].mean() < 0.005
    assert abs(after - before)[:, right].mean() > 0.02
    page.page.locator("#split-bar").focus()
    page.page.keyboard.press("Home")  # all of it as it is now
    page.waits_for(REST)
    assert abs(page.relief(pad=0.2) - before)[:, left].mean() > 0.02


def test_the_browser_keeps_lights_and_material(studio, window):
    page = shown(studio, window)
    page.page.locator("#material").select_option("bronze")
    page.page.locator("#add-light").click()
    page.page.reload()
    page.ready()
    assert page.page.locator("#material").input_value() == "bronze"
    assert page.page.locator(".light").count() == 2
    assert page.js("studio.document.undo") == 0  # the document does not know


def test_the_picture_comes_back_after_the_graphics_card_forgot_it(studio, window):
    page = shown(studio, window)
    page.page.locator("#overlay").select_option(label="curl")
    page.waits_for("studio.stage.view.renderer.layer.width > 1")
    page.waits_for(REST)
    before = page.relief()
    page.js("""() => new Promise((done) => {
      const { canvas, renderer } = studio.stage.view;
      const extension = renderer.gl.getExtension("WEBGL_lose_context");
      canvas.addEventListener("webglcontextlost", () => setTimeout(() => extension.restoreContext(), 50));
      canvas.addEventListener("webglcontextrestored", done);
      extension.loseContext();
    })""")
    page.expected.append("CONTEXT_LOST|context lost")
    page.waits_for("studio.stage.view.renderer.layer.width > 1")
    eventually(page.relief, lambda now: abs(now - before).mean() < 0.005)


def test_nothing_is_drawn_while_nothing_changes(studio, window):
    page = shown(studio, window)
    drawn = page.js("studio.stage.view.drawn")
    page.page.wait_for_timeout(600)
    assert page.js("studio.stage.view.drawn") == drawn
    page.page.locator("#material").select_option("clay")
    eventually(lambda: page.js("studio.stage.view.drawn"), lambda now: now > drawn)


def test_a_tool_gets_the_pointer_and_space_moves_the_view(studio, window):
    page = shown(studio, window)
    page.js("""() => { window.got = [];
      const note = (kind) => (event, place) => got.push([kind, place.x, place.y]);
      window.ends = studio.stage.claim({ down: note("down"), move: note("move"), up: note("up") }); }""")
    start, end = page.place(0.25, 0.25, "window"), page.place(0.75, 0.5, "window")
    origin = page.place(0, 0)
    page.drag(start, end)
    got = page.js("got.filter(([kind]) => kind !== 'move')")
    assert [kind for kind, *_ in got] == ["down", "up"]
    assert np.ravel([place for _, *place in got]) == pytest.approx([30, 30, 90, 60], abs=0.3)
    assert page.place(0, 0) == pytest.approx(origin)
    page.page.locator("#view").focus()
    page.page.keyboard.down("Space")
    page.drag(start, end)
    page.page.keyboard.up("Space")
    assert page.place(0, 0) == pytest.approx([origin[0] + end[0] - start[0], origin[1] + end[1] - start[1]], abs=1)
    page.js("() => ends()")
    page.drag(start, end)
    assert len(page.js("got.filter(([kind]) => kind === 'down')")) == 1
