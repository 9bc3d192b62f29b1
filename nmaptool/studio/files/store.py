"""The folder of a running studio: what was dropped, baked and painted, until the document is saved."""

from __future__ import annotations

import os
import secrets
import shutil
import time
from pathlib import Path, PurePosixPath, PureWindowsPath

from nmaptool.core.errors import InputError, OutputError, reason_of

_LONGEST_NAME = 120
# Windows refuses these, and / separates folders
_REFUSED = frozenset('<>:"/\\|?*')


class Store:
    """A folder of its own below ``root``.

    Parameters
    ----------
    root : Path
        Made if it does not exist.
    address : (str, int)
        Host and port of the studio; another studio asks there whether this one still runs.

    Raises
    ------
    OutputError
        If the folder cannot be made.
    """

    def __init__(self, root: Path, address: tuple[str, int] = ("127.0.0.1", 0)) -> None:
        self.address = address
        self.folder = root / f"{time.strftime('%Y%m%d-%H%M%S')}-{secrets.token_hex(3)}"
        try:
            self.folder.mkdir(parents=True)
        except OSError as error:
            raise OutputError(f"{self.folder}: cannot be made ({reason_of(error)})") from None

    def place(self, name: str) -> Path:
        """Return a path for a new file, which no other file has; ``name`` is that of the user's file.

        Raises
        ------
        InputError
            If the name is empty or holds characters that a file name cannot hold.
        """
        plain = plain_name(name)
        path = self.folder / plain
        number = 1
        while path.exists():
            number += 1
            path = self.folder / f"{Path(plain).stem}-{number}{Path(plain).suffix}"
        return path

    def holds(self, path: Path) -> bool:
        """Whether a file is one of its own."""
        return path.is_relative_to(self.folder)

    def named(self, text: str) -> str:
        """Return a message with the plain names of its own files, as the user knows them."""
        return text.replace(f"{self.folder}{os.sep}", "")

    def remove(self) -> None:
        """Delete the folder and everything in it."""
        shutil.rmtree(self.folder, ignore_errors=True)


def plain_name(name: str) -> str:
    """Return the name of a file without its folders.

    Raises
    ------
    InputError
        If nothing is left, or it holds characters that a file name cannot hold.
    """
    plain = PurePosixPath(PureWindowsPath(name).name).name.strip()
    if not plain.strip(".") or len(plain) > _LONGEST_NAME:
        raise InputError(f"{name[:60]!r}: is not the name of a file")
    if any(letter in _REFUSED or not letter.isprintable() for letter in plain):
        raise InputError(f"{plain!r}: holds characters that a file name cannot hold")
    return plain
