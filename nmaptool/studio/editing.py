"""Requests that change options, and steps back and forward."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nmaptool.core.errors import UsageError
from nmaptool.studio.room import Message, Room


def set_values(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Set options: ``values`` by name, ``moving`` while a slider moves."""
    values = message.get("values")
    if not isinstance(values, Mapping):
        raise UsageError("the page sent no values; reload it")
    room.do(room.now.changed(values), joining=("set", *sorted(values)))
    if not message.get("moving"):
        room.rest()  # the last event of a drag still belongs to it
    return None


def undo(room: Room, _: Mapping[str, Any]) -> Message | None:
    """Go one step back."""
    room.step(room.history.undo())
    return None


def redo(room: Room, _: Mapping[str, Any]) -> Message | None:
    """Take a step again."""
    room.step(room.history.redo())
    return None
