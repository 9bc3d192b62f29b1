"""Decode the Draco-compressed parts of a glTF with DracoPy, which the extra ``draco`` installs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.accessors import Accessors, normalised
from nmaptool.io.meshes.gltf_buffers import whole_number
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers

DRACO = "KHR_draco_mesh_compression"


@dataclass(frozen=True, eq=False)
class DracoPart:
    """A compressed set of triangles with the numbers of vertices and faces that its accessors declare.

    Attributes
    ----------
    file : MeshFile
    data : bytes
    count, faces : int
    """

    file: MeshFile
    data: bytes
    count: int
    faces: int

    def triangles(self) -> Integers:
        """(M, 3) int64 triangles."""
        faces = np.asarray(self._mesh.faces).astype(np.int64).reshape(-1, 3)
        if len(faces) != self.faces:
            raise self.file.damaged
        return faces

    def attribute(self, number: int, width: int) -> NDArray[Any]:
        """(N, width): an attribute of the vertices as stored."""
        found = self._mesh.get_attribute_by_unique_id(number)
        stored = np.asarray(None if found is None else found["data"])
        if stored.shape != (self.count, width) or stored.dtype.kind not in "iuf":
            raise self.file.damaged
        return stored

    @cached_property
    def _mesh(self) -> Any:
        import DracoPy

        try:
            mesh = DracoPy.decode(self.data)
            _ = mesh.faces
        except Exception:  # noqa: BLE001 - the decoder raises many kinds of errors for damaged data
            raise self.file.damaged from None
        return mesh


@dataclass(frozen=True, eq=False)
class DracoColumn:
    """One attribute of a compressed part, decoded on demand; it serves as a `Column`."""

    part: DracoPart
    number: int
    width: int
    is_normalized: bool

    @property
    def count(self) -> int:
        """Declared number of vertices."""
        return self.part.count

    def stored(self) -> NDArray[Any]:
        """(N, W): the values as stored."""
        return self.part.attribute(self.number, self.width)

    def values(self) -> Float64:
        """(N, W) float64: the values, with normalised integers as fractions."""
        return normalised(self.stored(), self.is_normalized)


def draco_part(accessors: Accessors, primitive: dict[str, Any], extension: dict[str, Any]) -> DracoPart | None:
    """Return a compressed part, or None if the file also holds it uncompressed and DracoPy is not installed.

    Raises
    ------
    InputError
        If it is only there compressed and DracoPy is not installed.
    """
    position = accessors.item("accessors", primitive["attributes"]["POSITION"])
    corners = accessors.item("accessors", primitive["indices"])
    try:
        import DracoPy  # noqa: F401 - whether it is installed
    except ImportError:
        if "bufferView" in position and "bufferView" in corners:
            return None
        raise InputError(
            f"{accessors.file.path}: is compressed with Draco; "
            'pip install "nmaptool-relief[draco]" to read it, or export it again without compression'
        ) from None
    count, indices = whole_number(position["count"]), whole_number(corners["count"])
    data = accessors.bytes_of(extension["bufferView"])
    # the best compression known takes about a bit for each face
    if indices % 3 or max(count, indices // 3) > 64 * len(data):
        raise ValueError
    return DracoPart(accessors.file, data, count, indices // 3)


def draco_column(
    accessors: Accessors, part: DracoPart, extension: dict[str, Any], name: str, index: Any, width: int
) -> DracoColumn | None:
    """Return an attribute of a compressed part, such as ``POSITION``; None if it is not compressed.

    ``index`` is the accessor that describes it.
    """
    if name not in extension["attributes"]:
        return None
    accessor = accessors.item("accessors", index)
    if whole_number(accessor["count"]) != part.count:
        raise ValueError
    number = whole_number(extension["attributes"][name])
    return DracoColumn(part, number, width, bool(accessor.get("normalized")))
