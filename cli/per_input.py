"""Flags that are given once for all inputs of a command or once for each."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, descriptions, kind_of
from nmaptool.options.kinds import Count, Kind, Numeric, Switch
from nmaptool_cli.flags import GROUPS, keyword
from nmaptool_cli.mentions import flag_of

_Value = TypeVar("_Value")


@dataclass(frozen=True)
class PerInput:
    """Fields of an options class as flags that may be repeated, once for each input.

    Parameters
    ----------
    options : type of Options
    names : tuple of str
        The fields.
    inputs : str
        The name of the inputs, singular and plural: ``mesh meshes``.
    base : Options
        Values of everything that is not given.
    """

    options: type[Options]
    names: tuple[str, ...]
    inputs: str
    base: Options

    def kinds(self) -> dict[str, Kind]:
        """The kind of each field."""
        found = {field.name: kind_of(field) for field in dataclasses.fields(self.options)}
        return {name: kind for name in self.names if (kind := found[name]) is not None}

    def flags(self) -> Iterator[inspect.Parameter]:
        """The flags as keyword parameters of a command; switches apply to all inputs."""
        help_texts = descriptions(self.options)
        for name, kind in self.kinds().items():
            default = getattr(self.base, name)
            shown = Parameter(
                name=flag_of(name),
                group=GROUPS[self.options.group],
                help=help_texts[name],
                show_default=False if default in (None, "", False) else partial(_shown, str(default)),
            )
            if isinstance(kind, Switch):
                yield keyword(name, False, bool, shown)
            else:
                yield keyword(name, (), tuple[_word_type(kind), ...], shown)  # type: ignore[misc]

    def spread(self, words: Mapping[str, Any], count: int) -> list[Any]:
        """The options of each of ``count`` inputs.

        Raises
        ------
        UsageError
            If a flag is given neither once nor once for each input.
        """
        each: list[dict[str, Any]] = [{} for _ in range(count)]
        for name in self.names:
            given = words.get(name, ())
            values = [given] * count if isinstance(given, bool) else spread(name, given or [None], count, self.inputs)
            for options, value in zip(each, values, strict=True):
                if value is not None:
                    options[name] = value
        return [dataclasses.replace(self.base, **options) for options in each]


def _shown(default: str, _: Any) -> str:
    """The default for each input; the default of the flag itself is an empty tuple."""
    return default


def _word_type(kind: Kind) -> type:
    if isinstance(kind, Count):
        return int
    return float if isinstance(kind, Numeric) else str


def spread(name: str, given: Sequence[_Value], count: int, inputs: str) -> Sequence[_Value]:
    """A value for each of ``count`` inputs.

    Parameters
    ----------
    name : str
        Name of the field.
    given : sequence
        One value or ``count``.
    count : int
    inputs : str
        Their name, singular and plural: ``mesh meshes``.

    Raises
    ------
    UsageError
        If the flag is given neither once nor ``count`` times.
    """
    if len(given) == 1:
        return [given[0]] * count
    if len(given) != count:
        one, several = inputs.split()
        remedy = f"give it once, or once for each {one}"
        raise UsageError(f"{flag_of(name)}: given {len(given)} times for {count} {several}; {remedy}")
    return given
