"""3MF archives made by hand, so that a test's own fault is the only one in the file."""

from __future__ import annotations

import io
import zipfile
from typing import Any

from mesh_files import FACES, VERTICES

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/'
    'relationships"><Relationship Target="/3D/{root}" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/'
    '2013/01/3dmodel"/></Relationships>'
)


def mesh_xml(vertices: Any = VERTICES, faces: Any = FACES) -> str:
    """The mesh of an object."""
    points = "".join(f'<vertex x="{x:g}" y="{y:g}" z="{z:g}"/>\n' for x, y, z in vertices)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}" pid="5"/>\n' for a, b, c in faces)
    return f"<mesh><vertices>{points}</vertices><triangles>{triangles}</triangles></mesh>"


def object_xml(number: int, content: str = "", kind: str = "model") -> str:
    """An object; a tetrahedron unless other content is given."""
    return f'<object id="{number}" type="{kind}">{content or mesh_xml()}</object>'


def components_xml(*uses: str) -> str:
    """The content of an object that holds others."""
    return f"<components>{''.join(f'<component {use}/>' for use in uses)}</components>"


def model_xml(objects: str = "", items: str = '<item objectid="1"/>', unit: str = "millimeter") -> str:
    """A whole model."""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="{unit}" xml:lang="en-US" xmlns="{CORE}" '
        'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06">\n'
        f"<metadata name='Title'>x</metadata><resources>{objects or object_xml(1)}</resources><build>{items}</build>"
        "</model>"
    )


def threemf(model: str = "", root: str = "3dmodel.model", **parts: str) -> bytes:
    """A 3MF with one model, and further parts by name; one called ``_rels`` replaces the list of relations."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        relations = parts.pop("_rels", RELATIONS.format(root=root))
        if relations:
            archive.writestr("_rels/.rels", relations)
        for name, text in parts.items():
            archive.writestr(name if name.startswith("Metadata/") else f"3D/{name}", text)
        archive.writestr(f"3D/{root}", model or model_xml())
    return stream.getvalue()
