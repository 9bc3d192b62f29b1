"""Write workspaces as Photoshop documents of 8 or 16 bits, built from psd-tools' structures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from psd_tools.constants import BlendMode, ChannelID, ColorMode, Compression, Resource, SectionDivider, Tag
from psd_tools.psd import PSD
from psd_tools.psd.header import FileHeader
from psd_tools.psd.image_data import ImageData
from psd_tools.psd.image_resources import ImageResource, ImageResources
from psd_tools.psd.layer_and_mask import (
    ChannelData,
    ChannelDataList,
    ChannelImageData,
    ChannelInfo,
    LayerAndMaskInformation,
    LayerFlags,
    LayerInfo,
    LayerRecord,
    LayerRecords,
    MaskData,
    MaskFlags,
)
from psd_tools.psd.tagged_blocks import TaggedBlocks

from nmaptool.io.workspaces import metadata as workspace_words
from nmaptool.types.picture import Frame
from nmaptool.types.workspace import Workspace, WorkspaceGroup, WorkspaceLayer, WorkspaceMask
from nmaptool.workspace.flatten import flattened

_LARGEST_PSD_SIDE = 30_000
_LARGEST_PSD_BYTES = 1_500_000_000  # the format's lengths end at 2 GB
_COLOR_CHANNELS = (ChannelID.CHANNEL_0, ChannelID.CHANNEL_1, ChannelID.CHANNEL_2)


def write_psd(workspace: Workspace, path: Path, version: int = 1) -> None:
    """Write a PSD or a PSB.

    Parameters
    ----------
    workspace : Workspace
        With 8 or 16 bits, the same in all layers.
    path : Path
    version : int
        1 for a PSD, 2 for a PSB, which can be larger.
    """
    depth = workspace.bits
    info = _layer_info(workspace, depth, version)
    frame = workspace.frame
    header = FileHeader(
        version=version, channels=4, height=frame.rows, width=frame.cols, depth=depth, color_mode=ColorMode.RGB
    )
    merged = ImageData(compression=Compression.RLE)
    top = (1 << depth) - 1
    preview = flattened(workspace)
    preview[..., :3] = preview[..., :3] * preview[..., 3:] + 1 - preview[..., 3:]  # the format requires a white matte
    preview = np.floor(preview * np.float32(top) + np.float32(0.5)).clip(0, top)
    merged.set_data([_big_endian(preview[..., i].astype(_kind(depth))) for i in range(4)], header)
    document = PSD(
        header=header,
        image_resources=_resources(workspace),
        # Photoshop keeps 16-bit layers in a separate block, which GIMP 2.10 does not read; all read this one
        layer_and_mask_information=LayerAndMaskInformation(LayerInfo(*info), None, TaggedBlocks()),
        image_data=merged,
    )
    with path.open("wb") as stream:
        document.write(stream)


def version_of(workspace: Workspace) -> int:
    """Return the lowest possible version: 2 (PSB) if a side is over 30,000 px or the data would not fit in 2 GB."""
    size = sum(layer.pixels.nbytes for layer in workspace.layers) + workspace.frame.rows * workspace.frame.cols * 8
    sides = (workspace.frame.longer_side, *(max(layer.size) for layer in workspace.layers))
    return 2 if max(sides) > _LARGEST_PSD_SIDE or size > _LARGEST_PSD_BYTES else 1


def _kind(depth: int) -> type[np.uint8 | np.uint16]:
    return np.uint8 if depth == 8 else np.uint16


def _big_endian(channel: NDArray[Any]) -> bytes:
    return np.ascontiguousarray(channel).astype(channel.dtype.newbyteorder(">")).tobytes()


def _layer_info(workspace: Workspace, depth: int, version: int) -> tuple[int, LayerRecords, ChannelImageData]:
    """Records and channels, bottom to top; the members of a group lie between its end mark and its own record."""
    records: list[LayerRecord] = []
    channels: list[ChannelDataList] = []
    opened: list[WorkspaceGroup] = []

    def add(record: LayerRecord, planes: list[ChannelData]) -> None:
        record.tagged_blocks.set_data(Tag.LAYER_ID, len(records) + 1)
        records.append(record)
        channels.append(ChannelDataList(planes))

    def close_to(kept: int) -> None:
        while len(opened) > kept:
            add(*_divider(opened.pop(), SectionDivider.OPEN_FOLDER))

    for layer in workspace.layers:
        shared = 0
        while shared < min(len(opened), len(layer.groups)) and opened[shared] is layer.groups[shared]:
            shared += 1
        close_to(shared)
        for group in layer.groups[shared:]:
            add(*_divider(WorkspaceGroup("</Layer group>"), SectionDivider.BOUNDING_SECTION_DIVIDER))
            opened.append(group)
        add(*_record(layer, workspace.frame, depth, version))
    close_to(0)
    # a negative count: the merged picture's fourth channel is its transparency
    return -len(records), LayerRecords(records), ChannelImageData(channels)


def _named(name: str) -> tuple[str, TaggedBlocks]:
    """The old-style name, which cannot hold all letters, and blocks with the full name."""
    blocks = TaggedBlocks()
    blocks.set_data(Tag.UNICODE_LAYER_NAME, name)
    return name.encode("macroman", "replace")[:255].decode("macroman"), blocks


def _divider(group: WorkspaceGroup, kind: SectionDivider) -> tuple[LayerRecord, list[ChannelData]]:
    name, blocks = _named(group.name)
    mode = BlendMode(workspace_words.psd_mode(group.blend_mode))
    if kind is SectionDivider.BOUNDING_SECTION_DIVIDER:
        blocks.set_data(Tag.SECTION_DIVIDER_SETTING, kind)
    else:
        blocks.set_data(Tag.SECTION_DIVIDER_SETTING, kind, signature=b"8BIM", blend_mode=mode)
    record = LayerRecord(
        name=name,
        blend_mode=mode,
        opacity=round(group.opacity * 255),
        flags=LayerFlags(visible=group.visible, pixel_data_irrelevant=True),
        channel_info=[ChannelInfo(id=i) for i in (ChannelID.TRANSPARENCY_MASK, *_COLOR_CHANNELS)],
        tagged_blocks=blocks,
    )
    return record, [ChannelData() for _ in range(4)]


def _record(layer: WorkspaceLayer, frame: Frame, depth: int, version: int) -> tuple[LayerRecord, list[ChannelData]]:
    rows, cols = layer.size
    name, blocks = _named(layer.name)
    record = LayerRecord(
        top=layer.top,
        left=layer.left,
        bottom=layer.top + rows,
        right=layer.left + cols,
        name=name,
        blend_mode=BlendMode(workspace_words.psd_mode(layer.blend_mode)),
        opacity=round(layer.opacity * 255),
        flags=LayerFlags(visible=layer.visible),
        tagged_blocks=blocks,
    )
    planes = [(ChannelID.TRANSPARENCY_MASK, layer.pixels[..., 3])]
    planes += [(name, layer.pixels[..., i]) for i, name in enumerate(_COLOR_CHANNELS)]
    if layer.mask is not None:
        record.mask_data = _mask_data(layer.mask)
        planes.append((ChannelID.USER_LAYER_MASK, layer.mask.values))
    record.channel_info = [ChannelInfo(id=name) for name, _ in planes]
    return record, [_channel(plane, depth, version) for _, plane in planes]


def _mask_data(mask: WorkspaceMask) -> MaskData:
    rows, cols = mask.values.shape
    return MaskData(
        top=mask.top,
        left=mask.left,
        bottom=mask.top + rows,
        right=mask.left + cols,
        background_color=255 if mask.outside >= 0.5 else 0,  # the format has only these two values
        flags=MaskFlags(mask_disabled=not mask.enabled),
    )


def _channel(plane: NDArray[Any], depth: int, version: int) -> ChannelData:
    data = ChannelData(compression=Compression.RLE)  # Krita 5.1 does not open zipped channels here
    rows, cols = plane.shape
    data.set_data(_big_endian(plane), cols, rows, depth, version)
    return data


def _resources(workspace: Workspace) -> ImageResources:
    resources = ImageResources.new()
    resources[Resource.VERSION_INFO].data.writer = "nmaptool"
    resources[Resource.VERSION_INFO].data.reader = "nmaptool"
    if workspace.metadata is not None:
        xmp = workspace_words.to_xmp(workspace.metadata)
        resources[Resource.XMP_METADATA] = ImageResource(key=Resource.XMP_METADATA, data=xmp)
    return resources
