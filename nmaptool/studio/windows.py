"""The pages that show the document, and the messages that wait for them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, TypeAlias

Message: TypeAlias = dict[str, Any]
# messages that a window has not yet taken; older ones are dropped
_MOST_WAITING = 64


class Window:
    """A page that shows the document: the messages that wait for it."""

    def __init__(self) -> None:
        self.waiting: asyncio.Queue[bytes | Message] = asyncio.Queue()

    def put(self, message: bytes | Message) -> None:
        """Add a message; heights replace those that wait, and a slow page loses the oldest of too many."""
        waiting = []
        while not self.waiting.empty():
            waiting.append(self.waiting.get_nowait())
        if isinstance(message, bytes):
            waiting = [one for one in waiting if not isinstance(one, bytes)]
        for one in (*waiting[1 - _MOST_WAITING :], message):
            self.waiting.put_nowait(one)


class Windows:
    """All open pages. Its methods are called in the thread of the server, except those that end in ``later``."""

    def __init__(self) -> None:
        self._open: set[Window] = set()
        self.loop: asyncio.AbstractEventLoop | None = None

    def enter(self, window: Window) -> None:
        """A page was opened."""
        self.loop = asyncio.get_running_loop()
        self._open.add(window)

    def leave(self, window: Window) -> None:
        """A page was closed."""
        self._open.discard(window)

    def tell(self, message: bytes | Message) -> None:
        """Send a message to every window."""
        for window in self._open:
            window.put(message)

    def tell_later(self, message: bytes | Message) -> None:
        """Send a message to every window, from any thread."""
        self.later(self.tell, message)

    def put_later(self, window: Window, message: bytes | Message) -> None:
        """Send a message to one window, from any thread."""
        self.later(window.put, message)

    def later(self, call: Callable[..., None], *arguments: object) -> None:
        """Call a function in the thread of the server, from any thread; nothing happens before a page was opened."""
        if self.loop is not None and not self.loop.is_closed():
            self.loop.call_soon_threadsafe(call, *arguments)
