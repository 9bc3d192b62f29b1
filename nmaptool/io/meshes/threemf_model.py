"""Parse the XML of one model in a 3MF, as a stream."""

from __future__ import annotations

import posixpath
import zipfile
from array import array
from dataclasses import dataclass, field
from typing import IO, Any
from xml.parsers import expat

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers

Key = tuple[str, str]  # part of the archive, and number of the object in it
_CHUNK = 1 << 16
_LONGEST = 1 << 24  # bytes between two elements, which the parser keeps in memory
_LARGEST_LIST = 1 << 20  # bytes of the relations
_RELATIONS, _USUAL_ROOT = "_rels/.rels", "3D/3dmodel.model"


@dataclass(frozen=True, eq=False)
class Use:
    """An object in the build or in another object.

    Attributes
    ----------
    key : (str, str)
    matrix : (4, 3) float64
        Applied to points as rows: ``(x, y, z, 1) @ matrix``.
    """

    key: Key
    matrix: Float64


@dataclass
class Object:
    """An object: triangles, or other objects.

    Attributes
    ----------
    kind : str
        Such as ``model`` or ``support``.
    vertices : (N, 3) float64
    triangles : (M, 3) int64
        Not checked.
    components : list of Use
    """

    kind: str
    vertices: Float64 = field(default_factory=lambda: np.zeros((0, 3)))
    triangles: Integers = field(default_factory=lambda: np.zeros((0, 3), np.int64))
    components: list[Use] = field(default_factory=list)


@dataclass
class Model:
    """One model: its objects by number, the items to build, its unit, and the number of lattices in it."""

    objects: dict[str, Object] = field(default_factory=dict)
    build: list[Use] = field(default_factory=list)
    unit: str = "millimeter"
    lattices: int = 0


def root_of(file: MeshFile, archive: zipfile.ZipFile) -> str:
    """The part of the archive that holds the build.

    Raises
    ------
    InputError
        If there is no model.
    """
    names = archive.namelist()
    found: list[str] = []

    def start(name: str, attributes: dict[str, str]) -> None:
        if name.endswith("Relationship") and attributes.get("Type", "").endswith("/3dmodel"):
            found.append(attributes.get("Target", "").lstrip("/"))

    if _RELATIONS in names and archive.getinfo(_RELATIONS).file_size < _LARGEST_LIST:
        parse_xml(file, _RELATIONS, archive.open(_RELATIONS), start, lambda _: None)
    models = [name for name in names if name.lower().endswith(".model")]
    for name in (*found, _USUAL_ROOT, *models):
        if name in names:
            return name
    raise InputError(f"{file.path}: holds no model; export it again")


def read_model(file: MeshFile, name: str, stream: IO[bytes], max_faces: int) -> Model:
    """Parse one model.

    Raises
    ------
    InputError
        If it is not valid XML, or an element lacks a value.
    LimitError
        If it has more than ``max_faces`` triangles.
    """
    reader = _Reader(file, name, max_faces)
    parse_xml(file, name, stream, reader.start, reader.end)
    return reader.model


class _Reader:
    def __init__(self, file: MeshFile, name: str, max_faces: int) -> None:
        self.model = Model()
        self._file, self._name, self._max_faces = file, name, max_faces
        self._object: Object | None = None
        self._coordinates, self._corners = array("d"), array("q")
        self._faces = 0

    def start(self, name: str, attributes: dict[str, str]) -> None:
        tag = name.rpartition(":")[2]
        if tag == "vertex":
            self._coordinates.extend((float(attributes["x"]), float(attributes["y"]), float(attributes["z"])))
        elif tag == "triangle":
            self._corners.extend((int(attributes["v1"]), int(attributes["v2"]), int(attributes["v3"])))
            self._faces += 1
            if self._faces > self._max_faces:
                self._file.check_limit(self._faces, self._max_faces)
        elif tag == "model":
            self.model.unit = attributes.get("unit", "millimeter")
        elif tag == "object":
            self._object = Object(attributes.get("type", "model"))
            self.model.objects[attributes["id"]] = self._object
        elif tag == "component" and self._object is not None:
            self._object.components.append(self._use(attributes))
        elif tag == "item":
            self.model.build.append(self._use(attributes))
        elif tag == "beamlattice":
            self.model.lattices += 1

    def end(self, name: str) -> None:
        tag = name.rpartition(":")[2]
        if tag == "mesh" and self._object is not None:
            self._object.vertices = np.array(self._coordinates, np.float64).reshape(-1, 3)
            self._object.triangles = np.array(self._corners, np.int64).reshape(-1, 3)
            self._coordinates, self._corners = array("d"), array("q")
        elif tag == "object":
            self._object = None

    def _use(self, attributes: dict[str, str]) -> Use:
        path = next((value for key, value in attributes.items() if key.endswith(":path")), None)
        part = self._name if path is None else posixpath.normpath(path.lstrip("/"))
        matrix = np.eye(4, 3)
        if "transform" in attributes:
            matrix = np.array([float(word) for word in attributes["transform"].split()]).reshape(4, 3)
        if not np.isfinite(matrix).all():
            raise ValueError
        return Use((part, attributes["objectid"]), matrix)


def parse_xml(file: MeshFile, name: str, stream: IO[bytes], start: Any, end: Any) -> None:
    """Call ``start`` and ``end`` for each element of some XML; documents with definitions of their own are refused."""
    parser = expat.ParserCreate()
    last = 0

    def counted_start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal last
        last = parser.CurrentByteIndex
        start(tag, attributes)

    def refuse(*_: Any) -> None:
        raise ValueError

    def counted_end(tag: str) -> None:
        nonlocal last
        last = parser.CurrentByteIndex
        end(tag)

    parser.StartElementHandler, parser.EndElementHandler = counted_start, counted_end
    parser.StartDoctypeDeclHandler = refuse
    parser.buffer_text = False
    done = 0
    try:
        while chunk := stream.read(_CHUNK):
            done += len(chunk)
            parser.Parse(chunk, False)
            if done - last > _LONGEST:
                raise ValueError
        parser.Parse(b"", True)
    except (expat.ExpatError, KeyError, OverflowError, UnicodeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        line = parser.CurrentLineNumber
        raise InputError(
            f"{file.path}: line {line} of {name} is not valid: the 3MF file is truncated or damaged; export it again"
        ) from None
