"""What a page may ask of the studio."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from nmaptool.core.errors import NmaptoolError
from nmaptool.studio import editing
from nmaptool.studio.background import error_message
from nmaptool.studio.files import adding, exporting, saving
from nmaptool.studio.forms import presetting
from nmaptool.studio.meshes import bakes, splits
from nmaptool.studio.painting import painting
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message, Window

Request: TypeAlias = Callable[[Room, Mapping[str, Any]], Message | None]
WindowRequest: TypeAlias = Callable[[Room, Mapping[str, Any], Window], Message | None]

# by the entry "do" of the message; an answer goes to the page that asked alone
REQUESTS: dict[str, Request] = {
    "set": editing.set_values,
    "undo": editing.undo,
    "redo": editing.redo,
    "set-layer": editing.set_layer,
    "move-layer": editing.move_layer,
    "remove-layer": editing.remove_layer,
    "double-layer": editing.double_layer,
    "add-layer": adding.add_layer,
    "add-depth": adding.add_depth,
    "set-depth": adding.set_depth,
    "set-file": adding.set_file,
    "set-layer-mask": adding.set_layer_mask,
    "use-as-detail": adding.use_as_detail,
    "open-recipe": adding.open_recipe,
    "paint": painting.paint,
    "apply-preset": presetting.apply_preset,
    "save-preset": presetting.save_preset,
    "delete-preset": presetting.delete_preset,
    "open-mesh": bakes.open_mesh,
    "close-mesh": bakes.close_mesh,
    "bake": bakes.bake,
    "cancel-bake": bakes.cancel_bake,
    "split-detail": splits.split_detail,
    "follow-details": splits.follow_details,
    "save": saving.save,
    "recipes": saving.list_recipes,
    "open": saving.open_file,
    "recover": saving.recover,
    "discard": saving.discard,
}
# those that need to know which window asks
WINDOW_REQUESTS: dict[str, WindowRequest] = {
    "estimate": exporting.ask_estimate,
    "export": exporting.begin_export,
    "cancel-export": exporting.cancel_export,
}


def answer(room: Room, message: Mapping[str, Any], window: Window) -> Message | None:
    """Do what a page asks; return an answer for that page alone."""
    wanted = message.get("do")
    if not isinstance(wanted, str) or wanted not in {**REQUESTS, **WINDOW_REQUESTS}:
        return {
            "kind": "error",
            "text": f"the page asked for {wanted!r}, which this version does not know; reload it",
        }
    try:
        if wanted in WINDOW_REQUESTS:
            return WINDOW_REQUESTS[wanted](room, message, window)
        return REQUESTS[wanted](room, message)
    except NmaptoolError as error:
        return error_message(error, room.store)
