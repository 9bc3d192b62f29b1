"""Parts of a plate with an exact outline: its solid, cut along planes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, UsageError
from nmaptool.options.parts import PartOrigin
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.cutting.clip import split
from nmaptool.types.parts import PlannedPart
from nmaptool.types.picture import Frame
from nmaptool.types.solid import Body, Faces, Nodes, Part, Solid


def check_clipped(options: SolidOptions) -> None:
    """Refuse a back that parts cannot share."""
    if options.hollow is not None:
        raise UsageError(
            f"`hollow='{options.hollow}'`: parts of a plate with an exact outline would be open where they are "
            "cut; use `shell` instead of `base` and `hollow`"
        )


def several_pieces(part: PlannedPart, count: int) -> InputError:
    """The error for a part that falls apart where one piece is demanded."""
    return InputError(
        f"`one_piece`: part {part.row}, {part.col} has {count} separate pieces; use other parts, connect them in the "
        "mask, or leave out `one_piece`"
    )


def clipped_parts(
    solid: Solid, frame: Frame, plan: Sequence[PlannedPart], snap_mm: float, *, origin: PartOrigin, one_piece: bool
) -> Iterator[tuple[PlannedPart, Solid | None]]:
    """Cut a solid or surface along the lines between parts; None for parts without a triangle.

    Parameters
    ----------
    solid : Solid
        In the frame of the whole.
    frame : Frame
        Of the whole, in the pixels of the plan.
    plan : sequence of PlannedPart
    snap_mm : float
        As for `split`.
    origin : str
        Where the coordinates of a part begin.
    one_piece : bool
        Whether to refuse parts that fall apart.
    """
    assert frame.pitch_mm is not None
    mesh, pitch_mm = solid.to_mesh(), frame.pitch_mm
    cut = partial(split, snap_mm=snap_mm, is_closed=solid.is_closed)
    vertices, faces = mesh.vertices.astype(np.float64), mesh.faces.astype(np.int64)
    columns = []
    for left in sorted({part.left for part in plan})[1:]:
        vertices, own, faces = cut(vertices, faces, 0, left * pitch_mm)
        columns.append(_compact(vertices, own))
    columns.append(_compact(vertices, faces))
    tops = sorted({part.top for part in plan})
    found = {}
    for col, column in enumerate(columns):
        vertices, faces = column
        for row in range(len(tops) - 1, 0, -1):
            at_mm = (frame.rows - tops[row]) * pitch_mm
            vertices, own, faces = cut(vertices, faces, 1, at_mm)
            found[row, col] = _compact(vertices, own)
        found[0, col] = _compact(vertices, faces)
    for part in plan:
        vertices, faces = found[part.row, part.col]
        if origin == "own":
            vertices = vertices - [part.left * pitch_mm, (frame.rows - part.bottom) * pitch_mm, 0]
        made = _part(vertices, faces, solid)
        if made is not None and one_piece and len(made.bodies) > 1:
            raise several_pieces(part, len(made.bodies))
        yield part, made


def _compact(vertices: Float64, faces: Nodes) -> tuple[Float64, Nodes]:
    """The vertices that some triangles use, in their order."""
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    numbers = np.cumsum(used) - 1
    return vertices[used], numbers[faces]


def _part(vertices: Float64, faces: Nodes, solid: Solid) -> Solid | None:
    """The solid of a part from its triangles."""
    if not len(faces):
        return None
    pieces = _pieces(faces, len(vertices)) if solid.is_closed else [faces]
    name = "relief" if len(pieces) == 1 else "relief {}"
    bodies = tuple(_body(name.format(number), vertices, own) for number, own in enumerate(pieces, start=1))
    bounds = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
    volume = _volume(vertices, faces) if solid.is_closed else float("nan")
    return Solid(bodies, solid.is_closed, bounds, volume, {**solid.facts, "pieces": len(pieces)})


def _pieces(faces: Nodes, count: int) -> list[Nodes]:
    """Triangles that hang together."""
    from scipy.sparse import coo_array  # takes long to load
    from scipy.sparse.csgraph import connected_components

    ends = np.roll(faces, -1, axis=1)
    links = coo_array((np.ones(faces.size, bool), (faces.ravel(), ends.ravel())), shape=(count, count))
    pieces, labels = connected_components(links, directed=False)
    of_face = labels[faces[:, 0]]
    return [faces[of_face == number] for number in range(pieces)] if pieces > 1 else [faces]


def _body(name: str, vertices: Float64, faces: Nodes) -> Body:
    own, numbered = _compact(vertices, faces)
    made: Faces = numbered.astype(np.int32)
    part = Part(own, made, np.arange(len(own)))
    return Body(name, lambda: iter((part,)), len(made), len(own))


def _volume(vertices: Float64, faces: Nodes) -> float:
    """Inside closed triangles, from their middle."""
    a, b, c = (vertices[faces[:, corner]] - vertices.mean(axis=0) for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
