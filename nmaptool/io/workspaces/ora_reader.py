"""Read OpenRaster files from Krita, GIMP, MyPaint and nmaptool."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import Any

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.interruption import UNFINISHED
from nmaptool.io.pictures.png import SIGNATURE
from nmaptool.io.pictures.reader import read_image
from nmaptool.io.pictures.size_limit import check_size
from nmaptool.io.workspaces import metadata as metadata
from nmaptool.io.workspaces.limits import Budget
from nmaptool.io.workspaces.ora_archive import OraArchive
from nmaptool.io.workspaces.ora_writer import METADATA_FILE, MIMETYPE
from nmaptool.io.workspaces.pages import four_channels, grey_channel
from nmaptool.io.workspaces.plain_xml import Element, parse_xml
from nmaptool.types.picture import Frame, RasterImage
from nmaptool.types.workspace import (
    MASK_SUFFIX,
    NORMAL_BLEND,
    PASS_THROUGH,
    Workspace,
    WorkspaceGroup,
    WorkspaceLayer,
    WorkspaceMask,
)

_LARGEST_LIST = 4_000_000
_LARGEST_METADATA = 16_000_000
_FURTHEST = 1_000_000


def read_ora(path: Path, max_megapixels: float) -> Workspace:
    """Read the layers of an OpenRaster file.

    Raises
    ------
    InputError
        If it is damaged, has entries that no editor writes, or has no pixel layer.
    LimitError
        If the canvas or all layers together are over ``max_megapixels``.
    """
    with OraArchive(path, max_megapixels) as archive:
        if "mimetype" in archive and archive.read("mimetype", 4096).strip() != MIMETYPE.encode("ascii"):
            raise InputError(f"{path}: is a ZIP archive but not an OpenRaster file; save it as ORA, PSD or TIFF")
        if "stack.xml" not in archive:
            raise InputError(f"{path}: is a ZIP archive without stack.xml, not an OpenRaster file; save it as ORA")
        root = parse_xml(archive.read("stack.xml", _LARGEST_LIST), f"{path}: stack.xml")
        if root.tag != "image":
            raise archive.damaged()
        cols, rows = (_whole(root, key, archive, 1) for key in ("w", "h"))
        check_size(path, cols, rows, max_megapixels)
        own = metadata.from_json(archive.read(METADATA_FILE, _LARGEST_METADATA)) if METADATA_FILE in archive else None
        with UNFINISHED.temporary_folder() as folder:
            found = _Layers(archive, max_megapixels, folder / "picture.png")
            for child in root.children:
                if child.tag == "stack":
                    found.check(child, 0)
            for child in root.children:
                if child.tag == "stack":
                    found.walk(child, ())
    layers = tuple(reversed(found.layers))
    if not layers:
        raise InputError(f"{path}: has no pixel layer; draw or paste one first")
    return Workspace(
        frame=Frame(rows, cols, metadata.pitch_in(own)),
        layers=layers,
        bits=max(found.bits),
        name=str(path),
        metadata=own,
        color_profile=found.profile,
        skipped=tuple(reversed(found.skipped)),
    )


def _whole(element: Element, key: str, archive: OraArchive, least: int = -_FURTHEST) -> int:
    """A whole number, which some editors write as ``12.0``."""
    try:
        value = float(element.attributes.get(key, "0"))
    except ValueError:
        raise archive.damaged() from None
    if not (math.isfinite(value) and least <= value <= _FURTHEST):
        raise InputError(f"{archive.path}: stack.xml has {key}={value:g}, which is out of range; save it again")
    return round(value)


def _share(element: Element, key: str, archive: OraArchive) -> float:
    try:
        value = float(element.attributes.get(key, "1"))
    except ValueError:
        raise archive.damaged() from None
    if not math.isfinite(value):
        raise archive.damaged()
    return min(max(value, 0.0), 1.0)


def _label(element: Element) -> str:
    return element.attributes.get("name", "")


class _Layers:
    """Layers top to bottom, as in stack.xml; a hidden ``NAME [mask]`` becomes the mask of the layer ``NAME`` below."""

    def __init__(self, archive: OraArchive, max_megapixels: float, picture: Path) -> None:
        self.archive, self.limit, self.picture = archive, max_megapixels, picture
        self.budget = Budget(archive.path, max_megapixels)
        self.layers: list[WorkspaceLayer] = []
        self.skipped: list[tuple[str, str]] = []
        self.bits: list[int] = []
        self.profile: str | None = None
        self._count = 0
        self._masks: dict[str, Element] = {}

    def check(self, stack: Element, depth: int) -> None:
        """Add up the sizes that all layers declare, before the first is decoded."""
        self.budget.check_depth(depth)
        for child in stack.children:
            if child.tag == "stack":
                self.check(child, depth + 1)
            elif child.tag == "layer" and self._source(child) is not None:
                self._count += 1
                self.budget.check_count(self._count)
                self.budget.add(_label(child), *self._claim(child))

    def _source(self, element: Element) -> str | None:
        source = element.attributes.get("src", "")
        return source if source.lower().endswith(".png") else None

    def _claim(self, element: Element) -> tuple[int, int]:
        head = self.archive.read(element.attributes["src"], head=26)
        if len(head) < 26 or not head.startswith(SIGNATURE) or head[12:16] != b"IHDR":
            raise self.archive.damaged()
        cols, rows = struct.unpack_from(">II", head, 16)
        return cols, rows

    def walk(self, stack: Element, groups: tuple[WorkspaceGroup, ...]) -> None:
        """Read every layer."""
        for child in stack.children:
            if child.tag == "stack":
                self._masks.clear()
                self.walk(child, (*groups, self._group(child)))
                self._masks.clear()
            elif child.tag == "layer":
                self._take(child, groups)
            elif child.tag in ("text", "filter"):
                self.skipped.append((_label(child), f"{child.tag} layer"))
        for mask in self._masks.values():  # masks whose layer is gone
            self.skipped.append((_label(mask), "mask without its layer"))
        self._masks.clear()

    def _take(self, element: Element, groups: tuple[WorkspaceGroup, ...]) -> None:
        if self._source(element) is None:
            kind = Path(element.attributes.get("src", "")).suffix or "empty"
            self.skipped.append((_label(element), f"layer with {kind} source"))
            return
        name = _label(element)
        if name.endswith(MASK_SUFFIX) and element.attributes.get("visibility") == "hidden":
            self._masks[name.removesuffix(MASK_SUFFIX)] = element
            return
        image = self._image(element)
        mask = self._masks.pop(name, None)
        self.bits.append(image.bits)
        if image.color_chunks and self.profile is None:
            self.profile = ", ".join(image.color_chunks)
        self.layers.append(
            WorkspaceLayer(
                name=name,
                pixels=four_channels(image),
                left=_whole(element, "x", self.archive),
                top=_whole(element, "y", self.archive),
                visible=element.attributes.get("visibility", "visible") != "hidden",
                opacity=_share(element, "opacity", self.archive),
                blend_mode=metadata.from_ora_mode(element.attributes.get("composite-op", "")),
                mask=None if mask is None else self._mask(mask),
                groups=groups,
                facts=_own(element),
            )
        )

    def _image(self, element: Element) -> RasterImage:
        source = element.attributes["src"]
        shown = "".join(c if c.isprintable() else "?" for c in source[:80])
        self.picture.write_bytes(self.archive.read(source))
        try:
            return read_image(self.picture, max_megapixels=self.limit)
        except (InputError, LimitError) as error:
            raise type(error)(str(error).replace(str(self.picture), f"{self.archive.path}: {shown}")) from None

    def _mask(self, element: Element) -> WorkspaceMask:
        grey = grey_channel(self._image(element))
        outside = _share(element, "nmaptool-outside", self.archive) if "nmaptool-outside" in element.attributes else 0.0
        enabled = element.attributes.get("nmaptool-enabled", "1") != "0"
        left, top = _whole(element, "x", self.archive), _whole(element, "y", self.archive)
        return WorkspaceMask(grey, left, top, outside, enabled)

    def _group(self, element: Element) -> WorkspaceGroup:
        through = element.attributes.get("isolation") == "auto"
        mode = metadata.from_ora_mode(element.attributes.get("composite-op", ""))
        return WorkspaceGroup(
            _label(element),
            element.attributes.get("visibility", "visible") != "hidden",
            _share(element, "opacity", self.archive),
            PASS_THROUGH if through and mode == NORMAL_BLEND else mode,
        )


def _own(element: Element) -> dict[str, Any]:
    """Mode and strength from nmaptool's attributes of a layer."""
    found: dict[str, Any] = {}
    mode, strength = element.attributes.get("nmaptool-mode"), element.attributes.get("nmaptool-strength")
    if mode is not None:
        found["mode"] = mode
    if strength is not None:
        try:
            found["strength"] = float(strength)
        except ValueError:
            return found
    return found
