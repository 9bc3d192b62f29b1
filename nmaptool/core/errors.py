"""Errors that nmaptool raises on purpose, each with the exit code of the command line.

A message is one line: the file or option, what was found, what is accepted, and the remedy. It names options as
`nmaptool.core.mentions` describes.
"""

from __future__ import annotations

from typing import ClassVar

from nmaptool.core.mentions import Mention, options_in, rendered


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
