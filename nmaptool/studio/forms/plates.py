"""What the page says about the plate of a document, which the stage does not show."""

from __future__ import annotations

from nmaptool.core.text import listed
from nmaptool.studio.document import Document
from nmaptool.types.shown import counted


def plate_line(document: Document) -> str | None:
    """One line about the plate that exported files will have; None without one.

    >>> plate_line(Document()) is None
    True
    """
    plate = document.plate
    if plate is None or plate.plate.get("shape") is None:
        return None
    parts = ["a frame"] if plate.frame.get("frame") is not None else []
    parts += [counted(len(plate.texts), "text")] if plate.texts else []
    parts += ["a loop"] if plate.plate.get("loop") is not None else []
    parts += ["holes"] if plate.plate.get("hole") is not None else []
    more = " with " + listed(parts, "and") if parts else ""
    return (
        f"Exported files have a plate ({plate.plate['shape']}){more}. The stage shows the motif without it; % refer to "
        "the plate in exported files. Edit the plate in the recipe."
    )
