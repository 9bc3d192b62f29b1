"""Why a control of the page has no effect, or one of its choices cannot be chosen, in the words of the options."""

from __future__ import annotations

import dataclasses
import functools
import re
from typing import Any

from nmaptool.core.errors import UsageError
from nmaptool.options import ReliefOptions, SolidOptions
from nmaptool.options.fields import Options, kind_of
from nmaptool.options.kinds import Choice, Numeric, Switch
from nmaptool.studio.document import Document

Reasons = dict[str, dict[str, Any]]


def reasons(document: Document) -> Reasons:
    """Return the controls that cannot be used now, and the choices, each with its reason.

    Where a value is refused together with the others, the reason is that of the options class, which is asked; values
    that are accepted but change nothing are listed here.
    """
    files = document.relief.files
    found = _refused(document.options, document.solid)
    controls, choices = dict(found["controls"]), dict(found["choices"])
    if files.detail is None:
        controls |= dict.fromkeys(("mu", "energy"), "has no effect without a detail map")
    if document.options.beta == 0:
        controls["delta"] = "has no effect while `beta` is 0"
    if files.surface is None:
        choices["background"] = {**choices.get("background", {}), "surface": "needs the file of a curved background"}
    return {"controls": controls, "choices": choices}


@functools.lru_cache(maxsize=64)
def _refused(options: ReliefOptions, solid: SolidOptions) -> Reasons:
    controls: dict[str, str] = {}
    choices: dict[str, dict[str, str]] = {}
    for given in (options, solid):
        for field in dataclasses.fields(given):
            kind, now = kind_of(field), getattr(given, field.name)
            if isinstance(kind, Choice):
                refused = {name: why for name in kind.names if name != now and (why := _why(given, field.name, name))}
                if refused and len(refused) == len(kind.names) - 1 and now == field.default:
                    controls[field.name] = next(iter(refused.values()))
                elif refused:
                    choices[field.name] = refused
            elif now == field.default and kind is not None and not isinstance(kind, Numeric):
                example = True if isinstance(kind, Switch) else kind.such_as
                why = _why(given, field.name, example)
                if why:
                    controls[field.name] = why
    return {"controls": controls, "choices": choices}


def _why(given: Options, name: str, value: Any) -> str:
    """Why a value is refused, without the value itself; empty if it is accepted."""
    try:
        dataclasses.replace(given, **{name: value})
    except UsageError as error:
        return re.sub(rf"^`{name}=[^`]*`: ", "", str(error)).removesuffix(f", not {value}")
    return ""
