"""``nmap compose``: edits of normal maps, one file per command, imported when it is called."""

from __future__ import annotations

from cyclopts import App

HELP = "Edit normal maps as vectors: blend, paste, transform, convert and compose them."

app = App(name="compose", help=HELP)
for _name, _help in (
    ("split", "Split a normal map into base and detail, without a mesh."),
    ("blend", "Blend a detail map with a base map."),
    ("paste", "Paste layers onto a background."),
    ("depth", "Turn a depth or height picture into a normal map."),
    ("stack", "Compose the layers of a recipe."),
    ("transform", "Crop, mirror, resize, rotate or pad a map."),
    ("convert", "Convert a map to another format or convention."),
    ("pack", "Pack maps as layers of one file for an image editor: PSD, ORA, TIFF, EXR."),
    ("unpack", "Unpack a layered file after editing, repair it and report the changes."),
):
    app.command(f"nmaptool_cli.compose.{_name}:{_name}", name=_name, help=_help)
