"""Read 3MF: the objects of the build, with the transforms of items and components, from all parts of the archive."""

from __future__ import annotations

import errno
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.polygons import Integers
from nmaptool.io.meshes.surface import Surface
from nmaptool.io.meshes.threemf_model import Key, Model, Object, Use, read_model, root_of
from nmaptool.io.meshes.threemf_modifiers import modifiers_note, remove_modifiers
from nmaptool.types.shown import counted

_MM = {"micron": 0.001, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
_BYTES_PER_FACE = 400  # of XML, at most, with its share of vertices
_LEAST_LIMIT = 1 << 24


def read_3mf(file: MeshFile, max_faces: int) -> Surface:
    """Read a 3MF.

    Raises
    ------
    InputError
        If it is damaged, or an object is missing or contains itself.
    LimitError
        If it has more than ``max_faces`` triangles; each placement of an object counts.
    """
    try:
        with zipfile.ZipFile(file.path) as archive:
            package = _Package(file, archive, max_faces)
            return package.surface()
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError):
        raise file.damaged from None
    except OSError as error:
        if error.errno == errno.EINVAL:  # the archive names a place before its own beginning
            raise file.damaged from None
        raise


@dataclass(eq=False)
class _Package:
    """The models of an archive, each read when an object in it is used."""

    file: MeshFile
    archive: zipfile.ZipFile
    max_faces: int
    models: dict[str, Model] = field(default_factory=dict)
    faces: dict[Key, int] = field(default_factory=dict)
    skipped: set[Key] = field(default_factory=set)
    modifiers: set[Key] = field(default_factory=set)

    def model(self, name: str) -> Model:
        """The model in one part of the archive."""
        if name not in self.models:
            try:
                info = self.archive.getinfo(name)
            except KeyError:
                raise InputError(f"{self.file.path}: lacks its part {name!r}; export or download it again") from None
            if info.file_size > max(_BYTES_PER_FACE * self.max_faces, _LEAST_LIMIT):
                raise LimitError(
                    f"{self.file.path}: {name} is {info.file_size / 1e6:.0f} MB of XML, too much for {self.max_faces} "
                    "faces; decimate it, or raise `max_faces`"
                )
            with self.archive.open(info) as stream:
                self.models[name] = read_model(self.file, name, stream, self.max_faces)
        return self.models[name]

    def object(self, key: Key) -> Object:
        """An object of one of the models."""
        found = self.model(key[0]).objects.get(key[1])
        if found is None:
            raise InputError(f"{self.file.path}: lacks its object {key[1]!r}; export it again")
        return found

    def components(self, found: Object) -> list[Use]:
        """The components of an object, without those of the type "other": slicers use it for modifiers."""
        kept = []
        for use in found.components:
            if self.object(use.key).kind == "other":
                self.modifiers.add(use.key)
            else:
                kept.append(use)
        return kept

    def count(self, key: Key, above: tuple[Key, ...] = ()) -> int:
        """Number of faces of an object with its components; 0 for supports."""
        if key in above:
            raise InputError(f"{self.file.path}: its object {key[1]!r} contains itself; export it again")
        if key not in self.faces:
            found = self.object(key)
            if found.kind in ("support", "solidsupport"):
                self.skipped.add(key)
                self.faces[key] = 0
            else:
                parts = sum(self.count(use.key, (*above, key)) for use in self.components(found))
                self.faces[key] = len(found.triangles) + parts
        return self.faces[key]

    def placed(self, use: Use, rotation: Float64, move: Float64) -> Iterator[tuple[Object, Float64, Float64]]:
        """The objects with triangles of an item or a component, each with its transform of row vectors."""
        waiting = [(use, rotation, move)]
        while waiting:
            here, outer, shift = waiting.pop()
            if not self.faces[here.key]:
                continue
            inner = here.matrix[:3] @ outer
            offset = here.matrix[3] @ outer + shift
            found = self.object(here.key)
            if len(found.triangles):
                yield found, inner, offset
            waiting += [(each, inner, offset) for each in reversed(self.components(found))]

    def surface(self) -> Surface:
        """All objects of the build; of a file without a build, those that are in no other."""
        root = root_of(self.file, self.archive)
        model = self.model(root)
        notes = remove_modifiers(self.file, self.archive, model)
        build = model.build
        if not build:
            used = {use.key for each in model.objects.values() for use in each.components}
            keys = [(root, name) for name in model.objects]
            build = [Use(key, np.eye(4, 3)) for key in keys if key not in used]
        self.file.check_limit(sum(self.count(use.key) for use in build), self.max_faces)
        points, triangles, count = list[Float64](), list[Integers](), 0
        for use in build:
            for each, rotation, move in self.placed(use, np.eye(3), np.zeros(3)):
                if count + len(each.vertices) > 3 * self.max_faces:
                    raise LimitError(
                        f"{self.file.path}: more than {3 * self.max_faces} vertices for {self.max_faces} faces; "
                        "decimate it, or raise `max_faces`"
                    )
                faces = each.triangles
                if faces.max() >= len(each.vertices) or faces.min() < 0:
                    raise self.file.names_missing_vertex(int(faces.max()), len(each.vertices))
                faces = faces[:, ::-1] if np.linalg.det(rotation) < 0 else faces  # mirroring turns it inside out
                points.append(each.vertices @ rotation + move)
                triangles.append(faces + count)
                count += len(each.vertices)
        if not triangles:
            raise self.file.holds_no_faces(sum(len(each.vertices) for each in model.objects.values()))
        return Surface(
            np.concatenate(points),
            np.concatenate(triangles),
            notes=(*notes, *self._notes(root)),
            mm_per_unit=self._unit(model.unit),
        )

    def _unit(self, name: str) -> float:
        if name not in _MM:
            raise InputError(f"{self.file.path}: has the unknown unit {name[:40]!r}; export it again in millimetres")
        return _MM[name]

    def _notes(self, root: str) -> tuple[str, ...]:
        notes = []
        if self.skipped:
            notes.append(f"ignored {counted(len(self.skipped), 'support')}")
        if self.modifiers:
            notes.append(modifiers_note(len(self.modifiers)))
        everything = {(root, number) for number, each in self.models[root].objects.items() if len(each.triangles)}
        left = everything - self.faces.keys() - self.modifiers
        if left:
            notes.append(f"ignored {counted(len(left), 'object')} outside the build")
        lattices = sum(model.lattices for model in self.models.values())
        if lattices:
            notes.append(f"ignored {counted(lattices, 'beam lattice')}")
        return tuple(notes)
