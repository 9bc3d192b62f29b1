"""The first bytes of a file, and every reason why there are none."""

from __future__ import annotations

from pathlib import Path

from nmaptool.core.errors import InputError, reason_of


def read_head(path: Path, count: int, wanted: str, for_streams: str) -> tuple[bytes, int]:
    """The first bytes of a file and its size.

    Parameters
    ----------
    path : Path
    count : int
        How many bytes at most.
    wanted, for_streams : str
        What to give instead of a folder, and what to do with a stream.

    Raises
    ------
    InputError
        If the file is missing, a folder, a device, empty or not readable.
    """
    try:
        if path.is_dir():  # which Windows refuses to open as if it were protected
            raise InputError(f"{path}: is a folder; give {wanted}")
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is not a file but a stream or device; {for_streams}")
        with path.open("rb") as stream:
            head = stream.read(count)
            size = stream.seek(0, 2)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason_of(error)})") from None
    except InputError:  # which is a ValueError
        raise
    except ValueError:  # a zero in the name
        raise InputError(f"{str(path)!r}: is no name that a file can have") from None
    if not head:
        raise InputError(f"{path}: is empty; export or download it again")
    return head, size
