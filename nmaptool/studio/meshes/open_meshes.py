"""Meshes that were dropped or named on the command line: read in the background, kept, and shown to the page."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.baking.bake import mesh_warnings
from nmaptool.core.errors import InputError, LimitError, NmaptoolError, UsageError
from nmaptool.filters.prepared import PreparedMesh, prepare_mesh
from nmaptool.io.meshes.reader import read_mesh
from nmaptool.options import BakeOptions, FilterOptions, MeshReadOptions
from nmaptool.render.camera import frame_camera
from nmaptool.studio.forms.given import in_words, options_from
from nmaptool.studio.jobs import failure
from nmaptool.studio.meshes.display_mesh import display_mesh
from nmaptool.studio.meshes.hull import hull
from nmaptool.types.mesh import Mesh
from nmaptool.types.mesh_arrays import MM_PER_UNIT

# meshes in memory
_MOST = 16
_NO_FACES = np.zeros((0, 3), np.int32)


@dataclass(frozen=True)
class BakeOrder:
    """What the camera panel asks for: how a mesh is read, seen and filtered."""

    reading: MeshReadOptions
    camera: BakeOptions
    filter: FilterOptions

    @classmethod
    def of(cls, values: Any) -> BakeOrder:
        """Return the order with the values of the page, in the tables ``reading``, ``camera`` and ``filter``.

        Raises
        ------
        UsageError, LimitError
            If one of them is not accepted.
        """
        if not isinstance(values, Mapping):
            raise UsageError("the page sent no options; reload it")
        tables = {f.name: values.get(f.name) or {} for f in dataclasses.fields(cls)}
        order = cls(
            options_from(MeshReadOptions, tables["reading"]),
            options_from(BakeOptions, tables["camera"]),
            options_from(FilterOptions, tables["filter"]),
        )
        if len(order.camera.views) > 1:
            raise UsageError(f"`view={order.camera.view!r}`: the camera shows one view; bake one after the other")
        return order


@dataclass(frozen=True)
class Origin:
    """What the map of a layer was baked from: a mesh, by its id, and the options of the page."""

    mesh: str
    values: Mapping[str, Any]


@dataclass
class OpenMesh:
    """A mesh file, and what has been made of it so far.

    Attributes
    ----------
    mesh : Mesh or None
        As it was read.
    clean : PreparedMesh or None
    corners : Mesh
        The corners of the clean mesh's convex hull, which frame it, without faces.
    bytes : bytes
        What `display_mesh` returns.
    """

    id: str
    path: Path
    state: str = "reading"
    text: str = "reading"
    mesh: Mesh | None = None
    clean: PreparedMesh | None = None
    corners: Mesh | None = None
    bytes: bytes = b""

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.path.name

    @property
    def shown(self) -> dict[str, Any]:
        """The mesh for the page's list."""
        return {"id": self.id, "name": self.name, "state": self.state, "text": self.text}


