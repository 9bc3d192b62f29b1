"""Requests about exports; the answers and the progress go to the window that asks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nmaptool.core.errors import UsageError
from nmaptool.studio.files.export import Wanted
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message, Window


def ask_estimate(room: Room, message: Mapping[str, Any], window: Window) -> Message | None:
    """Tell what an export as ``format`` will be."""
    room.exports.estimate(window, room.worker.engine_of(room.now), room.now, _wanted(message))
    return None


def begin_export(room: Room, message: Mapping[str, Any], window: Window) -> Message | None:
    """Begin an export as ``format``."""
    name = room.now.name if room.now.path is None else room.now.path.name
    return room.exports.begin(window, room.now, _wanted(message), Path(name).stem)


def cancel_export(room: Room, _: Mapping[str, Any], window: Window) -> Message | None:
    """End the export of this window."""
    room.exports.cancel(window)
    return None


def _wanted(message: Mapping[str, Any]) -> Wanted:
    format_, at = message.get("format"), message.get("at", "centers")
    if not isinstance(format_, str) or at not in ("centers", "corners"):
        raise UsageError("the page asked for no format; reload it")
    return Wanted(format_, at)
