"""Read Photoshop documents: PSD and PSB, 8, 16 and 32 bits, groups, masks, hidden layers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from psd_tools.constants import ChannelID, Clipping, Resource, SectionDivider, Tag
from psd_tools.psd import PSD
from psd_tools.psd.layer_and_mask import ChannelData, LayerRecord

from nmaptool.core.errors import InputError
from nmaptool.io.workspaces import metadata as metadata
from nmaptool.io.workspaces.limits import Budget
from nmaptool.io.workspaces.pages import masks_joined
from nmaptool.io.workspaces.psd_document import check_end, check_header, damaged, explain_damage, layer_records, parse
from nmaptool.types.picture import Frame
from nmaptool.types.workspace import Workspace, WorkspaceGroup, WorkspaceLayer, WorkspaceMask

_TEXT = (Tag.TYPE_TOOL_OBJECT_SETTING, Tag.TYPE_TOOL_INFO)
_SHAPE = (Tag.VECTOR_STROKE_DATA, Tag.VECTOR_STROKE_CONTENT_DATA, Tag.VECTOR_ORIGINATION_DATA)
_FILL = (Tag.SOLID_COLOR_SHEET_SETTING, Tag.GRADIENT_FILL_SETTING, Tag.PATTERN_FILL_SETTING)
_ADJUSTMENT = (
    *(Tag.BLACK_AND_WHITE, Tag.BRIGHTNESS_AND_CONTRAST, Tag.CHANNEL_MIXER, Tag.COLOR_BALANCE, Tag.COLOR_LOOKUP),
    *(Tag.CURVES, Tag.EXPOSURE, Tag.GRADIENT_MAP, Tag.HUE_SATURATION, Tag.HUE_SATURATION_V4, Tag.INVERT, Tag.LEVELS),
    *(Tag.PHOTO_FILTER, Tag.POSTERIZE, Tag.SELECTIVE_COLOR, Tag.THRESHOLD, Tag.VIBRANCE),
)
_EFFECTS = (Tag.EFFECTS_LAYER, Tag.OBJECT_BASED_EFFECTS_LAYER_INFO, Tag.OBJECT_BASED_EFFECTS_LAYER_INFO_V0)


def read_psd(path: Path, max_megapixels: float) -> Workspace:
    """Read the layers of a PSD or PSB.

    Raises
    ------
    InputError
        If it is damaged, not RGB, or has no pixel layer.
    LimitError
        If the canvas or all layers together are over ``max_megapixels``.
    """
    header = check_header(path, max_megapixels)
    with explain_damage(path):
        return _workspace(path, parse(path), header, max_megapixels)


def _workspace(path: Path, document: PSD, header: tuple[int, int, int], max_megapixels: float) -> Workspace:
    rows, cols, depth = header
    resources = document.image_resources
    own = metadata.from_xmp(_bytes(resources.get_data(Resource.XMP_METADATA)))
    profile = _bytes(resources.get_data(Resource.ICC_PROFILE))
    budget = Budget(path, max_megapixels)
    records, channels = layer_records(document)
    check_end(path, document, header)
    found = _Layers(path, depth, document.header.version, budget)
    found.read(records, channels)
    if not records:
        found.layers.append(_merged(document, depth))
    if not found.layers:
        what = ", ".join(f"{name} ({kind})" for name, kind in found.skipped[:5])
        raise InputError(f"{path}: has no pixel layer{f', only {what}' if what else ''}; rasterise a layer first")
    return Workspace(
        frame=Frame(rows, cols, metadata.pitch_in(own)),
        layers=tuple(found.layers),
        bits=depth,
        name=str(path),
        metadata=own,
        color_profile=metadata.profile_name(profile) if profile else None,
        skipped=tuple(found.skipped),
    )


def _bytes(value: Any) -> bytes:
    return value if isinstance(value, bytes) else b""


class _Layers:
    """Turns records, bottom to top, into layers and groups; the record of a group comes after its members."""

    def __init__(self, path: Path, depth: int, version: int, budget: Budget) -> None:
        self.path, self.depth, self.version, self.budget = path, depth, version, budget
        self.layers: list[WorkspaceLayer] = []
        self.skipped: list[tuple[str, str]] = []

    def read(self, records: list[LayerRecord], channels: list[Any]) -> None:
        """Read all records; sizes are checked before the first channel is decoded."""
        if len(channels) < len(records):
            raise damaged(self.path)
        self.budget.check_count(len(records))
        for record in records:
            if _kind(record) == "pixels":
                self.budget.add(_name(record), record.width, record.height)
                if record.mask_data is not None:
                    self.budget.add(_name(record), record.mask_data.width, record.mask_data.height)
        inside: list[WorkspaceGroup] = []
        # from the top down, a group's record comes before its members
        for record, planes in zip(reversed(records), reversed(channels), strict=False):
            kind = _kind(record)
            if kind == "group":
                inside.append(_group(record))
                self.budget.check_depth(len(inside))
            elif kind == "end":
                if inside:
                    inside.pop()
            elif kind == "pixels":
                self.layers.append(self._layer(record, list(planes), tuple(inside)))
            else:
                self.skipped.append((_name(record), kind))
        self.layers = masks_joined(list(reversed(self.layers)))
        self.skipped.reverse()

    def _layer(
        self, record: LayerRecord, planes: list[ChannelData], groups: tuple[WorkspaceGroup, ...]
    ) -> WorkspaceLayer:
        by_id = {info.id: plane for info, plane in zip(record.channel_info, planes, strict=False)}
        rows, cols = record.height, record.width
        color = (0, 1, 2) if all(i in by_id for i in (1, 2)) else (0, 0, 0)  # Krita writes grey layers with one channel
        if 0 not in by_id:
            raise damaged(self.path)
        stack = [self._plane(by_id[ChannelID(i)], rows, cols) for i in color]
        clear = by_id.get(ChannelID.TRANSPARENCY_MASK)
        top = 1 if self.depth == 32 else (1 << self.depth) - 1
        stack.append(np.full((rows, cols), top, stack[0].dtype) if clear is None else self._plane(clear, rows, cols))
        fill = record.tagged_blocks.get_data(Tag.BLEND_FILL_OPACITY, 255)
        share = fill / 255 if isinstance(fill, int) and 0 <= fill <= 255 else 1.0
        return WorkspaceLayer(
            name=_name(record),
            pixels=np.dstack(stack),
            left=record.left,
            top=record.top,
            visible=record.flags.visible,
            opacity=record.opacity / 255 * share,
            blend_mode=metadata.from_psd_mode(record.blend_mode.value),
            mask=self._mask(record, by_id),
            groups=groups,
            facts={"not_kept": _not_kept(record)},
        )

    def _mask(self, record: LayerRecord, by_id: dict[ChannelID, ChannelData]) -> WorkspaceMask | None:
        data, plane = record.mask_data, by_id.get(ChannelID.USER_LAYER_MASK)
        if data is None or plane is None:
            return None
        left, top = data.left, data.top
        if data.flags.pos_relative_to_layer:
            left, top = left + record.left, top + record.top
        outside = data.background_color / 255
        if data.width < 1 or data.height < 1:
            values: NDArray[Any] = np.full((1, 1), data.background_color, np.uint8)
            return WorkspaceMask(values, record.left, record.top, outside, not data.flags.mask_disabled)
        values = self._plane(plane, data.height, data.width)
        return WorkspaceMask(values, left, top, outside, not data.flags.mask_disabled)

    def _plane(self, plane: ChannelData, rows: int, cols: int) -> NDArray[Any]:
        limit = rows * cols * self.depth // 8
        raw = plane.get_data(cols, rows, self.depth, self.version, max_output_bytes=limit)
        return _native(raw, self.depth).reshape(rows, cols)


def _native(raw: bytes, depth: int) -> NDArray[Any]:
    stored = {8: ">u1", 16: ">u2", 32: ">f4"}[depth]
    values = np.frombuffer(raw, stored)
    return values.astype(values.dtype.newbyteorder("="))


def _merged(document: PSD, depth: int) -> WorkspaceLayer:
    """The picture of a document without layers, as a layer."""
    header = document.header
    if header.channels < 3:
        raise ValueError("an RGB picture has three channels")
    limit = header.width * header.height * header.channels * depth // 8
    raw = document.image_data.get_data(header, split=False, max_output_bytes=limit)
    assert isinstance(raw, bytes)
    planes = _native(raw, depth).reshape(header.channels, header.height, header.width)
    top = 1 if depth == 32 else (1 << depth) - 1
    alpha = planes[3] if header.channels > 3 else np.full(planes[0].shape, top, planes.dtype)
    return WorkspaceLayer("Background", np.dstack([*planes[:3], alpha]), facts={"flattened": True})


def _name(record: LayerRecord) -> str:
    full = record.tagged_blocks.get_data(Tag.UNICODE_LAYER_NAME)
    return str(full if isinstance(full, str) and full else record.name).strip("\0")


def _kind(record: LayerRecord) -> str:
    """``pixels``, ``group``, ``end`` of a group, or the name of a kind of layer that cannot be read."""
    blocks = record.tagged_blocks
    for tag in (Tag.SECTION_DIVIDER_SETTING, Tag.NESTED_SECTION_DIVIDER_SETTING):
        setting = blocks.get_data(tag)
        if setting is not None and setting.kind != SectionDivider.OTHER:
            return "end" if setting.kind == SectionDivider.BOUNDING_SECTION_DIVIDER else "group"
    for tags, what in ((_TEXT, "text layer"), (_ADJUSTMENT, "adjustment layer"), (_SHAPE, "shape layer")):
        if any(tag in blocks for tag in tags):
            return what
    if any(tag in blocks for tag in _FILL):
        return "fill layer"
    return "pixels" if record.width > 0 and record.height > 0 else "empty layer"


def _not_kept(record: LayerRecord) -> list[str]:
    """Features of a layer that an editor shows but its pixels do not hold."""
    found = []
    if record.clipping == Clipping.NON_BASE:
        found.append("clipping to the layer below")
    if any(tag in record.tagged_blocks for tag in _EFFECTS):
        found.append("layer effects")
    if any(tag in record.tagged_blocks for tag in (Tag.VECTOR_MASK_SETTING1, Tag.VECTOR_MASK_SETTING2)):
        found.append("a vector mask")
    return found


def _group(record: LayerRecord) -> WorkspaceGroup:
    mode = record.blend_mode.value
    setting = record.tagged_blocks.get_data(Tag.SECTION_DIVIDER_SETTING)
    if setting is not None and setting.blend_mode is not None:
        mode = setting.blend_mode.value
    return WorkspaceGroup(_name(record), record.flags.visible, record.opacity / 255, metadata.from_psd_mode(mode))
