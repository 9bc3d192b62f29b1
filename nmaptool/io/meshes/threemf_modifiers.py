"""Volumes of a 3MF that slicers use to change settings or to cut material away, and that are no surface of the model.

PrusaSlicer and its relatives store all volumes of an object in one mesh; a list beside the model says which triangles
belong to which. Bambu Studio and OrcaSlicer give such volumes the type "other" instead.
"""

from __future__ import annotations

import re
import zipfile

import numpy as np

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.headers import MeshFile
from nmaptool.io.meshes.threemf_model import Model, parse_xml

_LIST = re.compile(r"Metadata/\w+_model\.config")
_LARGEST_LIST = 1 << 24  # bytes; settings of each volume
_Range = tuple[int, int]


def remove_modifiers(file: MeshFile, archive: zipfile.ZipFile, model: Model) -> tuple[str, ...]:
    """Remove the triangles of such volumes from a model, in place, and return notes about that."""
    name = next((name for name in archive.namelist() if _LIST.fullmatch(name)), None)
    if name is None:
        return ()
    try:
        found = _ranges(file, archive, name)
    except InputError:
        return (f"did not read {name}, which tells modifiers from parts: the mesh may hold both",)
    count = 0
    for number, ranges in found.items():
        part = model.objects.get(number)
        if part is None:
            continue
        keep = np.ones(len(part.triangles), bool)
        for first, last in ranges:
            count += first < len(keep)
            keep[first : last + 1] = False
        part.triangles = part.triangles[keep]
    return (modifiers_note(count),) if count else ()


def modifiers_note(count: int) -> str:
    """The note about modifiers that were left out."""
    only = "volume that only modifies" if count == 1 else "volumes that only modify"
    return f"ignored {count} {only} others in a slicer"


def _ranges(file: MeshFile, archive: zipfile.ZipFile, name: str) -> dict[str, list[_Range]]:
    """First and last triangle of each volume that is not a part of the model, by the number of its object."""
    if archive.getinfo(name).file_size > _LARGEST_LIST:
        raise file.damaged
    found: dict[str, list[_Range]] = {}
    number, place, is_part = "", (0, -1), True

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal number, place, is_part
        if tag == "object":
            number = attributes["id"]
        elif tag == "volume":
            place, is_part = (int(attributes["firstid"]), int(attributes["lastid"])), True
            if place[0] < 0:
                raise ValueError
        elif tag == "metadata" and attributes.get("key") == "volume_type":
            is_part = attributes.get("value") == "ModelPart"
        elif tag == "metadata" and attributes.get("key") == "modifier":  # of older versions
            is_part = is_part and attributes.get("value") != "1"

    def end(tag: str) -> None:
        if tag == "volume" and not is_part:
            found.setdefault(number, []).append(place)

    with archive.open(name) as stream:
        parse_xml(file, name, stream, start, end)
    return found
