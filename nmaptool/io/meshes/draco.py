"""Decode the Draco-compressed parts of a glTF with DracoPy, which the extra ``draco`` installs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

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
    attribute : int
        Number of its positions in the compressed data.
    is_normalized : bool
    count, faces : int
    """

    file: MeshFile
    data: bytes
    attribute: int
    is_normalized: bool
    count: int
    faces: int

    def values(self) -> Float64:
        """(N, 3) float64 positions."""
        return self._decoded[0]

    def triangles(self) -> Integers:
        """(M, 3) int64 triangles."""
        return self._decoded[1]

    @cached_property
    def _decoded(self) -> tuple[Float64, Integers]:
        import DracoPy

        try:
            mesh = DracoPy.decode(self.data)
            stored = np.asarray(mesh.get_attribute_by_unique_id(self.attribute)["data"])
            faces = np.asarray(mesh.faces).astype(np.int64).reshape(-1, 3)
        except Exception:  # noqa: BLE001 - the decoder raises many kinds of errors for damaged data
            raise self.file.damaged from None
        if stored.shape != (self.count, 3) or len(faces) != self.faces:
            raise self.file.damaged
        return normalised(stored, self.is_normalized), faces


def draco_part(accessors: Accessors, primitive: dict[str, Any], extension: dict[str, Any]) -> DracoPart | None:
    """Return a compressed part, or None if the file also holds it uncompressed and DracoPy is not installed.

    Raises
    ------
    InputError
        If it is only there compressed and DracoPy is not installed, or if it also has a skin or morph targets.
    """
    position = accessors.item("accessors", primitive["attributes"]["POSITION"])
    corners = accessors.item("accessors", primitive["indices"])
    path = accessors.file.path
    try:
        import DracoPy  # noqa: F401 - whether it is installed
    except ImportError:
        if "bufferView" in position and "bufferView" in corners:
            return None
        raise InputError(
            f"{path}: is compressed with Draco; "
            'pip install "nmaptool-relief[draco]" to read it, or export it again without compression'
        ) from None
    if primitive.get("targets") or "JOINTS_0" in primitive["attributes"]:
        raise InputError(
            f"{path}: is compressed with Draco and has a skin or morph targets, which are not read together; export "
            "it again without compression, such as by gltf-transform cp OLD.glb NEW.glb"
        )
    attribute = whole_number(extension["attributes"]["POSITION"])
    count, indices = whole_number(position["count"]), whole_number(corners["count"])
    data = accessors.bytes_of(extension["bufferView"])
    # the best compression known takes about a bit for each face
    if indices % 3 or max(count, indices // 3) > 64 * len(data):
        raise ValueError
    return DracoPart(accessors.file, data, attribute, bool(position.get("normalized")), count, indices // 3)
