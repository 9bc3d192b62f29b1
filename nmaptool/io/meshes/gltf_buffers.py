"""Buffers of a glTF: the binary part of a GLB, ``data:`` URIs, and files in the folder of the glTF."""

from __future__ import annotations

import base64
import binascii
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile

COMPRESSED = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
}
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")


def whole_number(value: Any) -> int:
    """Return the value if it is a whole number of at least 0.

    Raises
    ------
    ValueError
        If the value is anything else.
    """
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError
    return value


def is_compressed(file: MeshFile, method: str) -> InputError:
    """The error for a mesh compressed by a method that cannot be read."""
    copied = "" if file.kind == "gltf" else ", such as by gltf-transform cp OLD.glb NEW.glb"
    return InputError(f"{file.path}: is compressed with {method}; export it again without compression{copied}")


@dataclass
class Buffers:
    """The buffers of a glTF, each checked at once and loaded when it is used.

    Attributes
    ----------
    file : MeshFile
    sizes : list of int
        Bytes that each buffer is known to hold.
    """

    file: MeshFile
    sizes: list[int]
    _sources: list[bytes | Path]
    _loaded: dict[Path, bytes] = field(default_factory=dict)

    @classmethod
    def of(cls, file: MeshFile, listed: Any, own: bytes | None) -> Buffers:
        """Check the buffers that the JSON lists; ``own`` is the binary part of a GLB.

        Raises
        ------
        InputError
            If a buffer is missing, too short, compressed, or not in the folder of the file.
        """
        sources = [_source(file, buffer, own if i == 0 else None) for i, buffer in enumerate(listed)]
        sizes = [len(s) if isinstance(s, bytes) else s.stat().st_size for s in sources]
        for buffer, source, size in zip(listed, sources, sizes, strict=True):
            declared = whole_number(buffer["byteLength"])
            if size < declared and isinstance(source, Path):
                raise InputError(
                    f"{file.path}: {source.name} is truncated: it should hold {declared} bytes but holds {size}; "
                    "export or download it again"
                )
            if size < declared:
                raise file.damaged
        return cls(file, sizes, sources)

    @property
    def total(self) -> int:
        """Bytes of all buffers and of the file itself."""
        return sum(self.sizes) + self.file.size

    def __getitem__(self, index: int) -> bytes:
        """The bytes of a buffer."""
        source = self._sources[index]
        if isinstance(source, bytes):
            return source
        if source not in self._loaded:
            self._loaded[source] = source.read_bytes()
        if len(self._loaded[source]) < self.sizes[index]:  # changed while we read
            raise self.file.damaged
        return self._loaded[source]


def _source(file: MeshFile, buffer: dict[str, Any], own: bytes | None) -> bytes | Path:
    uri = buffer.get("uri")
    if uri is None:
        if own is None:
            for name in COMPRESSED.keys() & set(buffer.get("extensions", {})):
                raise is_compressed(file, COMPRESSED[name])
            raise file.damaged
        return own
    if isinstance(uri, str) and uri[:5].lower() == "data:":
        head, _, text = uri.partition(",")
        if not head.endswith(";base64"):
            raise file.damaged
        try:
            return base64.b64decode(text, validate=True)
        except binascii.Error:
            raise file.damaged from None
    return _beside(file, uri)


def _beside(file: MeshFile, uri: Any) -> Path:
    """The file with a relative name in the folder of the glTF; nothing else is ever opened.

    Raises
    ------
    InputError
        If the name leads out of the folder, or there is no such file.
    """
    if not isinstance(uri, str) or not uri:
        raise file.damaged
    shown = repr(uri if len(uri) < 80 else f"{uri[:77]}...")
    folder = file.path.parent.resolve()
    for name in (unquote(uri), uri):
        parts = re.split(r"[/\\]", name)
        if _SCHEME.match(name) or not parts[0] or ".." in parts or "\0" in name:
            break
        try:
            target = folder.joinpath(*parts).resolve()
            is_file = target.is_file()
        except (OSError, ValueError):
            continue
        if not target.is_relative_to(folder):  # by a link
            break
        if is_file:
            return target
    else:
        raise InputError(
            f"{file.path}: needs the file {shown} beside it, which is missing; put it there, or export one GLB file"
        )
    raise InputError(
        f"{file.path}: needs {shown}, but only files in its own folder are opened; put all in one folder, or export "
        "one GLB file"
    )
