"""A solid or a surface to a file, by ending."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from nmaptool.core.errors import OutputError, reason_of
from nmaptool.io.solids.check import check_written
from nmaptool.io.solids.glb import write_glb
from nmaptool.io.solids.obj import write_obj
from nmaptool.io.solids.ply import write_ply
from nmaptool.io.solids.stl import write_stl
from nmaptool.io.solids.threemf import write_3mf
from nmaptool.options.formats import MESH_FORMATS, check_ending
from nmaptool.types.solid import Solid

_WRITERS: dict[str, Callable[[Solid, Path], None]] = {
    ".stl": write_stl,
    ".ply": write_ply,
    ".obj": write_obj,
    ".glb": write_glb,
}


def write_solid(
    solid: Solid,
    path: Path,
    *,
    title: str = "relief",
    thumbnail_png: Callable[[], bytes] | None = None,
    is_checked: bool = True,
) -> None:
    """Write triangles part by part, and read the file back to check it.

    Parameters
    ----------
    solid : Solid
    path : Path
        By ending: .stl .ply .obj .3mf in mm, .glb in metres.
    title : str
        Title of a 3MF file.
    thumbnail_png : callable, optional
        Makes the picture of a 3MF file.
    is_checked : bool
        Whether to read the file back.

    Raises
    ------
    UsageError
        If the ending is not offered.
    LimitError
        If the format cannot hold so much.
    OutputError
        If it cannot be written, or fails the check.
    """
    check_ending(path, MESH_FORMATS, "meshes")
    ending = path.suffix.lower()
    entry = MESH_FORMATS[ending]
    try:
        if entry.write is not None:
            entry.write(solid.to_mesh(), path)
            return
        if ending == ".3mf":
            write_3mf(solid, path, _facts(title), b"" if thumbnail_png is None else thumbnail_png())
        else:
            _WRITERS[ending](solid, path)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None
    if is_checked:
        check_written(solid, path)


def _facts(title: str) -> Mapping[str, str]:
    return {"Title": title, "Application": "nmaptool"}