class Meshes:
    """The meshes that are open.

    Parameters
    ----------
    changed : callable
        Called from any thread when one of them has changed.
    """

    def __init__(self, changed: Callable[[], None]) -> None:
        self._changed = changed
        self._open: dict[str, OpenMesh] = {}
        self._number = 0
        # one at a time: a large mesh needs much memory while it is read
        self._reading = threading.Lock()

    @property
    def shown(self) -> list[dict[str, Any]]:
        """The meshes for the page, in the order in which they came."""
        return [one.shown for one in self._open.values()]

    def add(self, path: Path) -> OpenMesh:
        """Begin to read a file.

        Raises
        ------
        LimitError
            If too many are open.
        """
        if len(self._open) >= _MOST:
            raise LimitError(f"{path.name}: {_MOST} meshes are open already; close one of them")
        self._number += 1
        one = OpenMesh(str(self._number), path)
        self._open[one.id] = one
        threading.Thread(target=self._read, args=(one,), name="studio mesh", daemon=True).start()
        return one

    def close(self, name: Any) -> None:
        """Forget a mesh."""
        self._open.pop(str(name), None)
        self._changed()

    def __getitem__(self, name: Any) -> OpenMesh:
        """Return the mesh with an id.

        Raises
        ------
        UsageError
            If there is none.
        """
        one = self._open.get(str(name))
        if one is None:
            raise UsageError("the page named a mesh that is not open; drop it again")
        return one

    def ready(self, name: Any) -> OpenMesh:
        """Return the mesh with an id once it is read.

        Raises
        ------
        UsageError
            If there is none, or it is still being read.
        InputError
            If it could not be read.
        """
        one = self[name]
        if one.state == "failed":
            raise InputError(one.text)
        if one.state != "ready":
            raise UsageError(f"{one.name}: is still being read; wait until it is shown")
        return one

    def _read(self, one: OpenMesh) -> None:
        """In a thread of its own."""
        with self._reading:
            if one.id not in self._open:
                return
            try:
                self._say(one, "reading")
                read = read_mesh(one.path, max_faces=MeshReadOptions().max_faces)
                one.mesh = dataclasses.replace(read, name=one.name)
                self._say(one, "checking")
                one.clean = prepare_mesh(one.mesh)
                one.corners = dataclasses.replace(
                    one.clean.mesh, vertices=hull(one.clean.mesh.vertices), faces=_NO_FACES
                )
                self._say(one, "preparing the view")
                one.bytes = display_mesh(one.clean.mesh, _facts(one.clean), one.corners.vertices)
            except Exception as error:  # noqa: BLE001 - the page must hear of it
                one.mesh = one.clean = one.corners = None
                said = failure(error)["text"].replace(str(one.path), one.name)
                self._say(one, said, "failed")
            else:
                self._say(one, one.clean.findings.summary(), "ready")

    def _say(self, one: OpenMesh, text: str, state: str = "reading") -> None:
        one.state, one.text = state, text
        self._changed()


def _facts(clean: PreparedMesh) -> dict[str, Any]:
    mesh = clean.mesh
    return {
        "name": mesh.name,
        "mm_per_unit": mesh.mm_per_unit,
        "unit_from": mesh.unit_from,
        "up_from": mesh.up_from,
        "mean_edge": mesh.mean_edge,
        "findings": f"{mesh.name}: {clean.findings.summary()}",
    }


def with_unit(mesh: Mesh, unit: str | None) -> Mesh:
    """Return a mesh as if it was read with ``unit``."""
    return mesh if unit is None else dataclasses.replace(mesh, mm_per_unit=MM_PER_UNIT[unit], unit_from="given")


def checked(one: OpenMesh, values: Any) -> dict[str, Any]:
    """Return what `bake` would make with the options of the page, and what can be doubted, without drawing.

    Returns
    -------
    dict
        ``size``, ``pitch_mm`` and ``width_mm`` of the maps, ``sigma_s_px``, and ``warnings``; or ``error``.
    """
    assert one.clean is not None
    assert one.corners is not None
    try:
        order = BakeOrder.of(values)
        options, view = order.camera, order.camera.views[0]
        camera = frame_camera(with_unit(one.corners, order.reading.unit), options, *options.directions[0])
        mesh = with_unit(one.clean.mesh, order.reading.unit)
        prepared = dataclasses.replace(one.clean, mesh=mesh, filter=order.filter)
        pitch_mm = camera.unit_per_px * mesh.mm_per_unit
        if options.width is not None:
            pitch_mm = options.width.to_mm(1.0, 1) / camera.cols
            sized = dataclasses.replace(mesh, mm_per_unit=pitch_mm / camera.unit_per_px, unit_from="given")
            prepared = dataclasses.replace(prepared, mesh=sized)
        return {
            "size": [camera.cols, camera.rows],
            "pitch_mm": pitch_mm,
            "width_mm": pitch_mm * camera.cols,
            "height_mm": pitch_mm * camera.rows,
            "sigma_s_px": 0.0 if order.filter.filter == "learned" else prepared.sigma_s / camera.unit_per_px,
            "warnings": [in_words(text) for text in mesh_warnings(prepared, options, view)],
        }
    except NmaptoolError as error:
        return {"error": in_words(str(error))}
