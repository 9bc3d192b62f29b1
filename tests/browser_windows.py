"""A window of the studio in a test: what a hand does to it, and what it shows."""

from __future__ import annotations

import base64
import re
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np

TIMEOUT_MS = 20_000
# heights as the page computes them for the values that it shows, as base64; the module is the page's own
HEIGHTS = """async () => {
  const { combined } = await import("/page/heights.js");
  const { frame, values } = window.studio;
  const { z, pitch } = combined(frame, values);
  const text = ({ buffer, byteOffset, byteLength }) => {
    const bytes = new Uint8Array(buffer, byteOffset, byteLength), parts = [];
    for (let i = 0; i < bytes.length; i += 8192) parts.push(String.fromCharCode(...bytes.subarray(i, i + 8192)));
    return btoa(parts.join(""));
  };
  return { z: text(z), pitch, surface: text(frame.surface), rows: frame.rows, full: frame.is_full };
}"""
QUIET = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def eventually(found: Callable[[], Any], holds: Callable[[Any], bool], what: str = "") -> Any:
    """Return what is found as soon as it holds; fails after the time of a slow machine."""
    end = time.monotonic() + TIMEOUT_MS / 1000
    while not holds(value := found()):
        assert time.monotonic() < end, f"{what or 'waited for another value'}; the last one: {value}"
        time.sleep(0.02)
    return value


