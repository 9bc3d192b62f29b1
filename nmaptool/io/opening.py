"""Read the first bytes of a file, with an error for every reason why that fails."""

from __future__ import annotations

from pathlib import Path

from nmaptool.core.errors import InputError, reason_of


def read_head(path: Path, count: int, wanted: str, for_streams: str) -> tuple[bytes, int]:
    """Return the first bytes of a file and its size.

    Parameters
    ----------
    path : Path
    count : int
        Maximum number of bytes.
    wanted, for_streams : str
        For messages: what to give instead of a folder, and what to do with a stream.

    Raises
    ------
    InputError
        If the file is missing, empty or not readable, or is a folder, a stream or a device.
    """
    try:
        if path.is_dir():  # Windows reports a folder as a protected file
            raise InputError(f"{path}: is a folder; give {wanted}")
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is a stream or device, not a file; {for_streams}")
        with path.open("rb") as stream:
            head = stream.read(count)
            size = stream.seek(0, 2)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason_of(error)})") from None
    except InputError:  # InputError is a ValueError
        raise
    except ValueError:  # a null character in the name
        raise InputError(f"{str(path)!r}: is not a valid file name") from None
    if not head:
        raise InputError(f"{path}: is empty; export or download it again")
    return head, size
