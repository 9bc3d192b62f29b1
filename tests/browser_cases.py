"""Fixtures of the tests in a real browser: one Chromium for each test process, and studios of this process to look at.

Chromium is the system's own. Where it is missing, the tests are skipped, and the reason names the command.
"""

from __future__ import annotations

import contextlib
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from browser_windows import TIMEOUT_MS, Window

PICTURES = Path(__file__).parents[1] / "build" / "pictures"
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
# WebGL on the processor, as the picture must also work there; the rest of the page is faster without WebGL's library
WEBGL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
FLAGS = (*WEBGL, "--disable-gpu-rasterization", "--disable-gpu-compositing")
COARSE = 'Object.defineProperty(window, "devicePixelRatio", { get: () => 0.4 })'
COMMAND = "import sys; from nmaptool_cli.start import run; sys.exit(run())"
MISSING = "needs Chromium; on Debian and Ubuntu: sudo apt-get install -y --no-install-recommends chromium"


def chromium() -> str:
    """The path of the system's Chromium; skips the test if there is none."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(MISSING)
    return found


class Browser:
    """A Chromium, and the thread that drives it.

    The driver keeps an asyncio loop running in its thread. In the main thread, no other test could start a loop.
    """

    def __init__(self) -> None:
        self._path = chromium()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="browser")
        self._stack = contextlib.ExitStack()
        self.do(self._start)

    def do(self, function: Callable[..., Any], *given: Any, **more: Any) -> Any:
        """Call a function in the thread of the browser."""
        return self._thread.submit(function, *given, **more).result()

    def launch(self, *flags: str) -> Any:
        """Start another Chromium."""
        return self._driver.chromium.launch(executable_path=self._path, args=[*FLAGS, *flags])

    def open(self, *, sharp: bool = False, **more: Any) -> Any:
        """Return a new context, which shares nothing with others.

        Unless ``sharp``, it draws a sixth of the pixels of the relief.
        """
        if not self._chromium.is_connected():
            self._chromium = self.launch()
        context = self._chromium.new_context(**{"viewport": {"width": 1280, "height": 800}, **more})
        context.set_default_timeout(TIMEOUT_MS)
        if not sharp:
            context.add_init_script(COARSE)
        return context

    def close(self) -> None:
        """End Chromium and the thread."""
        self.do(self._chromium.close)
        self.do(self._stack.close)
        self._thread.shutdown()

    def _start(self) -> None:
        from playwright.sync_api import sync_playwright

        self._driver = self._stack.enter_context(sync_playwright())
        self._chromium = self.launch()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A Chromium for all tests of the process."""
    found = Browser()
    yield found
    found.close()


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Run a test that uses the browser in the browser's thread."""
    if "browser" not in pyfuncitem.funcargs:
        return None
    given = {name: pyfuncitem.funcargs[name] for name in pyfuncitem._fixtureinfo.argnames}
    pyfuncitem.funcargs["browser"].do(pyfuncitem.obj, **given)
    return True


@contextlib.contextmanager
def running(*files: Path, root: Path, port: int = 0) -> Iterator[Any]:
    """A studio of this process that shows some files; ``root`` is its folder."""
    from nmaptool.studio.document import opened
    from nmaptool.studio.server import Studio

    studio = Studio(opened([str(file) for file in files]), port, root=root)
    thread = threading.Thread(target=studio.run)
    thread.start()
    while not studio.is_started:
        time.sleep(0.01)
    try:
        yield studio
    finally:
        studio.stop()
        thread.join(20)
        assert not thread.is_alive()


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """``serve(*files)`` starts a studio, which ends with the test."""
    with contextlib.ExitStack() as stack:
        yield lambda *files, **more: stack.enter_context(running(*files, root=tmp_path / "state", **more))


@pytest.fixture
def window(browser: Browser, request: pytest.FixtureRequest) -> Iterator[Callable[..., Window]]:
    """``window(studio)`` opens the page of a studio.

    At the end of the test, every window must have had no error and no request to another machine. Options of the
    context, such as ``color_scheme="dark"``, may be given; ``beside=window`` opens a second window of the same browser.
    """
    opened: list[Window] = []
    contexts: list[Any] = []
    name = re.sub(r"\W+", "-", request.node.name.removeprefix("test_")).strip("-")

    def make(studio: Any, beside: Window | None = None, **more: Any) -> Window:
        context = browser.open(**more) if beside is None else beside.page.context
        if beside is None:
            contexts.append(context)
        opened.append(Window(context, studio, PICTURES / f"{name}-{len(opened) + 1}" if opened else PICTURES / name))
        return opened[-1]

    yield make
    try:
        for one in opened:
            browser.do(one.check)
    finally:
        for context in contexts:
            browser.do(context.close)


def nmap(*words: object) -> None:
    """Run the command line in its own process."""
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *map(str, words)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
