"""A solid or a surface to a file, by ending."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from nmaptool.core.errors import OutputError, reason_of
from nmaptool.core.progress import Progress
from nmaptool.io.solids.check import check_written
from nmaptool.io.solids.glb import write_glb
from nmaptool.io.solids.obj import write_obj
from nmaptool.io.solids.ply import write_ply
from nmaptool.io.solids.stl import write_stl
from nmaptool.io.solids.threemf import write_3mf
from nmaptool.options.formats import MESH_FORMATS, check_ending
from nmaptool.types.solid import Body, Part, Solid

# how often a writer asks for the parts of a body, where it is not three times
_PASSES = {".stl": 1}
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
    progress: Progress | None = None,
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
    progress : callable, optional
        Called with "writing" or "checking" and the share done, 0 to 1.

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
    watched = solid if progress is None else _watched(solid, progress, _PASSES.get(ending, 3))
    try:
        if entry.write is not None:
            entry.write(solid.to_mesh(), path)
            return
        if ending == ".3mf":
            write_3mf(watched, path, _facts(title), b"" if thumbnail_png is None else thumbnail_png())
        else:
            _WRITERS[ending](watched, path)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None
    if is_checked:
        check_written(solid, path, progress)


def _watched(solid: Solid, progress: Progress, passes: int) -> Solid:
    """The same solid, which reports how many of its triangles were made."""
    total, done = max(1, passes * solid.face_count), 0

    def watched(body: Body) -> Body:
        def parts() -> Iterator[Part]:
            nonlocal done
            for part in body.parts():
                yield part
                done += len(part.faces)
                progress("writing", min(1.0, done / total))

        return dataclasses.replace(body, parts=parts)

    return dataclasses.replace(solid, bodies=tuple(watched(body) for body in solid.bodies))


def _facts(title: str) -> Mapping[str, str]:
    return {"Title": title, "Application": "nmaptool"}
