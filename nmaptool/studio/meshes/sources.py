"""The meshes of a studio, the layers that were baked from them, and the detail maps of layers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TypeVar

from nmaptool.studio.document import Document
from nmaptool.studio.files.store import Store
from nmaptool.studio.jobs import Jobs
from nmaptool.studio.layers import maps_of
from nmaptool.studio.meshes.details import Details, Split, content_of
from nmaptool.studio.meshes.open_meshes import Meshes, OpenMesh, Origin
from nmaptool.studio.windows import Message, Windows

_T = TypeVar("_T")


class Sources:
    """What a room knows about meshes.

    Attributes
    ----------
    origins : dict of str to Origin
        What maps were baked from, by their path.
    splits : dict of str to Split
        What detail maps were split from, by their path.

    Parameters
    ----------
    store : Store
    windows : Windows
        Are told when something changes.
    now : callable
        Returns the document as it is.
    """

    def __init__(self, store: Store, windows: Windows, now: Callable[[], Document]) -> None:
        self.origins: dict[str, Origin] = {}
        self.splits: dict[str, Split] = {}
        self.details = Details(store)
        self.meshes = Meshes(lambda: windows.later(lambda: windows.tell(self.message(now()))))
        self.background = Jobs(windows.tell_later, windows.later)
        self._welcome: list[Message] = []

    def open(self, path: Path) -> Message:
        """Begin to read a mesh file; return the message with which a page opens the camera panel."""
        one: OpenMesh = self.meshes.add(path)
        return {"kind": "mesh", "id": one.id, "name": one.name}

    def welcome(self, path: Path) -> None:
        """Begin to read a mesh file; the first page to come opens the camera panel."""
        self._welcome.append(self.open(path))

    def greetings(self, document: Document) -> Iterator[Message]:
        """Yield the messages for a page that was opened."""
        yield self.message(document)
        while self._welcome:
            yield self._welcome.pop(0)

    def followed(self, before: Document, after: Document) -> Document:
        """Return a changed document with the detail of its layers, if the one before used it."""
        return self.details.followed(after) if self.details.follow(before, after) else after

    def moved(self, copies: Mapping[Path, Path]) -> None:
        """The document names copies of files."""
        _copied(self.origins, copies)
        _copied(self.splits, copies)
        self.details.moved(copies)

    def stop(self) -> None:
        """End what runs in the background."""
        self.background.stop()

    def message(self, document: Document) -> Message:
        """Return the meshes that are open, the layers baked from them, the detail map, and what runs."""
        baked = []
        for place, layer in maps_of(document.layers, with_hidden=True):
            origin = self.origins.get(str(document.folder / layer.file))
            if origin is not None:
                label = layer.options.name or Path(layer.file).name
                baked.append({"place": place, "mesh": origin.mesh, "values": origin.values, "label": label})
        detail = document.relief.files.detail
        split = None if detail is None else self.splits.get(str(document.folder / detail))
        return {
            "kind": "meshes",
            "meshes": self.meshes.shown,
            "layers": baked,
            "detail": {
                "name": detail and Path(detail).name,
                "is_followed": detail is not None and self.details.can_follow(document),
                "is_offered": self.details.are_offered(document),
                "split": None if split is None else split.values,
                "is_stale": split is not None and split.content != content_of(document),
            },
            "running": self.background.message,
        }


def _copied(known: dict[str, _T], copies: Mapping[Path, Path]) -> None:
    """Know the copies of files, too."""
    known.update({str(target): known[str(source)] for source, target in copies.items() if str(source) in known})
