"""Identify mesh files by their first bytes and check their size before any of it is loaded."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import InputError, LimitError
from nmaptool.core.text import listed
from nmaptool.io.meshes.other_formats import other_format, zip_content
from nmaptool.io.opening import read_head
from nmaptool.types.shown import counted

NAMES = {
    "obj": "OBJ",
    "ply": "PLY",
    "stl": "STL",
    "off": "OFF",
    "glb": "GLB",
    "gltf": "glTF",
    "3mf": "3MF",
    "dae": "DAE",
    "usd": "USD",
}
_OTHER_ENDINGS = {"usda": "usd", "usdc": "usd", "usdz": "usd"}
_MARKS = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}
STL_HEADER, STL_FACE = 84, 50
_HEAD = 1 << 16
_CONTROL = re.compile(rb"[\0-\x08\x0e-\x19\x1c-\x1f]")  # 0x1A is allowed: old programs end texts with it
_WEB_PAGE = re.compile(rb"\s*<(!doctype\s+html|html|head|body)\b", re.IGNORECASE)
_MAGIC = {
    "ply": re.compile(rb"ply[ \t]*[\r\n]"),
    "glb": re.compile(rb"glTF"),
    "off": re.compile(rb"(?:\s*#[^\r\n]*[\r\n])*\s*(?:ST)?C?N?4?n?OFF\b"),
    "gltf": re.compile(rb"\s*\{(?=.*\"asset\")", re.DOTALL),
    "stl": re.compile(rb"\s*solid\b(?=[^\0]*\bfacet\b)", re.IGNORECASE),
    "dae": re.compile(rb"\s*<(?=.{0,4096}<?(?:\w+:)?COLLADA\b)", re.DOTALL),
    "usd": re.compile(rb"#usda \d|PXR-USDC"),
}
_BINARY = ("ply", "glb", "usd")
_JSON = re.compile(rb"\s*\{")
_COUNTS = re.compile(rb"(?:\s*#[^\r\n]*[\r\n])*\s*\d+[ \t]+\d+(?:[ \t]+\d+)?[ \t]*[\r\n]")
_OBJ_LINE = re.compile(rb"(?:\A|[\r\n])[ \t]*v[nt]?[ \t]+[-+.\d]")


@dataclass(frozen=True)
class MeshFile:
    """A mesh file that has been identified but not loaded yet.

    Attributes
    ----------
    path : Path
    kind : str
        ``obj``, ``ply``, ``stl``, ``off``, ``glb``, ``gltf``, ``3mf``, ``dae`` or ``usd``.
    head : bytes
        Its first 64 KiB, as `read_bytes` returns them.
    size : int
        In bytes.
    """

    path: Path
    kind: str
    head: bytes
    size: int

    @property
    def is_text(self) -> bool:
        """Whether the file begins as text."""
        return is_text(self.head)

    def read_bytes(self) -> bytes:
        """The whole file; text without a byte order mark, and in UTF-8 if it is UTF-16."""
        return _unmarked(self.path.read_bytes())

    @property
    def damaged(self) -> InputError:
        """The error for a file whose content is not what its format or its header requires."""
        return InputError(f"{self.path}: the {NAMES[self.kind]} file is truncated or damaged; export it again")

    def names_missing_vertex(self, index: int, vertices: int) -> InputError:
        """The error for a face with a missing vertex; ``index`` is counted as in the file."""
        return InputError(
            f"{self.path}: a face refers to vertex {index}, which is missing (vertices: {vertices}); export it again"
        )

    def holds_no_faces(self, points: int) -> InputError:
        """The error for a file of points or lines, or an empty one."""
        if not points:
            return InputError(f"{self.path}: holds no faces; export it again as a surface")
        return InputError(
            f"{self.path}: holds {counted(points, 'point')} and no faces; make a mesh from the points first"
        )

    def check_limit(self, faces: int, max_faces: int) -> None:
        """Refuse more faces than ``max_faces``.

        Raises
        ------
        LimitError
        """
        if faces > max_faces:
            raise LimitError(
                f"{self.path}: {faces} faces, more than the limit of {max_faces}; decimate it, or raise `max_faces`"
            )

    def check_stl_claim(self, max_faces: int) -> int:
        """Return the number of faces that a binary STL declares, once it is known to hold that many.

        Raises
        ------
        InputError
            If it is too short for them; it may be longer, because some programs append colours.
        LimitError
            If there are more than ``max_faces``.
        """
        if self.size < STL_HEADER:
            raise self.damaged
        claimed = _stl_count(self.head)
        if self.size < STL_HEADER + STL_FACE * claimed:
            raise InputError(
                f"{self.path}: the STL file is truncated: it declares {counted(claimed, 'face')} but holds "
                f"{(self.size - STL_HEADER) // STL_FACE}; export or download it again"
            )
        self.check_limit(claimed, max_faces)
        return claimed

    def check_obj_count(self, max_faces: int) -> None:
        """Refuse an OBJ with more than ``max_faces`` face lines, without loading the whole file.

        Raises
        ------
        LimitError
        """
        if self.size < 8 * max_faces:  # bytes of the shortest face, "f 1 2 3", and its line end
            return
        count, last = 0, b"\n"
        with self.path.open("rb") as stream:
            while block := stream.read(1 << 24):
                count += (last + block).count(b"\nf ")
                last = block[-2:]
        self.check_limit(count, max_faces)


def is_text(head: bytes) -> bool:
    """Whether the first 4 KiB hold no control characters other than white space."""
    return _CONTROL.search(head[:4096]) is None


def _unmarked(data: bytes) -> bytes:
    """Text without its byte order mark, and in UTF-8 if it is UTF-16; anything else unchanged."""
    if data[:3] == b"\xef\xbb\xbf":
        return data[3:] if is_text(data[3:4096]) else data
    code = _MARKS.get(data[:2])
    if code is None or not is_text(data[2:4096].decode(code, "ignore").encode("utf-8", "ignore")):
        return data
    return data[2:].decode(code, "ignore").encode("utf-8", "ignore")


def _stl_count(head: bytes) -> int:
    return int.from_bytes(head[80:84], "little")


def _content(head: bytes, size: int) -> str | None:
    """The format that the bytes prove, or None."""
    text = is_text(head)
    for kind, magic in _MAGIC.items():
        if magic.match(head) and (text or kind in _BINARY):
            return kind
    if size > STL_HEADER and size == STL_HEADER + STL_FACE * _stl_count(head):
        return "stl"
    return "obj" if text and _OBJ_LINE.search(head) else None


def _is_possible(ending: str, head: bytes, size: int) -> bool:
    """Whether bytes that prove no format may still be in the format of the extension."""
    if ending == "stl":
        return not is_text(head) or head.lstrip()[:5].lower() == b"solid"
    if ending == "obj":
        return is_text(head) and size > _HEAD  # the vertices may follow a long comment
    if ending == "off":  # the word OFF is optional
        return is_text(head) and _COUNTS.match(head) is not None
    return ending == "gltf" and _JSON.match(head) is not None


def identify_mesh_file(path: Path) -> MeshFile:
    """Identify a mesh file by its extension and its bytes.

    Raises
    ------
    InputError
        If the file is missing or empty, is a folder or a device, is not in a supported format, or has the extension
        of another format.
    """
    head, size = read_head(path, _HEAD, "a mesh file", "save the mesh as a file")
    head = _unmarked(head)
    written = path.suffix.lower()[1:]
    ending = _OTHER_ENDINGS.get(written, written)
    kind, said = _content(head, size), None
    if kind is None and head.startswith(b"PK\x03\x04"):
        kind, said = zip_content(path)
    if kind is not None and kind != ending:
        right = path.with_suffix(f".{'usdz' if kind == 'usd' and said == '' else kind}").name
        raise InputError(f"{path}: holds {NAMES[kind]} data; rename it to {right}")
    if _WEB_PAGE.match(head):
        raise InputError(f"{path}: holds a web page instead of a mesh; download the mesh itself")
    said = said or (None if kind else other_format(ending, head))
    if said:
        raise InputError(f"{path}: {said}")
    accepted = listed(NAMES.values(), "or")
    if ending not in NAMES:
        raise InputError(f"{path}: is not a mesh in a supported format; export it as {accepted}")
    if kind is None and not _is_possible(ending, head, size):
        raise InputError(f"{path}: holds no {NAMES[ending]} data; export it again as {accepted}")
    return MeshFile(path, ending, head, size)
