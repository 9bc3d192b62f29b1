"""Layers of EXR files as renderers name them: found by name, chosen for normals or for depth, listed in errors."""

import struct

import numpy as np
import pytest
from test_layers import write_parts

import nmaptool as nm

RNG = np.random.default_rng(9)
COMBINED = [f"ViewLayer.Combined.{c}" for c in "RGBA"]
NORMAL = [f"ViewLayer.Normal.{c}" for c in "XYZ"]
BLENDER = [
    *COMBINED,
    "ViewLayer.Depth.Z",
    "ViewLayer.Mist.Z",
    *NORMAL,
    *(f"ViewLayer.Denoising Normal.{c}" for c in "XYZ"),
]
BLENDER += [f"ViewLayer.CryptoObject00.{c}" for c in "RGBA"]


@pytest.fixture
def exr(tmp_path, picture):
    """``exr(names)``: a file with these channels, and the pixels of each by name."""

    def write(names, **more):
        pixels = RNG.uniform(0.1, 1, size=(6, 8, len(names))).astype(np.float32)
        picture(tmp_path / "a.exr", pixels, names, **more)
        return tmp_path / "a.exr", dict(zip(names, np.moveaxis(pixels, -1, 0), strict=True))

    return write


def stacked(stored, names):
    return np.dstack([stored[name] for name in names])


@pytest.mark.parametrize(
    "names",
    [
        ("Nx", "Ny", "Nz"),
        ("nx", "ny", "nz"),
        ("NX", "NY", "NZ"),
        ("normal_x", "normal_y", "normal_z"),
        ("normalR", "normalG", "normalB"),
        ("N.x", "N.y", "N.z"),
    ],
)
def test_normals_are_found_under_every_usual_name(exr, names):
    path, stored = exr(names)
    assert np.array_equal(nm.read_raster(path).pixels, stacked(stored, names))
    path, stored = exr(("R", "G", "B", "A", *names, "Z"))
    image = nm.read_raster(path)
    assert np.array_equal(image.pixels[..., :3], stacked(stored, names))
    assert image.name.lower().startswith(f"{path}:n".lower())


def test_the_normal_pass_of_blender_is_taken_and_named(exr):
    path, stored = exr(BLENDER)
    image = nm.read_raster(path)
    assert np.array_equal(image.pixels, stacked(stored, NORMAL))
    assert image.name == f"{path}:ViewLayer.Normal"


def test_the_depth_pass_of_blender_is_taken_and_named(exr):
    path, stored = exr(BLENDER)
    image = nm.read_raster(path, holds="depth")
    assert np.array_equal(image.pixels[..., 0], stored["ViewLayer.Depth.Z"])
    assert image.name == f"{path}:ViewLayer.Depth"


@pytest.mark.parametrize("wanted", ["ViewLayer.Depth", "viewlayer.depth", "Depth", "ViewLayer.Depth.Z", "depth.z"])
def test_a_layer_is_found_by_its_whole_name_or_its_end(exr, wanted):
    path, stored = exr(BLENDER)
    for image in (nm.read_raster(f"{path}:{wanted}"), nm.read_raster(path, nm.ReadOptions(layer=wanted))):
        assert np.array_equal(image.pixels[..., 0], stored["ViewLayer.Depth.Z"])
        assert image.channels == ("Y",)


def test_the_end_of_a_name_must_mean_one_layer(exr):
    path, stored = exr(BLENDER)
    with pytest.raises(
        nm.InputError, match=r"several layers are called 'z': ViewLayer\.Depth, ViewLayer\.Mist; give the"
    ):
        nm.read_raster(f"{path}:z")
    path, stored = exr([*COMBINED, "ViewLayer.Depth.Z"])
    assert np.array_equal(nm.read_raster(f"{path}:Z").pixels[..., 0], stored["ViewLayer.Depth.Z"])
    image = nm.read_raster(f"{path}:ViewLayer.Combined.G")
    assert np.array_equal(image.pixels[..., 0], stored["ViewLayer.Combined.G"])


def test_an_unknown_layer_lists_single_channels_too(exr):
    path, _ = exr([*COMBINED, "ViewLayer.Depth.Z", "ViewLayer.Mist.Z"])
    listed = r"it holds: ViewLayer\.Combined, ViewLayer\.Depth, ViewLayer\.Mist"
    with pytest.raises(nm.InputError, match=rf"has no layer 'Depht'; {listed}"):
        nm.read_raster(f"{path}:Depht")


@pytest.mark.parametrize(
    "name", ["Z", "depth.Y", "depth.V", "Depth.Z", "disparity", "depth", "ZDepth", "main.depth", "height.Y"]
)
def test_depth_is_found_under_every_usual_name(exr, name):
    path, stored = exr(["R", "G", "B", "A", name])
    image = nm.read_raster(path, holds="depth")
    assert np.array_equal(image.pixels[..., 0], stored[name])
    assert ":" in image.name.removeprefix(str(path))
    path, stored = exr([name])
    alone = nm.read_raster(path, holds="depth")
    assert np.array_equal(alone.pixels[..., 0], stored[name])
    assert alone.layer == name.removesuffix(".Y").removesuffix(".V").removesuffix(".Z")
    assert nm.read_raster(path).layer is None
    is_distance = nm.depth_to_normals(alone).report.inverted_from == "found"
    assert is_distance == (name in {"Z", "depth.Y", "depth.V", "Depth.Z", "depth", "main.depth"})


