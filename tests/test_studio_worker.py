"""The solver's thread: which requests it answers while a control moves."""

import json
import struct
import threading

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.studio.document import Document
from nmaptool.studio.windows import Window
from nmaptool.studio.worker import Worker


class FakeEngine:
    """Stands in for the engine: a solve on either grid lasts until the test lets it go on."""

    size, scene = (4, 4), None
    started, go_on = threading.Semaphore(0), threading.Semaphore(0)

    def __init__(self, *_):
        self.parts_ = nm.ReliefSession(np.dstack([np.full((4, 4), 0.5), np.zeros((4, 4)), np.ones((4, 4))])).parts()

    def fits(self, _):
        return True

    def is_whole(self, longest):
        return longest is None

    def parts(self, _, *, longest, progress):
        self.started.release()
        assert self.go_on.acquire(timeout=20)
        progress("solving", 0.5)
        return self.parts_


@pytest.fixture
def answers(monkeypatch):
    """A worker, and the headers of the frames that it sent."""
    monkeypatch.setattr("nmaptool.studio.worker.Engine", FakeEngine)
    monkeypatch.setattr("nmaptool.studio.worker.placements", lambda _: {"kind": "placements"})
    sent, came = [], threading.Semaphore(0)

    def send(message):
        if isinstance(message, bytes):
            sent.append(json.loads(message[4 : 4 + struct.unpack("<I", message[:4])[0]]))
            came.release()

    worker = Worker(send)
    yield worker, sent, came
    FakeEngine.go_on.release(4)
    worker.stop()
    while FakeEngine.go_on.acquire(blocking=False) or FakeEngine.started.acquire(blocking=False):
        pass


def test_a_preview_is_shown_even_if_the_hand_has_moved_on_and_the_newest_request_follows(answers):
    worker, sent, came = answers
    worker.want(Document())
    assert FakeEngine.started.acquire(timeout=20)
    for _ in range(3):
        worker.want(Document())
    for _ in range(2):
        FakeEngine.go_on.release()
        assert came.acquire(timeout=20)
    assert [(one["request"], one["is_full"]) for one in sent] == [(1, False), (4, False)]


def test_a_full_solve_that_is_no_longer_wanted_is_given_up(answers):
    worker, sent, came = answers
    worker.want(Document())
    FakeEngine.go_on.release()
    assert came.acquire(timeout=20)
    for _ in range(2):  # the preview's, and that at full resolution
        assert FakeEngine.started.acquire(timeout=20)
    worker.want(Document())
    FakeEngine.go_on.release()  # the full solve learns that it is not wanted
    FakeEngine.go_on.release()
    assert came.acquire(timeout=20)
    assert [(one["request"], one["is_full"]) for one in sent] == [(1, False), (2, False)]


class GridEngine(FakeEngine):
    """Stands in for an engine that tells which grids it solves."""

    solved: list[int | None]

    def __init__(self, *_):
        super().__init__()
        self.solved = []

    def is_whole(self, longest):
        return longest is None

    def parts(self, _, *, longest, progress):
        self.solved.append(longest)
        return self.parts_


@pytest.mark.parametrize(
    ("preview_s", "is_moving", "grids"),
    [
        (0.001, True, [512, None]),
        (0.1, True, [256, 512, None]),  # a slow machine
        (0.1, False, [512, None]),
    ],
)
def test_a_slow_machine_solves_a_quicker_grid_while_a_control_moves(monkeypatch, preview_s, is_moving, grids):
    monkeypatch.setattr("nmaptool.studio.worker.Engine", GridEngine)
    monkeypatch.setattr("nmaptool.studio.worker.placements", lambda _: {"kind": "placements"})
    full = threading.Event()

    def send(message):
        if isinstance(message, bytes) and b'"is_full": true' in message:
            full.set()

    worker = Worker(send)
    worker._preview_s = preview_s
    worker.want(Document(), is_moving=is_moving)
    assert full.wait(20)
    assert worker._engine.solved == grids
    worker.stop()


def test_heights_that_wait_are_replaced_by_newer_ones():
    window = Window()
    for message in ({"n": 1}, b"old", {"n": 2}, b"new"):
        window.put(message)
    waiting = [window.waiting.get_nowait() for _ in range(window.waiting.qsize())]
    assert waiting == [{"n": 1}, {"n": 2}, b"new"]
    for number in range(100):
        window.put({"n": number})
    assert window.waiting.qsize() == 64
    assert window.waiting.get_nowait() == {"n": 36}
