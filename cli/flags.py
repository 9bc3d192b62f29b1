"""Flags of commands, made from the fields of options classes: names, types, defaults, help and groups."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from cyclopts import Group, Parameter

from nmaptool.options.fields import Options, descriptions, kind_of
from nmaptool.options.kinds import Choice, Kind
from nmaptool_cli.mentions import flag_of

# groups of flags, in the order in which --help shows them
_ORDER = (
    "Inputs",
    "Outputs",
    "Camera",
    "Filter",
    "Reconstruction",
    "Depth",
    "Transform",
    "Blending",
    "Layers",
    "Canvas",
    "Relief",
    "Plate",
    "Frame",
    "Text",
    "Solid",
    "Parts",
    "Machine",
    "Large maps",
    "Picture",
    "Studio",
    "Batch",
    "Reading",
    "Run",
)
GROUPS = {name: Group(name, sort_key=place) for place, name in enumerate(_ORDER, start=1)}
# types that the parser converts itself
_PARSED = (str, bool, int, float, Path)


def flags_of(options: type[Options]) -> Iterator[inspect.Parameter]:
    """The fields of a class as keyword parameters of a command: the output first, fields of base classes last."""
    hints, help_texts = get_type_hints(options), descriptions(options)
    for field in sorted(dataclasses.fields(options), key=lambda f: (f.name != "output", _depth(options, f.name))):
        kind = kind_of(field)
        shown = Parameter(
            name=[flag_of(field.name), *([field.metadata["short"]] if "short" in field.metadata else [])],
            group=GROUPS[options.group],
            help=help_texts[field.name],
            show_default=False if field.default == () or field.default is False else None,
        )
        yield keyword(field.name, field.default, _hint(field.name, hints[field.name], kind), shown)


def keyword(name: str, default: Any, hint: Any, shown: Parameter) -> inspect.Parameter:
    """A keyword parameter with its settings for the parser."""
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[hint, shown])


def _depth(options: type[Options], name: str) -> int:
    """How many classes up the field is defined."""
    return max(place for place, owner in enumerate(options.__mro__) if name in vars(owner).get("__annotations__", ()))


def _hint(name: str, hint: Any, kind: Kind | None) -> Any:
    """The type that the parser uses."""
    if isinstance(kind, Choice) and callable(kind.choices):
        return Literal[kind.names]
    parts = [part for part in (get_args(hint) or (hint,)) if part is not type(None)]
    if kind is None or get_origin(hint) in (tuple, Literal) or all(_is_parsed(part) for part in parts):
        return hint
    # one word, such as 12mm, parsed by its kind: the parser itself would expect a word for each field of the value
    one_word = Parameter(n_tokens=1, accepts_keys=False, converter=lambda _, tokens: kind.read(name, tokens[0].value))
    return Annotated[hint, one_word]


def _is_parsed(part: Any) -> bool:
    return part in _PARSED or get_origin(part) is Literal
