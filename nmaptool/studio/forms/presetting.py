"""Requests about presets."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from nmaptool.core.errors import UsageError
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message


def apply_preset(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Set the options of the preset ``name``, of the user's own if ``is_own``: one step to undo."""
    name, is_own = _name(message), message.get("is_own") is True
    changed = room.now.changed(room.presets.values(name, is_own=is_own))
    room.do(dataclasses.replace(changed, plate=room.presets.plate(name, room.now.plate, is_own=is_own)))
    return None


def save_preset(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Keep the options under ``name``; ``overwrite`` replaces a preset of the user's."""
    room.presets.save(_name(message), room.now, overwrite=message.get("overwrite") is True)
    room.windows.tell(room.presets.message())
    return None


def delete_preset(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Delete the user's preset ``name``."""
    room.presets.delete(_name(message))
    room.windows.tell(room.presets.message())
    return None


def _name(message: Mapping[str, Any]) -> str:
    name = message.get("name")
    if not isinstance(name, str):
        raise UsageError("the page named no preset; reload it")
    return name
