"""Progress and timing of the stages of a computation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# called with the name of the stage and the share done, 0 to 1
Progress = Callable[[str, float], None]


def part(progress: Progress | None, start: float, end: float) -> Progress | None:
    """Report the progress of a part: its shares 0 to 1 become ``start`` to ``end`` of the whole.

    >>> part(lambda word, share: print(word, share), 0.5, 1.0)("rebuilding", 0.5)
    rebuilding 0.75
    """
    if progress is None:
        return None
    return lambda word, share: progress(word, start + (end - start) * share)


class Stages:
    """Times the stages of a computation and reports its progress.

    Parameters
    ----------
    progress : callable, optional
        Called as each stage begins.

    Attributes
    ----------
    elapsed : dict of str to float
        Seconds by stage, summed over repeated stages.
    """

    def __init__(self, progress: Progress | None = None) -> None:
        self.progress = progress
        self.elapsed: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str, share: float | None = None) -> Iterator[None]:
        """Time a stage; if ``share``, the share done so far, is given, also report that the stage begins."""
        if share is not None:
            self.tell(name, share)
        start = time.perf_counter()
        yield
        self.elapsed[name] = self.elapsed.get(name, 0.0) + time.perf_counter() - start

    def tell(self, name: str, share: float) -> None:
        """Report the share done so far."""
        if self.progress is not None:
            self.progress(name, share)

    def seconds(self, digits: int = 4) -> dict[str, float]:
        """Rounded seconds by stage, for a report."""
        return {name: round(value, digits) for name, value in self.elapsed.items()}