class Window:
    """A page that shows a studio.

    Parameters
    ----------
    context : playwright's BrowserContext
    studio : nmaptool.studio.server.Studio
    pictures : Path
        Where `shot` writes: a number and a name are added.
    """

    def __init__(self, context: Any, studio: Any, pictures: Path) -> None:
        self.page = context.new_page()
        self.studio = studio
        self.faults: list[str] = []
        self.expected: list[str] = []
        self.hosts: set[str] = set()
        self._pictures = pictures
        self._shots = 0
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("request", lambda request: self._note(request.url))
        self.page.on("websocket", lambda socket: self._note(socket.url))
        self.page.goto(studio.address)

    def _hear(self, message: Any) -> None:
        is_advice = "GL Driver Message" in message.text  # on the speed of reading pixels
        if (
            message.type in ("error", "warning") and not is_advice
        ):  # violations of the Content-Security-Policy are among them
            self.faults.append(f"{message.type}: {message.text}")

    def _note(self, url: str) -> None:
        if re.match("(http|ws)s?:", url):  # data: and blob: do not leave the page
            self.hosts.add(re.sub(r"^\w+://([^/:]*).*", r"\1", url))

    def check(self) -> None:
        """Fail if there was an error or a request to another machine."""
        known = [re.compile(pattern) for pattern in self.expected]
        assert [fault for fault in self.faults if not any(one.search(fault) for one in known)] == []
        assert self.hosts == {"127.0.0.1"}

    def shot(self, name: str) -> None:
        """Keep a picture of the window for people to look at."""
        self._shots += 1
        self._pictures.parent.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=f"{self._pictures}-{self._shots}-{name}.png")

    # what it shows

    def js(self, code: str, given: Any = None) -> Any:
        """The value of an expression of the page."""
        return self.page.evaluate(code, given)

    def text(self, name: str) -> str:
        """The text of an element with an id."""
        return self.page.locator(f"#{name}").inner_text()

    def value(self, name: str) -> str:
        """The text in the field of an option."""
        return self.page.locator(f"#value-{name}").input_value()

    def heights(self) -> SimpleNamespace:
        """``z`` (rows, cols) in mm and ``surface`` of what the page computes now; ``full`` unless it is a preview."""
        found = self.js(HEIGHTS)
        z, surface = (
            np.frombuffer(base64.b64decode(found[name]), kind) for name, kind in (("z", "<f4"), ("surface", "u1"))
        )
        z, surface = (field.reshape(found["rows"], -1) for field in (z * np.float64(found["pitch"]), surface > 0))
        return SimpleNamespace(z=z, surface=surface, full=found["full"])

    def picture(self, canvas: str = "#view") -> np.ndarray:
        """Brightness, 0 to 1, of a canvas as it is on the screen."""
        self.js(QUIET)
        shot = self.page.locator(canvas).screenshot()
        grey = cv2.imdecode(np.frombuffer(shot, np.uint8), cv2.IMREAD_GRAYSCALE)
        assert grey is not None
        return grey.astype(np.float64) / 255

    def relief(self, pad: float = 0.12) -> np.ndarray:
        """Brightness of the relief on the canvas, without a share of its width and height on each side."""
        (left, top), (right, bottom) = (self.place(share, share) for share in (0, 1))
        pad_x, pad_y = pad * (right - left), pad * (bottom - top)
        rows, cols = slice(round(top + pad_y), round(bottom - pad_y)), slice(round(left + pad_x), round(right - pad_x))
        return self.picture()[rows, cols]

    def place(self, across: float, down: float, within: str = "canvas") -> tuple[float, float]:
        """Where a point of the map, in shares of its width and height, lies on the canvas or in the window."""
        x, y = self.js(
            """([u, v]) => { const { camera } = studio.stage.view;
              const { x, y } = camera.toScreen(u * camera.full[0], v * camera.full[1]);
              return [x, y]; }""",
            [across, down],
        )
        if within == "canvas":
            return x, y
        box = self.page.locator("#view").bounding_box()
        return box["x"] + x, box["y"] + y

    def ready(self) -> Window:
        """Wait for the first picture at full resolution."""
        self.page.wait_for_function("() => window.studio?.frame?.is_full && studio.stage.view.drawn > 0")
        return self

    def waits_for(self, expression: str) -> None:
        """Wait until an expression of the page holds."""
        self.page.wait_for_function(f"() => {expression}")

    # what a hand does

    def drag(self, start: tuple[float, float], end: tuple[float, float], steps: int = 6) -> None:
        """Drag with the mouse from one point of the window to another."""
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        mouse.move(*end, steps=steps)
        mouse.up()

    def tab(self, name: str) -> None:
        """Show the panel relief, layers or brushes."""
        if self.page.locator(f"#panel-{name}").is_hidden():
            self.page.locator(f"#tab-{name}").click()

    def slide(self, name: str, share: float) -> None:
        """Drag the slider of an option from where it is to a share of its length."""
        self.tab("relief")
        slider = self.page.locator(f"#slide-{name}")
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        now = self.js("(name) => { const s = document.getElementById(name); return s.value / s.max }", f"slide-{name}")
        thumb = 16  # its middle moves between half of it from both ends

        def at(part: float) -> tuple[float, float]:
            return box["x"] + thumb / 2 + part * (box["width"] - thumb), box["y"] + box["height"] / 2

        self.drag(at(now), at(share))

    def type(self, name: str, text: str) -> None:
        """Type a value and press Enter."""
        self.tab("relief")
        field = self.page.locator(f"#value-{name}")
        field.fill(text)
        field.press("Enter")

    def drop(self, *files: Path, at: tuple[float, float] = (400, 300)) -> None:
        """Drag files from outside onto the window, as from a folder of the desktop."""
        data = {"items": [], "files": [str(file) for file in files], "dragOperationsMask": 1}
        driver = self.page.context.new_cdp_session(self.page)
        for step in ("dragEnter", "dragOver", "drop"):
            driver.send("Input.dispatchDragEvent", {"type": step, "x": at[0], "y": at[1], "data": data})
        driver.detach()

    def save(self, name: str) -> None:
        """Save under a name."""
        self.page.keyboard.press("Control+s")
        self.page.locator("#save-name").fill(name)
        self.page.locator("#save-name").press("Enter")
        self.page.locator("#save-dialog").wait_for(state="hidden")

    def export(self, ending: str) -> Any:
        """Export the relief by the dialog; return the download."""
        self.page.keyboard.press("Control+e")
        self.page.locator("#export-format").select_option(ending)
        with self.page.expect_download() as download:
            self.page.locator("#export-start").click()
        self.page.locator("#export-close").click()
        return download.value
