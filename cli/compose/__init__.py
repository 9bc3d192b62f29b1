"""``nmap compose``: edits of normal maps, one file a command; they load when they are called."""

from __future__ import annotations

from cyclopts import App

HELP = "Edit normal maps as vectors: blend, paste, turn, convert, compose them."

app = App(name="compose", help=HELP)
for _name, _help in (
    ("split", "Split a map that has no mesh into base and detail."),
    ("blend", "Blend a detail map with a base map."),
    ("paste", "Paste layers on a background."),
    ("depth", "Turn a depth or height picture into a normal map."),
    ("stack", "Compose the layers of a recipe."),
    ("transform", "Crop, mirror, resize, turn or pad a map."),
    ("convert", "Write a map as another kind of file."),
    ("pack", "Lay maps over each other in one file for an image editor: PSD, ORA, TIFF, EXR."),
    ("unpack", "Take a layered file apart after an editor's hand: repaired, and with what was done to it."),
):
    app.command(f"nmaptool_cli.compose.{_name}:{_name}", name=_name, help=_help)
