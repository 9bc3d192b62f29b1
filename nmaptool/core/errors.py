"""Errors a user can meet, each with the exit code that the command line answers with.

A message is one line: the file or option, what was found, what is accepted, and the remedy.
"""

from __future__ import annotations


def reason_of(error: OSError) -> str:
    """Why the operating system refused, in its words."""
    return error.strerror or "is the disk full?"


class NmaptoolError(Exception):
    """Base of every error that nmaptool raises on purpose."""

    exit_code = 1


class UsageError(NmaptoolError, ValueError):
    """An option or argument that is not accepted (exit code 2)."""

    exit_code = 2


class InputError(NmaptoolError, ValueError):
    """A file or array that cannot be used as it is (exit code 3)."""

    exit_code = 3


class LimitError(NmaptoolError):
    """An input over a limit of size or memory, refused before allocation (exit code 4)."""

    exit_code = 4


class OutputError(NmaptoolError, OSError):
    """A result that cannot be written (exit code 5)."""

    exit_code = 5


class RendererError(NmaptoolError, RuntimeError):
    """No OpenGL context is available, or it cannot draw (exit code 6)."""

    exit_code = 6


class ConvergenceError(NmaptoolError, ArithmeticError):
    """A solve that did not reach its tolerance (exit code 7).

    Attributes
    ----------
    history : tuple of float
        Relative residual after each iteration.
    """

    exit_code = 7

    def __init__(self, message: str, history: tuple[float, ...]) -> None:
        super().__init__(message)
        self.history = history
