"""Flags that are given once for all inputs of a command, or once for each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from nmaptool.core.errors import UsageError

_Value = TypeVar("_Value")


def spread(flag: str, given: Sequence[_Value], count: int, inputs: str) -> Sequence[_Value]:
    """A value for each of ``count`` inputs.

    Parameters
    ----------
    flag : str
        Without its dashes.
    given : sequence
        One value or ``count``.
    count : int
    inputs : str
        What they are called, one of them and several: ``mesh meshes``.

    Raises
    ------
    UsageError
        If the flag was given another number of times.
    """
    if len(given) == 1:
        return [given[0]] * count
    if len(given) != count:
        one, several = inputs.split()
        raise UsageError(
            f"--{flag}: is given {len(given)} times for {count} {several}; give it once, or once for each {one}"
        )
    return given
