"""Options that the page sends as JSON: their types are checked, then the options classes check their values."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar

from nmaptool.core.errors import UsageError
from nmaptool.core.mentions import rendered
from nmaptool.options.fields import Options, kind_of
from nmaptool.options.kinds import Choice, Count, Kind, Numeric, Switch

_Given = TypeVar("_Given", bound=Options)


def options_from(options: type[_Given], values: Any) -> _Given:
    """Return options with values of the page; None stands for the default.

    Parameters
    ----------
    options : type
        The options class.
    values : mapping
        By the names of its fields.

    Raises
    ------
    UsageError
        If a name is not known or a value is not accepted.
    """
    if not isinstance(values, Mapping):
        raise UsageError("the page sent no options; reload it")
    fields = {f.name: f for f in dataclasses.fields(options)}
    read = {}
    for name, value in values.items():
        if name not in fields:
            raise UsageError(f"`{name}`: is not one of the options {', '.join(fields)}")
        if value is not None:
            read[name] = _typed(name, value, kind_of(fields[name]), fields[name].default)
    return options(**read)


def _typed(name: str, value: Any, kind: Kind | None, default: Any) -> Any:
    if isinstance(kind, Switch):
        if not isinstance(value, bool):
            raise UsageError(f"`{name}={value!r}`: must be on or off")
    elif isinstance(kind, Numeric):
        if type(value) not in (int, float):
            raise UsageError(f"`{name}={value!r}`: must be a number, such as {kind.such_as or default}")
        if isinstance(kind, Count) and value != round(value):
            raise UsageError(f"`{name}={value!r}`: must be a whole number")
        return round(value) if isinstance(kind, Count) else float(value)
    elif isinstance(kind, Choice) and isinstance(default, int):
        text = str(value)
        return int(text) if text in kind.names else text
    else:
        return str(value)
    return value


def in_words(text: str) -> str:
    """Return a message with the options named as the page labels them.

    >>> in_words("`sigma_s='4px'`: a mesh has no pixels; leave out `max_faces`")
    'sigma s = 4px: a mesh has no pixels; leave out max faces'
    """
    return rendered(text, _named)


def _named(name: str, value: Any) -> str:
    label = name.replace("_", " ")
    return label if value is None else f"{label} = {value}"
