"""The studio for everybody: axe-core finds nothing serious, the keyboard reaches everything, and focus is visible."""

import re

import numpy as np
import pytest
from axe_playwright_python.base import AXE_FILE_PATH
from browser_windows import QUIET
from stack_cases import write_maps

SCRIPT = AXE_FILE_PATH.read_text(encoding="utf-8")
SIZES = {"desktop": {"width": 1280, "height": 800}, "tablet": {"width": 820, "height": 1180}}
# what the Tab key should reach: seen, not disabled, and of a group of radio buttons one
REACHABLE = """() => {
  const all = document.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex='0']");
  const isOne = (e) => e.type !== "radio" || e.checked;
  const isSeen = (e) => e.getClientRects().length > 0 && e.checkVisibility({ visibilityProperty: true });
  return [...all].filter((e) => !e.disabled && e.tabIndex >= 0 && isSeen(e) && isOne(e)).map(window.nameOf);
}"""
NAME_OF = """() => { window.nameOf = (e) => {
  const n = [...document.querySelectorAll("*")].indexOf(e);
  return e.id || `${e.tagName} ${e.getAttribute("aria-label") ?? e.textContent.trim()} ${n}`; } }"""
# the focused element: its name, whether an outline (of a shape: a wide line) shows it, and whether it is in the window
FOCUSED = """() => {
  const e = document.activeElement, style = getComputedStyle(e), box = e.getBoundingClientRect();
  const line = e instanceof SVGElement ? style.strokeWidth : style.outlineStyle === "none" ? 0 : style.outlineWidth;
  const isInside = box.bottom > 0 && box.right > 0 && box.top < innerHeight && box.left < innerWidth;
  return { name: e === document.body ? null : window.nameOf(e), seen: parseFloat(line) >= 2 && isInside };
}"""


@pytest.fixture
def studio(serve, tmp_path, png):
    folder = write_maps(tmp_path, png)
    return serve(folder / "plate.exr", folder / "bunny.exr")


def findings(page):
    """What axe-core calls serious or critical, each with the elements."""
    page.js(QUIET)
    page.js(SCRIPT)
    found = page.js("axe.run()")
    assert "color-contrast" in {one["id"] for one in found["passes"]}
    return [
        f"{one['id']} ({one['impact']}): {node['html'][:160]} {node['failureSummary']}"
        for one in found["violations"]
        if one["impact"] in ("serious", "critical")
        for node in one["nodes"]
    ]


def contrast(one, other):
    """The ratio of WCAG between two colours such as "rgb(20, 30, 40)"."""

    def luminance(colour):
        values = np.array([int(value) / 255 for value in re.findall(r"\d+", colour)[:3]])
        return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722)

    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_that_axe_does_not_measure_have_contrast(scheme, studio, window):
    page = window(studio, color_scheme=scheme).ready()
    pair = """(part) => { const field = document.getElementById("value-height");
      return [getComputedStyle(field, part).color, getComputedStyle(field).backgroundColor]; }"""
    assert contrast(*page.js(pair, "::placeholder")) > 4.5


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_axe_finds_nothing_serious(size, scheme, studio, window):
    page = window(studio, viewport=SIZES[size], color_scheme=scheme).ready()
    page.shot("page")
    assert findings(page) == []
    page.tab("layers")
    page.page.get_by_text("bunny.exr").first.click()
    page.page.locator("#layer-details").wait_for()
    page.type("beta", "-3")  # an error is shown
    page.page.get_by_text("must be zero or more").wait_for()
    page.shot("layer")
    assert findings(page) == []
    page.page.keyboard.press("Control+e")
    page.page.locator("#export-facts dd").first.wait_for()
    page.shot("export")
    assert findings(page) == []
    page.page.keyboard.press("Escape")
    page.page.locator("#export-dialog").wait_for(state="hidden")


@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_wider_than_the_window(size, studio, window):
    page = window(studio, viewport=SIZES[size]).ready()
    assert page.js("document.documentElement.scrollWidth <= innerWidth")
    assert page.js("document.getElementById('view').clientHeight") > 240
    for name in ("undo", "save", "export", "slide-beta", "value-base"):
        page.page.locator(f"#{name}").scroll_into_view_if_needed()
        box = page.page.locator(f"#{name}").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= SIZES[size]["width"]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_keyboard_reaches_every_control_and_focus_is_seen(scheme, studio, window):
    page = window(studio, color_scheme=scheme).ready()
    page.type("beta", "0.003")  # so that there is a step to undo
    page.waits_for("!document.getElementById('undo').disabled")
    page.tab("layers")
    page.page.get_by_text("bunny.exr").first.click()
    page.page.locator("#layer-details").wait_for()
    page.js(NAME_OF)
    wanted, reached, hidden = page.js(REACHABLE), [], []
    for _ in range(len(wanted) + 20):
        page.page.keyboard.press("Tab")
        now = page.js(FOCUSED)
        if now["name"] in reached:
            break
        if now["name"] is not None:  # behind the last control, Tab leaves the page and comes back
            reached.append(now["name"])
            hidden += [] if now["seen"] else [now["name"]]
        if now["name"] in ("view", "slide-beta"):
            page.shot(f"focus-{now['name']}")
    assert sorted(set(wanted) - set(reached)) == []
    assert hidden == []


def test_the_canvas_and_the_light_work_by_keys(studio, window):
    page = window(studio).ready()
    page.page.locator("#view").focus()
    before = page.picture()
    for _ in range(6):
        page.page.keyboard.press("ArrowLeft")
    page.js(QUIET)
    turned = page.picture()
    assert abs(turned - before).mean() > 0.01
    zoom = page.js("studio.stage.view.camera.zoom")
    page.page.keyboard.press("+")
    assert page.js("studio.stage.view.camera.zoom") > 1.1 * zoom
