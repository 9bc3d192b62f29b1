"""Workspaces as editors write them, without nmaptool's metadata."""

import zipfile
from xml.sax.saxutils import quoteattr

import numpy as np
import pytest
import tifffile
from psd_tools import PSDImage
from psd_tools.constants import ChannelID, Compression, Resource, Tag
from psd_tools.psd import PSD
from psd_tools.psd.image_resources import ImageResource
from psd_tools.psd.layer_and_mask import LayerInfo, LayerInfoBlock
from psd_tools.psd.tagged_blocks import TaggedBlock
from workspace_cases import bumpy, random_workspace, turned_freely

import nmaptool as nm


def rewritten(path, change):
    """Rewrite the PSD with its structures changed."""
    with path.open("rb") as stream:
        document = PSD.read(stream)
    change(document)
    with path.open("wb") as stream:
        document.write(stream)
    return path


@pytest.fixture
def psd(tmp_path):
    nm.write_workspace(random_workspace(), tmp_path / "a.psd")
    return tmp_path / "a.psd"


def same_pixels(workspace, other):
    for one, two in zip(workspace.layers, other.layers, strict=True):
        assert np.array_equal(one.pixels, two.pixels)


@pytest.mark.parametrize("compression", list(Compression))
def test_sixteen_bit_layers_are_read_where_photoshop_stores_them(psd, compression):
    def change(document):
        info = document.layer_and_mask_information.layer_info
        for record, channels in zip(info.layer_records, info.channel_image_data, strict=True):
            for (cols, rows), channel in zip(record.channel_sizes, channels, strict=True):
                if cols and rows:
                    raw = channel.get_data(cols, rows, 16)
                    channel.compression = compression
                    channel.set_data(raw, cols, rows, 16)
        block = LayerInfoBlock(info.layer_count, info.layer_records, info.channel_image_data)
        document.layer_and_mask_information.tagged_blocks[Tag.LAYER_16] = TaggedBlock(key=Tag.LAYER_16, data=block)
        document.layer_and_mask_information.layer_info = LayerInfo()

    same_pixels(random_workspace(), nm.read_workspace(rewritten(psd, change)))


def test_layers_without_pixels_are_named_and_left_out(psd):
    def change(document):
        records = document.layer_and_mask_information.layer_info.layer_records
        records[0].tagged_blocks[Tag.LEVELS] = TaggedBlock(key=Tag.LEVELS, data=b"")
        records[2].tagged_blocks[Tag.TYPE_TOOL_OBJECT_SETTING] = TaggedBlock(key=Tag.TYPE_TOOL_OBJECT_SETTING, data=b"")

    workspace = nm.read_workspace(rewritten(psd, change))
    assert workspace.skipped == (("base", "adjustment layer"), ("détail", "text layer"))
    codes = {(finding.code, finding.layer) for finding in nm.unpack(workspace).findings}
    assert {("skipped", "base"), ("skipped", "détail")} <= codes


def test_clipping_and_effects_are_reported_and_fill_opacity_is_applied(psd):
    def change(document):
        record = document.layer_and_mask_information.layer_info.layer_records[0]
        record.clipping = 1
        record.tagged_blocks[Tag.EFFECTS_LAYER] = TaggedBlock(key=Tag.EFFECTS_LAYER, data=b"")
        record.tagged_blocks.set_data(Tag.BLEND_FILL_OPACITY, 51)

    workspace = nm.read_workspace(rewritten(psd, change))
    assert workspace.layers[0].opacity == pytest.approx(0.2)
    told = [finding.message for finding in nm.unpack(workspace).findings if finding.code == "not-kept"]
    assert told == [
        "has clipping to the layer below, which its pixels do not include",
        "has layer effects, which its pixels do not include",
    ]


def test_a_layer_without_transparency_is_opaque_and_grey_is_grey(psd):
    def change(document):
        info = document.layer_and_mask_information.layer_info
        for number, dropped in ((0, (ChannelID.TRANSPARENCY_MASK,)), (-1, (ChannelID.CHANNEL_1, ChannelID.CHANNEL_2))):
            record, channels = info.layer_records[number], info.channel_image_data[number]
            kept = [i for i, channel in enumerate(record.channel_info) if channel.id not in dropped]
            channels[:] = [channels[i] for i in kept]
            record.channel_info = [record.channel_info[i] for i in kept]

    workspace = nm.read_workspace(rewritten(psd, change))
    assert (workspace.layers[0].pixels[..., 3] == 65535).all()
    top = workspace.layers[-1].pixels
    assert np.array_equal(top[..., 0], top[..., 2])


def test_a_colour_profile_is_reported(psd):
    name = b"sRGB IEC61966-2.1\0"
    body = b"desc\0\0\0\0" + len(name).to_bytes(4, "big") + name
    table = (1).to_bytes(4, "big") + b"desc" + (144).to_bytes(4, "big") + len(body).to_bytes(4, "big")
    profile = bytes(128) + table + body

    def change(document):
        document.image_resources[Resource.ICC_PROFILE] = ImageResource(key=Resource.ICC_PROFILE, data=profile)

    workspace = nm.read_workspace(rewritten(psd, change))
    assert workspace.color_profile == "sRGB IEC61966-2.1"
    finding = nm.unpack(workspace).findings[0]
    assert (finding.code, finding.layer) == ("color-profile", None)


