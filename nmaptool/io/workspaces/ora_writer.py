"""Write workspaces as OpenRaster: a ZIP archive of PNGs and a list of them."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import OutputError
from nmaptool.io.interruption import UNFINISHED
from nmaptool.io.pictures.writer import write_image
from nmaptool.io.workspaces import metadata as metadata
from nmaptool.types.workspace import MASK_SUFFIX, PASS_THROUGH, Workspace, WorkspaceGroup, WorkspaceLayer
from nmaptool.workspace.flatten import flattened

MIMETYPE = "image/openraster"
METADATA_FILE = "nmaptool.json"
_THUMBNAIL_PX = 256
_EPOCH = (1980, 1, 1, 0, 0, 0)  # so that the same workspace always gives the same file


def write_ora(workspace: Workspace, path: Path) -> None:
    """Write an OpenRaster file; a layer's mask is a hidden grey layer above it, called ``NAME [mask]``.

    Raises
    ------
    OutputError
        If a picture in it cannot be written.
    """
    with zipfile.ZipFile(path, "w") as archive, UNFINISHED.temporary_folder() as folder:
        _add(archive, "mimetype", MIMETYPE.encode("ascii"))
        picture = folder / "picture.png"

        def add_png(name: str, pixels: NDArray[Any]) -> None:
            count = pixels.shape[2]
            try:
                write_image(pixels, picture, ("R", "G", "B", "A") if count == 4 else ("Y",), {})
            except OutputError as error:
                raise OutputError(str(error).replace(str(picture), str(path))) from None
            _add(archive, name, picture.read_bytes())

        stack = []
        for number, layer in enumerate(workspace.layers):
            add_png(f"data/layer{number:03}.png", layer.pixels)
            if layer.mask is not None:
                add_png(f"data/mask{number:03}.png", layer.mask.values[..., None])
            stack.append(_entries(number, layer))
        merged = _codes(flattened(workspace), workspace.bits)
        add_png("mergedimage.png", merged)
        add_png("Thumbnails/thumbnail.png", _thumbnail(merged))
        if workspace.metadata is not None:
            _add(archive, METADATA_FILE, metadata.to_json(workspace.metadata).encode("utf-8"))
        _add(archive, "stack.xml", _stack_xml(workspace, stack).encode("utf-8"))


def _add(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    """Store without compression: the PNGs are compressed already, and the mimetype must be plain."""
    archive.writestr(zipfile.ZipInfo(name, _EPOCH), data, zipfile.ZIP_STORED)


def _codes(shares: NDArray[np.float32], bits: int) -> NDArray[Any]:
    top = (1 << bits) - 1
    codes: NDArray[Any] = np.floor(shares * np.float32(top) + np.float32(0.5)).clip(0, top)
    return codes.astype(np.uint8 if bits == 8 else np.uint16)


def _thumbnail(merged: NDArray[Any]) -> NDArray[Any]:
    import cv2

    rows, cols = merged.shape[:2]
    factor = min(1.0, _THUMBNAIL_PX / max(rows, cols))
    size = (max(1, round(cols * factor)), max(1, round(rows * factor)))
    small = cv2.resize(merged.astype(np.float32) / np.iinfo(merged.dtype).max, size, interpolation=cv2.INTER_AREA)
    return _codes(np.asarray(small, np.float32), 8)


def _attributes(**values: object) -> str:
    return " ".join(f"{name.replace('_', '-')}={quoteattr(str(value))}" for name, value in values.items())


def _entries(number: int, layer: WorkspaceLayer) -> str:
    """The lines of one layer, its mask above it."""
    own = {f"nmaptool_{key}": layer.facts[key] for key in ("mode", "strength") if key in layer.facts}
    line = _attributes(
        name=layer.name,
        src=f"data/layer{number:03}.png",
        x=layer.left,
        y=layer.top,
        opacity=f"{layer.opacity:.6g}",
        visibility="visible" if layer.visible else "hidden",
        composite_op=metadata.ora_mode(layer.blend_mode),
        **own,
    )
    entry = f"<layer {line}/>"
    if layer.mask is None:
        return entry
    place = _attributes(
        name=layer.name + MASK_SUFFIX,
        src=f"data/mask{number:03}.png",
        x=layer.mask.left,
        y=layer.mask.top,
        opacity=1,
        visibility="hidden",
        composite_op="svg:src-over",
        nmaptool_outside=f"{layer.mask.outside:g}",
        nmaptool_enabled=int(layer.mask.enabled),
    )
    return f"<layer {place}/>\n{entry}"


def _stack_xml(workspace: Workspace, entries: list[str]) -> str:
    """The list of layers, topmost first."""
    frame = workspace.frame
    dpi = round(25.4 / frame.pitch_mm) if frame.pitch_mm else 72
    lines = ["<?xml version='1.0' encoding='UTF-8'?>"]
    size = _attributes(version="0.0.5", w=frame.cols, h=frame.rows, xres=max(dpi, 1), yres=max(dpi, 1))
    lines.append(f"<image {size}>\n<stack>")
    lines.extend(_nested(workspace, entries))
    return "\n".join([*lines, "</stack>\n</image>\n"])


def _nested(workspace: Workspace, entries: list[str]) -> Iterator[str]:
    opened: list[WorkspaceGroup] = []
    for layer, entry in zip(reversed(workspace.layers), reversed(entries), strict=True):
        shared = 0
        while shared < min(len(opened), len(layer.groups)) and opened[shared] is layer.groups[shared]:
            shared += 1
        yield from ["</stack>"] * (len(opened) - shared)
        del opened[shared:]
        for group in layer.groups[shared:]:
            opened.append(group)
            through = group.blend_mode == PASS_THROUGH
            line = _attributes(
                name=group.name,
                opacity=f"{group.opacity:.6g}",
                visibility="visible" if group.visible else "hidden",
                composite_op="svg:src-over" if through else metadata.ora_mode(group.blend_mode),
                isolation="auto" if through else "isolate",
            )
            yield f"<stack {line}>"
        yield entry
    yield from ["</stack>"] * len(opened)
