"""Keeps unsaved work: the document is written to the store after each change, and offered at the next start."""

from __future__ import annotations

import contextlib
import json
import shutil
import socket
import time
from dataclasses import dataclass
from pathlib import Path

from nmaptool.composition.recipe_toml import to_toml
from nmaptool.core.errors import InputError, NmaptoolError
from nmaptool.io.pictures.normal_maps import split_layer
from nmaptool.io.recipes.reader import read_recipe
from nmaptool.options.formats import is_recipe
from nmaptool.studio.document import Document, relative
from nmaptool.studio.files.store import Store
from nmaptool.studio.meshes.details import carried

_RECIPE, _FACTS = "autosave.toml", "autosave.json"
_OLDEST_S = 30 * 24 * 3600.0


@dataclass(frozen=True)
class Unsaved:
    """Work that was not saved when a studio ended.

    Attributes
    ----------
    folder : Path
        The store of that studio.
    name : str
        Name of the document.
    time : float
        When it was written, in seconds since 1970.
    home : Path
        The folder of the document.
    path : Path or None
        The recipe that it was saved in before.
    """

    folder: Path
    name: str
    time: float
    home: Path
    path: Path | None


def keep(store: Store, document: Document) -> None:
    """Write a document to its store."""
    facts = {
        "name": document.name if document.path is None else document.path.name,
        "time": time.time(),
        "home": str(document.folder),
        "path": None if document.path is None else str(document.path),
        "address": store.address,
    }
    with contextlib.suppress(OSError, NmaptoolError):  # a full disk must not end the work
        for name, text in ((_RECIPE, to_toml(document.recipe)), (_FACTS, json.dumps(facts))):
            new = store.folder / f"{name}.new"
            new.write_text(text, encoding="utf-8")
            new.replace(store.folder / name)


def forget(store: Store) -> None:
    """Remove what `keep` wrote: the document is saved."""
    for name in (_FACTS, _RECIPE):
        (store.folder / name).unlink(missing_ok=True)


def found(root: Path, own: Path) -> list[Unsaved]:
    """Return the unsaved work below ``root`` of studios that ended, the newest first; what is old is deleted."""
    unsaved = []
    for folder in root.iterdir() if root.is_dir() else ():
        facts = _facts(folder)
        if folder == own or facts is None:
            continue
        if time.time() - facts.time > _OLDEST_S:
            shutil.rmtree(folder, ignore_errors=True)
        else:
            unsaved.append(facts)
    return sorted(unsaved, key=lambda one: one.time, reverse=True)


def _facts(folder: Path) -> Unsaved | None:
    """The unsaved work in a folder; None if there is none, or its studio still runs."""
    try:
        read = json.loads((folder / _FACTS).read_text(encoding="utf-8"))
        path = None if read["path"] is None else Path(read["path"])
        one = Unsaved(folder, str(read["name"]), float(read["time"]), Path(read["home"]), path)
        host, port = read["address"]
        address = str(host), int(port)
    except (OSError, ValueError, TypeError, KeyError):
        return None
    with contextlib.suppress(OSError), socket.create_connection(address, 0.2):
        return None
    return one


def recovered(unsaved: Unsaved, store: Store) -> Document:
    """Return unsaved work as a document; its files are moved to the store of this studio.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    read = Document.of(read_recipe(unsaved.folder / _RECIPE, folder=unsaved.home, name=unsaved.name), unsaved.path)
    moved: dict[Path, Path] = {}

    def new(name: str) -> str:
        # names are relative if the store lies in the folder of the document, such as the user's own
        file, layer = split_layer(str(unsaved.home / name))
        if not file.is_relative_to(unsaved.folder):
            return name
        if file not in moved:
            if not file.is_file():
                raise InputError(f"{unsaved.name}: {file.name} is gone")
            moved[file] = store.place(file.name)
            if is_recipe(file.name):
                text = carried(file, lambda own: str(read.folder / new(own)))
                moved[file].write_text(text, encoding="utf-8")
            else:
                shutil.copyfile(file, moved[file])
        return relative(moved[file], read.folder) + ("" if layer is None else f":{layer}")

    document = read.renamed(new)
    shutil.rmtree(unsaved.folder, ignore_errors=True)
    return document
