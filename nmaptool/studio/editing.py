"""Requests that change options and layers, and steps back and forward."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nmaptool.core.errors import NmaptoolError, UsageError
from nmaptool.studio import layers
from nmaptool.studio.background import error_message
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message


def set_values(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Set options: ``values`` by name, ``moving`` while a slider moves."""
    values = message.get("values")
    if not isinstance(values, Mapping):
        raise UsageError("the page sent no values; reload it")
    try:
        document = room.now.changed(values)
    except NmaptoolError as error:
        return {**error_message(error, room.store), "names": sorted(values)}  # shown beside their controls
    room.do(document, joining=("set", *sorted(values)))
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


def set_layer(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Set ``values`` of the layer at ``place``, ``moving`` while a control or a handle moves."""
    values = message.get("values")
    if not isinstance(values, Mapping):
        raise UsageError("the page sent no values; reload it")
    if "file" in values or values.get("mask") is not None:
        raise UsageError("the page may name dropped files alone; reload it")
    place = layers.place_of(message.get("place"))
    room.do(layers.edited(room.now, place, values), joining=("layer", place, *sorted(values)))
    if not message.get("moving"):
        room.rest()
    return None


def move_layer(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Move the layer at ``place`` below the one at ``to``."""
    place, to = layers.place_of(message.get("place")), layers.place_of(message.get("to"))
    room.do(layers.moved(room.now, place, to))
    return None


def remove_layer(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Remove the layer at ``place``."""
    room.do(layers.removed(room.now, layers.place_of(message.get("place"))))
    return None


def double_layer(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Copy the layer at ``place``."""
    room.do(layers.doubled(room.now, layers.place_of(message.get("place"))))
    return None
