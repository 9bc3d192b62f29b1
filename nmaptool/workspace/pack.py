"""Pack normal maps into a workspace: one layer each, with a signature that later shows what an editor changed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.maps import codec
from nmaptool.options import PackOptions
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.packed_map import PackedMap
from nmaptool.types.picture import Frame
from nmaptool.types.workspace import (
    MASK_SUFFIX,
    PASS_THROUGH,
    Workspace,
    WorkspaceGroup,
    WorkspaceLayer,
    WorkspaceMask,
    unique_names,
)
from nmaptool.workspace.signature import sign


def pack(
    maps: Sequence[PackedMap | NormalsLike],
    options: PackOptions | None = None,
    *,
    frame: Frame | None = None,
    ground: str = "clear",
) -> Workspace:
    """Pack normal maps as the layers of one file for an image editor.

    Each layer gets a signature, so that `unpack` can detect what the editor changed, and repair it.

    Parameters
    ----------
    maps : sequence of NormalMap, PackedMap or (h, w, 3) float
        Bottom to top.
    options : PackOptions, optional
        Bits per channel; None means 16.
    frame : Frame, optional
        The canvas. Default: the size of the largest map.
    ground : str
        What is below the lowest layer when they are composed again: ``clear`` or ``flat``.

    Returns
    -------
    Workspace
        Layers of codes for `nmaptool.write_workspace`.

    Raises
    ------
    UsageError
        If there is no map, or a value is neither a map nor an array.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> nm.pack([flat, nm.PackedMap(nm.NormalMap.from_array(flat[:8, :8]), "patch", left=4)])
    <Workspace workspace: 48 x 32 px, pitch unknown, 16 bits, 2 layers>
    """
    options = options or PackOptions()
    placed = [one if isinstance(one, PackedMap) else PackedMap(as_normal_map(one, "the layer")) for one in maps]
    if not placed:
        raise UsageError("a workspace needs at least one map")
    bits = 32 if options.half else options.bits or 16
    frame = frame or common_frame([one.normal_map for one in placed])
    names = unique_names([_plain(one.name or _stem(one.normal_map.name)) for one in placed])
    groups = _groups(placed)
    layers = tuple(_layer(*one, bits) for one in zip(placed, names, groups, strict=True))
    metadata: dict[str, Any] = {
        "nmaptool": __version__,
        "canvas": [frame.cols, frame.rows],
        "pitch_mm": frame.pitch_mm,
        "bits": bits,
        "ground": ground,
        "layers": [dict(layer.facts) for layer in layers],
    }
    return Workspace(frame, layers, bits, options.half, metadata=metadata)


def common_frame(maps: Sequence[NormalMap]) -> Frame:
    """A canvas with the size of the largest map and the first known pitch."""
    frames = [one.frame for one in maps]
    pitch = next((f.pitch_mm for f in frames if f.pitch_mm is not None), None)
    return Frame(max(f.rows for f in frames), max(f.cols for f in frames), pitch)


def _stem(name: str) -> str:
    """Layer name of a map: detail for ``maps/work.exr:detail``, shell for ``shell.png``."""
    path, mark, layer = name.rpartition(":")
    return layer if mark and layer and Path(path).suffix else Path(name).stem


def _plain(name: str) -> str:
    """A layer name that cannot be mistaken for that of a mask."""
    return name.replace(MASK_SUFFIX, " mask")


def _groups(placed: Sequence[PackedMap]) -> list[tuple[WorkspaceGroup, ...]]:
    """The groups of each map; neighbours with the same names share them."""
    out: list[tuple[WorkspaceGroup, ...]] = []
    before: tuple[WorkspaceGroup, ...] = ()
    for one in placed:
        shared = 0
        while shared < min(len(before), len(one.group)) and before[shared].name == one.group[shared]:
            shared += 1
        before = (*before[:shared], *(WorkspaceGroup(name, blend_mode=PASS_THROUGH) for name in one.group[shared:]))
        out.append(before)
    return out


def _layer(placed: PackedMap, name: str, groups: tuple[WorkspaceGroup, ...], bits: int) -> WorkspaceLayer:
    source = placed.normal_map
    pixels = codec.encode_map(source.normals, source.coverage, bits)
    rows, cols = source.frame.shape
    seal = sign(codec.stored_shares(pixels, bits == 32), source.coverage, source.normals, placed.left, placed.top)
    facts = {
        "name": name,
        "source": Path(source.name).name,
        "left": placed.left,
        "top": placed.top,
        "cols": cols,
        "rows": rows,
        "mode": placed.mode,
        "strength": placed.strength,
        "group": list(placed.group),
        "visible": placed.visible,
        **seal.to_dict(),
    }
    mask = None
    if placed.mask is not None:
        mask = WorkspaceMask(codec.encode_grey(placed.mask, bits), placed.left, placed.top)
    return WorkspaceLayer(
        name,
        pixels,
        placed.left,
        placed.top,
        placed.visible,
        mask=mask,
        groups=groups,
        facts=facts,
        signed=bits == 32,
    )
