"""Stores that are written under another name, and get their own when they are complete."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import OutputError, UsageError, reason_of
from nmaptool.io.output.targets import exists_already
from nmaptool.io.stores.extra import fsspec_module
from nmaptool.io.stores.names import ZARR_ENDING, local_path
from nmaptool.io.stores.zarr_writing import make_room


@dataclass(frozen=True)
class NewStore:
    """A Zarr store to be written, all or nothing.

    Parameters
    ----------
    name : str
        A path or a URL.
    what : str
        What it holds, for messages, such as "the edited map".
    overwrite : bool
        Replace a store that exists.

    Raises
    ------
    UsageError
        If the name does not end in .zarr.
    OutputError
        If it exists and is not to be replaced, or its folder does not exist.
    """

    name: str
    what: str
    overwrite: bool = False

    def __post_init__(self) -> None:
        place = self.place
        if not place.endswith(ZARR_ENDING):
            raise UsageError(f"{self.name}: {self.what} is written to a Zarr store, such as -o map.zarr")
        path = local_path(place)
        if path is None:
            files, root = fsspec_module(place).core.url_to_fs(place)
            if files.exists(root) and not self.overwrite:
                raise exists_already(Path(place))
            return
        if path.exists() and not self.overwrite:
            raise exists_already(path)
        if not path.parent.is_dir():
            raise OutputError(f"{place}: the folder {path.parent} does not exist; create it first")

    @property
    def place(self) -> str:
        """The name without a slash at its end."""
        return self.name.rstrip("/")

    @property
    def partial_name(self) -> str:
        """The name of the store until it is complete."""
        return f"{self.place.removesuffix(ZARR_ENDING)}.partial{ZARR_ENDING}"

    def finish(self) -> None:
        """Give the store its name.

        Raises
        ------
        OutputError
            If it cannot be renamed.
        """
        make_room(self.place, self.overwrite)
        path, partial = local_path(self.place), local_path(self.partial_name)
        try:
            if path is not None and partial is not None:
                partial.replace(path)
            else:
                files, root = fsspec_module(self.place).core.url_to_fs(self.place)
                files.mv(files._strip_protocol(self.partial_name), root, recursive=True)
        except OSError as error:
            raise OutputError(f"{self.place}: cannot be written ({reason_of(error)})") from None

    def has_partial(self) -> bool:
        """Whether an earlier run began to write it."""
        path = local_path(self.partial_name)
        if path is not None:
            return path.exists()
        files, root = fsspec_module(self.place).core.url_to_fs(self.partial_name)
        return bool(files.exists(root))

    def remove_partial(self) -> None:
        """Remove what was written."""
        make_room(self.partial_name, overwrite=True)
