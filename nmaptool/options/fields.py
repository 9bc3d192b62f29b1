"""Fields of the options' dataclasses: a default and a kind each, checked when the options are made."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar, get_args

from nmaptool.options.kinds import Choice, Kind


def option(default: Any, kind: Kind | None = None) -> Any:
    """A field with its default and what it takes; None as the default means that it may be left out."""
    return dataclasses.field(default=default, metadata={} if kind is None else {"kind": kind})


def choice_of(literal: Any, such_as: str = "") -> Choice:
    """The kind of a field whose type is a ``Literal``."""
    return Choice(such_as, tuple(str(name) for name in get_args(literal)))


def kind_of(field: dataclasses.Field[Any]) -> Kind | None:
    """What a field of options takes, where that is said."""
    kind: Kind | None = field.metadata.get("kind")
    return kind


@dataclasses.dataclass(frozen=True)
class Options:
    """Base of all options: checks every field by its kind, and names the group that the help shows them in.

    Docstrings list every field under ``Parameters``; the meaning of names that come from a table is added there.
    """

    group: ClassVar[str] = ""

    def __init_subclass__(cls, group: str = "", **more: Any) -> None:
        super().__init_subclass__(**more)
        cls.group = group or cls.group
        cls.__doc__ = _with_choices(cls.__doc__ or "", vars(cls))

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value, kind = getattr(self, field.name), kind_of(field)
            if kind is not None and value is not None:
                read = kind.read(field.name, value)
                if read is not value:
                    object.__setattr__(self, field.name, read)


def choices_text(kind: Kind | None) -> str:
    """The names of a choice with their meanings, as sentences for a help text; empty where they have none."""
    if not isinstance(kind, Choice) or not kind.descriptions:
        return ""
    return "; ".join(f'"{name}" {meaning}' for name, meaning in kind.descriptions.items()) + "."


def _with_choices(doc: str, members: Mapping[str, Any]) -> str:
    """A docstring with the meaning of each name under the field that takes it."""
    for name, member in members.items():
        kind = member.metadata.get("kind") if isinstance(member, dataclasses.Field) else None
        text = choices_text(kind)
        if text:
            head, mark, rest = doc.partition(f"\n    {name}:\n")
            first, newline, rest = rest.partition("\n")
            doc = f"{head}{mark}{first} {text}{newline}{rest}" if mark else doc
    return doc
