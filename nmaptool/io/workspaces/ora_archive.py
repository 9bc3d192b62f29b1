"""The zip around an OpenRaster file, opened as if it wished us harm."""

from __future__ import annotations

import struct
import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Self

from nmaptool.core.errors import InputError, LimitError

MOST_ENTRIES = 20_000
# deflate cannot do better; more is a lie or a bomb
_LARGEST_RATIO = 1040
_CHUNK = 1 << 20
_END, _END64 = b"PK\5\6", b"PK\6\7"
_ENTRY_BYTES = 600  # of the directory, for one name


class OraArchive:
    """A checked zip: safe names, no links, no encryption, sizes that can be true.

    Parameters
    ----------
    path : Path
    max_megapixels : float
        Bounds what one picture in it may unpack to.

    Raises
    ------
    InputError
        If it is damaged or holds what no editor writes.
    LimitError
        If it claims too many entries.
    """

    def __init__(self, path: Path, max_megapixels: float) -> None:
        self.path = path
        self._largest = int(max_megapixels * 1e6 * 16) + (1 << 24)
        _check_directory(path)
        try:
            self._zip = zipfile.ZipFile(path)
        except (zipfile.BadZipFile, OSError, ValueError, struct.error, NotImplementedError, UnicodeError):
            raise self.damaged() from None
        try:
            self._entries = self._checked()
        except BaseException:
            self._zip.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._zip.close()

    def damaged(self) -> InputError:
        """What is said of a file that cannot be an OpenRaster file any more."""
        return InputError(f"{self.path}: the ORA file is cut short or damaged; save or download it again")

    def _checked(self) -> dict[str, zipfile.ZipInfo]:
        found: dict[str, zipfile.ZipInfo] = {}
        for info in self._zip.infolist():
            shown = "".join(c if c.isprintable() else "?" for c in info.orig_filename[:80])
            name = info.filename
            unsafe = "\\" in info.orig_filename or "\0" in info.orig_filename or ":" in name or name.startswith("/")
            if unsafe or ".." in PurePosixPath(name).parts:
                raise InputError(f"{self.path}: holds the entry {shown!r}, which points outside; no editor writes such")
            if (info.external_attr >> 16) & 0o170000 == 0o120000:
                raise InputError(f"{self.path}: holds a link, {shown!r}; no editor writes such")
            if info.flag_bits & 1:
                raise InputError(f"{self.path}: holds the encrypted entry {shown!r}; save it without a password")
            if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise InputError(f"{self.path}: entry {shown!r} is compressed in a way that ORA does not know")
            if name in found:
                raise InputError(f"{self.path}: holds two entries {shown!r}; save it again")
            if info.file_size > info.compress_size * _LARGEST_RATIO + 1024:
                raise InputError(
                    f"{self.path}: entry {shown!r} claims to unpack to more than its data can hold; save it again"
                )
            found[name] = info
        return found

    def __contains__(self, name: str) -> bool:
        return name in self._entries

    def read(self, name: str, largest: int | None = None, head: int | None = None) -> bytes:
        """An entry's bytes, or its first ``head``; no more than ``largest`` are ever unpacked.

        Raises
        ------
        InputError
            If it is missing or damaged.
        LimitError
            If it is larger than ``largest``, by what it claims or in truth.
        """
        info = self._entries.get(name)
        shown = "".join(c if c.isprintable() else "?" for c in name[:80])
        if info is None:
            raise InputError(f"{self.path}: lists {shown!r}, which is not in it; save it again")
        limit = min(self._largest if largest is None else largest, self._largest)
        if info.file_size > limit and head is None:
            raise LimitError(
                f"{self.path}: entry {shown!r} unpacks to {info.file_size / 1e6:.0f} MB, more than the limit of "
                f"{limit / 1e6:.0f} MB; make it smaller"
            )
        pieces, total = [], 0
        try:
            with self._zip.open(info) as stream:
                while piece := stream.read(_CHUNK if head is None else head - total):
                    pieces.append(piece)
                    total += len(piece)
                    if head is not None and total >= head:
                        break
                    if total > limit:
                        raise LimitError(f"{self.path}: entry {shown!r} unpacks to more than it claims; save it again")
        except (zipfile.BadZipFile, OSError, EOFError, ValueError, zlib.error, struct.error, NotImplementedError):
            raise self.damaged() from None
        except RuntimeError:  # encrypted after all
            raise self.damaged() from None
        return b"".join(pieces)


def _check_directory(path: Path) -> None:
    """Refuse a directory that would fill the memory, from the last bytes of the file."""
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(max(0, size - 65_557 - 20))
        tail = stream.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) < at + 22:
        raise InputError(f"{path}: the ORA file is cut short or damaged; save or download it again")
    entries, length = struct.unpack_from("<HI", tail, at + 10)
    if tail[max(0, at - 20) : at].startswith(_END64) or entries == 0xFFFF or length == 0xFFFFFFFF:
        raise LimitError(f"{path}: is a 64-bit zip, which no workspace of an accepted size needs; make it smaller")
    if entries > MOST_ENTRIES or length > MOST_ENTRIES * _ENTRY_BYTES:
        raise LimitError(f"{path}: claims {entries} entries; accepted are at most {MOST_ENTRIES}")
