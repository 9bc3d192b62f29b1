"""The relief of a document as a file: the same steps as `nmap relief scene.toml`, so the same bytes."""

from __future__ import annotations

from pathlib import Path

from nmaptool.core.progress import Progress
from nmaptool.io.output.relief import write_relief
from nmaptool.io.recipes.scenes import read_scene
from nmaptool.options.formats import MESH_FORMATS
from nmaptool.reliefs.relief import relief
from nmaptool.solids.solid import solid
from nmaptool.studio.document import Document


def export(document: Document, path: Path, progress: Progress | None = None) -> None:
    """Solve the document in full and write its relief.

    Raises
    ------
    NmaptoolError
        If a file cannot be read, the relief cannot be solved, or the file cannot be written.
    """
    scene = read_scene(document.recipe)
    result = relief(**scene.inputs, progress=progress)
    body = solid(result, scene.solid) if path.suffix.lower() in MESH_FORMATS else None
    write_relief(result, path, solid=body)
