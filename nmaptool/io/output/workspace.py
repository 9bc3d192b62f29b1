"""Write a workspace to a file, which is read back before it gets its final name."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError, OutputError, UsageError
from nmaptool.io.output.targets import Destination, Place, place_of
from nmaptool.io.output.transaction import Outputs, Target
from nmaptool.io.workspaces.files import read_workspace
from nmaptool.options.formats import WORKSPACE_FORMATS, check_ending
from nmaptool.types.workspace import Workspace, WorkspaceMask

_NO_LIMIT = 1e7  # megapixels


def check_workspace_target(place: Place, bits: int | None, half: bool) -> int:
    """Refuse what a format cannot hold; return the bits of a file with this extension.

    Raises
    ------
    UsageError
        If the extension, or the bits for it, are not supported.
    """
    check_ending(place, WORKSPACE_FORMATS, "a workspace")
    ending = place.suffix.lower()
    offered = WORKSPACE_FORMATS[ending].bits
    if half and ending != ".exr":
        raise UsageError(f"{place}: `half` is for EXR; {ending} holds codes of 8 or 16 bits")
    if bits is None:
        return max(offered)
    if bits not in offered:
        held = "floats; leave `bits` out" if ending == ".exr" else "8 or 16 bits"
        raise UsageError(f"{place}: `bits={bits!r}` is not supported; {ending} holds {held}")
    return bits


def workspace_outputs(output: Destination, *, overwrite: bool = False) -> Outputs[Workspace]:
    """The plan of `write_workspace`."""
    return Outputs([Target(place_of(output), "a workspace", WORKSPACE_FORMATS, _write)], overwrite=overwrite)


def write_workspace(workspace: Workspace, path: Destination, *, overwrite: bool = False) -> None:
    """Write a workspace and read it back before it gets its final name.

    Parameters
    ----------
    workspace : Workspace
    path : str, Path or OutputStream
        ``.psd``, ``.psb``, ``.ora``, ``.tif`` (8 or 16 bits) or ``.exr`` (floats).
    overwrite : bool
        Replace a file that exists.

    Raises
    ------
    UsageError
        If the extension is not supported, or its format cannot hold the workspace's bits.
    OutputError
        If it cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> flat = np.full((32, 48, 3), (0.0, 0, 1))
    >>> nm.write_workspace(nm.pack([flat]), "flat.ora")
    """
    check_workspace_target(place_of(path), workspace.bits, workspace.half)
    workspace_outputs(path, overwrite=overwrite).write(workspace)


def _write(workspace: Workspace, path: Path) -> None:
    added = WORKSPACE_FORMATS[path.suffix.lower()].write
    if added is not None:
        added(workspace, path)
        return
    full = OutputError(f"{path}: cannot be written (is the disk full?)")
    try:
        _write_own(workspace, path)
        back = read_workspace(path, max_megapixels=_NO_LIMIT)
    except (InputError, LimitError):
        raise full from None
    except (struct.error, OverflowError):
        raise OutputError(f"{path}: is too large for the format; write an .exr, or fewer layers") from None
    if not _same(workspace, back):
        raise full


def _write_own(workspace: Workspace, path: Path) -> None:
    ending = path.suffix.lower()
    if ending in (".psd", ".psb"):
        from nmaptool.io.workspaces.psd_writer import version_of, write_psd

        if ending == ".psd" and version_of(workspace) == 2:
            raise OutputError(f"{path}: is too large for PSD; write a .psb")
        write_psd(workspace, path, 2 if ending == ".psb" else 1)
    elif ending == ".ora":
        from nmaptool.io.workspaces.ora_writer import write_ora

        write_ora(workspace, path)
    elif ending == ".exr":
        from nmaptool.io.workspaces.layered_exr import write_layered_exr

        write_layered_exr(workspace, path)
    else:
        from nmaptool.io.workspaces.layered_tiff import write_layered_tiff

        write_layered_tiff(workspace, path)


def _same(workspace: Workspace, back: Workspace) -> bool:
    if len(workspace.layers) != len(back.layers) or workspace.frame.shape != back.frame.shape:
        return False
    for sent, came in zip(workspace.layers, back.layers, strict=True):
        if (sent.name, sent.left, sent.top, sent.visible) != (came.name, came.left, came.top, came.visible):
            return False
        if not _equal(sent.pixels, came.pixels, workspace.half) or not _same_mask(sent.mask, came.mask, workspace.half):
            return False
    return True


def _same_mask(sent: WorkspaceMask | None, came: WorkspaceMask | None, half: bool) -> bool:
    if sent is None or came is None:
        return sent is came
    return (sent.left, sent.top) == (came.left, came.top) and _equal(sent.values, came.values, half)


def _equal(sent: NDArray[Any], came: NDArray[Any], half: bool) -> bool:
    expected = sent.astype(np.float16).astype(np.float32) if half else sent
    return expected.dtype == came.dtype and bool(np.array_equal(expected, came))
