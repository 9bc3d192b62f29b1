"""Looks for problems in the maps of the layers, in a thread of its own, and offers remedies."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from nmaptool.composition.recipe_values import with_recipe_keys
from nmaptool.core.errors import NmaptoolError
from nmaptool.core.mentions import mentions_in
from nmaptool.io.pictures.normal_maps import read_raster, split_layer
from nmaptool.maps.inspect import inspect_map
from nmaptool.options import ReadOptions
from nmaptool.studio.document import Document
from nmaptool.studio.layers import maps_of
from nmaptool.types.recipe import READ_KEYS, RELIEF_KEYS, RecipeLayer

# findings by file, its time and how it is read
Key = tuple[object, ...]
Findings = list[dict[str, Any]]


class Inspector:
    """Inspects the map of each layer once for each way to read it.

    Parameters
    ----------
    send : callable
        Called in the inspector's thread with a message for the page whenever there is something new.
    """

    def __init__(self, send: Callable[[dict[str, Any]], None]) -> None:
        self._send = send
        self._pool = ThreadPoolExecutor(1, "studio inspector")
        self._known: dict[Key, Findings] = {}
        self._document: Document | None = None

    def look(self, document: Document) -> None:
        """Inspect the maps of a document that were not inspected yet; the newest document wins."""
        self._document = document
        self._pool.submit(self._look, document)

    def message(self, document: Document) -> dict[str, Any]:
        """Return what is known about the layers of a document."""
        layers = []
        for place, layer in maps_of(document.layers):
            found = self._known.get(_key(document, layer))
            if found is not None:
                layers.append({"place": place, "findings": found})
        return {"kind": "findings", "layers": layers}

    def stop(self) -> None:
        """End the thread."""
        self._document = None
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _look(self, document: Document) -> None:
        for _, layer in maps_of(document.layers):
            key = _key(document, layer)
            if key in self._known:
                continue
            if self._document is not document:
                return
            self._known[key] = _inspected(document, layer)
        self._send(self.message(document))


def _key(document: Document, layer: RecipeLayer) -> Key:
    file = split_layer(str(document.folder / layer.file))[0]
    try:
        stamp = file.stat().st_mtime_ns
    except (OSError, ValueError):
        stamp = 0
    return str(file), layer.file, stamp, tuple(sorted((k, str(v)) for k, v in layer.read.items()))


def _inspected(document: Document, layer: RecipeLayer) -> Findings:
    reading, file = ReadOptions(**layer.read), document.folder / layer.file
    try:
        found = inspect_map(read_raster(file, reading), reading)
    except NmaptoolError as error:
        return [_shown(str(error).removeprefix(f"{file}: "), "", "cannot-read")]
    return [_shown(one.message, one.remedy, one.code) for one in found.findings]


def _shown(message: str, remedy: str, code: str) -> dict[str, Any]:
    return {
        "code": code,
        "message": with_recipe_keys(message),
        "remedy": with_recipe_keys(remedy),
        "offers": list(_offers(mentions_in(remedy or message))),
    }


def _offers(mentions: Iterable[tuple[str, Any]]) -> Iterable[dict[str, Any]]:
    """Yield what a button can set: the options with a value that the remedy mentions."""
    for name, value in mentions:
        wanted = True if name == "force" else value
        if wanted is None or name not in (*READ_KEYS, *RELIEF_KEYS):
            continue
        label = with_recipe_keys(f"`{name}={wanted!r}`")
        yield {"label": label, "of": "read" if name in READ_KEYS else "relief", "values": {name: wanted}}