def test_of_two_depths_the_better_name_is_taken_and_equals_are_an_error(exr):
    path, stored = exr(["disparity.Y", "depth.Y", "R", "G", "B"])
    assert np.array_equal(nm.read_raster(path, holds="depth").pixels[..., 0], stored["depth.Y"])
    path, _ = exr(["left.depth.Y", "right.depth.Y", *COMBINED])
    with pytest.raises(nm.InputError, match=r"several layers are called 'depth': left\.depth, right\.depth"):
        nm.read_raster(path, nm.ReadOptions(layer="depth"), holds="depth")


@pytest.mark.parametrize(
    ("names", "holds", "named"),
    [
        (
            [*COMBINED, *(f"ViewLayer.Noisy Normal.{c}" for c in "XYZ"), *(f"Other.Old Normal.{c}" for c in "XYZ")],
            "normals",
            "Other.Old Normal",
        ),
        ([*COMBINED, *(f"ViewLayer.Position.{c}" for c in "XYZ")], "normals", "ViewLayer.Position"),
        (
            [*(f"a.{c}" for c in "RGB"), *(f"b.{c}" for c in "RGB"), "c.depth pass.Z", "d.depth pass.Z"],
            "depth",
            "c.depth pass",
        ),
        ([*(f"a.{c}" for c in "RGB"), *(f"b.{c}" for c in "RGB"), "c.Mist.Z"], "depth", "c.Mist"),
    ],
)
def test_the_message_proposes_a_sensible_layer(exr, names, holds, named):
    path, _ = exr(names)
    with pytest.raises(nm.InputError, match=rf"holds several layers \(.*\); name one, such as a\.exr:{named}$"):
        nm.read_raster(path, holds=holds)


def test_a_denoising_normal_is_taken_if_there_is_no_other(exr):
    path, _ = exr([*COMBINED, *(f"ViewLayer.Denoising Normal.{c}" for c in "XYZ")])
    assert nm.read_raster(path).layer == "ViewLayer.Denoising Normal"


def test_luminance_is_read_and_chroma_is_named(exr):
    path, stored = exr(["Y", "RY", "BY"])
    image = nm.read_raster(path, holds="depth")
    assert np.array_equal(image.pixels[..., 0], stored["Y"])
    assert image.notes == ("stores luminance and chroma; only the luminance is read",)
    with pytest.raises(nm.InputError, match=r"has 1 channel \(Y\); a normal map needs red, green and blue"):
        nm.read_normal_map(path)


def test_parts_are_layers_for_depth_too(tmp_path):
    pixels = RNG.uniform(size=(6, 8, 3)).astype(np.float32)
    depth = RNG.uniform(size=(6, 8, 1)).astype(np.float32)
    parts = [
        ("ViewLayer.Combined", ("R", "G", "B"), pixels),
        ("ViewLayer.Depth", ("Z",), depth),
        ("ViewLayer.Normal", ("X", "Y", "Z"), 1 - pixels),
    ]
    path = write_parts(tmp_path / "p.exr", parts)
    assert np.array_equal(nm.read_raster(path, holds="depth").pixels, depth)
    assert np.array_equal(nm.read_raster(f"{path}:depth").pixels, depth)
    assert np.array_equal(nm.read_raster(path).pixels, 1 - pixels)


def test_unsigned_integers_in_an_exr_keep_their_values(tmp_path, picture):
    import OpenImageIO as oiio  # noqa: N813

    numbers = RNG.integers(0, 5000, (6, 8, 1)).astype(np.uint32)
    spec = oiio.ImageSpec(8, 6, 1, "uint")
    spec.channelnames = ("Z",)
    sink = oiio.ImageOutput.create(str(tmp_path / "u.exr"))
    assert sink.open(str(tmp_path / "u.exr"), spec)
    assert sink.write_image(numbers)
    assert sink.close()
    assert np.array_equal(nm.read_raster(tmp_path / "u.exr", holds="depth").pixels, numbers)


def test_compose_depth_and_relief_take_the_fitting_layer(tmp_path, picture, dome, run):
    d = dome()
    depth = np.hypot(*(np.mgrid[0:96, 0:96] - 48.0)).astype(np.float32)
    names = [*COMBINED, "ViewLayer.Depth.Z", *NORMAL]
    picture(tmp_path / "r.exr", np.dstack([np.full((96, 96, 4), 0.5), depth, d.normals]), names)
    done = run("compose", "depth", tmp_path / "r.exr", "-o", tmp_path / "d.exr", "--invert")
    assert (done.code, done.err) == (0, done.err)
    assert "r.exr:ViewLayer.Depth" in done.out + done.err
    done = run("compose", "convert", tmp_path / "r.exr", tmp_path / "n.exr")
    assert done.code == 0
    assert np.abs(nm.read_raster(tmp_path / "n.exr").pixels[..., :3] - d.normals).max() < 1e-6


def test_chroma_at_half_resolution_is_refused(tmp_path):
    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value

    window = struct.pack("<4i", 0, 0, 7, 7)
    channels = b"".join(c + b"\0" + struct.pack("<IIii", 1, 0, s, s) for c, s in ((b"BY", 2), (b"RY", 2), (b"Y", 1)))
    parts = [
        attribute(b"channels", b"chlist", channels + b"\0"),
        attribute(b"compression", b"compression", b"\0"),
        *(attribute(name, b"box2i", window) for name in (b"dataWindow", b"displayWindow")),
        attribute(b"lineOrder", b"lineOrder", b"\0"),
        attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", bytes(8)),
        attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)),
    ]
    head = b"\x76\x2f\x31\x01" + struct.pack("<I", 2) + b"".join(parts) + b"\0"
    (tmp_path / "a.exr").write_bytes(head + bytes(400))
    with pytest.raises(nm.InputError, match=r"stores colour at half resolution; export red, green and blue at full"):
        nm.read_raster(tmp_path / "a.exr")
