"""Options in messages: written as Python has them, so that every front end can say them in its own way.

A message of the library names an option in backticks, alone or with a value: ``use a larger `beta``` or
```fit='scale'`: needs `height```. Python shows it as it is; the command line and recipes render it.
"""

from __future__ import annotations

import ast
import contextlib
import re
from collections.abc import Callable
from typing import Any

_MENTION = re.compile(r"`([a-z][a-z0-9_]*)(?:=([^`]*))?`")

# the name of an option and its value; None where the option is named alone
Mention = Callable[[str, Any], str]


def rendered(text: str, mention: Mention) -> str:
    """A message with every option as ``mention(name, value)`` says it.

    >>> rendered("use `fit='scale'` or a larger `height`", lambda name, value: f"{name.upper()} {value}")
    'use FIT scale or a larger HEIGHT None'
    """
    return _MENTION.sub(lambda found: mention(found[1], found[2] and _value(found[2])), text)


def options_in(text: str) -> tuple[str, ...]:
    """The names of the options in a message, in its order.

    >>> options_in("`fit='height'`: needs `height`")
    ('fit', 'height')
    """
    return tuple(found[1] for found in _MENTION.finditer(text))


def _value(text: str) -> Any:
    """What is written after ``name=``: a literal of Python, or inf or nan; other text stays text."""
    for read in (ast.literal_eval, float):
        with contextlib.suppress(ValueError, SyntaxError, TypeError):
            return read(text)
    return text
