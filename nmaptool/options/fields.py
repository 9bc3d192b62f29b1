"""Fields of the options dataclasses: each has a default and a kind, and is checked when the options are created."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Mapping
from typing import Any, ClassVar, get_args

from nmaptool.options.kinds import Choice, Kind

# a field and its description
_ENTRY = re.compile(r"^(\w+):\n((?:    .*\n?)+)", re.MULTILINE)


def option(default: Any, kind: Kind | None = None, short: str = "") -> Any:
    """Declare a field with its default, its kind and a short flag; a default of None makes it optional."""
    metadata = {"kind": kind, "short": short}
    return dataclasses.field(default=default, metadata={key: value for key, value in metadata.items() if value})


def choice_of(literal: Any, such_as: str = "") -> Choice:
    """The kind of a field whose type is a ``Literal``."""
    return Choice(such_as, tuple(str(name) for name in get_args(literal)))


def kind_of(field: dataclasses.Field[Any]) -> Kind | None:
    """The kind of an options field; None if it has none."""
    kind: Kind | None = field.metadata.get("kind")
    return kind


@dataclasses.dataclass(frozen=True)
class Options:
    """Base of all options: checks every field by its kind, and sets the group of the fields in --help.

    Docstrings describe every field under ``Parameters``. If a field's choices come from a table, their meanings are
    appended.
    """

    group: ClassVar[str] = ""
    written_doc: ClassVar[str] = ""

    def __init_subclass__(cls, group: str = "", **more: Any) -> None:
        super().__init_subclass__(**more)
        cls.group = group or cls.group
        cls.written_doc = inspect.cleandoc(cls.__doc__ or "")  # Python 3.13 strips the indent itself
        cls.__doc__ = _with_choices(cls.written_doc, vars(cls))

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value, kind = getattr(self, field.name), kind_of(field)
            if kind is not None and (value is not None or field.default is not None):
                read = kind.read(field.name, value)
                if read is not value:
                    object.__setattr__(self, field.name, read)


def read_values(options: type[Options], given: Mapping[str, Any]) -> dict[str, Any]:
    """Values of some fields, each checked by its kind; whether they agree with each other is not checked.

    Raises
    ------
    UsageError
        If a value is not accepted.
    """
    kinds = {field.name: kind_of(field) for field in dataclasses.fields(options)}
    return {name: value if (kind := kinds[name]) is None else kind.read(name, value) for name, value in given.items()}


def descriptions(options: type[Options]) -> dict[str, str]:
    """The description of each field of an options class, one line each, with the current names of its choices."""
    written: dict[str, str] = {}
    for owner in options.__mro__:
        for name, text in _ENTRY.findall(getattr(owner, "written_doc", "")):
            written.setdefault(name, " ".join(text.split()))
    kinds = {field.name: kind_of(field) for field in dataclasses.fields(options)}
    meanings = {name: kind.meanings() for name, kind in kinds.items() if kind is not None}
    return {name: f"{text} {meanings.get(name, '')}".strip() for name, text in written.items()}


def _with_choices(doc: str, members: Mapping[str, Any]) -> str:
    """A docstring with the meaning of each choice added below its field."""

    def filled(entry: re.Match[str]) -> str:
        member = members.get(entry[1])
        kind = member.metadata.get("kind") if isinstance(member, dataclasses.Field) else None
        text = "" if kind is None else kind.meanings()
        return f"{entry[0].rstrip()}\n    {text}\n" if text else entry[0]

    return _ENTRY.sub(filled, doc)
