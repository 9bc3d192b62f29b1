"""Errors that nmaptool raises on purpose, each with the exit code of the command line.

A message is one line: ``SUBJECT: FINDING; REMEDY``. The subject is a file or an option, and the finding says what was
found and what is accepted. It names options as `nmaptool.core.mentions` describes; an error gives its parts one by one.
"""

from __future__ import annotations

import re
from typing import Any, ClassVar

from nmaptool.core.mentions import Mention, mentions_in, options_in, rendered

# how a message begins to say what is accepted
_ACCEPTED = re.compile(r"\b(?:must|use one of|use|expected|accepted are|needs)\b.*")


def _finding(text: str) -> str:
    """A message without its subject, its remedy and its example."""
    subject, colon, rest = text.partition(": ")
    return (rest if colon else subject).partition("; ")[0].partition(", such as ")[0]


def reason_of(error: OSError) -> str:
    """The reason that the operating system gives for a failure."""
    return error.strerror or "is the disk full?"


class NmaptoolError(Exception):
    """Base of every error that nmaptool raises on purpose."""

    exit_code: ClassVar[int] = 1

    def __init_subclass__(cls, exit_code: int | None = None) -> None:
        super().__init_subclass__()
        cls.exit_code = cls.exit_code if exit_code is None else exit_code

    @property
    def found(self) -> Any:
        """The value of the first option in the message; None if the message gives none."""
        return next((value for _, value in mentions_in(str(self)) if value is not None), None)

    @property
    def accepted(self) -> str:
        """What the message says is accepted, such as "must lie between 0 and 1"; empty if it does not say."""
        said = _ACCEPTED.search(_finding(str(self)))
        return said[0] if said else ""

    @property
    def remedy(self) -> str:
        """What to do, the part after the last semicolon or "such as"; empty if the message does not say."""
        text = str(self)
        for mark in ("; ", ", such as "):
            before, _, after = text.rpartition(mark)
            if before:
                return after
        return ""

    @property
    def options(self) -> tuple[str, ...]:
        """Field names of the options in the message, in order of appearance."""
        return options_in(str(self))

    def rendered(self, mention: Mention) -> str:
        """The message, with each option replaced by ``mention(name, value)``."""
        return rendered(str(self), mention)


class UsageError(NmaptoolError, ValueError, exit_code=2):
    """An option or argument that is not accepted (exit code 2)."""


class InputError(NmaptoolError, ValueError, exit_code=3):
    """A file or array that cannot be used (exit code 3)."""


class LimitError(NmaptoolError, exit_code=4):
    """An input that exceeds a limit of size or memory, refused before allocation (exit code 4)."""


class OutputError(NmaptoolError, OSError, exit_code=5):
    """A result that cannot be written (exit code 5)."""


class RendererError(NmaptoolError, RuntimeError, exit_code=6):
    """No OpenGL context is available, or it cannot draw (exit code 6)."""


class ClusterError(NmaptoolError, RuntimeError, exit_code=8):
    """A Dask cluster that cannot be started or reached, has gone, or lost the process of a job (exit code 8)."""


class ConvergenceError(NmaptoolError, ArithmeticError, exit_code=7):
    """A solve that did not reach its tolerance (exit code 7).

    Attributes
    ----------
    history : tuple of float
        Relative residual after each iteration.
    """

    def __init__(self, message: str, history: tuple[float, ...]) -> None:
        super().__init__(message)
        self.history = history
