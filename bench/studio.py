"""The studio in a browser while a control moves: ``python -m bench.studio [--side 512] [--events 60]``.

Headless Chromium draws on the processor (software WebGL), beside the server, so both share its cores.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import nmaptool as nm
from bench.checks import line
from bench.maps import scene
from bench.report import Report
from bench.session import maps_of
from bench.table import table

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
# as Chromium runs where there is no graphics card: WebGL and the page are drawn by the processor
_FLAGS = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--no-sandbox",
)
_TIMEOUT_MS = 60_000
# from a value, and a factor at each event
SOLVED = {"mu": (0.1, 1.03), "beta": (0.001, 1.02), "slope_cap": (3.0, 0.985)}
DRAWN = ("delta", "height", "light")
MOST_MEDIAN_MS, MOST_P90_MS, LEAST_FRAMES, MOST_FIRST_S = 60.0, 100.0, 30.0, 2.5

# moves a control once for each picture of the screen, and times each event until a frame holds it or a newer one
_DRAG = """async ([name, values]) => {
  const { studio } = window;
  const events = [];
  const sent = [];
  const seen = [];
  const ask = studio.ask.bind(studio);
  studio.ask = (message) => {
    if (message.do === "set") sent.push(events.length);
    return ask(message);
  };
  const first = studio.frame.request;
  const see = studio.see.bind(studio);
  studio.see = (frame) => {
    const started = performance.now();
    see(frame);
    const now = performance.now();
    const held = sent[frame.request - first - 1] ?? 0;
    seen.push({ held, at: now, page: now - started, engine: 1000 * frame.seconds, cols: frame.cols });
  };
  for (const value of values) {
    events.push(performance.now());
    studio.change(name, value, true);
    await new Promise(requestAnimationFrame);
  }
  const moved = performance.now();
  const isShown = () => seen.at(-1)?.held >= events.length;
  while (!isShown() && performance.now() < moved + 10000) await new Promise((go) => setTimeout(go, 5));
  delete studio.ask;
  delete studio.see;
  studio.change(name, values.at(-1), false);
  const waits = events.map((at, i) => (seen.find((frame) => frame.held > i)?.at ?? Infinity) - at);
  const [page, engine, cols] = ["page", "engine", "cols"].map((fact) => seen.map((one) => one[fact]));
  return { waits, sent: sent.length, page, engine, cols, pace: (moved - events[0]) / values.length };
}"""
# changes what the page computes alone, once for each picture of the screen
_DRAW = """async ([name, values]) => {
  const { studio } = window;
  let asked = 0;
  const ask = studio.ask.bind(studio);
  studio.ask = (message) => {
    asked += 1;
    return ask(message);
  };
  const light = document.querySelector("#light, .light");
  const started = performance.now();
  for (const value of values) {
    if (name === "light") light.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
    else studio.change(name, value, true);
    await new Promise(requestAnimationFrame);
  }
  const seconds = (performance.now() - started) / 1000;
  delete studio.ask;
  return { asked, frames: values.length / seconds };
}"""


@dataclass
class Dragged:
    """Times in ms of a drag: of each event until its frame, of the engine and the page for each frame."""

    waits: list[float]
    engine: list[float]
    page: list[float]

    @property
    def p90(self) -> float:
        """The time that nine of ten events take at most."""
        return float(np.quantile(self.waits, 0.9))


@contextlib.contextmanager
def served(file: Path, home: Path) -> Iterator[str]:
    """The address of a studio in its own process."""
    env = {**os.environ, **dict.fromkeys(("HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME"), str(home))}
    code = "import sys; from nmaptool_cli.start import run; sys.exit(run())"
    command = [sys.executable, "-c", code, "studio", str(file), "--no-browser"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=env) as process:
        assert process.stderr is not None
        try:
            yield process.stderr.readline().partition("studio: ")[2].strip()
        finally:
            process.terminate()


def opened(browser: Any, address: str) -> Any:
    """A page that shows the first picture of a studio."""
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.set_default_timeout(_TIMEOUT_MS)
    page.goto(address)
    page.wait_for_function("() => window.studio?.frame && studio.stage.view.drawn > 0")
    return page


def first_picture(browser: Any, folder: Path) -> float:
    """Seconds from the command to the picture of a map of 1000 x 900 px."""
    path = folder / "map.png"
    nm.write_normal_map(scene(1000, 900).cut_out(), path)
    seconds = []
    for number in range(3):
        started = time.perf_counter()
        with served(path, folder / f"first{number}") as address:
            page = opened(browser, address)
            seconds.append(time.perf_counter() - started)
            page.close()
    return median(seconds)


def document(folder: Path, side: int) -> Path:
    """A recipe of an original and a detail map."""
    for name, one in zip(("original", "detail"), maps_of("statue", side), strict=True):
        nm.write_normal_map(one, folder / f"{name}.exr")
    text = '[[layer]]\nfile = "original.exr"\n[relief]\ndetail = "detail.exr"\nheight = "5mm"\n'
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    return folder / "scene.toml"


def drag(page: Any, name: str, events: int) -> Dragged:
    """Drag the slider of an option that needs a solve."""
    start, factor = SOLVED[name]
    page.wait_for_function("() => studio.frame.is_full")
    page.evaluate(_DRAG, [name, [start * factor]])  # loads what the first move needs
    page.wait_for_function("() => studio.frame.is_full")
    found = page.evaluate(_DRAG, [name, [start * factor**step for step in range(2, events + 2)]])
    return Dragged(found["waits"], found["engine"], found["page"])


def draw(page: Any, name: str, events: int) -> tuple[float, int]:
    """Frames a second, and requests, while something moves that the page computes alone."""
    values: list[Any] = [f"{4 + step / 20:.4g}mm" if name == "height" else 20 + step for step in range(events)]
    found = page.evaluate(_DRAW, [name, values])
    return found["frames"], found["asked"]


def measured(report: Report, path: str, side: int, events: int) -> None:
    """Measure everything with one Chromium."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as name, sync_playwright() as driver:
        folder = Path(name)
        browser = driver.chromium.launch(executable_path=path, args=list(_FLAGS))
        opening = first_picture(browser, folder)
        with served(document(folder, side), folder / "home") as address:
            page = opened(browser, address)
            dragged = {option: drag(page, option, events) for option in SOLVED}
            drawn = {what: draw(page, what, events) for what in DRAWN}
        browser.close()
    rows = [
        [option, f"{median(one.waits):.0f}", f"{one.p90:.0f}", f"{len(one.engine)}"]
        + [f"{median(times):.1f}" for times in (one.engine, one.page)]
        for option, one in dragged.items()
    ]
    lines = [line("first picture of a map of 1000 x 900 px, from the command", opening, MOST_FIRST_S, "s")]
    for option, one in dragged.items():
        lines.append(line(f"{option}, event to frame at {side} px, median", median(one.waits), MOST_MEDIAN_MS, "ms"))
        lines.append(line(f"{option}, event to frame at {side} px, 90 %", one.p90, MOST_P90_MS, "ms"))
    for what, (frames, asked) in drawn.items():
        lines.append(line(f"{what}, time of a frame at {side} px", 1000 / frames, 1000 / LEAST_FRAMES, "ms"))
        lines.append(line(f"{what}, requests", float(asked), 0.0, ""))
    preface = (
        f"A drag of {events} events, one for each picture of the screen, in headless Chromium with WebGL on the\n"
        "processor: milliseconds from an event to the first frame that holds it or a newer one. Of the frames: the\n"
        "time of the solver, and that of the page, which computes the heights. The rest is the wait for a solve under\n"
        "way, the encoding and the way between the two."
    )
    header = ("option", "median", "90 %", "frames", "engine", "page")
    report.end(preface, table(header, rows), "\n".join(lines))


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("studio", __doc__)
    report.argument("--side", type=int, default=512, help="side of the map in pixels (512)")
    report.argument("--events", type=int, default=60, help="events of a drag (60)")
    options = report.begin()
    path = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if path is None:
        print("not measured: Chromium is not installed; on Debian and Ubuntu: sudo apt-get install -y chromium")
        return
    measured(report, path, options.side, options.events)


if __name__ == "__main__":
    main()
