"""Workspace files as independent readers see them, bit for bit."""

import itertools
import json
import zipfile
from xml.etree import ElementTree

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import psd_tools
import pytest
import tifffile
from workspace_cases import bumpy, random_workspace

import nmaptool as nm


def same(first, second):
    assert first.frame.shape == second.frame.shape
    for one, other in zip(first.layers, second.layers, strict=True):
        assert (one.name, one.left, one.top, one.visible) == (other.name, other.left, other.top, other.visible)
        assert other.pixels.dtype == one.pixels.dtype
        assert np.array_equal(one.pixels, other.pixels)
        assert other.opacity == pytest.approx(one.opacity, abs=1 / 255)
        assert [g.name for g in other.groups] == [g.name for g in one.groups]
        assert [g.visible for g in other.groups] == [g.visible for g in one.groups]
        assert (one.mask is None) == (other.mask is None)
        if one.mask is not None:
            assert np.array_equal(one.mask.values, other.mask.values)
            assert (one.mask.left, one.mask.top) == (other.mask.left, other.mask.top)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *itertools.product(("a.psd", "a.ora", "a.tif"), (np.uint8, np.uint16)),
        ("a.psb", np.uint16),
        ("a.exr", np.float32),
    ],
)
def test_everything_is_read_back(tmp_path, name, kind):
    workspace = random_workspace(kind)
    nm.write_workspace(workspace, tmp_path / name)
    back = nm.read_workspace(tmp_path / name)
    same(workspace, back)
    assert back.bits == workspace.bits
    assert back.color_profile is None
    assert back.layers[1].groups[0] is back.layers[2].groups[0]  # one group, not two of the same name
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_psd_tools_reads_a_psd(tmp_path):
    workspace = random_workspace()
    nm.write_workspace(workspace, tmp_path / "a.psd")
    document = psd_tools.PSDImage.open(tmp_path / "a.psd")
    assert (document.width, document.height, document.depth) == (100, 90, 16)
    found = {layer.name: layer for layer in document.descendants() if not layer.is_group()}
    for layer in workspace.layers:
        other = found[layer.name]
        assert (other.left, other.top, other.width, other.height) == (layer.left, layer.top, *layer.size[::-1])
        assert other.visible == layer.visible
        assert other.opacity == round(layer.opacity * 255)
        shares = other.numpy("color"), other.numpy("shape")
        assert np.array_equal(np.rint(np.dstack(shares) * 65535).astype(np.uint16), layer.pixels)
    assert found["中文"].parent.name == "inner ä"
    assert found["中文"].parent.parent.name == "outer group"
    mask = found["détail"].mask
    assert (mask.left, mask.top, mask.width, mask.height) == (3, 71, 22, 20)


def test_the_preview_in_a_psd_shows_the_layers_over_each_other(tmp_path):
    workspace = nm.pack([bumpy(), nm.PackedMap(bumpy(60, 50, 1), left=30, top=20)])
    nm.write_workspace(workspace, tmp_path / "a.psd")
    merged = psd_tools.PSDImage.open(tmp_path / "a.psd").numpy()
    inside = workspace.layers[1].pixels[20:40, 15:35]
    assert np.abs(merged[40:60, 45:65] - inside / 65535).max() < 1e-4


def test_a_zip_reader_reads_an_ora(tmp_path):
    workspace = random_workspace()
    nm.write_workspace(workspace, tmp_path / "a.ora")
    with zipfile.ZipFile(tmp_path / "a.ora") as archive:
        first = archive.infolist()[0]
        assert (first.filename, first.compress_type) == ("mimetype", zipfile.ZIP_STORED)
        assert archive.read("mimetype") == b"image/openraster"
        assert {"mergedimage.png", "Thumbnails/thumbnail.png", "stack.xml"} <= set(archive.namelist())
        image = ElementTree.fromstring(archive.read("stack.xml"))
        assert (image.get("w"), image.get("h")) == ("100", "90")
        entries = {entry.get("name"): entry for entry in image.iter("layer")}
        assert list(entries) == ["top", "中文", "détail [mask]", "détail", "base"]
        for layer in workspace.layers:
            entry = entries[layer.name]
            assert (entry.get("x"), entry.get("y")) == (str(layer.left), str(layer.top))
            archive.extract(entry.get("src"), tmp_path)
            spec = oiio.ImageSpec()
            spec.attribute("oiio:UnassociatedAlpha", 1)
            source = oiio.ImageInput.open(str(tmp_path / entry.get("src")), spec)
            assert str(source.spec().format) == "uint16"
            assert np.array_equal(source.read_image(0, 0, 0, 4, oiio.UINT16), layer.pixels)
            source.close()


