"""Workspaces as files, by ending and first bytes: PSD, PSB, ORA, TIFF, EXR."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError, OutputError, UsageError, reason_of
from nmaptool.io.opening import read_head
from nmaptool.io.replace import written_beside
from nmaptool.types.workspace import Workspace, WorkspaceMask

WRITE_ENDINGS = (".psd", ".psb", ".ora", ".tif", ".tiff", ".exr")
_KINDS = {
    b"8BPS\0\1": ("PSD", (".psd",)),
    b"8BPS\0\2": ("PSB", (".psb", ".psd")),
    b"PK\3\4": ("ORA", (".ora",)),
    b"II*\0": ("TIFF", (".tif", ".tiff")),
    b"MM\0*": ("TIFF", (".tif", ".tiff")),
    b"II+\0": ("TIFF", (".tif", ".tiff")),
    b"MM\0+": ("TIFF", (".tif", ".tiff")),
    b"\x76\x2f\x31\x01": ("EXR", (".exr",)),
}
_NO_LIMIT = 1e7  # megapixels
_ACCEPTED = "PSD, PSB, ORA, TIFF or EXR"
_BITS = {".psd": (8, 16), ".psb": (8, 16), ".ora": (8, 16), ".tif": (8, 16), ".tiff": (8, 16), ".exr": (32,)}


def _kind(path: Path) -> str:
    head, _ = read_head(path, 8, "a workspace file", "give a file")
    for magic, (kind, endings) in _KINDS.items():
        if head.startswith(magic):
            if path.suffix and path.suffix.lower() not in endings:
                right = path.with_suffix(endings[0]).name
                raise InputError(f"{path}: holds {kind} data but is not named so; rename it to {right}")
            return kind
    if head.startswith(b"gimp xcf"):
        raise InputError(f"{path}: is GIMP's own format, which is not read here; export it as PSD")
    raise InputError(f"{path}: is no workspace that can be read here; accepted are {_ACCEPTED}")


def read_workspace(path: str | Path, *, max_megapixels: float = 270.0) -> Workspace:
    """Read the layers of a file that an image editor wrote, or `write_workspace`.

    Parameters
    ----------
    path : str or Path
        PSD, PSB, ORA, multi-page TIFF or multi-part EXR, recognised by its bytes.
    max_megapixels : float
        Limit for the canvas, and for all layers together; checked before memory is allocated.

    Returns
    -------
    Workspace

    Raises
    ------
    InputError
        If it cannot be read, or holds no layer of pixels.
    LimitError
        If it is larger than ``max_megapixels``.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> nm.write_workspace("flat.psd", nm.pack([flat]))
    >>> nm.read_workspace("flat.psd")
    <Workspace flat.psd: 48 x 32 px, pitch unknown, 16 bits, 1 layer>
    """
    path = Path(path)
    kind = _kind(path)
    try:
        if kind in ("PSD", "PSB"):
            from nmaptool.io.workspaces.psd_reader import read_psd

            return read_psd(path, max_megapixels)
        if kind == "ORA":
            from nmaptool.io.workspaces.ora_reader import read_ora

            return read_ora(path, max_megapixels)
        if kind == "TIFF":
            from nmaptool.io.workspaces.layered_tiff import read_layered_tiff

            return read_layered_tiff(path, max_megapixels)
        from nmaptool.io.workspaces.layered_exr import read_layered_exr

        return read_layered_exr(path, max_megapixels)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason_of(error)})") from None
    except MemoryError:
        raise LimitError(f"{path}: does not fit in memory; make it smaller") from None


def check_workspace_target(path: Path, bits: int | None, half: bool) -> int:
    """Refuse what a format cannot hold; the bits that a file of this ending gets.

    Raises
    ------
    UsageError
        If the ending, or the bits for it, are not offered.
    """
    ending = path.suffix.lower()
    if ending not in _BITS:
        found = f"ends in {path.suffix}" if path.suffix else "has no ending"
        raise UsageError(f"{path}: {found}; a workspace is written as {', '.join(WRITE_ENDINGS)}")
    if half and ending != ".exr":
        raise UsageError(f"{path}: --half is for EXR; {ending} holds codes of 8 or 16 bits")
    if bits is None:
        return max(_BITS[ending])
    if bits not in _BITS[ending]:
        held = "floats; leave --bits out" if ending == ".exr" else "8 or 16 bits"
        raise UsageError(f"{path}: --bits {bits} is not offered; {ending} holds {held}")
    return bits


def write_workspace(path: str | Path, workspace: Workspace, *, overwrite: bool = False) -> None:
    """Write a workspace and read it back before it gets its name.

    Parameters
    ----------
    path : str or Path
        ``.psd``, ``.psb``, ``.ora``, ``.tif`` (8 or 16 bits) or ``.exr`` (floats).
    workspace : Workspace
    overwrite : bool
        Replace a file that exists.

    Raises
    ------
    UsageError
        If the ending is not offered, or does not hold the workspace's bits.
    OutputError
        If it cannot be written, or exists.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> nm.write_workspace("flat.ora", nm.pack([flat]))
    """
    target = Path(path)
    check_workspace_target(target, workspace.bits, workspace.half)
    with written_beside([target], overwrite) as (beside,):
        try:
            _write(beside, workspace)
            back = read_workspace(beside, max_megapixels=_NO_LIMIT)
        except (OutputError, InputError, LimitError) as error:
            reason = str(error).replace(str(beside), str(target))
            raise OutputError(reason if isinstance(error, OutputError) else _full(target)) from None
        except OSError as error:
            raise OutputError(f"{target}: cannot be written ({reason_of(error)})") from None
        except (struct.error, OverflowError):
            raise OutputError(f"{target}: is too large for the format; write an .exr, or fewer layers") from None
        if not _same(workspace, back):
            raise OutputError(_full(target))


def _full(target: Path) -> str:
    return f"{target}: cannot be written (is the disk full?)"


def _write(path: Path, workspace: Workspace) -> None:
    ending = path.suffix.lower()
    if ending in (".psd", ".psb"):
        from nmaptool.io.workspaces.psd_writer import version_of, write_psd

        if ending == ".psd" and version_of(workspace) == 2:
            raise OutputError(f"{path}: is too large for PSD; write a .psb")
        write_psd(path, workspace, 2 if ending == ".psb" else 1)
    elif ending == ".ora":
        from nmaptool.io.workspaces.ora_writer import write_ora

        write_ora(path, workspace)
    elif ending == ".exr":
        from nmaptool.io.workspaces.layered_exr import write_layered_exr

        write_layered_exr(path, workspace)
    else:
        from nmaptool.io.workspaces.layered_tiff import write_layered_tiff

        write_layered_tiff(path, workspace)


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