def test_a_flattened_psd_is_read_and_reported(tmp_path):
    from PIL import Image

    PSDImage.frompil(Image.new("RGB", (12, 9), (128, 128, 255))).save(tmp_path / "a.psd")
    workspace = nm.read_workspace(tmp_path / "a.psd")
    unpacked = nm.unpack(workspace)
    assert workspace.frame.shape == (9, 12)
    assert "flattened" in {finding.code for finding in unpacked.findings}
    assert (unpacked.layers[0].normal_map.normals == (0, 0, 1)).all()


def test_floats_from_an_editor_are_unsigned(tmp_path):
    normals = bumpy().normals
    codes = np.dstack([(normals + 1) / 2, np.ones(normals.shape[:2])]).astype(np.float32)
    layer = nm.WorkspaceLayer("a", codes)
    found = nm.unpack(nm.Workspace(nm.Frame(160, 180), (layer,), bits=32)).layers[0]
    assert np.abs(found.normal_map.normals - normals).max() < 1e-5


def test_an_ora_from_krita_is_read(tmp_path, png):
    pixels = np.random.default_rng(0).integers(0, 256, (6, 7, 4)).astype(np.uint8)
    data = png(tmp_path / "l.png", pixels).read_bytes()
    mask = png(tmp_path / "m.png", np.dstack([pixels[..., :1]] * 3 + [np.full((6, 7, 1), 255, np.uint8)])).read_bytes()
    entries = [
        "<stack isolation='auto' name='g' opacity='0.5' composite-op='krita:soft_light' visibility='hidden'>",
        f"<layer name={quoteattr('a [mask]')} src='m.png' x='2.0' y='3' visibility='hidden'/>",
        "<layer name='a' src='l.png' x='2.0' y='3' composite-op='svg:multiply' opacity='0.25'/></stack>",
        "<layer name='vector' src='v.svg'/>",
    ]
    with zipfile.ZipFile(tmp_path / "a.ora", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mimetype", "image/openraster", zipfile.ZIP_STORED)
        archive.writestr("stack.xml", f"<image w='20' h='30'><stack>{''.join(entries)}</stack></image>")
        archive.writestr("l.png", data)
        archive.writestr("m.png", mask)
    workspace = nm.read_workspace(tmp_path / "a.ora")
    layer = workspace.layers[0]
    assert np.array_equal(layer.pixels, pixels)
    assert (layer.left, layer.top, layer.opacity, layer.blend_mode) == (2, 3, 0.25, "multiply")
    assert (layer.groups[0].blend_mode, layer.groups[0].visible) == ("soft light", False)
    assert np.array_equal(layer.mask.values, pixels[..., 0])
    assert workspace.skipped == (("vector", "layer with .svg source"),)
    assert workspace.metadata is None
    assert not nm.unpack(workspace).has_metadata


def test_a_tiff_from_gimp_is_read(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 65536, (6, 7, 4)).astype(np.uint16)
    with tifffile.TiffWriter(tmp_path / "a.tif") as writer:
        for name, left in (("a", 0), ("b", 30)):
            tags = [(285, 2, 0, name.encode() + b"\0", True), (286, 5, 1, (left, 300), True)]
            writer.write(
                pixels,
                photometric="rgb",
                extrasamples=["unassalpha"],
                resolution=(300, 300),
                resolutionunit="inch",
                metadata=None,
                extratags=tags,
            )
    workspace = nm.read_workspace(tmp_path / "a.tif")
    assert [(layer.name, layer.left, layer.top) for layer in workspace.layers] == [("a", 0, 0), ("b", 30, 0)]
    assert np.array_equal(workspace.layers[1].pixels, pixels)
    assert workspace.frame.shape == (6, 37)


def test_a_layer_moved_in_a_tiff_with_old_metadata_has_its_new_position(tmp_path):
    nm.write_workspace(nm.pack([nm.PackedMap(bumpy(), left=-5, top=4)]), tmp_path / "a.tif")
    assert (nm.read_workspace(tmp_path / "a.tif").layers[0].left) == -5
    raw = (tmp_path / "a.tif").read_bytes()
    moved = raw.replace(np.array([4, 72], "<u4").tobytes(), np.array([9, 72], "<u4").tobytes())
    (tmp_path / "a.tif").write_bytes(moved)
    layer = nm.read_workspace(tmp_path / "a.tif").layers[0]
    assert (layer.left, layer.top) == (-5, 9)


def test_most_faults_are_found_even_without_metadata(tmp_path):
    pixels = turned_freely(nm.pack([bumpy()]).layers[0].pixels, 25)
    workspace = nm.Workspace(nm.Frame(160, 180), (nm.WorkspaceLayer("a", np.rint(pixels / 257).astype(np.uint8)),), 8)
    nm.write_workspace(workspace, tmp_path / "a.psd")
    codes = {finding.code for finding in nm.unpack(nm.read_workspace(tmp_path / "a.psd")).findings}
    assert codes == {"eight-bit", "turned-freely"}
