"""3MF: millimetres, a title, a thumbnail, and one object for each body."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO

from nmaptool.io.compression import LEVEL_OF_3MF
from nmaptool.io.solids.text import decimals_as_text, wholes_as_text, words_of
from nmaptool.types.solid import NumberedBody, Solid

MODEL_PATH = "3D/3dmodel.model"
_THUMBNAIL_PATH = "Metadata/thumbnail.png"
_MODEL_KIND = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_XML = '<?xml version="1.0" encoding="UTF-8"?>\n'
VERTEX = words_of('<vertex x="#" y="#" z="#"/>\n')
TRIANGLE = words_of('<triangle v1="#" v2="#" v3="#"/>\n')


def write_3mf(solid: Solid, path: Path, metadata: Mapping[str, str], thumbnail_png: bytes = b"") -> None:
    """Write every body as an object of a 3MF file in mm.

    Parameters
    ----------
    solid : Solid
    path : Path
    metadata : mapping of str to str
        Such as ``Title`` and ``Application``.
    thumbnail_png : bytes
        A picture for file managers and slicers; none if empty.
    """
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL_OF_3MF) as archive:
        _add(archive, "[Content_Types].xml", _content_types().encode())
        _add(archive, "_rels/.rels", _relations(bool(thumbnail_png)).encode())
        if thumbnail_png:
            _add(archive, _THUMBNAIL_PATH, thumbnail_png)
        with _entry(archive, MODEL_PATH) as file:
            _write_model(file, solid, metadata)


def _entry(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    """An entry without the time of writing, so that the same relief gives the same bytes."""
    return archive.open(name, "w", force_zip64=name == MODEL_PATH)


def _add(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    with _entry(archive, name) as file:
        file.write(data)


def _write_model(file: IO[bytes], solid: Solid, metadata: Mapping[str, str]) -> None:
    from xml.sax.saxutils import escape, quoteattr  # loads the network modules of Python

    facts = "".join(f"<metadata name={quoteattr(key)}>{escape(value)}</metadata>\n" for key, value in metadata.items())
    file.write(f'{_XML}<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">\n{facts}<resources>\n'.encode())
    for number, body in enumerate(solid.bodies, start=1):
        numbered = NumberedBody.of(body)
        file.write(f'<object id="{number}" name={quoteattr(body.name)} type="model"><mesh><vertices>\n'.encode())
        for vertices in numbered.vertices():
            file.writelines(decimals_as_text(vertices, VERTEX))
        file.write(b"</vertices><triangles>\n")
        for faces in numbered.faces():
            file.writelines(wholes_as_text(faces, TRIANGLE))
        file.write(b"</triangles></mesh></object>\n")
    items = "".join(f'<item objectid="{number}"/>' for number in range(1, len(solid.bodies) + 1))
    file.write(f"</resources>\n<build>{items}</build>\n</model>\n".encode())


def _content_types() -> str:
    kinds = {
        "rels": "application/vnd.openxmlformats-package.relationships+xml",
        "model": "application/vnd.ms-package.3dmanufacturing-3dmodel+xml",
        "png": "image/png",
    }
    entries = "".join(f'<Default Extension="{ending}" ContentType="{kind}"/>' for ending, kind in kinds.items())
    return f'{_XML}<Types xmlns="{_PACKAGE}/content-types">{entries}</Types>'


def _relations(has_thumbnail: bool) -> str:
    targets = {"model": (f"/{MODEL_PATH}", _MODEL_KIND)}
    if has_thumbnail:
        targets["thumbnail"] = (f"/{_THUMBNAIL_PATH}", f"{_PACKAGE}/relationships/metadata/thumbnail")
    entries = "".join(
        f'<Relationship Target="{target}" Id="{name}" Type="{kind}"/>' for name, (target, kind) in targets.items()
    )
    return f'{_XML}<Relationships xmlns="{_PACKAGE}/relationships">{entries}</Relationships>'
