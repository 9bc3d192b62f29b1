"""Options as plain values for reports and file metadata."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from nmaptool.options.filter import FilterOptions


def plain_values(options: Any) -> dict[str, Any]:
    """The fields of an options dataclass as values for JSON; lengths become text such as ``3mm``."""
    values = {f.name: getattr(options, f.name) for f in dataclasses.fields(options)}
    return {name: _plain(value) for name, value in values.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _plain(each) for name, each in value.items()}
    if type(value) is tuple:
        return tuple(_plain(each) for each in value)
    return str(value) if dataclasses.is_dataclass(value) else value


def filter_values(options: FilterOptions) -> dict[str, Any]:
    """`plain_values` of a filter; a learned filter has no parameters."""
    return {"filter": options.filter} if options.filter == "learned" else plain_values(options)
