"""Record a newcomer's first relief in the studio as pictures: ``python docs/studio_pictures.py``.

A mesh is dropped, baked and shaped, its ear is painted flatter, and the relief is exported, saved and reopened.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
sys.path.insert(0, str(ROOT / "tests"))

from browser_cases import Browser, running  # noqa: E402
from browser_windows import Window, eventually  # noqa: E402

# where the ear is on the map of the portrait, in shares of its width and height
EAR = ((0.525, 0.47), (0.56, 0.565))


class Walk:
    """A window, and the number of the last picture."""

    def __init__(self, window: Window) -> None:
        self.window = window
        self.number = 0

    def solved(self, action: Callable[[], object]) -> None:
        """Do something that needs a solve, and wait for its heights at full resolution."""
        before = self.window.js("studio.frame.request")
        action()
        self.window.page.wait_for_function(
            "(before) => studio.frame.request > before && studio.frame.is_full", arg=before, timeout=60_000
        )

    def picture(self, name: str) -> None:
        """Write the next picture."""
        self.number += 1
        self.window.page.mouse.move(5, 795)  # no hint under the pointer
        self.window.page.wait_for_timeout(600)  # the picture has come to rest
        path = PICTURES / f"studio-{self.number}-{name}.jpg"
        self.window.page.screenshot(path=path, type="jpeg", quality=78)


def bake(walk: Walk) -> None:
    page = walk.window.page
    walk.window.waits_for("window.studio?.document")
    walk.window.drop(ROOT / "samples" / "portrait.ply")
    page.locator("#mesh-bake:enabled").wait_for(timeout=60_000)
    walk.picture("camera")
    page.locator("#mesh-bake").click()
    page.locator("#mesh-dialog").wait_for(state="hidden", timeout=300_000)
    walk.window.ready()
    walk.picture("baked")


def shape(walk: Walk) -> None:
    window = walk.window
    walk.solved(lambda: window.slide("beta", 0.35))
    knob = window.page.locator("#light-1").bounding_box()
    box = window.page.locator("#view").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    start = knob["x"] + knob["width"] / 2, knob["y"] + knob["height"] / 2
    window.drag(start, (middle[0] - 0.39 * box["height"], middle[1] - 0.02 * box["height"]))
    walk.picture("shaped")


def paint(walk: Walk) -> None:
    window, page = walk.window, walk.window.page
    window.tab("brushes")
    page.locator("#brush-role").select_option("delta_map")
    page.locator("#brush-on").click()
    page.locator("#brush-size").fill("110")
    walk.solved(lambda: window.drag(*(window.place(*place, "window") for place in EAR), steps=10))
    walk.picture("painted")
    window.tab("relief")


def export(walk: Walk, folder: Path) -> None:
    window, page = walk.window, walk.window.page
    window.type("height", "6mm")
    window.type("base", "2mm")
    page.keyboard.press("Control+e")
    page.locator("#export-facts dd").first.wait_for()
    with page.expect_download(timeout=300_000) as download:
        page.locator("#export-start").click()
    download.value.save_as(folder / "portrait.stl")
    walk.picture("export")
    page.locator("#export-close").click()
    window.save("portrait.toml")
    eventually(lambda: window.text("saved"), lambda found: found == "saved")


@contextmanager
def studio(browser: Browser, folder: Path, *files: Path) -> Iterator[Window]:
    with running(*files, root=folder / "state") as served, closing(browser.open(sharp=True)) as context:
        window = Window(context, served, folder / "shot")
        yield window
        window.check()


def walk(browser: Browser, folder: Path) -> None:
    with studio(browser, folder) as window:
        first = Walk(window)
        bake(first)
        shape(first)
        paint(first)
        export(first, folder)
    with studio(browser, folder, folder / "portrait.toml") as window:
        window.ready()
        again = Walk(window)
        again.number = first.number
        window.page.locator("#orbit").click()
        again.picture("reopened")


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)  # the folder of a new document
        browser: Any = Browser()
        try:
            browser.do(walk, browser, Path(name))
        finally:
            browser.close()
            os.chdir(ROOT)


if __name__ == "__main__":
    main()
