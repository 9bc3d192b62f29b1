"""Option names in messages: written in Python style, and rendered by each front end in its own style.

A message of the library names an option in backticks, alone or with a value: ``use a larger `beta``` or
```fit='scale'`: needs `height```. Python shows it unchanged; the command line and recipes render it.
"""

from __future__ import annotations

import ast
import contextlib
import re
from collections.abc import Callable
from typing import Any

_MENTION = re.compile(r"`([a-z][a-z0-9_]*)(?:=([^`]*))?`")

# called with the name of an option and its value, None if the message gives no value
Mention = Callable[[str, Any], str]


def rendered(text: str, mention: Mention) -> str:
    """A message with each option replaced by ``mention(name, value)``.

    >>> rendered("use `fit='scale'` or a larger `height`", lambda name, value: f"{name.upper()} {value}")
    'use FIT scale or a larger HEIGHT None'
    """
    return _MENTION.sub(lambda found: mention(found[1], found[2] and _value(found[2])), text)


def written_name(field: str) -> str:
    """The name of an option as users write it: without the underscore that keeps it apart from a keyword of Python.

    >>> written_name("from_"), written_name("max_error")
    ('from', 'max_error')
    """
    return field.removesuffix("_")


def options_in(text: str) -> tuple[str, ...]:
    """The names of the options in a message, in order of appearance.

    >>> options_in("`fit='height'`: needs `height`")
    ('fit', 'height')
    """
    return tuple(found[1] for found in _MENTION.finditer(text))


def mentions_in(text: str) -> tuple[tuple[str, Any], ...]:
    """The names of the options in a message with their values, None where the message gives no value.

    >>> mentions_in("`fit='height'`: needs `height`")
    (('fit', 'height'), ('height', None))
    """
    return tuple((found[1], found[2] and _value(found[2])) for found in _MENTION.finditer(text))


def _value(text: str) -> Any:
    """The value after ``name=``: a Python literal, inf or nan; any other text is returned unchanged."""
    for read in (ast.literal_eval, float):
        with contextlib.suppress(ValueError, SyntaxError, TypeError):
            return read(text)
    return text
