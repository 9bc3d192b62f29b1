"""Ctrl-C ends a command within a second, even in the middle of a long call."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
import time
from collections.abc import Iterator
from types import FrameType

from nmaptool.io.interruption import UNFINISHED
from nmaptool_cli.guard import CTRL_C, interrupted

# Python handles Ctrl-C only between two of its own steps, and decoding or compressing a large picture is one step.
# If no step has ended after this time, the process is ended.
_PATIENCE_S = 0.6


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """While the block runs in the main thread, a second thread waits for Ctrl-C."""
    ours, signals = socket.socketpair()
    signals.setblocking(False)
    before = signal.set_wakeup_fd(signals.fileno(), warn_on_full_buffer=False)
    handler = signal.getsignal(signal.SIGINT)
    if handler is signal.default_int_handler:  # a shell's background jobs ignore Ctrl-C
        signal.signal(signal.SIGINT, _raise)
    threading.Thread(target=_wait, args=(ours,), daemon=True).start()
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        signal.set_wakeup_fd(before)
        signals.close()


def _raise(number: int, frame: FrameType | None) -> None:
    CTRL_C.set()
    signal.default_int_handler(number, frame)


def _wait(ours: socket.socket) -> None:
    """End the process some time after Ctrl-C, unless Ctrl-C itself has ended it by then."""
    with contextlib.suppress(ConnectionError):  # Windows may close a socket pair this way
        while numbers := ours.recv(1):
            if numbers[0] == signal.SIGINT:
                time.sleep(_PATIENCE_S)
                UNFINISHED.sweep()
                os._exit(interrupted())
