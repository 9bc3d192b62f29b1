"""The folder of a solve by tiles: its arrays, and a record of each finished step, so that a later run can go on."""

from __future__ import annotations

import contextlib
import io
import json
import os
import secrets
import shutil
import socket
import sys
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError, OutputError, reason_of
from nmaptool.core.units import memory_text
from nmaptool.io.stores.extra import fsspec_module
from nmaptool.io.stores.names import local_path

_CHUNK = 512
_RECIPE = "recipe.json"
_LOCK = "lock"


def _is_alive(owner: str) -> bool:
    """Whether the process of a lock runs; one on another machine is taken to."""
    host, number, *_ = (*owner.split(), "", "")
    # on Windows, signal 0 would interrupt the process
    if host != socket.gethostname() or not number.isdecimal() or sys.platform == "win32":
        return True
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


@lru_cache(maxsize=64)
def _array(url: str) -> Any:
    import zarr

    return zarr.open_array(url, mode="r+")


def chunk_of(tile: int) -> int:
    """Side of the chunks of an array that is written by tiles: the largest power of two up to 512 that divides them.

    >>> chunk_of(2048), chunk_of(320)
    (512, 64)
    """
    return min(_CHUNK, tile & -tile)


@dataclass(frozen=True)
class WorkFolder:
    """Arrays and records below one folder or address.

    Parameters
    ----------
    url : str
        A folder, or an address that fsspec knows.
    owner : str
        The run that may write; empty if it does not matter.
    """

    url: str
    owner: str = ""

    def make_array(self, name: str, shape: tuple[int, ...], dtype: str, tile: int, *, packed: bool = False) -> None:
        """Create an array of zeros, unless it is there.

        Parameters
        ----------
        name : str
        shape : tuple of int
        dtype : str
        tile : int
            Side of the part that one task writes. It consists of whole chunks, because two tasks must never write to
            the same one.
        packed : bool
            Compress it.
        """
        import zarr
        from zarr.codecs import BloscCodec

        if self._exists(f"{name}/zarr.json"):
            return
        codec = BloscCodec(cname="lz4", clevel=1) if packed else None
        zarr.create_array(
            f"{self.url}/{name}",
            shape=shape,
            chunks=(chunk_of(tile), chunk_of(tile), *shape[2:]),
            dtype=dtype,
            compressors=codec,
            overwrite=True,
        )

    def read(self, name: str, box: tuple[slice, slice]) -> NDArray[Any]:
        """Read a window of an array.

        Raises
        ------
        InputError
            If it cannot be read.
        """
        try:
            return np.asarray(_array(f"{self.url}/{name}")[box])
        except (OSError, ValueError, RuntimeError) as error:
            raise InputError(
                f"{self.url}: a chunk of {name} is missing or damaged ({error}); remove the folder and run again"
            ) from error

    def write(self, name: str, box: tuple[slice, slice], values: NDArray[Any]) -> None:
        """Write a window of an array.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        try:
            _array(f"{self.url}/{name}")[box] = values
        except OSError as error:
            raise OutputError(
                f"{self.url}: cannot write {name}: {reason_of(error)}; free some space and run again, it goes on"
            ) from error

    def put(self, key: str, values: Mapping[str, Any]) -> None:
        """Record a finished step, all or nothing.

        Raises
        ------
        OutputError
            If it cannot be written, or another run has taken over.
        """
        self.check_owner()
        buffer = io.BytesIO()
        np.savez(buffer, **values)
        data = buffer.getvalue()
        self._put_bytes(f"{key}.npz", zlib.crc32(data).to_bytes(4, "big") + data)

    def get(self, key: str) -> dict[str, NDArray[Any]] | None:
        """Return what was recorded for a step; None if it is not finished."""
        data = self._bytes(f"{key}.npz")
        if data is None or zlib.crc32(data[4:]).to_bytes(4, "big") != data[:4]:
            return None
        with np.load(io.BytesIO(data[4:])) as found:
            return dict(found)

    def known(self, step: str, tile: Any) -> dict[str, NDArray[Any]]:
        """Return what was recorded for a finished step of a tile, which has a ``row`` and a ``col``.

        Raises
        ------
        InputError
            If the record is gone or damaged.
        """
        found = self.get(f"{step}/{tile.row}_{tile.col}")
        if found is None:
            raise InputError(f"{self.url}: a record of {step} is missing or damaged; remove the folder and run again")
        return found

    def recipe(self) -> dict[str, Any] | None:
        """Return the recipe that the folder belongs to; None for a new folder."""
        data = self._bytes(_RECIPE)
        try:
            return None if data is None else dict(json.loads(data))
        except ValueError:
            return None

    def begin(self, recipe: Mapping[str, Any]) -> None:
        """Start a folder for a recipe."""
        self._put_bytes(_RECIPE, json.dumps(recipe, indent=1).encode())

    def check_room(self, needed_bytes: int) -> None:
        """Check that a disk of this machine has room for the arrays; what is there already counts.

        Raises
        ------
        LimitError
            If it has not.
        """
        place = local_path(self.url)
        if place is None:
            return
        there = sum(path.stat().st_size for path in place.rglob("*") if path.is_file()) if place.is_dir() else 0
        free = shutil.disk_usage(next(folder for folder in place.absolute().parents if folder.is_dir())).free
        if needed_bytes > free + there:
            raise LimitError(
                f"{self.url}: needs about {memory_text(needed_bytes)} of disk space, {memory_text(free + there)} are "
                "free; give another `work_folder`"
            )

    def finished(self) -> int:
        """Number of finished steps."""
        files, path = self._files()
        return len(files.glob(f"{path}/*/*.npz"))

    def has_any(self, step: str) -> bool:
        """Whether a step was finished for any tile."""
        files, path = self._files()
        return bool(files.glob(f"{path}/{step}/*.npz"))

    @contextlib.contextmanager
    def locked(self) -> Iterator[WorkFolder]:
        """Keep other runs out; yields the folder for this run, which refuses to write once another has taken over.

        Raises
        ------
        OutputError
            If another run uses the folder.
        """
        owner = self._owner()
        if owner and _is_alive(owner):
            host, number, _ = owner.split()
            raise OutputError(
                f"{self.url}: another run uses it (process {number} on {host}); wait for it, or remove {_LOCK} in that "
                "folder if it has ended"
            )
        mine = f"{socket.gethostname()} {os.getpid()} {secrets.token_hex(8)}"
        self._put_bytes(_LOCK, mine.encode())
        try:
            yield replace(self, owner=mine)
        finally:
            files, path = self._files()
            with contextlib.suppress(FileNotFoundError):
                files.rm_file(f"{path}/{_LOCK}")

    def _owner(self) -> str:
        return (self._bytes(_LOCK) or b"").decode()

    def check_owner(self) -> None:
        """Check that this run still has the folder.

        Raises
        ------
        OutputError
            If another has taken over.
        """
        if self.owner and self._owner() != self.owner:
            raise OutputError(f"{self.url}: another run has taken over; what is finished is kept")

    def clear(self) -> None:
        """Remove what an earlier run left, except the lock."""
        files, path = self._files()
        _array.cache_clear()
        for entry in files.ls(path, detail=False):
            if not entry.endswith(f"/{_LOCK}"):
                files.rm(entry, recursive=True)

    def remove(self) -> None:
        """Remove the folder with all that is in it."""
        files, path = self._files()
        _array.cache_clear()
        if files.exists(path):
            files.rm(path, recursive=True)

    def _files(self) -> tuple[Any, str]:
        files, path = fsspec_module(self.url).core.url_to_fs(self.url)
        return files, path

    def _exists(self, key: str) -> bool:
        files, path = self._files()
        return bool(files.exists(f"{path}/{key}"))

    def _bytes(self, key: str) -> bytes | None:
        files, path = self._files()
        try:
            return bytes(files.cat_file(f"{path}/{key}"))
        except FileNotFoundError:
            return None

    def _put_bytes(self, key: str, data: bytes) -> None:
        files, path = self._files()
        target = f"{path}/{key}"
        try:
            files.makedirs(target.rpartition("/")[0], exist_ok=True)
            # a reader checks the sum, so a file that was cut off counts as missing
            files.pipe_file(target, data)
        except OSError as error:
            raise OutputError(
                f"{self.url}: cannot write: {reason_of(error)}; free some space and run again, it goes on"
            ) from error
