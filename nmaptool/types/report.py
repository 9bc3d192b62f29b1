"""The base class of reports."""

from __future__ import annotations

import dataclasses
from typing import Any

from nmaptool.options.fields import Options
from nmaptool.options.plain_values import plain_values
from nmaptool.types.shown import OneLine


class Report(OneLine):
    """A report: one line of text for people, plain values for JSON."""

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; lengths in options are text such as ``3mm``."""
        out = dataclasses.asdict(self)  # type: ignore[call-overload]  # mixed into dataclasses only
        options = getattr(self, "options", None)
        return out | {"options": plain_values(options)} if isinstance(options, Options) else out  # type: ignore[no-any-return]
