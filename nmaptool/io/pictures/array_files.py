"""NumPy array files, .npy and .npz: headers first, so that limits apply before any data are read; no pickles."""

from __future__ import annotations

import contextlib
import io
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError, reason_of
from nmaptool.io.pictures.request import damaged

_ARRAYS = ".npy"
_MOST_ENTRIES = 1000
_MOST_HEADER = 16384  # NumPy reads headers of up to 10000 characters
_ZIP_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError)


class ArrayHeader(NamedTuple):
    """What the header of an array declares."""

    shape: tuple[int, ...]
    kind: np.dtype[Any]
    by_columns: bool = False

    @property
    def size(self) -> int:
        """Bytes of data."""
        count = 1
        for side in self.shape:
            count *= side
        return count * self.kind.itemsize


def read_header(name: str, stream: Any) -> ArrayHeader:
    """Read the header of an array, leaving the stream at its data.

    Parameters
    ----------
    name : str
        For messages.
    stream : binary stream

    Raises
    ------
    InputError
    """
    broken = InputError(f"{name}: is not a NumPy array file, or is truncated; save it again")
    begin = io.BytesIO(stream.read(_MOST_HEADER))  # a header may claim to be 4 GB long
    try:
        version = np.lib.format.read_magic(begin)
        if version == (1, 0):
            shape, by_columns, kind = np.lib.format.read_array_header_1_0(begin)
        elif version in ((2, 0), (3, 0)):
            shape, by_columns, kind = np.lib.format.read_array_header_2_0(begin)
        else:
            raise broken
        if not all(type(side) is int and side >= 0 for side in shape):
            raise broken
        stream.seek(begin.tell())
    except InputError:
        raise
    except (ValueError, EOFError, TypeError, SyntaxError, RecursionError, MemoryError, tokenize.TokenError):
        raise broken from None
    if kind.hasobject:
        raise InputError(
            f"{name}: holds Python objects (a pickle), which may run code and are not read; save the plain array of "
            "numbers in it"
        )
    return ArrayHeader(shape, kind, by_columns)


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    try:
        if path.is_dir():  # Windows reports a folder as a protected file
            raise InputError(f"{path}: is a folder; give an array file")
        with path.open("rb") as stream:
            yield stream
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason_of(error)})") from None


def header_of(path: Path) -> ArrayHeader:
    """Read the header of an .npy file.

    Raises
    ------
    InputError
    """
    with _opened(path) as stream:
        return read_header(str(path), stream)


def load_npy(path: Path, check: Callable[[str, ArrayHeader], None]) -> NDArray[Any]:
    """Read an .npy file.

    Parameters
    ----------
    path : Path
    check : callable
        ``check(name, header)`` raises an error if the array is not wanted, before its data are read.

    Raises
    ------
    InputError, LimitError
    """
    with _opened(path) as stream:
        return _load(str(path), stream, check, path.stat().st_size)


def _load(name: str, stream: BinaryIO, check: Callable[[str, ArrayHeader], None], size: int) -> NDArray[Any]:
    header = read_header(name, stream)
    check(name, header)
    if size - stream.tell() < header.size:
        raise InputError(f"{name}: is not a NumPy array file, or is truncated; save it again")
    stream.seek(0)
    try:
        values: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    except MemoryError:
        raise LimitError(f"{name}: does not fit in memory; make it smaller") from None
    except (ValueError, EOFError):
        raise InputError(f"{name}: is not a NumPy array file, or is truncated; save it again") from None
    return values


class Archive:
    """The arrays in an .npz file, by name, with their headers.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If it is not an archive of arrays, or is damaged.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            with zipfile.ZipFile(path) as archive:
                members = [one for one in archive.infolist() if one.filename.endswith(_ARRAYS)]
                if not members:
                    raise InputError(
                        f"{path}: is a ZIP archive without NumPy arrays; export the map as PNG, EXR or TIFF"
                    )
                if len(members) > _MOST_ENTRIES:
                    raise LimitError(f"{path}: holds more than {_MOST_ENTRIES} arrays; save the map alone")
                self.headers = {one.filename.removesuffix(_ARRAYS): self._header(archive, one) for one in members}
        except _ZIP_DAMAGE:
            raise damaged(path, "NumPy .npz") from None

    def _header(self, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> ArrayHeader | None:
        """The header of a member; None if it holds Python objects."""
        if member.flag_bits & 1:
            raise InputError(f"{self._path}: is encrypted; save it without a password")
        try:
            with archive.open(member) as stream:
                return read_header(str(self._path), stream)
        except InputError:
            return None

    def load(self, key: str, check: Callable[[str, ArrayHeader], None]) -> NDArray[Any]:
        """Read one array; ``check`` as in `load_npy`.

        Raises
        ------
        InputError, LimitError
        """
        name = f"{self._path}:{key}"
        try:
            with zipfile.ZipFile(self._path) as archive:
                member = archive.getinfo(key + _ARRAYS)
                with archive.open(member) as stream:
                    header = read_header(name, stream)
                    check(name, header)
                    data = stream.read(header.size + 1)  # never more than the header declares, whatever was packed
        except _ZIP_DAMAGE:
            raise damaged(self._path, "NumPy .npz") from None
        except MemoryError:
            raise LimitError(f"{name}: does not fit in memory; make it smaller") from None
        if len(data) != header.size:
            raise damaged(self._path, "NumPy .npz")
        return np.frombuffer(data, header.kind).reshape(header.shape, order="F" if header.by_columns else "C")
