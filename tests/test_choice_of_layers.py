"""Which layer of a file is read if none is named: names of many renderers, equals, depth in colour channels, masks."""

import numpy as np
import pytest

import nmaptool as nm

RNG = np.random.default_rng(10)
BEAUTY = ["R", "G", "B", "A"]


def layer(name, components="RGB"):
    return [f"{name}.{c}" for c in components]


@pytest.fixture
def exr(tmp_path, picture):
    """``exr(names)``: a file with these channels, and the pixels of each by name."""

    def write(names):
        pixels = RNG.uniform(0.1, 1, size=(6, 8, len(names))).astype(np.float32)
        picture(tmp_path / "a.exr", pixels, names)
        return tmp_path / "a.exr", dict(zip(names, np.moveaxis(pixels, -1, 0), strict=True))

    return write


@pytest.mark.parametrize(
    ("program", "names", "normals", "depth"),
    [
        ("Blender", [*layer("V.Combined", "RGBA"), *layer("V.Normal", "XYZ"), "V.Depth.Z"], "V.Normal", "V.Depth"),
        ("Nuke", [*BEAUTY, *layer("N", ("red", "green", "blue")), "depth.Z", "motion.u", "motion.v"], "N", "depth"),
        ("Arnold", [*BEAUTY, *layer("N", "XYZ"), *layer("P", "XYZ"), "Z"], "N", "Z"),
        ("Arnold, AOVs in colours", [*BEAUTY, *layer("N"), *layer("Z")], "N", "Z"),
        ("V-Ray", [*BEAUTY, *layer("VRayNormals"), *layer("VRayZDepth")], "VRayNormals", "VRayZDepth"),
        ("V-Ray for Blender", [*BEAUTY, *layer("normals", "XYZ"), "zDepth.Z"], "normals", "zDepth"),
        ("Houdini Mantra", [*BEAUTY, *layer("N", "xyz"), "Pz"], "N", "Pz"),
        ("Houdini Karma", [*layer("C", "rgba"), *layer("N", "xyz"), *layer("hitP", "xyz"), "depth.y"], "N", "depth"),
        ("RenderMan", ["r", "g", "b", "a", *layer("Nn", "rgb"), "z"], "Nn", "z"),
        (
            "Unreal",
            [*BEAUTY, *layer("FinalImageWorldNormal"), *layer("WorldDepth")],
            "FinalImageWorldNormal",
            "WorldDepth",
        ),
        ("Cinema 4D", [*BEAUTY, *layer("Material Normals"), *layer("Depth")], "Material Normals", "Depth"),
    ],
)
def test_the_layers_of_a_renderer_are_found(exr, program, names, normals, depth):
    path, _ = exr(names)
    assert nm.read_raster(path).layer == normals, program
    assert nm.read_raster(path, holds="depth").layer == depth, program


@pytest.mark.parametrize(
    ("names", "holds", "listing"),
    [
        ([*BEAUTY, *layer("Shading normal"), *layer("Geometric normal")], "normals", "RGB, Geometric normal, Shading"),
        ([*BEAUTY, *layer("N", "XYZ"), *layer("left.N", "XYZ")], "normals", r"RGB, N, left\.N"),
        ([*BEAUTY, "left.Z", "right.Z"], "depth", r"RGB, left, right"),
        ([*BEAUTY, "dd.T"], "depth", r"RGB, dd\.T"),
    ],
)
def test_the_picture_is_not_taken_in_place_of_one_of_several(exr, names, holds, listing):
    path, _ = exr(names)
    with pytest.raises(nm.InputError, match=rf"holds several layers \({listing}.*\); name one, such as a\.exr:"):
        nm.read_raster(path, holds=holds)


def test_the_unnamed_layer_says_what_is_beside_it(exr):
    path, stored = exr([*BEAUTY, *layer("P", "XYZ"), *layer("albedo")])
    image = nm.read_raster(path)
    assert np.array_equal(image.pixels[..., 0], stored["R"])
    assert image.notes == ("is read from RGB; it also holds the layers P, albedo",)
    path, _ = exr([*BEAUTY, *(channel for n in range(9) for channel in layer(f"aov{n}"))])
    assert nm.read_raster(path).notes == (
        "is read from RGB; it also holds the layers aov0, aov1, aov2, aov3, aov4 and 4 more",
    )
    path, _ = exr([*BEAUTY, "Z"])
    assert nm.read_raster(path).notes == ()


def test_a_mask_is_found_by_its_name(exr, tmp_path):
    path, stored = exr([*layer("N", "XYZ"), "motif.mask.Y", "Z"])
    assert np.array_equal(nm.read_grey(path), stored["motif.mask.Y"])
    normals, mask = RNG.normal(size=(6, 8, 3)), RNG.random((6, 8)) > 0.5
    np.savez(tmp_path / "all.npz", normal=normals, depth=normals[..., 2], mask=mask)
    assert np.array_equal(nm.read_grey(tmp_path / "all.npz"), mask)


@pytest.mark.parametrize("name", ["Pz", "ViewLayer.Denoising Depth.Z"])
def test_layers_of_distances_are_read_as_such(exr, name):
    path, _ = exr([*BEAUTY, name])
    assert nm.depth_to_normals(nm.read_raster(path, holds="depth")).report.values == "distance"
