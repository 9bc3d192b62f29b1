"""The ZIP archive of an OpenRaster file, treated as untrusted."""

from __future__ import annotations

import struct
import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Self

from nmaptool.core.errors import InputError, LimitError

MOST_ENTRIES = 20_000
# deflate cannot compress better; a larger ratio is a false size or a zip bomb
_LARGEST_RATIO = 1040
_CHUNK = 1 << 20
_END, _END64 = b"PK\5\6", b"PK\6\7"
_ENTRY_BYTES = 600  # of the directory, per entry


class OraArchive:
    """A checked ZIP archive: safe names, no links, no encryption, plausible sizes.

    Parameters
    ----------
    path : Path
    max_megapixels : float
        Limits the unpacked size of a picture in it.

    Raises
    ------
    InputError
        If it is damaged or has entries that no editor writes.
    LimitError
        If it declares too many entries.
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
        """The error for a truncated or damaged OpenRaster file."""
        return InputError(f"{self.path}: the ORA file is truncated or damaged; save or download it again")

    def _checked(self) -> dict[str, zipfile.ZipInfo]:
        found: dict[str, zipfile.ZipInfo] = {}
        for info in self._zip.infolist():
            shown = "".join(c if c.isprintable() else "?" for c in info.orig_filename[:80])
            name = info.filename
            unsafe = "\\" in info.orig_filename or "\0" in info.orig_filename or ":" in name or name.startswith("/")
            if unsafe or ".." in PurePosixPath(name).parts:
                raise InputError(f"{self.path}: holds the entry {shown!r}, whose path is not safe; save it again")
            if (info.external_attr >> 16) & 0o170000 == 0o120000:
                raise InputError(f"{self.path}: holds the link {shown!r}; save it again without links")
            if info.flag_bits & 1:
                raise InputError(f"{self.path}: holds the encrypted entry {shown!r}; save it without a password")
            if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise InputError(f"{self.path}: entry {shown!r} has an unsupported compression; save it again")
            if name in found:
                raise InputError(f"{self.path}: holds two entries named {shown!r}; save it again")
            if info.file_size > info.compress_size * _LARGEST_RATIO + 1024:
                raise InputError(
                    f"{self.path}: entry {shown!r} declares a larger size than its data can unpack to; save it again"
                )
            found[name] = info
        return found

    def __contains__(self, name: str) -> bool:
        return name in self._entries

    def read(self, name: str, largest: int | None = None, head: int | None = None) -> bytes:
        """Return the bytes of an entry, or its first ``head``; no more than ``largest`` are unpacked.

        Raises
        ------
        InputError
            If it is missing or damaged.
        LimitError
            If its declared or its actual size is larger than ``largest``.
        """
        info = self._entries.get(name)
        shown = "".join(c if c.isprintable() else "?" for c in name[:80])
        if info is None:
            raise InputError(f"{self.path}: lists {shown!r} but does not contain it; save it again")
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
                        raise LimitError(f"{self.path}: entry {shown!r} is larger than it declares; save it again")
        except (zipfile.BadZipFile, OSError, EOFError, ValueError, zlib.error, struct.error, NotImplementedError):
            raise self.damaged() from None
        except RuntimeError:  # encrypted after all
            raise self.damaged() from None
        return b"".join(pieces)


def _check_directory(path: Path) -> None:
    """Refuse a directory that would fill the memory; its size is in the last bytes of the file."""
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(max(0, size - 65_557 - 20))
        tail = stream.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) < at + 22:
        raise InputError(f"{path}: the ORA file is truncated or damaged; save or download it again")
    entries, length = struct.unpack_from("<HI", tail, at + 10)
    if tail[max(0, at - 20) : at].startswith(_END64) or entries == 0xFFFF or length == 0xFFFFFFFF:
        raise LimitError(f"{path}: is a 64-bit ZIP archive, which is not supported; make it smaller")
    if entries > MOST_ENTRIES or length > MOST_ENTRIES * _ENTRY_BYTES:
        raise LimitError(f"{path}: declares {entries} entries; the limit is {MOST_ENTRIES}; merge layers")