def test_tifffile_reads_a_tiff(tmp_path):
    workspace = random_workspace()
    nm.write_workspace(workspace, tmp_path / "a.tif")
    with tifffile.TiffFile(tmp_path / "a.tif") as tiff:
        names = [page.tags["PageName"].value for page in tiff.pages]
        layers = {layer.name: layer for layer in workspace.layers}
        assert len(names) == 5
        for page in tiff.pages[:2]:
            assert int(page.tags["ExtraSamples"].value[0]) == 2  # unassociated alpha
        assert np.array_equal(tiff.pages[0].asarray(), layers["base"].pixels)
        assert np.array_equal(tiff.pages[1].asarray(), layers["détail"].pixels)
        assert np.array_equal(tiff.pages[2].asarray(), layers["détail"].mask.values)
        assert tiff.pages[4].tags["XPosition"].value == (98, 72)


@pytest.mark.parametrize("half", [False, True])
def test_openimageio_reads_an_exr(tmp_path, half):
    workspace = nm.pack(
        [bumpy(), nm.PackedMap(bumpy(60, 50, 1, "b.png"), left=-7, top=20)], nm.PackOptions(bits=32, half=half)
    )
    nm.write_workspace(workspace, tmp_path / "a.exr")
    source = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    assert source.seek_subimage(1, 0)
    spec = source.spec()
    assert (spec.x, spec.y, spec.full_width, spec.full_height) == (-7, 20, 180, 160)
    assert str(spec.format) == ("half" if half else "float")
    stored = source.read_image(1, 0, 0, 4, oiio.FLOAT)
    source.close()
    assert np.abs(stored[..., :3] - bumpy(60, 50, 1).normals).max() <= (1e-3 if half else 0)
    assert nm.read_normal_map(f"{tmp_path / 'a.exr'}:b").frame.shape == (160, 180)  # like any layer of an EXR


@pytest.mark.parametrize(("name", "bits"), [("a.psd", 16), ("a.ora", 16), ("a.tif", 16), ("a.exr", 32)])
def test_metadata_are_read_back(tmp_path, name, bits):
    workspace = nm.pack([nm.PackedMap(bumpy(), mode="pd", strength=0.5)], nm.PackOptions(bits=bits))
    nm.write_workspace(workspace, tmp_path / name)
    back = nm.read_workspace(tmp_path / name)
    assert back.metadata["layers"] == json.loads(json.dumps(workspace.metadata["layers"]))
    assert back.frame.pitch_mm == 0.1
    layer = nm.unpack(back).layers[0]
    assert (layer.mode, layer.strength) == ("pd", 0.5)


def test_the_same_workspace_gives_the_same_file(tmp_path):
    for name in ("a.psd", "b.psd", "a.ora", "b.ora"):
        nm.write_workspace(random_workspace(), tmp_path / name)
    assert (tmp_path / "a.psd").read_bytes() == (tmp_path / "b.psd").read_bytes()
    assert (tmp_path / "a.ora").read_bytes() == (tmp_path / "b.ora").read_bytes()


def test_content_that_a_format_cannot_hold_is_refused(tmp_path):
    with pytest.raises(nm.UsageError, match=r"a\.png: ends in \.png; a workspace is written as \.psd"):
        nm.write_workspace(random_workspace(), tmp_path / "a.png")
    with pytest.raises(nm.UsageError, match=r"`bits=32` is not supported; \.psd holds 8 or 16 bits"):
        nm.write_workspace(random_workspace(np.float32), tmp_path / "a.psd")
    with pytest.raises(nm.UsageError, match=r"`bits=16` is not supported; \.exr holds floats"):
        nm.write_workspace(random_workspace(), tmp_path / "a.exr")
    nm.write_workspace(random_workspace(), tmp_path / "a.psd")
    with pytest.raises(nm.OutputError, match="already exists"):
        nm.write_workspace(random_workspace(), tmp_path / "a.psd")
    wide = nm.Workspace(nm.Frame(2, 30_001), (nm.WorkspaceLayer("a", np.zeros((2, 30_001, 4), np.uint8)),), bits=8)
    with pytest.raises(nm.OutputError, match=r"too large for PSD; write a \.psb"):
        nm.write_workspace(wide, tmp_path / "wide.psd")
    nm.write_workspace(wide, tmp_path / "wide.psb")
    assert nm.read_workspace(tmp_path / "wide.psb").frame.cols == 30_001
