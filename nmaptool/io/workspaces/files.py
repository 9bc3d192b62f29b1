"""Read workspaces, identified by extension and first bytes: PSD, PSB, ORA, TIFF, EXR."""

from __future__ import annotations

from pathlib import Path

from nmaptool.core.errors import InputError, LimitError, reason_of
from nmaptool.io.opening import read_head
from nmaptool.types.workspace import Workspace

_ORA = b"image/openraster"
_KINDS = {
    _ORA: ("ORA", (".ora",)),
    b"8BPS\0\1": ("PSD", (".psd",)),
    b"8BPS\0\2": ("PSB", (".psb", ".psd")),
    b"II*\0": ("TIFF", (".tif", ".tiff")),
    b"MM\0*": ("TIFF", (".tif", ".tiff")),
    b"II+\0": ("TIFF", (".tif", ".tiff")),
    b"MM\0+": ("TIFF", (".tif", ".tiff")),
    b"\x76\x2f\x31\x01": ("EXR", (".exr",)),
}
_ACCEPTED = "PSD, PSB, ORA, TIFF or EXR"


def _kind(path: Path) -> str:
    head, _ = read_head(path, 64, "a workspace file", "give a file")
    if head.startswith(b"PK\3\4") and (path.suffix.lower() == ".ora" or head[38:].startswith(_ORA)):
        head = _ORA
    for magic, (kind, endings) in _KINDS.items():
        if head.startswith(magic):
            if path.suffix and path.suffix.lower() not in endings:
                right = path.with_suffix(endings[0]).name
                raise InputError(f"{path}: holds {kind} data; rename it to {right}")
            return kind
    if head.startswith(b"gimp xcf"):
        raise InputError(f"{path}: is in GIMP's own format, which is not supported; export it as PSD")
    raise InputError(f"{path}: is not a workspace in a supported format; export it as {_ACCEPTED}")


def read_workspace(path: str | Path, *, max_megapixels: float = 270.0) -> Workspace:
    """Read the layers of a file written by an image editor or by `write_workspace`.

    Parameters
    ----------
    path : str or Path
        PSD, PSB, ORA, multi-page TIFF or multi-part EXR, recognised by its bytes.
    max_megapixels : float
        Limit for the canvas, and for all layers together; larger files are refused before memory is allocated.

    Returns
    -------
    Workspace

    Raises
    ------
    InputError
        If it cannot be read, or has no pixel layer.
    LimitError
        If it is larger than ``max_megapixels``.

    Examples
    --------
    >>> flat = np.zeros((32, 48, 3))
    >>> flat[..., 2] = 1
    >>> nm.write_workspace(nm.pack([flat]), "flat.psd")
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
